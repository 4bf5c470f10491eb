"""Test, on some steps of a run, whether they are short enough to resolve the field, g and event functions."""

from __future__ import annotations

from itertools import chain, islice

import numpy as np
from numpy.typing import NDArray

from core.diagnostics.close_zeros import zeros_too_close
from core.diagnostics.departures import APART, departures, too_long_for_the_field
from core.diagnostics.doubtful_steps import doubtful_steps, pushed_steps
from core.diagnostics.examined_steps import NEAR, Steps
from core.diagnostics.lost_order import too_long_for_the_order
from core.diagnostics.missed_crossings import hides, too_long_for_g
from core.diagnostics.missed_events import too_long_for_events
from core.diagnostics.unlike_steps import stretches, unlike_steps
from core.integration.trajectory import Status, Trajectory
from core.kernels.arrays import Floats
from core.methods import METHODS

__all__ = ["RUNS_AWAY", "resolvable", "unresolved"]

RUNS_AWAY = (Status.ESCAPED, Status.UNSTABLE)
"""How runs end in which the numerical solution grows without bound."""

#: Steps before such an end in which steps of one size resolve nothing: at a pole, the time left is the time scale.
_LAST_STEPS = 64.0
#: Most steps from entries into a mode that are examined, besides the steps kept by the loop.
_MOST_ENTRIES = 64


def unresolved(run: Trajectory) -> tuple[str, ...]:
    """Say where steps are too long for g, so that crossings may have been missed, or for the field.

    Returns
    -------
    tuple of str
        () where all steps examined are short enough, else warnings, the more serious first.
    """
    samples = run.samples
    if samples is None:
        return ()
    kept = Steps.towards_the_end(run, samples[:, 0], samples[:, 3:], samples[:, 1].astype(np.int64), samples[:, 2])
    if run.status in RUNS_AWAY:  # no step is short enough where the solution escapes
        return tuple(too_long_for_g(kept, _hides_before_it_runs_away(kept)))
    first, doubtful = _first_steps(run), _at_rows(run, doubtful_steps(run))
    pushed = _at_rows(run, pushed_steps(run)).with_others(first) if run.record == "steps" else kept
    of_g = (words for steps in (kept, first, doubtful) for words in too_long_for_g(steps, hides(steps)))
    of_events = (words for steps in (kept, doubtful) for words in too_long_for_events(steps))
    of_zeros = zeros_too_close(run)
    groups = (kept, _unlike(run), first)
    of_field = chain(too_long_for_the_field(groups, pushed), too_long_for_the_order(groups))
    return (*islice(of_g, 1), *dict.fromkeys(of_events), *of_zeros, *islice(of_field, 1))


def resolvable(run: Trajectory, t: Floats) -> NDArray[np.bool_]:
    """Whether steps of the size of a run could resolve the solution at times: not just before it grows without bound.

    A method that chooses its steps takes shorter ones there.
    """
    last = 0.0 if METHODS[run.method].adaptive or run.status not in RUNS_AWAY else _LAST_STEPS * run.tau
    return np.asarray(np.abs(run.t[-1] - t) >= last)


def _unlike(run: Trajectory) -> Steps:
    """Steps that are least like the one before."""
    return _unlike_recorded(run) if run.record == "steps" else _unlike_made_again(run)


def _unlike_made_again(run: Trajectory) -> Steps:
    """Some of a run that has not recorded its steps, in the stretches that the loop has kept."""
    none = Steps(run, np.empty(0), np.empty((0, run.system.dimension)), np.empty(0, dtype=np.int64), np.empty(0))
    made = stretches(run, none.states)
    if not made.t.shape[1] > 2:
        return none
    rows, columns = made.least_like()
    t, x = made.t[rows, columns], made.x[rows, columns]
    return Steps.towards_the_end(run, t, x, made.mode[rows], made.t[rows, columns + 1] - t)


def _unlike_recorded(run: Trajectory) -> Steps:
    """Of all steps of a run."""
    k = unlike_steps(run) if not METHODS[run.method].adaptive else np.empty(0, dtype=np.intp)
    k = k[run.mode[k] >= 0]
    h = run.t[k + 1] - run.t[k]
    cut = run.segment[k + 1] != run.segment[k]
    h[cut] = run.crossings.t[run.segment[k[cut]]] - run.t[k[cut]]
    return Steps.towards_the_end(run, run.t[k], run.x[k], run.mode[k], h)


def _at_rows(run: Trajectory, k: NDArray[np.intp]) -> Steps:
    """Those that begin at some rows of a run."""
    return Steps.towards_the_end(run, run.t[k], run.x[k], run.mode[k], run.t[k + 1] - run.t[k])


def _first_steps(run: Trajectory) -> Steps:
    """Steps of the run's size from where it has entered a side, and those that it made there, which are shorter."""
    crossings = run.crossings
    count = 0 if METHODS[run.method].adaptive else len(crossings)
    k = np.unique(np.linspace(0, count - 1, _MOST_ENTRIES).astype(np.int64)) if count > 0 else np.empty(0, np.int64)
    span = np.append(crossings.t[1:], run.t[-1])[k] - crossings.t[k]
    if run.record == "steps":
        made = run.t[np.minimum(np.searchsorted(run.segment, k + 1), len(run.t) - 1)] - crossings.t[k]
        shorter = (np.abs(made) < np.abs(span)) & (made * span > 0.0)
        k, span = np.append(k, k[shorter]), np.append(span, made[shorter])
    goes_on = (crossings.mode[k] >= 0) & (span != 0.0)
    k, span = k[goes_on], span[goes_on]
    return Steps.towards_the_end(run, crossings.t[k], crossings.x_after[k], crossings.mode[k], span)


def _hides_before_it_runs_away(steps: Steps) -> NDArray[np.bool_]:
    """As `hides`, without the last steps, each faster than the one before, none of which resolves g or the field.

    Of a step that a crossing cuts, the part before it is not asked whether it does.
    """
    hidden, found = hides(steps), departures(steps)
    speed = np.linalg.norm(found.way, axis=1) / np.abs(steps.h)
    with np.errstate(all="ignore"):
        astray = hides(steps, beyond=True) | ~(found.apart <= APART * found.way.max(axis=1, keepdims=True)).all(axis=1)
        astray |= np.abs(steps.h) < (1.0 - NEAR) * (0.0 if steps.method.adaptive else steps.run.tau)
        astray[:-1] &= ~(speed[1:] < speed[:-1])
    last = len(astray) - int(np.argmin(astray[::-1])) if len(astray) and not astray.all() else 0
    hidden[last:] = False
    return hidden
