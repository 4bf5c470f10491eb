"""Interval arithmetic on arrays: bounds on expressions, such as g over short times from bounds on the state there.

Every operation is rounded outwards by more than its round-off, so that the result encloses the true value. Where an
operation is not defined throughout an interval, its bounds are infinite or nan; no comparison with them succeeds, so
nothing is concluded from them. Source: Moore, Kearfott, Cloud, *Introduction to Interval Analysis* (2009).
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from core.symbolic.program import Constant, Doubles

__all__ = ["Interval", "Intervals", "around"]

Bounds: TypeAlias = NDArray[np.float64]

#: Relative widening of the value of a function: numpy's err by less than four units in the last place.
_OUTWARDS = 2.0**-50
#: Absolute widening of the value of a function, for values near 0: larger than any error by underflow.
_TINY = 1e-300


class Interval:
    """The numbers from `low` (n,) to `high` (n,)."""

    def __init__(self, low: Bounds, high: Bounds) -> None:
        self.low, self.high = low, high

    def __add__(self, other: Interval) -> Interval:
        return _outwards(self.low + other.low, self.high + other.high)

    def __mul__(self, other: Interval) -> Interval:
        p, q, r, s = self.low * other.low, self.low * other.high, self.high * other.low, self.high * other.high
        low, high = np.minimum(np.minimum(p, q), np.minimum(r, s)), np.maximum(np.maximum(p, q), np.maximum(r, s))
        return _outwards(low, high)

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low)

    def within(self, other: Interval) -> Interval:
        """The intersection of two enclosures of the same number; a bound that is nan is ignored."""
        return Interval(np.fmax(self.low, other.low), np.fmin(self.high, other.high))

    def spread(self, n: int) -> Interval:
        """The interval broadcast to n."""
        return Interval(np.broadcast_to(self.low, n), np.broadcast_to(self.high, n))

    def __getitem__(self, rows: slice) -> Interval:
        return Interval(self.low[rows], self.high[rows])


class Intervals:
    """The arithmetic of n intervals at once, for `Program.run`."""

    def __init__(self) -> None:
        self._doubles = Doubles()
        self._numbers: dict[Constant, Interval] = {}

    def number(self, constant: Constant) -> Interval:
        """An enclosure of the constant, around the nearest double."""
        if constant not in self._numbers:
            value = np.asarray(self._doubles.number(constant))
            self._numbers[constant] = _widely(value, value)
        return self._numbers[constant]

    def power(self, base: Interval, exponent: Constant) -> Interval:
        """A power; nan where the base of a root may be negative."""
        low, high, n = base.low, base.high, self._doubles.number(exponent)
        if n == 2:
            return _square(low, high)
        if exponent.integer is None:
            low, high = np.where(low >= 0, low, np.nan), np.where(low >= 0, high, np.nan)
        elif exponent.integer % 2 == 0:
            low, high = _sizes(low, high)
        power = _widely_at_least(low ** abs(n), high ** abs(n), -np.inf if n % 2 == 1 else 0.0)
        return _reciprocal(power) if n < 0 else power

    def call(self, name: str, *arguments: Interval) -> Interval:
        """A function, also of those with which laws are written near zeros."""
        low, high = arguments[0].low, arguments[0].high
        if name == "magnitude":
            return Interval(*_sizes(low, high))
        if name == "Choice":
            return _chosen(*arguments)
        if name == "sin":
            return _sine(low, high)
        if name == "cos":
            return _cosine(low, high)
        if name == "tan":
            pole = np.floor((high + _slack(high)) / np.pi - 0.5) != np.floor((low - _slack(low)) / np.pi - 0.5)
            return _widely(np.where(pole, -np.inf, np.tan(low)), np.where(pole, np.inf, np.tan(high)))
        if name == "cosh":
            least, largest = _sizes(low, high)
            return _widely(np.cosh(least), np.cosh(largest))
        if name == "log":
            low = np.where(low > 0, low, np.nan)
            return _widely(np.log(low), np.log(np.where(np.isnan(low), np.nan, high)))
        rising = {"exp": np.exp, "sinh": np.sinh, "tanh": np.tanh}[name]
        return _widely_at_least(rising(low), rising(high), 0.0 if name == "exp" else -np.inf)


def _outwards(low: Bounds, high: Bounds) -> Interval:
    """The interval between bounds that were rounded to nearest."""
    return Interval(np.nextafter(low, -np.inf), np.nextafter(high, np.inf))


def _widely(low: Bounds, high: Bounds) -> Interval:
    """The interval between bounds that may err by some units in the last place."""
    return Interval(low - (_OUTWARDS * np.abs(low) + _TINY), high + (_OUTWARDS * np.abs(high) + _TINY))


def _widely_at_least(low: Bounds, high: Bounds, least: float) -> Interval:
    wide = _widely(low, high)
    return Interval(np.maximum(wide.low, least), wide.high)


def _chosen(far: Interval, near: Interval, other: Interval) -> Interval:
    """`near` where `far` is not positive, else `other`; where it may be either, what encloses both."""
    first, second = far.high <= 0.0, far.low > 0.0
    low, high = np.minimum(near.low, other.low), np.maximum(near.high, other.high)
    return Interval(
        np.where(first, near.low, np.where(second, other.low, low)),
        np.where(first, near.high, np.where(second, other.high, high)),
    )


def _sizes(low: Bounds, high: Bounds) -> tuple[Bounds, Bounds]:
    """The least and largest size of the numbers between the bounds."""
    a, b = np.abs(low), np.abs(high)
    return np.where((low <= 0) & (high >= 0), 0.0, np.minimum(a, b)), np.maximum(a, b)


def _square(low: Bounds, high: Bounds) -> Interval:
    least, largest = _sizes(low, high)
    square = _outwards(least * least, largest * largest)
    return Interval(np.maximum(square.low, 0.0), square.high)


def _reciprocal(x: Interval) -> Interval:
    through = (x.low <= 0) & (x.high >= 0)
    one_sided = _outwards(1 / x.high, 1 / x.low)
    return Interval(np.where(through, -np.inf, one_sided.low), np.where(through, np.inf, one_sided.high))


def _slack(x: Bounds) -> Bounds:
    """Bound on the error of multiples of π near x when computed from the double nearest to π."""
    return _OUTWARDS * (1 + np.abs(x))


def _reaches(low: Bounds, high: Bounds, phase: float) -> NDArray[np.bool_]:
    """Whether phase + 2πk lies between the bounds for some integer k; True where that is uncertain."""
    first = np.ceil((low - _slack(low) - phase) / (2 * np.pi))
    return ~(phase + 2 * np.pi * first > high + _slack(high))


def _sine(low: Bounds, high: Bounds) -> Interval:
    ends = _widely(np.minimum(np.sin(low), np.sin(high)), np.maximum(np.sin(low), np.sin(high)))
    return _wave(ends, _reaches(low, high, -np.pi / 2), _reaches(low, high, np.pi / 2))


def _cosine(low: Bounds, high: Bounds) -> Interval:
    ends = _widely(np.minimum(np.cos(low), np.cos(high)), np.maximum(np.cos(low), np.cos(high)))
    return _wave(ends, _reaches(low, high, np.pi), _reaches(low, high, 0.0))


def _wave(ends: Interval, trough: NDArray[np.bool_], crest: NDArray[np.bool_]) -> Interval:
    return Interval(
        np.where(trough, -1.0, np.maximum(ends.low, -1.0)), np.where(crest, 1.0, np.minimum(ends.high, 1.0))
    )


def around(center: Bounds, radius: Bounds) -> Interval:
    """The interval of a radius around a number."""
    return _outwards(center - radius, center + radius)
