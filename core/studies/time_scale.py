"""The power of ten of time in which a system does something worth seeing, and not too much."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import TypeAlias

import numpy as np

from core.studies.external_solvers import EXTERNAL_SOLVERS, ManyCrossings, ScalarFunctions, Stopped, external_arcs
from core.system import PiecewiseSystem

__all__ = ["moderate_time"]

#: End time -> evaluations of g until then, and crossings.
Trial: TypeAlias = Callable[[float], tuple[int, int]]

#: Tolerance of the trial runs, of which only the number of steps is of interest.
_TOLERANCE = 1e-4
#: Evaluations of g in a run that shows something, in one that shows much, and in the longest.
_ENOUGH, _MUCH, _MOST = 30, 300, 1000
#: Crossings in the longest: a segment takes far longer to set up than a step, above all one of no length.
_CROSSINGS = 100
#: Powers of ten by which the time is lengthened or shortened, at most.
_LONGEST, _SHORTEST = 2, 4


def moderate_time(system: PiecewiseSystem, usual: float) -> float:
    """Return the time for which to run a system that nobody has run yet: `usual`, or that by a power of ten.

    SciPy's DOP853 evaluates g some five times a period of an oscillator at a loose tolerance, and ten times a crossing.
    If it does so many hundreds of times until `usual`, the time is shortened; if hardly ever, it is lengthened until
    there are more crossings, if that helps. The result follows from the declaration alone.

    Parameters
    ----------
    system : PiecewiseSystem
        At its parameter values; it starts at `x0`, at time 0.
    usual : float
        Time that suits a system whose rates are of the order of 1.
    """
    functions, x0 = ScalarFunctions(system), np.array(system.x0, dtype=float)
    if not functions.field[functions.first_mode(0.0, x0)](0.0, x0).any():
        return usual  # it rests; on a surface, the trial runs would meet that again and again
    trial = cache(partial(_trial, system))
    evaluations, crossings = trial(usual)
    if evaluations > _MOST:
        shorter = [usual / 10.0**k for k in range(1, _SHORTEST + 1)]
        found = _first(trial, shorter, _ENOUGH, _MUCH) or _first(trial, shorter, _ENOUGH, _MOST)
        return found or 10.0 * (_first(trial, shorter, 0, _MUCH) or usual / 10.0)  # it begins to do much
    longer = [usual * 10.0**k for k in range(1, _LONGEST + 1)] if evaluations < _ENOUGH else []
    return _first(trial, longer, _ENOUGH, _MUCH, crossings + 1) or usual


def _first(trial: Trial, times: list[float], least: int, most: int, crossings: int = 0) -> float | None:
    """Return the first of some times until which there are so many evaluations of g, and at least so many crossings."""
    for time in times:
        evaluations, met = trial(time)
        if least <= evaluations <= most and met >= crossings:
            return time
    return None


def _trial(system: PiecewiseSystem, end: float) -> tuple[int, int]:
    """Evaluations of g in a trial run, of which `_MOST` are enough, and crossings if it reaches the end."""
    done = 0

    def check() -> None:
        nonlocal done
        done += 1
        if done > _MOST:
            raise Stopped("enough is known")

    functions, x0 = ScalarFunctions(system, slides=not system.laws.jumps), np.array(system.x0, dtype=float)
    prepared = EXTERNAL_SOLVERS["scipy"].prepare(functions, _TOLERANCE, float(np.abs(x0).max()) or 1.0)
    try:
        with np.errstate(all="ignore"):
            arcs = external_arcs(functions, prepared, 0.0, end, x0, _CROSSINGS, check)
    except ManyCrossings:
        return _MOST + 1, _CROSSINGS
    except Stopped:  # at a pole, say: what happened until then counts
        return done, 0
    return done, arcs.crossings
