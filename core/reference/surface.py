"""The switching function and its rates: at a point in many digits, and bounds on them over short times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import sympy
from numpy.typing import NDArray

from core.reference.intervals import Interval, Intervals, around
from core.reference.powers import Step
from core.reference.program import Digits, Doubles, Program
from core.symbolic.expressions import TIME

__all__ = ["Enclosure", "Polynomial", "Surface"]

#: Number of derivatives in the Taylor bound on the state around the middle of a piece.
_DERIVATIVES = 6


class Surface:
    """g with the fields on both sides of it.

    Parameters
    ----------
    g : expression
        In the variables and time.
    fields : mapping of side, −1 or +1, to d expressions
    variables : d symbols
    """

    def __init__(
        self, g: sympy.Expr, fields: Mapping[int, Sequence[sympy.Expr]], variables: Sequence[sympy.Symbol]
    ) -> None:
        symbols, gradient = (TIME, *variables), [g.diff(v) for v in variables]
        self.moves = TIME in g.free_symbols
        self._intervals, self._doubles = Intervals(), Doubles()
        rates = {side: _rate(g, f, variables) for side, f in fields.items()}
        self._point = {side: Program([g, rate], symbols) for side, rate in rates.items()}
        self._bounds = {
            side: Program([g, rate, _rate(rate, fields[side], variables)], symbols) for side, rate in rates.items()
        }
        self._slopes = Program([sum(u**2 for u in gradient), g.diff(TIME)], symbols)

    def evaluate(self, digits: Digits, side: int, t: Any, x: NDArray[np.object_]) -> tuple[Any, Any]:
        """g and its rate ġ = g_t + ∇g·f, with the field of a side, at time t and state x (d,), in many digits."""
        height, rate = self._point[side].run(digits, [t, *x])
        return height, rate

    def evaluate_in_doubles(self, side: int, t: float, x: NDArray[np.float64]) -> tuple[float, float]:
        """The same in doubles."""
        height, rate = self._point[side].run(self._doubles, [np.float64(t), *x])
        return height, rate

    def round_off(self, digits: Digits, t: Any, x: NDArray[np.object_]) -> float:
        """Bound on |g| at a point of the surface whose t and x (d,) are rounded to double."""
        square, drift = self._slopes.run(digits, [t, *x])
        slope = np.sqrt(float(square))
        return float(2 * np.finfo(float).eps * (slope * float(np.abs(x).max()) + abs(float(drift * t))))

    def enclose(self, side: int, t: float, span: float, states: Polynomial, edges: NDArray[np.float64]) -> Enclosure:
        """Bounds on side·g and its first two rates over equal pieces of a step.

        Parameters
        ----------
        t, span
            Start and length of the step in time.
        states
            The state over the step.
        edges
            (m + 1,) ends of the pieces, as parts of the step from 0 to 1.
        """
        m = len(edges) - 1
        middle, radius = (edges[1:] + edges[:-1]) / 2, np.diff(edges) / 2
        values, distances = states.around(float(edges[0]), float(edges[-1]), m)
        centers, radii = (
            np.tile(values, (2, 1)),
            np.concatenate([np.broadcast_to(states.error, values.shape), distances]),
        )
        clock = t + span * np.tile(middle, 2)
        slack = np.spacing(np.abs(clock)) + np.concatenate([np.zeros(m), span * radius])
        inputs = [around(clock, slack), *map(around, centers.T, radii.T)]
        bounds = [u.spread(2 * m) for u in self._bounds[side].run(self._intervals, inputs)]
        height, rate, second_rate = (u if side > 0 else -u for u in bounds)
        return Enclosure.of(height, rate, second_rate, span * radius)


def _rate(g: sympy.Expr, field: Sequence[sympy.Expr], variables: Sequence[sympy.Symbol]) -> sympy.Expr:
    return sum((g.diff(v) * f for v, f in zip(variables, field, strict=True)), g.diff(TIME))


class Polynomial:
    """The state over a step as a polynomial, in doubles, of the part of the step from 0 to 1."""

    def __init__(self, step: Step) -> None:
        self.coefficients = step.polynomial()  #: (order + 1, d)
        sizes = np.abs(self.coefficients)
        self._remainder = _choices(len(sizes))[-1] @ sizes  # (d,) of derivative `_DERIVATIVES`, over its factorial
        self.error = 2.0**-46 * sizes.sum(axis=0)  # (d,) bound on the round-off of a value: 64 eps of the sum of sizes

    def at(self, part: float) -> NDArray[np.float64]:
        """State (d,) at a part of the step."""
        state: NDArray[np.float64] = part ** np.arange(len(self.coefficients)) @ self.coefficients
        return state

    def grid(self, count: int) -> NDArray[np.float64]:
        """States (count, d) at equally spaced parts of the step, its ends included."""
        states: NDArray[np.float64] = _grid(count, len(self.coefficients)) @ self.coefficients
        return states

    def around(self, low: float, high: float, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """States (count, d) in the middle of equal pieces of [low, high], and bounds on distances from them there."""
        basis = _basis(low, high, count, len(self.coefficients))
        derivatives = basis @ self.coefficients  # (1 + _DERIVATIVES, count, d), scaled with powers of half a piece
        half = (high - low) / (2 * count)
        distance = np.abs(derivatives[1:]).sum(axis=0) + self._remainder * half**_DERIVATIVES + self.error
        return derivatives[0], distance


@lru_cache
def _grid(count: int, n: int) -> NDArray[np.float64]:
    """Powers (count, n) of equally spaced numbers from 0 to 1."""
    return np.vander(np.linspace(0, 1, count), n, increasing=True)


@lru_cache
def _choices(n: int) -> NDArray[np.float64]:
    """Binomial coefficients (1 + _DERIVATIVES, n): entry (k, j) is j over k."""
    powers = np.arange(n)
    rows = [np.ones(n)]
    for k in range(1, _DERIVATIVES + 1):
        rows.append(rows[-1] * (powers - k + 1) / k)
    return np.array(rows)


@lru_cache(maxsize=4096)
def _basis(low: float, high: float, count: int, n: int) -> NDArray[np.float64]:
    """Derivatives 0 … _DERIVATIVES − 1 of the powers in the middle of equal pieces, (_DERIVATIVES, count, n).

    Derivative k is divided by k! and multiplied by the k-th power of half a piece.
    """
    edges = np.linspace(low, high, count + 1)
    middle, half = (edges[1:] + edges[:-1]) / 2, (high - low) / (2 * count)
    powers = np.vander(middle, n, increasing=True)
    shifted = [np.pad(powers, ((0, 0), (k, 0)))[:, :n] * half**k for k in range(_DERIVATIVES)]
    return np.array(shifted) * _choices(n)[:-1, None]


class Enclosure(NamedTuple):
    """Bounds on side·g (positive inside) and its first two rates over m pieces of an arc."""

    height: Interval
    rate: Interval
    second_rate: Interval
    largest_height: float
    largest_rate: float

    @classmethod
    def of(cls, height: Interval, rate: Interval, second_rate: Interval, half: NDArray[np.float64]) -> Enclosure:
        """From bounds in the middle of each piece (the first m) and over all of it; `half` is half its time, (m,)."""
        m = len(half)
        here, there = slice(0, m), slice(m, None)
        away = around(np.zeros(m), half)
        rates = rate[there].within(rate[here] + second_rate[there] * away)
        heights = height[there].within(height[here] + rates * away)
        with np.errstate(all="ignore"):
            largest_height, largest_rate = (float(np.nanmax(np.abs(u.low[:m]), initial=0.0)) for u in (height, rate))
        return cls(heights, rates, second_rate[there], largest_height, largest_rate)
