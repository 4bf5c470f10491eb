"""Runs near a tangency: the crossings that a method misses, and its error of ψ."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from core.integration.tally import KINDS, Tally, crossed
from core.interface.cancelling import Cancel, Cancelled
from core.interface.summary import Brief
from core.interface.tasks import GivenUp, as_completed
from core.kernels.arrays import Floats
from core.reference import Solution
from core.studies.sequence import CrossingSequence
from core.studies.stability.plan import MAX_STEPS, Plan
from core.studies.stability.runs import runs_of
from core.studies.stability.tangency import Tangency, exact_times, find_tangency
from core.studies.stability.verdict import start_at

__all__ = ["UNKNOWN", "Grazing", "count", "run"]

UNKNOWN = -1
"""In place of a number that is not computed, or not known."""

#: Distances of the starts from the tangency, relative to the size of the coordinate.
_DELTAS = 10.0 ** -np.arange(1.0, 15.0)
#: End times tried, in units of the time from touch to horizon; the one farthest from a crossing is taken.
_HORIZONS = np.array([1.0, 0.8, 1.2, 0.6, 1.4])
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False, repr=False)
class Grazing(Brief):
    """Runs from starts near that from which the trajectory touches the surface without crossing it.

    The starts lie on both sides of it: on one, the trajectory crosses the surface twice within a short time; on the
    other, it turns just before the surface.
    """

    searched: bool
    """Whether a tangency was sought; otherwise the rest has no meaning."""
    instants: bool
    """Whether all surfaces are instants, which no trajectory touches: none is then sought."""
    between: tuple[float, float]
    """Least and greatest value of the coordinate of x₀ between which a tangency was sought."""
    value: float
    """Its value at the tangency; nan if none lies between these."""
    time: float
    """Time at which the surface is touched."""
    state: Floats
    """(d,) state there."""
    tau: float
    """Step size; of a variable-step method, the largest allowed."""
    delta: Floats
    """(n,) distances from `value`: 0.1 … 1e-14 times the size of the coordinate."""
    starts: Floats
    """(2, n) values of the coordinate at the starts: `value` − `delta`, and `value` + `delta`."""
    horizon: Floats
    """(2, n) end time of each run: after the touch, away from other crossings."""
    expected_met: Integers
    """(2, n, 4) how often the solution meets the surface until then: a `Tally` each; −1 where not computed, or where
    the solution ends before (it slides, say)."""
    met: Integers
    """(methods, 2, n, 4) how often the run meets it; −1 where not computed."""
    error: Floats
    """(methods, 2, n) largest |Δψ|; nan where no ψ is known."""
    status: Integers
    """(methods, 2, n) values of `Status`."""

    @property
    def found(self) -> bool:
        """Whether there is a tangency."""
        return bool(np.isfinite(self.value))

    @property
    def crossings(self) -> Integers:
        """(methods, 2, n) crossings and jumps of the run; −1 where not computed."""
        return crossed(self.met)

    @property
    def expected(self) -> Integers:
        """(2, n) those of the solution; −1 where unknown."""
        return crossed(self.expected_met)

    @property
    def computed(self) -> NDArray[np.bool_]:
        """(methods, 2, n) which runs are."""
        return np.asarray(self.met[..., 0] != UNKNOWN)

    @property
    def judged(self) -> NDArray[np.bool_]:
        """(2, n) for which of them the solution is known."""
        return np.asarray(self.expected_met[..., 0] != UNKNOWN)

    @property
    def missed(self) -> Integers:
        """(methods, 2, n) crossings, beginnings and ends of sliding that a run misses (negative: too many); 0 where
        either number is unknown.
        """
        return np.where(self.computed & self.judged, self.expected_met.sum(axis=-1) - self.met.sum(axis=-1), 0)


def count(plan: Plan) -> int:
    """Number of tasks: one for the search, and one for each start."""
    del plan
    return 1 + 2 * len(_DELTAS)


def run(plan: Plan, executor: Executor | None, cancel: Cancel | None) -> Iterator[Grazing]:
    """Yield the results so far after the search for a tangency, and after each start near it."""
    try:
        tangency = None if _has_instants_alone(plan) else find_tangency(plan, cancel)
    except Cancelled:
        return
    found = _empty(plan, tangency)
    yield found
    if tangency is None:
        return
    places = [(side, n) for n in range(len(_DELTAS)) for side in (0, 1)]
    given_up = GivenUp()
    horizons = tangency.time + _HORIZONS * (tangency.horizon - tangency.time)
    tasks = [(plan, start_at(plan.x0, plan.coordinate, found.starts[place]), horizons, given_up) for place in places]
    for k, (horizon, expected, rows) in as_completed(_runs_from, tasks, executor, cancel, given_up):
        side, n = places[k]
        found.horizon[side, n], found.expected_met[side, n] = horizon, expected
        found.met[:, side, n], found.error[:, side, n], found.status[:, side, n] = zip(*rows, strict=True)
        filled = ("horizon", "expected_met", "met", "error", "status")
        yield replace(found, **{name: getattr(found, name).copy() for name in filled})


def _has_instants_alone(plan: Plan) -> bool:
    laws = plan.system.laws
    return len(laws.instants) == len(laws.surfaces)


def _empty(plan: Plan, tangency: Tangency | None) -> Grazing:
    n, m = len(_DELTAS) if tangency else 0, len(plan.methods)
    value, size = (tangency.value, tangency.size) if tangency else (np.nan, 1.0)
    delta = _DELTAS[:n] * size
    return Grazing(
        searched=True,
        instants=_has_instants_alone(plan),
        value=value,
        between=(float(plan.values[0]), float(plan.values[-1])),
        time=tangency.time if tangency else np.nan,
        state=tangency.state if tangency else np.full(plan.system.dimension, np.nan),
        tau=plan.tau,
        delta=delta,
        starts=value + np.array([[-1.0], [1.0]]) * delta,
        horizon=np.full((2, n), np.nan),
        expected_met=np.full((2, n, len(KINDS)), UNKNOWN),
        met=np.full((m, 2, n, len(KINDS)), UNKNOWN),
        error=np.full((m, 2, n), np.nan),
        status=np.zeros((m, 2, n), dtype=np.int64),
    )


def _runs_from(
    plan: Plan, x0: tuple[float, ...], horizons: Floats, given_up: GivenUp
) -> tuple[float, Integers, list[tuple[Tally, float, int]]]:
    """End time of the runs from a start, the solution's tally, and (tally, error, status) per method."""
    t0 = plan.t_span[0]
    times, solution = exact_times(plan, x0, float(horizons.max()), given_up)
    clear = [float(np.abs(times - t).min(initial=np.inf)) for t in horizons]
    horizon = float(horizons[int(np.argmax(clear))])
    rows = []
    for method in plan.methods:
        how = MAX_STEPS, plan.transition, plan.sliding, given_up
        (one,) = runs_of(plan.system, x0, (t0, horizon), method, [plan.tau], *how)
        rows.append((one.passed.tally, one.error, int(one.status)))
    return horizon, _expected(plan, solution, times[times <= horizon].tolist(), horizon), rows


def _expected(plan: Plan, solution: Solution | None, times: list[float], horizon: float) -> Integers:
    """(4,) tally of the solution by the times of its crossings; unknown where it does not extend to the horizon."""
    try:
        if solution is None:
            raise ValueError("there is no start")
        solution.state(horizon)
    except ValueError:
        return np.full(len(KINDS), UNKNOWN)
    labels = [solution.side(plan.t_span[0]), *(solution.entered(k + 1) for k in range(len(times)))]
    return np.array(CrossingSequence.labelled(plan.system, times, labels).tally)
