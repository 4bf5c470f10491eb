"""Beside a tangency: crossings that a method misses, and what it makes of ψ."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from core.integrate import integrate
from core.interface.summary import Brief
from core.kernels.arrays import Floats
from core.reference import Solution
from core.studies.stability.plan import MAX_STEPS, Plan
from core.studies.stability.tangency import Tangency, exact_times, find_tangency
from core.studies.stability.verdict import start_at, worst_error
from core.studies.tasks import Cancel, as_completed
from core.system import PiecewiseSystem

__all__ = ["UNKNOWN", "Grazing", "count", "run"]

UNKNOWN = -1
"""Instead of a number of crossings: not computed, or not known."""

_DELTAS = 10.0 ** -np.arange(1.0, 15.0)
_HORIZONS = np.array([1.0, 0.8, 1.2, 0.6, 1.4])  # of the time from the touch to the horizon
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False, repr=False)
class Grazing(Brief):
    """Runs that start beside the value at which the trajectory touches the surface without crossing it.

    Both sides of that value: on one of them the trajectory dips through the surface, and crosses it twice within a
    short time; on the other it turns just before.
    """

    searched: bool
    """Whether a tangency was looked for; only then the rest means anything."""
    value: float
    """Of the coordinate at the tangency; nan where there is none between the values looked at."""
    time: float
    """When it touches."""
    state: Floats
    """(d,) where."""
    tau: float
    """Step size; of a method that chooses its own, the longest it may take."""
    delta: Floats
    """(n,) distances from `value`: 0.1 … 1e-14 times the size of the coordinate."""
    starts: Floats
    """(2, n) values started from: less, and more, by delta."""
    horizon: Floats
    """(2, n) until when each was run: past the touch, away from other crossings."""
    expected: Integers
    """(2, n) crossings of the solution until then; −1 where not computed, or where it stops before: it slides, say."""
    crossings: Integers
    """(methods, 2, n) crossings of the run; −1 where not computed."""
    error: Floats
    """(methods, 2, n) largest |Δψ|; nan where no ψ is known."""
    status: Integers
    """(methods, 2, n) values of `Status`."""

    @property
    def found(self) -> bool:
        """Whether there is a tangency."""
        return bool(np.isfinite(self.value))

    @property
    def missed(self) -> Integers:
        """(methods, 2, n) crossings that a run has too few (too many: negative); 0 where either is not known."""
        known = (self.crossings != UNKNOWN) & (self.expected != UNKNOWN)
        return np.where(known, self.expected - self.crossings, 0)


def count(plan: Plan) -> int:
    """Number of tasks: the search, and a start each."""
    del plan
    return 1 + 2 * len(_DELTAS)


def run(plan: Plan, executor: Executor | None, cancel: Cancel | None) -> Iterator[Grazing]:
    """Yield what is known after the search for a tangency, and after each start beside it."""
    tangency = find_tangency(plan, cancel)
    if cancel is not None and cancel():
        return
    found = _empty(plan, tangency)
    yield found
    if tangency is None:
        return
    places = [(side, n) for n in range(len(_DELTAS)) for side in (0, 1)]
    horizons = tangency.time + _HORIZONS * (tangency.horizon - tangency.time)
    tasks = [
        (plan.system, start_at(plan.x0, plan.coordinate, found.starts[place]), plan.t_span[0], horizons,
         plan.methods, plan.tau)
        for place in places
    ]  # fmt: skip
    for k, (horizon, expected, rows) in as_completed(_runs_from, tasks, executor, cancel):
        side, n = places[k]
        found.horizon[side, n], found.expected[side, n] = horizon, expected
        found.crossings[:, side, n], found.error[:, side, n], found.status[:, side, n] = zip(*rows, strict=True)
        filled = ("horizon", "expected", "crossings", "error", "status")
        yield replace(found, **{name: getattr(found, name).copy() for name in filled})


def _empty(plan: Plan, tangency: Tangency | None) -> Grazing:
    n, m = len(_DELTAS) if tangency else 0, len(plan.methods)
    value, size = (tangency.value, tangency.size) if tangency else (np.nan, 1.0)
    delta = _DELTAS[:n] * size
    return Grazing(
        searched=True,
        value=value,
        time=tangency.time if tangency else np.nan,
        state=tangency.state if tangency else np.full(plan.system.dimension, np.nan),
        tau=plan.tau,
        delta=delta,
        starts=value + np.array([[-1.0], [1.0]]) * delta,
        horizon=np.full((2, n), np.nan),
        expected=np.full((2, n), UNKNOWN),
        crossings=np.full((m, 2, n), UNKNOWN),
        error=np.full((m, 2, n), np.nan),
        status=np.zeros((m, 2, n), dtype=np.int64),
    )


def _runs_from(
    system: PiecewiseSystem, x0: tuple[float, ...], t0: float, horizons: Floats, methods: tuple[str, ...], tau: float
) -> tuple[float, int, list[tuple[int, float, int]]]:
    """Until when a start was run, how many crossings it has till then, and (crossings, error, status) per method."""
    times, solution = exact_times(system, x0, t0, float(horizons.max()))
    clear = [float(np.abs(times - t).min(initial=np.inf)) for t in horizons]
    horizon = float(horizons[int(np.argmax(clear))])
    rows = []
    for method in methods:
        one = integrate(system, (t0, horizon), x0, tau, method, max_steps=MAX_STEPS, max_crossings=MAX_STEPS)
        rows.append((len(one.crossings.passed), worst_error(one), int(one.status)))
    expected = int(np.count_nonzero(times <= horizon)) if _reaches(solution, horizon) else UNKNOWN
    return horizon, expected, rows


def _reaches(solution: Solution | None, t: float) -> bool:
    """Whether a solution goes on to time t."""
    if solution is None:
        return False
    try:
        solution.state(t)
    except ValueError:
        return False
    return True
