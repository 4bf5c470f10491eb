"""Search steps for features of a height that are narrower than the distances of the places at which it is sampled.

Between two places the state follows the cubic with its values and rates there, within a box. Where bounds on the height
over the box do not tell that it is positive, the piece is cut into shorter ones, in smaller boxes. If the height is
negative throughout a box, it has two zeros there: a pair of crossings that no place has shown. What is narrower than a
thousandth of the bend of the way between two places stays unseen: so far may the state be from the cubic.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from sympy import Expr, Symbol

from core.kernels.arrays import Floats
from core.symbolic.intervals import Interval, Intervals
from core.symbolic.program import Program

__all__ = ["Dips", "Way", "dips_between", "doubts"]

#: Parts into which a piece is cut.
_PARTS = 8
#: How often: the shortest piece is 2⁻³⁰ of that between two places.
_CUTS = 10
#: Most pieces that are cut at a time, those with the lowest bounds.
_MOST = 512
#: Distance of the state from the cubic, as part of the largest distance of this from the straight way; over a step.
_BESIDE, _BESIDE_STEP = 2.0**-10, 2.0**-4


class Way(NamedTuple):
    """Places in k steps, n in each."""

    times: Floats
    """(k, n)."""
    states: Floats
    """(k, n, d)."""
    rates: Floats
    """(k, n, d) of the states in time."""


class _Cubics(NamedTuple):
    """Time and state between neighbouring places as cubics of a part from 0 to 1, (m, 1 + d) each."""

    coefficients: Floats
    """(4, m, 1 + d), the lowest power first."""
    bend: Floats
    """Largest second derivative."""

    @classmethod
    def of(cls, way: Way) -> _Cubics:
        """Between all neighbouring places, step by step."""
        points = np.concatenate([way.times[..., None], way.states], axis=2)
        slopes = np.concatenate([np.ones_like(way.times)[..., None], way.rates], axis=2)
        span = np.diff(way.times)[..., None]
        begin, go, first, last = points[:, :-1], np.diff(points, axis=1), span * slopes[:, :-1], span * slopes[:, 1:]
        rows = np.stack([begin, first, 3.0 * go - 2.0 * first - last, first + last - 2.0 * go])
        rows = rows.reshape(4, -1, points.shape[2])
        second = 2.0 * np.abs(np.stack([rows[2], rows[2] + 3.0 * rows[3]]))
        return cls(rows, second.max(axis=0))

    def boxes(
        self, number: NDArray[np.intp], begin: Floats, width: float, slack: float = _BESIDE
    ) -> tuple[Floats, Floats]:
        """Lower and upper ends (p, 1 + d) of boxes around pieces of cubics that begin at parts (p,)."""
        a, b = (self._at(number, part[:, None]) for part in (begin, begin + width))
        beside = self.bend[number] * (0.125 * (width**2 + slack)) + np.spacing(np.maximum(np.abs(a), np.abs(b)))
        return np.minimum(a, b) - beside, np.maximum(a, b) + beside

    def _at(self, number: NDArray[np.intp], part: Floats) -> Floats:
        c0, c1, c2, c3 = self.coefficients[:, number]
        return np.asarray(c0 + part * (c1 + part * (c2 + part * c3)))


class Dips(NamedTuple):
    """What bounds tell of a height in k steps, between the places of each."""

    found: NDArray[np.bool_]
    """(k,): it is negative somewhere between places at which it is positive."""
    none: NDArray[np.bool_]
    """(k, n - 1): it is positive throughout, from one place to the next."""


def dips_between(
    height: Expr, symbols: Sequence[Symbol], way: Way, parameters: Floats, wanted: NDArray[np.bool_]
) -> Dips:
    """Search steps for pairs of zeros of a height between places at which it is positive.

    Parameters
    ----------
    height : expression
        In the symbols.
    symbols : sequence of symbols
        Time, the d variables, and the parameters.
    way : Way
        The places.
    parameters : (m,) array
        Values of the parameters.
    wanted : (k, n - 1) array of bool
        Between which places to look.

    Returns
    -------
    Dips
    """
    found, none = np.zeros(len(wanted), dtype=bool), wanted.ravel().copy()
    with np.errstate(all="ignore"):
        cubics, search = _Cubics.of(way), _Search(height, symbols, parameters)
        none &= np.isfinite(cubics.coefficients).all(axis=(0, 2))
        number, row = np.flatnonzero(none), np.repeat(np.arange(len(wanted)), wanted.shape[1])
        begin, width = np.zeros(len(number)), 1.0
        for _ in range(_CUTS + 1):
            low, high = search.bounds(*cubics.boxes(number, begin, width))
            found[row[number[high < 0.0]]] = True
            undecided = np.flatnonzero(~(low > 0.0) & ~found[row[number]])
            if len(undecided) > _MOST:
                lowest = np.argpartition(np.nan_to_num(low[undecided], nan=-np.inf), _MOST)
                none[number[undecided[lowest[_MOST:]]]] = False
                undecided = undecided[lowest[:_MOST]]
            width /= _PARTS
            begin = (begin[undecided, None] + width * np.arange(_PARTS)).ravel()
            number = np.repeat(number[undecided], _PARTS)
            if not len(number):
                break
        none[number] = False
    return Dips(found, none.reshape(wanted.shape) & ~found[:, None])


def doubts(height: Expr, symbols: Sequence[Symbol], way: Way, parameters: Floats, values: Floats) -> Floats:
    """How much bounds on a height leave in doubt that it is positive throughout steps at whose ends it is.

    Parameters
    ----------
    height, symbols, parameters
        As for `dips_between`.
    way : Way
        The two ends of each of k steps.
    values : (k, 2) array
        The height there.

    Returns
    -------
    (k,) array
        0 where it is positive throughout, or not at both ends; else up to 1: the lesser value at an end as part of its
        distance from the lower bound. Near a zero that a step ends at, there is little.
    """
    with np.errstate(all="ignore"):
        number = np.arange(len(values))
        boxes = _Cubics.of(way).boxes(number, np.zeros(len(values)), 1.0, _BESIDE_STEP)
        low, _ = _Search(height, symbols, parameters).bounds(*boxes)
        least = values.min(axis=1)
        return np.nan_to_num(np.where((least > 0.0) & (low <= 0.0), least / (least - low), 0.0))


class _Search:
    """Bounds on a height over boxes of time and state."""

    def __init__(self, height: Expr, symbols: Sequence[Symbol], parameters: Floats) -> None:
        self._program, self._arithmetic = Program([height], symbols), Intervals()
        self._parameters = [Interval(value, value) for value in np.asarray(parameters, dtype=float)[:, None]]

    def bounds(self, low: Floats, high: Floats) -> tuple[Floats, Floats]:
        """Lower and upper bounds (p,) over boxes with these ends (p, 1 + d); nan where it is not defined throughout."""
        inputs = [*map(Interval, low.T, high.T), *self._parameters]
        (height,) = self._program.run(self._arithmetic, inputs)
        height = height.spread(len(low))
        return height.low, height.high
