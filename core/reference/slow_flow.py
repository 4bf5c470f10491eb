"""The flow of a linear field where its fastest part has decayed.

A power series takes steps of some time constants of the fastest part of a flow, and does so long after that part has
decayed: in each step rounding excites it anew. Once it is below the precision, the state x lies where

    x' = P f(x) = f(x),    f(x) = A x + b,

with P the projector onto the slow eigenvectors of A along the fast ones. The field P f has no fast part, so that its
series takes steps as long as the slow part allows. P is found from the sign function of A + σ, with −σ between the real
parts of the fast and of the slow eigenvalues, whatever their multiplicities. Source: Higham, *Functions of Matrices*
(2008), ch. 5.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import sympy
from numpy.typing import NDArray

from core.reference.solution import State
from core.symbolic.program import Digits, Program

__all__ = ["FastPart", "SlowFlow"]

Matrix: TypeAlias = Any  # of an mpmath context

#: Least ratio of the largest eigenvalues of the fast and of the slow part: by so much steps become longer.
_FASTER = 4.0
#: Least ratio of the slowest rate of decay of the fast part to the largest one of the slow part.
_APART = 2.0
#: Most radians that the fast part may turn by in a time constant: else it takes too many steps to decay.
_TURNS = 64.0
#: Rate of decay, as part of the largest coefficient, below which doubles do not tell it from zero.
_ROUNDING = 2.0**-40
#: Bits of the sign function beyond those of the precision and of the condition of the problem.
_MORE = 32


class SlowFlow(NamedTuple):
    """The flow of x' = A x + b on the eigenvectors that are left where the fast ones have decayed."""

    field: tuple[sympy.Expr, ...]
    """P (A x + b), in ratios that are right to the precision."""
    fast: NDArray[np.object_]
    """(d, d) takes A x + b to the fast part of x, which decays."""
    rate: Program
    """A x + b."""

    def entered(self, digits: Digits, x: State, least: Any) -> State | None:
        """The state (d,) without its fast part, if that is at most `least` times the state; else None."""
        fast = self.fast @ np.array(self.rate.run(digits, list(x)), dtype=object)
        return x - fast if np.abs(fast).max() <= least * np.abs(x).max() else None


class FastPart(NamedTuple):
    """The part of a linear field A x + b that decays much faster than all others."""

    field: tuple[sympy.Expr, ...]
    variables: tuple[sympy.Symbol, ...]
    slopes: sympy.Matrix
    """A, in rational numbers."""
    between: float
    """A rate slower than those with which it decays, and faster than all others."""

    @classmethod
    def of(cls, field: Sequence[sympy.Expr], variables: Sequence[sympy.Symbol]) -> FastPart | None:
        """The part of a field that decays first; None if there is none, or the field is not linear."""
        slopes = sympy.Matrix(list(field)).jacobian(list(variables))
        if not all(u.is_Rational for u in slopes):
            return None
        with np.errstate(all="ignore"):
            numbers = np.array(slopes.tolist(), dtype=float)
        if not np.isfinite(numbers).all():
            return None
        eigenvalues = np.linalg.eigvals(numbers)
        eigenvalues = eigenvalues[np.argsort(eigenvalues.real)]
        rounding, end = _ROUNDING * float(np.abs(numbers).max()), np.zeros(1)  # it may all be fast, and come to rest
        for count in range(1, len(eigenvalues) + 1):
            fast, slow = eigenvalues[:count], np.append(eigenvalues[count:], end)
            decay, slower = -float(fast[-1].real), float(-slow.real.min())
            faster = np.abs(fast).max() > _FASTER * np.abs(slow).max()
            if decay > max(_APART * slower, rounding) and faster and (_TURNS * -fast.real > np.abs(fast.imag)).all():
                return cls(tuple(field), tuple(variables), slopes, (decay + max(slower, 0.0)) / 2)
        return None

    def left_out(self, digits: Digits) -> SlowFlow | None:
        """The flow without this part; None if no projector is found."""
        d, size = len(self.variables), max(map(abs, self.slopes))
        more = Digits.of(digits.context.prec + 2 * max(0, math.ceil(sympy.log(size / self.between, 2))) + _MORE)
        context, rate = more.context, Program(self.field, self.variables)
        a = context.matrix([[context.mpf(int(u.p)) / int(u.q) for u in row] for row in self.slopes.tolist()])
        one = context.eye(d)
        sign = _sign(context, a + self.between * one)
        if sign is None:
            return None
        slow = (one + sign) / 2
        fast = context.inverse(a * (one - slow) + slow) * (one - slow)
        numbers = np.array(list(map(digits.context.mpf, fast)), dtype=object).reshape(d, d)
        b = context.matrix(rate.run(more, [context.mpf(0)] * d))
        linear, constant = (_without_round_off(digits, slow * u, u) for u in (a, b))
        return SlowFlow(tuple(linear * sympy.Matrix(self.variables) + constant), numbers, rate)


def _sign(context: Any, a: Matrix) -> Matrix | None:
    """Sign function of a matrix, by Newton's method, S ← (S + S⁻¹)/2; None for eigenvalues on the imaginary axis."""
    try:
        for _ in range(context.prec):
            new = (a + context.inverse(a)) / 2
            change, a = context.mnorm(new - a, 1), new
            if change <= context.ldexp(context.mnorm(a, 1), -context.prec // 2):  # the next one is about its square
                return (a + context.inverse(a)) / 2
    except ZeroDivisionError:
        pass
    return None


def _without_round_off(digits: Digits, product: Matrix, factor: Matrix) -> sympy.Matrix:
    """A product with a projector, in ratios; 0 for what is not above the rounding of its other factor.

    What is left of a part that has decayed would else move the state, in a time without bound.
    """
    least = digits.context.ldexp(max(map(abs, factor)) * factor.rows, -digits.context.prec)
    return sympy.Matrix(product.rows, product.cols, [_exactly(u) if abs(u) > least else 0 for u in product])


def _exactly(number: Any) -> sympy.Rational:
    """A number of an mpmath context as a ratio."""
    sign, mantissa, exponent, _ = number._mpf_
    return (-1) ** sign * sympy.Integer(int(mantissa)) * sympy.Integer(2) ** exponent
