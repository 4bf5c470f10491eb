"""Warn where small errors grow to the size of the solution: rounding decides what a run shows.

Another run starts anew beside it at many instants. How far they are apart at the next one tells how errors grow from
one to the other; at each, those of rounding are added. This is measured, in the direction into which the errors before
have grown, and not a bound.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from core.diagnostics.kept_at_zero import with_units_of_others
from core.diagnostics.resolution import RUNS_AWAY
from core.integration.run_settings import Settings
from core.integration.runner import Runner
from core.integration.trajectory import Status, Trajectory
from core.kernels.arrays import Floats
from core.methods import METHODS

__all__ = ["amplified", "tells_of_growth"]

#: How a warning begins of errors that do not only add up.
_GROW = "Small errors grow by a factor of "
#: Error, relative to the range of a variable so far, that is told.
_SPOILT = 0.1
#: Error, relative to the same, from which on the range is no longer widened: the run's own error may do so.
_WIDENED = 1e-3
#: Range of a variable, relative to its size, that may be rounding.
_RESTS = 2.0**-44
#: Least range of a variable, below which numbers have fewer digits than others, or errors beside it have.
_LEAST = float(np.finfo(float).tiny) / 2.0**-52
#: Factor from which on errors are said to grow: else they add up.
_SOME = 10.0
#: Distance of the other run, relative to the same: errors are small beside it, and it grows in proportion.
_BESIDE = 1e-7
_EPS = 2.0**-52
#: Number of equally spaced instants …
_INSTANTS = 32
#: … which are this part of their distance earlier, so that impacts at even times are not among them.
_UNEVEN = 0.381966
#: Instants within which an error must not have grown to that, or the time up to there is divided anew …
_EARLY = 12
#: … so often at most.
_ROUNDS = 6
#: Most steps, times d: of longer runs, the beginning is examined.
_MOST_STEPS = 200_000


def amplified(run: Trajectory) -> Iterator[str]:
    """Say from when on a run depends on how it was rounded, or stepped.

    Yields
    ------
    str
        Sentences without the last full stop; none where small errors stay small.
    """
    if run.t[-1] == run.t[0] or run.status in RUNS_AWAY:  # at a pole every error grows without bound
        return
    growth = _growth(run)
    if growth.spoilt is not None:
        yield (
            f"From t = {growth.spoilt:.3g} on, the states need not be those of the exact solution. "
            f"{_told(growth.factor)} until then. Rounding alone may then amount to a tenth of the range of the state. "
            "Averages, and the set that the orbit fills, may still be right"
        )


def _told(factor: float) -> str:
    return f"{_GROW}{factor:.0e}" if factor > _SOME else "Small errors add up"


def tells_of_growth(warning: str) -> bool:
    """Whether a warning says that small errors of a motion grow, as in chaos, and nothing against its steps."""
    return _GROW in warning


@dataclass(frozen=True)
class _Growth:
    """What the errors of a run have grown to."""

    factor: float
    """Largest factor between two instants."""
    spoilt: float | None
    """Time at which they are as large as the range of a variable; None if they are not."""


def _growth(run: Trajectory) -> _Growth:
    """The growth of the errors of rounding."""
    length = _examined(run)
    found = _Growth(1.0, None)
    for _ in range(_ROUNDS):
        times = run.t[0] + length * (np.arange(1, _INSTANTS + 1) - _UNEVEN) / (_INSTANTS - _UNEVEN)
        if length == run.t[-1] - run.t[0]:
            times[-1] = run.t[-1]
        again = _grown(run, times)
        if again.spoilt is None:
            return again if found.spoilt is None else found
        found = again
        if found.spoilt in times[_EARLY:]:
            break
        length = found.spoilt - run.t[0]
    return found


def _grown(run: Trajectory, times: Floats) -> _Growth:
    """The growth of errors over some times."""
    base = _fresh(run)
    low = high = base.x
    unspoilt = np.full(len(low), np.inf)
    error, factor, largest = _rounding(low), 1.0, 1.0
    for t in times.tolist():
        other = base.copy()
        if base.advance(t, keep_hits=False) is not Status.COMPLETED:
            break
        x = base.x
        low, high = np.minimum(low, x), np.maximum(high, x)
        size = with_units_of_others(run, _range(low, high))
        error, by = _propagated(other, t, x, error, size)
        other.release()
        factor = max(1.0, factor * by)
        largest = max(largest, factor)
        unspoilt = np.where(np.isfinite(unspoilt) & (np.abs(error) >= _WIDENED * size), unspoilt, size)
        if (np.abs(error) >= _SPOILT * unspoilt).any():
            return _Growth(largest, t)
    return _Growth(largest, None)


def _examined(run: Trajectory) -> float:
    """The length of time, signed, that is examined."""
    part = min(1.0, _MOST_STEPS / (max(run.steps, 1) * run.system.dimension))
    return float(part * (run.t[-1] - run.t[0]))


def _fresh(run: Trajectory) -> Runner:
    """The run anew, with room for as many crossings and steps as a finer one may need."""
    crossings = 2 * run.crossing_count + _INSTANTS
    steps = 2 * run.steps + 2 * crossings + _INSTANTS
    settings = Settings(run.tau, run.tolerance, max_crossings=crossings, max_steps=steps, slides=run.slides)
    return Runner(run.system, METHODS[run.method], float(run.t[0]), tuple(run.x[0].tolist()), settings)


def _range(low: Floats, high: Floats) -> Floats:
    """Ranges of the coordinates; inf for one that rests, but for rounding: no error is large beside it."""
    moves = high - low > np.maximum(_RESTS * np.maximum(np.abs(low), np.abs(high)), _LEAST)
    return np.asarray(np.where(moves, high - low, np.inf))


def _propagated(other: Runner, t: float, x: Floats, error: Floats, size: Floats) -> tuple[Floats, float]:
    """The error at a time t, where the state is x, of one before it, with that of rounding; and how it has grown."""
    before = float((np.abs(error) / size).max())
    if not 0.0 < before < np.inf:
        return _rounding(x), 1.0
    times = _BESIDE / before
    other.displace(times * error)
    if other.advance(t, keep_hits=False) is not Status.COMPLETED:
        return error, 1.0
    grown = (other.x - x) / times
    after = float((np.abs(grown) / size).max())
    return grown + _rounding(x), after / before


def _rounding(x: Floats) -> Floats:
    """An error by rounding of a state, of no symmetry: that of a symmetric start may be what grows."""
    error: Floats = _EPS * np.abs(x) * np.cos(2.4 * np.arange(len(x)))
    return error
