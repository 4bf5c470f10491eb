"""Tell whether a quantity is conserved but for the rounding of its decimals: 0.333333 in place of 1/3."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import NamedTuple

import mpmath
import numpy as np
import sympy
from sympy import Dummy, Expr, Rational

from core.kernels.arrays import Floats
from core.symbolic.sampling import Domain, Samples

__all__ = ["Rounded", "rounded_decimals"]

#: Least number of digits of a decimal that is taken for a rounded number, and most such decimals looked into.
_LEAST_DIGITS, _MOST = 3, 8
#: Digits in which the derivative is evaluated: its terms may cancel to the last digit of those that are typed.
_WORKING_DIGITS = 60
#: Points at which it is evaluated for each unknown number, and besides.
_POINTS_EACH, _POINTS_BESIDES = 3, 6
#: Part of the derivative that may be left with other decimals.
_LEFT = 1e-6
#: Change of a decimal, in units of its last digit, that rounding or truncation stays below; it is found to six digits.
_ROUNDED = 1.0 - 1e-6
#: Largest denominator of a fraction that is proposed, and its distance from what is found, in units of the last digit;
#: a decimal as near as that is meant as it is typed.
_DENOMINATOR, _NEAR = 999, 1e-6


class Rounded(NamedTuple):
    """A decimal, and the number with which the quantity would be conserved."""

    typed: Rational
    meant: Rational
    unit: Rational
    """That of the last digit."""

    @property
    def change(self) -> float:
        """Size of the change, relative to the decimal."""
        return float(abs(self.meant / self.typed - 1))

    def words(self) -> str:
        """Return the two in words, the second as a fraction if it is a simple one."""
        simple = Fraction(int(self.meant.p), int(self.meant.q)).limit_denominator(_DENOMINATOR)
        near = abs(Rational(simple.numerator, simple.denominator) - self.meant) <= _NEAR * self.unit
        digits = len(str(abs(self.typed / self.unit)))
        enough = digits + 3
        while (meant := str(sympy.N(self.meant, enough))) == str(sympy.N(self.typed, enough)):
            enough += 1
        meant = str(simple) if near else meant
        return f"{meant} in place of {sympy.N(self.typed, digits)!s}"


def rounded_decimals(u: Expr, rate_of: Callable[[Expr], Expr], domain: Domain) -> tuple[Rounded, ...]:
    """Decimals of u within whose rounding there are numbers with which its rate vanishes; () if there are none.

    The change of each decimal is found by least squares, from values of the rate and its derivatives at some points.
    """
    decimals = {r: unit for r in sorted(u.atoms(Rational)) if (unit := _unit(r)) is not None}
    if not 0 < len(decimals) <= _MOST:
        return ()
    names = {r: Dummy() for r in decimals}
    rate = rate_of(u.xreplace(names))
    back = {name: r for r, name in names.items()}
    parts = [rate, *(rate.diff(name) * decimals[r] for r, name in names.items())]
    values = _values([part.xreplace(back) for part in parts], domain)
    if len(values) <= len(decimals):
        return ()
    values /= np.abs(values[:, 1:]).max(axis=1, keepdims=True)
    left, effects = values[:, 0] / (size := float(np.abs(values[:, 0]).max())), values[:, 1:]
    change = -np.linalg.lstsq(effects, left, rcond=1e-10)[0]
    if np.abs(effects @ change + left).max() > _LEFT or np.abs(change * size).max() >= _ROUNDED:
        return ()
    changes = [
        Rational(float(part)) * Rational(size) * unit for part, unit in zip(change, decimals.values(), strict=True)
    ]
    found = zip(decimals.items(), changes, strict=True)
    return tuple(Rounded(r, r + by, unit) for (r, unit), by in found if abs(by) > _NEAR * unit)


def _unit(number: Rational) -> Rational | None:
    """The unit of the last digit of a number that may be a decimal of some digits; None if it is none."""
    twos, rest = sympy.multiplicity(2, number.q), number.q
    fives = sympy.multiplicity(5, number.q)
    rest //= 2**twos * 5**fives
    unit = Rational(1, 10 ** max(twos, fives))
    return unit if rest == 1 and abs(number / unit) >= 10 ** (_LEAST_DIGITS - 1) and unit < 1 else None


def _values(expressions: Sequence[Expr], domain: Domain) -> Floats:
    """Values of expressions at some points of a domain, (points, expressions): those of many digits, rounded."""
    samples = Samples(tuple(expressions), domain)
    wanted = _POINTS_EACH * len(expressions) + _POINTS_BESIDES
    rows = np.unique(np.linspace(0, len(samples.points) - 1, wanted).astype(int)) if len(samples.points) else ()
    evaluate = sympy.lambdify(samples.symbols, list(expressions), "mpmath")
    with mpmath.workdps(_WORKING_DIGITS):
        at = [evaluate(*map(mpmath.mpf, samples.points[row].tolist())) for row in rows]
        found = np.array([[complex(value) for value in values] for values in at]).reshape(-1, len(expressions))
    known = np.isfinite(found).all(axis=1) & (found.imag == 0.0).all(axis=1) & (np.abs(found[:, 1:]) > 0.0).any(axis=1)
    return np.asarray(found.real[known])
