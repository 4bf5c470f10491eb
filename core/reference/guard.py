"""A guard of a mode and its rates: at a point in many digits, and bounds on them over short times."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
import sympy
from numpy.typing import NDArray

from core.reference.powers import Step
from core.symbolic.expressions import TIME
from core.symbolic.intervals import Interval, Intervals, around
from core.symbolic.mode import rate_along
from core.symbolic.program import Digits, Doubles, Program

__all__ = ["Enclosure", "Guard", "Polynomial"]

#: Number of derivatives in the Taylor bound on the state around the middle of a piece.
_DERIVATIVES = 6


class Guard:
    """A height that is positive in a mode and ends it where it vanishes, with its rates along the field of the mode.

    Parameters
    ----------
    height : expression
        In the variables and time.
    field : d expressions
        In the variables.
    variables : d symbols
    """

    def __init__(self, height: sympy.Expr, field: Sequence[sympy.Expr], variables: Sequence[sympy.Symbol]) -> None:
        self.moves = TIME in height.free_symbols
        self._height, self._field, self._variables = height, field, variables
        self._rate = rate_along(field, variables, height)
        self._intervals, self._doubles = Intervals(), Doubles()
        self._symbols = (TIME, *variables)
        self._point = Program([height, self._rate], self._symbols)

    @cached_property
    def _bounds(self) -> Program:
        second = rate_along(self._field, self._variables, self._rate)
        return Program([self._height, self._rate, second], self._symbols)

    @cached_property
    def _slopes(self) -> Program:
        slope = sympy.Add(*(self._height.diff(v) ** 2 for v in self._variables))
        return Program([slope, self._height.diff(TIME)], self._symbols)

    def evaluate(self, digits: Digits, t: Any, x: NDArray[np.object_]) -> tuple[Any, Any]:
        """The height and its rate at time t and state x (d,), in many digits."""
        height, rate = self._point.run(digits, [t, *x])
        return height, rate

    def evaluate_in_doubles(self, t: float, x: NDArray[np.float64]) -> tuple[float, float]:
        """The same in doubles."""
        height, rate = self._point.run(self._doubles, [np.float64(t), *x])
        return height, rate

    def size(self, digits: Digits, t: Any, x: NDArray[np.object_]) -> float:
        """By how much t and x (d,) together change the height: rounding them changes it by eps times this."""
        square, drift = self._slopes.run(digits, [t, *x])
        return float(np.sqrt(float(square)) * float(np.abs(x).max()) + abs(float(drift * t)))

    def enclose(self, t: float, span: float, states: Polynomial, edges: NDArray[np.float64]) -> Enclosure:
        """Bounds on the height and its first two rates over equal pieces of a step.

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
        height, rate, second_rate = (u.spread(2 * m) for u in self._bounds.run(self._intervals, inputs))
        return Enclosure.of(height, rate, second_rate, span * radius)


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
    """Bounds on a height and its first two rates over m pieces of an arc."""

    height: Interval
    rate: Interval
    second_rate: Interval
    largest_height: float
    largest_rate: float

    @property
    def is_bounded(self) -> NDArray[np.bool_]:
        """Over which pieces (m,) the height has no pole, beyond which it would not go on as its rate tells."""
        return np.isfinite(self.height.low) & np.isfinite(self.height.high)

    @classmethod
    def of(cls, height: Interval, rate: Interval, second_rate: Interval, half: NDArray[np.float64]) -> Enclosure:
        """From bounds in the middle of each piece (the first m) and over all of it; `half` is half its time, (m,)."""
        m = len(half)
        here, there = slice(0, m), slice(m, None)
        away = around(np.zeros(m), half)
        rates = rate[there].within(rate[here] + second_rate[there] * away)
        heights = height[there].within(height[here] + rates * away)
        with np.errstate(all="ignore"):
            sizes = [np.abs(u.low[:m]) for u in (height, rate)]
            largest_height, largest_rate = (float(np.max(u, where=np.isfinite(u), initial=0.0)) for u in sizes)
        return cls(heights, rates, second_rate[there], largest_height, largest_rate)
