"""States of a run at times between its steps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from core.integration.crossings import Integers
from core.integration.dense_output import Stepper, Track
from core.kernels.arrays import Floats
from core.methods import METHODS

if TYPE_CHECKING:
    from core.integration.trajectory import Trajectory

__all__ = ["states_at"]


def states_at(run: Trajectory, times: Floats, before: bool) -> Floats:
    """States (n, d) at times (n,): see `Trajectory.at`."""
    _check_times(run, times)
    x = _kept(run, times) if run.record != "steps" else _between(run, times)
    if len(run.crossings) and (before or run.record != "steps"):
        found, k = _matches(run.crossings.t, times, first=before)
        x[found] = (run.crossings.x if before else run.crossings.x_after)[k]
    if (missing := np.isnan(x).any(axis=1)).any():
        raise ValueError(_missing(run, float(times[missing][0])))
    return x


def _check_times(run: Trajectory, times: Floats) -> None:
    ends = [float(t) for t in (run.t[0], *run.t[-2:])]
    outside = (times < min(ends)) | (times > max(ends))
    if outside.any():
        span = f"{ends[0]!r} … {ends[-1]!r}"
        raise ValueError(f"t = {float(times[outside][0])!r} is outside the run, which goes over t = {span}")


def _kept(run: Trajectory, times: Floats) -> Floats:
    """States at times that were recorded, nan at others."""
    x = np.full((len(times), run.x.shape[1]), np.nan)
    found, k = _matches(run.t, times)
    x[found] = run.x[k]
    return x


def _between(run: Trajectory, times: Floats) -> Floats:
    """States at times between recorded steps, nan where there is no solution."""
    entered = np.concatenate([run.mode[:1], run.crossings.mode])
    # A perturbation may have moved the crossing at which the run stopped back beyond the last step.
    back = len(run.t) > 2 and (run.t[-1] - run.t[-2]) * (run.t[-2] - run.t[0]) < 0.0
    n = len(run.t) - back
    rows = run.t[:n], run.x[:n], run.mode[:n], run.segment[:n]
    track = Track(*rows, run.entered_t, run.entered_x, entered)
    along = times if track.t[-1] >= track.t[0] else -times
    order = None if (along[1:] >= along[:-1]).all() else np.argsort(along)
    stepper = Stepper(run.system, METHODS[run.method], run.tolerance)
    states = found = stepper.find(track, times if order is None else times[order]).x
    if order is not None:
        states = np.empty_like(found)
        states[order] = found
    if back:
        states[times == run.t[-1]] = run.x[-1]
    return states


def _missing(run: Trajectory, t: float) -> str:
    if run.record == "steps":
        return f"t = {t!r}: the equations of the step to there have no real solution; take a smaller tau"
    return (
        f"t = {t!r}: the run has not recorded its steps (record={run.record!r}), so only the times it "
        'has kept are available; integrate with record="steps", or with t_eval at the times wanted'
    )


def _matches(known: Floats, times: Floats, first: bool = False) -> tuple[NDArray[np.bool_], Integers]:
    """Which times are among known ones, and their indices there: the last of equal ones, or the first."""
    order = np.argsort(known, kind="stable")
    ordered = known[order]
    k = np.searchsorted(ordered, times, "left") if first else np.searchsorted(ordered, times, "right") - 1
    k = np.clip(k, 0, len(known) - 1)
    found = ordered[k] == times
    return found, order[k[found]]
