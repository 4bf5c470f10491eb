"""When the crossings of runs of one problem cease to correspond: then not all of them follow the solution."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

import core
from pwsviz.geometry.polyline_reduction import Floats

Integers = NDArray[np.int64]

__all__ = ["Parting", "parting"]

BRIEF = 0.01
"""Time, relative to the mean time between crossings, within which several count as one: at a corner, at a touch, and
where bounces accumulate, runs that differ by round-off alone may not have the same ones."""


@dataclass(frozen=True)
class Parting:
    """From when on crossings of runs do not correspond to those of one of them."""

    agreeing: str
    """The integrator of that run, which agrees longest with others."""
    parted: tuple[tuple[str, float], ...]
    """The integrators of the other runs that part from it, and when, in this order."""


def parting(runs: Mapping[str, core.Trajectory]) -> Parting | None:
    """Return which of the runs, given by their integrators, part, and when; None if no two of them do.

    Crossings correspond if they have the same number in their runs, the same mode is entered, and each is nearer in
    time to the other than to the crossings before and after that; those in quick succession count as one. The last may
    fall beyond the end of one run alone.
    """
    pairs = {(one, other): _time(runs[one], runs[other]) for one, other in combinations(runs, 2)}
    times: dict[str, dict[str, float]] = {one: {} for one in runs}
    for (one, other), t in pairs.items():
        times[one][other] = times[other][one] = t
    agreeing = max(times, key=lambda one: sorted(times[one].values(), reverse=True))
    parted = sorted((t, other) for other, t in times[agreeing].items() if np.isfinite(t))
    return Parting(agreeing, tuple((other, t) for t, other in parted)) if parted else None


def _time(one: core.Trajectory, other: core.Trajectory) -> float:
    """Return when two runs part; infinity if they do not."""
    end = min(one.t[-1], other.t[-1])
    mean = (end - one.t[0]) / max(1, *(np.count_nonzero(run.crossings.passed.t <= end) for run in (one, other)))
    (few, modes), (many, others) = sorted(
        (_met(run, end, BRIEF * mean) for run in (one, other)), key=lambda met: len(met[0])
    )
    n = len(few)
    between = np.minimum(_to_neighbours(few), _to_neighbours(many)[:n])
    apart = (modes != others[:n]) | (abs(few - many[:n]) > between / 2)
    if apart.any():
        k = int(np.argmax(apart))
        return float(min(few[k], many[k]))
    if len(many) > n and end - many[n] > mean:
        return float(many[n])
    return np.inf


def _met(run: core.Trajectory, end: float, brief: float) -> tuple[Floats, Integers]:
    """Return the (k,) times of crossings up to an end, and the modes entered; of several in quick succession, the last.

    If these lead back to where they began, as at a touch, none is returned.
    """
    met = run.crossings.passed
    last = np.flatnonzero(np.append(np.diff(met.t) > brief, True)[: len(met)] & (met.t <= end))
    mode = met.mode[last]
    led_on = (mode != np.concatenate([run.mode[:1], mode[:-1]])) | (met.kind[last] == "jump")
    return met.t[last][led_on], mode[led_on]


def _to_neighbours(t: Floats) -> Floats:
    """Return the (k,) times from each crossing to the nearer of those before and after it."""
    gaps = np.concatenate([[np.inf], np.diff(t), [np.inf]])
    nearer: Floats = np.minimum(gaps[:-1], gaps[1:]) if len(t) else t
    return nearer
