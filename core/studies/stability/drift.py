"""The drift of ψ in a long run."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TypeVar

import numpy as np

from core.integrate import integrate
from core.integration.trajectory import Status, Trajectory
from core.interface.cancelling import Cancel, raise_if
from core.interface.summary import Brief
from core.interface.tasks import GivenUp, as_completed
from core.kernels.arrays import Floats
from core.methods import METHODS
from core.studies.stability.plan import Plan
from core.transition.records import NO_MODE

__all__ = ["Drift", "count", "run"]

Item = TypeVar("Item")

#: Number of steps of the first piece of a run, which shows a result at once.
_FIRST = 100
#: Number of steps of the longest piece: some tenths of a second.
_LONGEST = 100_000
#: Number of equal parts of a piece, of each of which the largest error is kept.
_COLUMNS = 24
#: Most steps of a variable-step method, in units of those of size τ.
_ADAPTIVE = 4


@dataclass(frozen=True, eq=False, repr=False)
class Drift(Brief):
    """|Δψ| against time: the change of ψ by the integrator, summed over the segments of a run.

    It is computed in double-double at the ends of steps and at crossings; rounding each state to double contributes
    about eps times the size of ψ’s terms (`psi_size`).
    """

    tau: float
    """Step size; of a variable-step method, the largest allowed."""
    steps: int
    """Length of the run in steps of size τ."""
    t: Floats
    """(n,) ends of the parts of the time, measured from the start."""
    error: Floats
    """(methods, n) largest |Δψ| in each part; nan where not computed, or beyond the end of a run."""
    reached: Floats
    """(methods,) time, measured from the start, that each run has reached."""
    status: tuple[Status, ...]
    """(methods,) how the run ended; RUNNING where it has not yet."""
    message: tuple[str, ...]
    """(methods,) where and why it stopped; empty where it did not."""
    crossings: tuple[int, ...]
    """(methods,) number of crossings."""
    seconds: Floats
    """(methods,) processor time (s) in the loop."""


@dataclass(frozen=True, eq=False)
class _Piece:
    """State of a run after a piece of it, and the errors in that piece."""

    t: float
    x: tuple[float, ...]
    mode: int
    """Number of the mode in which it is."""
    offset: Floats
    """(m,) change of ψ so far."""
    error: Floats
    status: Status
    message: str
    crossings: int
    seconds: float


def count(plan: Plan) -> int:
    """Number of tasks."""
    return len(plan.methods) * (len(_edges(plan.steps)) - 1)


def run(plan: Plan, executor: Executor | None, cancel: Cancel | None) -> Iterator[Drift]:
    """Yield the results so far after each piece of each run: first pieces first, then second ones, and so on."""
    n, edges = len(plan.methods), _edges(plan.steps)
    parts = np.arange(1, _COLUMNS + 1) / _COLUMNS
    t = np.concatenate([a + (b - a) * parts for a, b in pairwise(edges)]) * plan.tau
    found = Drift(
        plan.tau, plan.steps, t, np.full((n, len(t)), np.nan), np.zeros(n), (Status.RUNNING,) * n, ("",) * n, (0,) * n,
        np.zeros(n),
    )  # fmt: skip
    laws = plan.system.laws
    count = laws.most_conserved_sliding if plan.sliding == "continue" else laws.most_conserved
    at = [_Piece(plan.t_span[0], plan.x0, NO_MODE, np.zeros(count), np.empty(0), Status.COMPLETED, "", 0, 0.0)] * n
    for number, (start, end) in enumerate(pairwise(edges)):
        given_up = GivenUp()
        going = [k for k in range(n) if at[k].status is Status.COMPLETED]
        span = (plan.t_span[0] + start * plan.tau, plan.t_span[0] + end * plan.tau)
        tasks = [(plan, plan.methods[k], span, at[k], end - start, given_up) for k in going]
        for which, piece in as_completed(_piece, tasks, executor, cancel, given_up):
            at[going[which]] = piece
            last = end == plan.steps
            found = _joined(found, going[which], number, piece, plan.t_span[0], last)
            yield found


def _edges(steps: int) -> list[int]:
    """Numbers of steps at which a run is cut into pieces: each tenfold the last up to the longest, then equal ones."""
    decades = [edge for edge in (0, _FIRST, 1_000, 10_000) if edge < steps]
    return [*decades, *range(_LONGEST, steps, _LONGEST), steps]


def _joined(drift: Drift, k: int, number: int, piece: _Piece, start: float, last: bool) -> Drift:
    """Return the drift with piece `number` of run k added."""
    error, reached, seconds = drift.error.copy(), drift.reached.copy(), drift.seconds.copy()
    reached[k] = piece.t - start
    error[k, number * _COLUMNS : (number + 1) * _COLUMNS] = piece.error
    seconds[k] += piece.seconds
    stopped = piece.status is not Status.COMPLETED
    status = piece.status if stopped or last else Status.RUNNING
    return replace(
        drift,
        error=error,
        reached=reached,
        seconds=seconds,
        status=_with(drift.status, k, status),
        message=_with(drift.message, k, piece.message if stopped else ""),
        crossings=_with(drift.crossings, k, drift.crossings[k] + piece.crossings),
    )


def _with(items: tuple[Item, ...], k: int, item: Item) -> tuple[Item, ...]:
    return (*items[:k], item, *items[k + 1 :])


def _piece(plan: Plan, method: str, span: tuple[float, float], before: _Piece, steps: int, cancel: Cancel) -> _Piece:
    """Run one piece, from where the one before has ended."""
    most = _ADAPTIVE * steps + _FIRST if METHODS[method].adaptive else steps + _FIRST
    laws = plan.system.laws
    region = None if before.mode == NO_MODE else laws.named_region(before.mode)
    part = integrate(
        plan.system, span, before.x, plan.tau, method, max_steps=most, max_crossings=most, transition=plan.transition,
        sliding=plan.sliding, cancel=cancel, region=region,
    )  # fmt: skip
    raise_if(cancel)
    x, change = tuple(map(float, part.x[-1])), before.offset + part.accumulated_error()
    change[part.sliding] = np.nan  # while it slides, g takes the place of ψ
    end = np.where(np.isnan(change[-1]), before.offset, change[-1])
    error = _column_errors(part.t, span, change)
    met = part.crossing_count - _resumed(part, before.mode, plan.tau)
    return _Piece(float(part.t[-1]), x, int(part.mode[-1]), end, error, part.status, part.outcome, met, part.seconds)


def _resumed(part: Trajectory, mode: int, tau: float) -> bool:
    """Whether the first thing that a piece meets is the slide during which the one before has ended.

    It begins off the surface by the rounding of a state, in the region there.
    """
    if mode < len(part.system.laws.regions) or part.mode[0] == mode or not len(part.crossings):
        return False
    return bool(part.crossings.mode[0] == mode and abs(part.crossings.t[0] - part.t[0]) <= tau)


def _column_errors(t: Floats, span: tuple[float, float], change: Floats) -> Floats:
    """Largest |Δψ| in each part of the time, (columns,), without the start; nan where no step ends."""
    errors = np.full(_COLUMNS, np.nan)
    edges = np.searchsorted(t, np.linspace(*span, _COLUMNS + 1), side="right")
    for c, (first, last) in enumerate(pairwise(edges)):
        if last > first:
            errors[c] = np.fmax.reduce(np.abs(change[first:last]), axis=None, initial=np.nan)
    return errors
