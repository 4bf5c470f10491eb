"""Search steps for pushes of the field that are narrower than the distances of the places at which it is sampled.

Where bounds on a rate over a box around the way between two places do not tell that it stays below twice its largest
value at the places of the step, the piece is cut into shorter ones, in smaller boxes. If the rate is larger throughout
a box, it has a peak there, and its integral over that is what the step has missed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from core.diagnostics.boxes import CUTS, PARTS, Bounds, Cubics, Way
from core.kernels.arrays import Floats
from core.symbolic.expressions import TIME
from core.system import PiecewiseSystem

__all__ = ["PEAK", "excess", "pushes"]

PEAK = 2.0
"""Size of a rate, in units of its largest at some places, above which it has a peak between them."""

#: Most pieces that are cut at a time, those with the largest bounds.
_MOST = 512
#: Places in a peak from which on shorter steps, from place to place, resolve it.
_CHANCE = 4
#: Relative to the state, what adds nothing to it; and the least rate that is looked for, beside a state of zero.
_ROUNDING, _LEAST = 2.0**-52, 1e-290
#: In place of a bound that is infinite.
_LARGEST = np.finfo(float).max
#: Places on both sides of a piece in which a peak is, at distances that double from one to the next, and within it.
_DOUBLINGS, _WITHIN = 40, 9


def pushes(system: PiecewiseSystem, number: int, way: Way) -> Floats:
    """What peaks of the field between places, or about a few of them, add to each coordinate.

    Parameters
    ----------
    system : PiecewiseSystem
        The system.
    number : int
        Of the mode.
    way : Way
        Places in k steps.

    Returns
    -------
    (k, d) array
        Integrals over time of what a rate exceeds its largest value at the places of its step by; of each coordinate
        the highest peak alone is counted.
    """
    shown = _shown(way)
    with np.errstate(all="ignore"):
        cubics = Cubics.of(way)
        of, begin, width = _highest(_bounds(system, number), cubics, _level(way))
        found: Floats = np.zeros(shown.shape)
        for row, k in np.argwhere(of >= 0).tolist():
            t, x = _about(cubics, of[row, k], begin[row, k], width[row, k])
            field = system.laws.mode(number).written.field
            rates = system.laws.evaluate(("field", number), field, t, x, system.parameter_array)
            found[row, k] = np.trapezoid(np.maximum(np.abs(rates[:, k]) - shown[row, k], 0.0), np.abs(t - t[0]))
    return found


def excess(system: PiecewiseSystem, number: int, way: Way) -> Floats:
    """By how much bounds on rates in steps (k,) exceed twice those at both ends, relative to these; 0 if nowhere."""
    with np.errstate(all="ignore"):
        low, high = _bounds(system, number).over(Cubics.of(way).boxes_of_all())
        part = np.maximum(high, -low) / _level(way)
        return np.asarray(np.nan_to_num(part.max(axis=1) - 1.0, nan=0.0, posinf=_LARGEST).clip(0.0))


def _level(way: Way) -> Floats:
    """Size of each rate in each step (k, d) above which it has a peak: one that adds more than rounding does."""
    long = np.abs(way.times[:, -1] - way.times[:, 0])[:, None]
    size = np.abs(way.states).max(axis=(0, 1), initial=0.0)
    return np.asarray(np.maximum(PEAK * _shown(way), _ROUNDING * size / long).clip(_LEAST))


def _shown(way: Way) -> Floats:
    """Largest size of each rate in each step (k, d) at its ends, or at more places than may by chance lie in a peak."""
    rates = np.nan_to_num(np.abs(way.rates), nan=np.inf)
    inner = np.partition(rates, -_CHANCE, axis=1)[:, -_CHANCE] if rates.shape[1] > _CHANCE else 0.0
    return np.asarray(np.maximum(rates[:, [0, -1]].max(axis=1), inner))


def _bounds(system: PiecewiseSystem, number: int) -> Bounds:
    """Bounds on the rates of all coordinates in a mode."""
    laws = system.laws
    return Bounds(laws.mode(number).field, (TIME, *laws.x, *laws.p), system.parameter_array)


def _highest(bounds: Bounds, cubics: Cubics, level: Floats) -> tuple[NDArray[np.intp], Floats, Floats]:
    """Cubic, begin and width of a piece in which a rate is above its level (k, d); cubic -1 where there is none."""
    row = np.repeat(np.arange(len(level)), len(cubics.bend) // max(len(level), 1))
    of, at, long = np.full(level.shape, -1), np.zeros_like(level), np.zeros_like(level)
    number, level = np.flatnonzero(cubics.known), level.copy()
    begin, width = np.zeros(len(number)), 1.0
    for _ in range(CUTS + 1):
        low, high = bounds.over(cubics.boxes(number, begin, width))
        least, most = np.nan_to_num(np.maximum(low, -high), nan=0.0), np.maximum(high, -low)
        piece, k = np.nonzero(least > level[row[number]])
        piece, k = (one[np.argsort(least[piece, k], kind="stable")] for one in (piece, k))  # the highest is kept
        place = row[number[piece]], k
        of[place], at[place], long[place], level[place] = number[piece], begin[piece], width, PEAK * least[piece, k]
        there = ~(most <= level[row[number]])
        undecided = np.flatnonzero(there.any(axis=1))
        if len(undecided) > _MOST:
            largest = np.nan_to_num(most[undecided] / level[row[number[undecided]]], nan=np.inf).max(axis=1)
            undecided = undecided[np.argpartition(-largest, _MOST)[:_MOST]]
        width /= PARTS
        begin = (begin[undecided, None] + width * np.arange(PARTS)).ravel()
        number = np.repeat(number[undecided], PARTS)
        if not len(number):
            break
    return of, at, long


def _about(cubics: Cubics, number: int, begin: float, width: float) -> tuple[Floats, Floats]:
    """Times (p,) and states (p, d) on a cubic, dense in a piece of it and ever less so away from that."""
    away = width * 2.0 ** np.arange(_DOUBLINGS)
    parts = np.concatenate([begin - away, np.linspace(begin, begin + width, _WITHIN), begin + width + away])
    parts = np.unique(parts.clip(0.0, 1.0))
    points = cubics.at(np.full(len(parts), number), parts[:, None])
    return points[:, 0], points[:, 1:]
