"""Quotients near common zeros of numerator and denominator, where rounding spoils them: by their power series.

(u − sin(u))/u³ is 1/6 − u²/120 + …, of which no digit is lost near u = 0, where the quotient as it stands loses all.
The series is used where its last terms are below the rounding of its first; the nearer to the zero the fewer digits the
quotient has left, the farther from it the more.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import reduce
from typing import NamedTuple

import sympy
from sympy import Expr, Symbol

from core.symbolic.algebra import factor, together
from core.symbolic.power_series import LONGEST, NoSeries, Series, SeriesIn

__all__ = ["Choice", "magnitude", "written_near"]

#: Number of terms of a series; where numerator and denominator vanish to order n, n fewer are left.
_TERMS = 32
#: Number of its last terms that are below rounding where it is used, and of its first, to which they are compared …
_LAST, _FIRST = 3, 6
#: … and at how many times the distance they are: a step of the Taylor method leads farther with the same coefficients.
_FARTHER = 2
#: Most operations of a discriminant that is factored, so that the root of a square is told.
_FACTORED = 100
#: The rounding of a number, relative to it.
_ROUNDING = sympy.Rational(1, 2**53)


class magnitude(sympy.Function):  # noqa: N801
    """|u|, which sympy does not simplify; printed as ``abs``."""

    nargs = 1


class Choice(sympy.Function):
    """Choice(far, near, other): `near` where far ≤ 0, else `other`; both have the same value, but for rounding."""

    nargs = 3

    @classmethod
    def eval(cls, far: Expr, near: Expr, other: Expr) -> Expr | None:
        """Either one where both are written alike."""
        return near if near == other else None

    def _eval_derivative(self, symbol: Symbol) -> Expr:
        far, near, other = self.args
        return Choice(far, near.diff(symbol), other.diff(symbol))


class _Place(NamedTuple):
    """A zero, as a point on an axis: what is replaced to move by w from it, and w in terms of time and state."""

    replaced: Expr
    moved: Expr
    distance: Expr


#: Distances up to which a series with known coefficients may be used: the first at which its last terms are small.
_RADII = [2.0 ** (-k / 8) for k in range(-64, 1600)]
#: The displacement from a zero.
_W = Symbol("displacement from a zero")


def written_near(u: Expr, zeros: Iterable[Expr]) -> Expr:
    """Write an expression such that it keeps its digits near the zeros of others, where a way is found."""
    for zero in zeros:
        u = _without_poles(u, zero)
        ways = (reduce(lambda v, place: _Rewritten(place).of(v), places, u) for places in _places(zero))
        u = next((v for v in ways if v != u), u)
    return u


def _without_poles(u: Expr, zero: Expr) -> Expr:
    """Write the tangents that have poles at a zero of a cosine as quotients: 1/tan(v) is cos(v)/sin(v)."""
    if not isinstance(zero, sympy.cos):
        return u
    (angle,) = zero.args
    quotients = u.xreplace({sympy.tan(angle): sympy.sin(angle) / zero})
    return quotients.replace(
        lambda v: v.is_Pow and v.base.is_Add and v.base.has(zero), lambda v: together(v.base) ** v.exp
    )


def _places(zero: Expr) -> Iterator[list[_Place]]:
    """All zeros of an expression, in each way in which they can be told: its own, or those of a function's argument."""
    for u in dict.fromkeys((zero, *(v for f in zero.atoms(sympy.Function) for v in sympy.Mul.make_args(f.args[0])))):
        # What stands beside a longer zero is too long for the coefficients of a series.
        nodes = sympy.preorder_traversal(u) if u.count_ops() <= LONGEST else ()
        atoms = [a for a in nodes if not (a.is_Add or a.is_Mul or a.is_number)]
        for a in sorted(dict.fromkeys(atoms), key=lambda a: (not a.is_Symbol, str(a))):
            blank = sympy.Dummy()
            line = u.xreplace({a: blank})
            if not line.is_polynomial(blank):  # asked before it is expanded, which takes long where it is long
                continue
            line = sympy.expand(line)
            rest, slope, square, higher = (sympy.Add(*terms) for terms in _by_power(line, blank))
            if higher == square == 0 and slope != 0:
                yield [_Place(a, (_W - rest) / slope, u)]
            elif higher == 0 and square != 0:
                yield [_Place(a, root + _W, a - root) for root in _roots(square, slope, rest)]
        yield [_Place(u, _W, u)]


def _by_power(line: Expr, x: Symbol) -> tuple[list[Expr], list[Expr], list[Expr], list[Expr]]:
    """The coefficients of 1, x and x² in an expanded polynomial, and those of all higher powers.

    Not by `sympy.Poly`, which looks for a domain of the coefficients and may take hours over functions.
    """
    parts: tuple[list[Expr], list[Expr], list[Expr], list[Expr]] = ([], [], [], [])
    powers = (sympy.S.One, x, x**2)
    for term in sympy.Add.make_args(line):
        factor, power = term.as_independent(x, as_Add=False)
        parts[powers.index(power) if power in powers else -1].append(factor)
    return parts


def _roots(a: Expr, b: Expr, c: Expr) -> set[Expr]:
    """The roots of a quadratic; not `sympy.roots`, which simplifies them and may take hours over functions."""
    discriminant = sympy.expand(b**2 - 4 * a * c)
    if discriminant.count_ops() <= _FACTORED:
        discriminant = factor(discriminant)
    return {(-b + sign * sympy.sqrt(discriminant)) / (2 * a) for sign in (1, -1)}


class _Rewritten:
    """Writes expressions with series about one zero."""

    def __init__(self, place: _Place) -> None:
        self._place, self._series = place, SeriesIn(_W, _TERMS)

    def of(self, u: Expr) -> Expr:
        """An expression with its quotients that are bounded at the zero written as series near it."""
        if not any(v.is_Pow and v.exp.is_number and v.exp < 0 for v in sympy.preorder_traversal(u)):
            return u
        if u.is_Add or u.is_Mul or u.is_Pow:
            return self._grouped(u)
        if isinstance(u, Choice):
            far, near, other = u.args
            return Choice(far, near, self.of(other))
        return u.func(*map(self.of, u.args))

    def _grouped(self, u: Expr) -> Expr:
        """A sum or product in which the parts that are bounded together, but not each by itself, are one series."""
        func = u.func if u.is_Add else sympy.Mul
        together: list[Expr] = []
        apart: list[Expr] = []
        for v in func.make_args(u):
            (together if self._concerned(v, u.is_Add) else apart).append(v)
        whole = func(*together)
        series = self._known(whole)
        if series is None or series.first < 0 or all(self._is_bounded(v) for v in together):
            return func(*together, *map(self._inside, apart))
        return func(self._chosen(series, whole), *map(self._inside, apart))

    def _concerned(self, v: Expr, is_term: bool) -> bool:
        """Whether a term is unbounded at the zero, or a factor vanishes or is unbounded there, or in other places."""
        series = self._known(v)
        if series is None or is_term:
            return series is not None and series.first < 0
        return series.first != 0 or bool(v.is_Pow and v.exp.is_number and v.exp < 0)

    def _is_bounded(self, u: Expr) -> bool:
        series = self._known(u)
        return series is not None and series.first >= 0

    def _inside(self, u: Expr) -> Expr:
        return u.func(*map(self.of, u.args)) if u.is_Pow else self.of(u)

    def _known(self, u: Expr) -> Series | None:
        moved = u.xreplace({self._place.replaced: self._place.moved})
        if moved.free_symbols & self._place.replaced.free_symbols:
            return None
        try:
            return self._series.of(moved)
        except NoSeries:
            return None

    def _chosen(self, series: Series, u: Expr) -> Expr:
        """The series near the zero, and the expression itself elsewhere."""
        w, terms = self._place.distance, [sympy.S.Zero] * series.first + series.coefficients
        return Choice(_far(terms, w), _polynomial(terms, w), u)


def _polynomial(terms: list[Expr], w: Expr) -> Expr:
    """Σ terms[k] wᵏ, by Horner's rule from one term that does not vanish to the next."""
    total, power = sympy.S.Zero, len(terms)
    for k in range(len(terms) - 1, -1, -1):
        if terms[k] != 0 or k == 0:
            total = terms[k] + w ** (power - k) * total
            power = k
    return total


def _far(terms: list[Expr], w: Expr) -> Expr:
    """What is positive where the last terms of a series are not below the rounding of its first."""
    sizes = [(k, magnitude(c)) for k, c in enumerate(terms) if c != 0]
    r = sympy.Dummy()
    first = sympy.Add(*(c * r**k for k, c in sizes[:_FIRST]))
    last = sympy.Add(*(c * (_FARTHER * r) ** k for k, c in sizes[-_LAST:]))
    excess = last - first * _ROUNDING
    if excess.free_symbols != {r}:
        return excess.xreplace({r: magnitude(w)})
    numbers = sympy.lambdify(r, excess.replace(magnitude, sympy.Abs), "math")
    return magnitude(w) - sympy.Rational(next(radius for radius in _RADII if numbers(radius) <= 0.0))
