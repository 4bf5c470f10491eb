"""Many runs at once: core.ensemble compared with heyoka's ensemble_propagate_until."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

import core
from pwsviz.bench.heyoka import HeyokaEnsemble, has_heyoka
from pwsviz.bench.plan import Plan
from pwsviz.bench.problems import Problem, named_problem
from pwsviz.bench.table import UNKNOWN, Table

__all__ = ["ensembles"]

Floats: TypeAlias = NDArray[np.float64]

#: End time, and the errors for which times are stated.
_END, _TARGETS = 20.0, (1e-6, 1e-9)
#: Tolerances tried, from coarse to fine.
_TOLERANCES = 10.0 ** -np.arange(2.0, 15.0, 0.5)
#: Members by whose median error a tolerance is chosen.
_JUDGED = 30
#: Size of the cube around the system's own start in which the members begin, and the seed.
_SPREAD, _SEED = 0.1, 20261123


def ensembles(plan: Plan) -> Table:
    """Time of a member at equal error, and of one that takes a single step."""
    rows = [row for name in plan.ensembles for row in _rows(named_problem(name), plan)]
    return Table(
        "Ensembles",
        f"wall-clock microseconds a member of {plan.members:,} to t = {_END:g}, by taylor on {os.cpu_count()} "
        f"processors, at the tolerance that brings the median of {_JUDGED} members to an error; heyoka's "
        "ensemble_propagate_until beside it, which copies its integrator for each member; the ratio; members a second; "
        "and what a member of a single step takes, the check of its start included.",
        ("system", "error", "taylor", "heyoka", "/ heyoka", "members a second", "single step"),
        rows,
    )


def _rows(problem: Problem, plan: Plan) -> Iterator[list[str]]:
    system, rng = problem.system, np.random.default_rng(_SEED)
    x0 = np.array(system.x0) + _SPREAD * rng.uniform(-0.5, 0.5, (plan.members, system.dimension))
    judged, few = x0[:_JUDGED], x0[: max(plan.members // 50, _JUDGED)]
    exact = np.array([core.reference_solution(system, tuple(x)).state(_END) for x in judged])
    single = _seconds(plan, partial(_ends, system, x0, 1e-9, 1e-6)) / len(x0)
    for target in _TARGETS:
        tolerance = _coarsest(partial(_ends, system, judged), exact, target)
        own, other = _seconds(plan, partial(_ends, system, x0, tolerance)) / len(x0), np.nan
        if has_heyoka():
            tolerance = _coarsest(partial(_ends_by_heyoka, problem, judged), exact, target)
            other = _seconds(plan, partial(HeyokaEnsemble(problem, tolerance).ends, few, _END)) / len(few)
        cells = [f"{1e6 * t:.3g}" if np.isfinite(t) else UNKNOWN for t in (own, other)]
        ratio = f"{own / other:.2g}" if np.isfinite(other) else UNKNOWN
        yield [problem.name, f"{target:.0e}", *cells, ratio, f"{1 / own:,.0f}", f"{1e6 * single:.2f}"]


def _ends(system: core.PiecewiseSystem, x0: Floats, tolerance: float, end: float = _END) -> Floats:
    return core.ensemble(system, (0.0, end), x0, method="taylor", tolerance=tolerance).x


def _ends_by_heyoka(problem: Problem, x0: Floats, tolerance: float) -> Floats:
    return HeyokaEnsemble(problem, tolerance).ends(x0, _END)


def _coarsest(ends: Callable[[float], Floats], exact: Floats, target: float) -> float:
    """Return the coarsest tolerance whose median error is below a target; the finest if none is."""
    for tolerance in _TOLERANCES.tolist():
        if np.median(np.abs(ends(tolerance) - exact).max(axis=1)) < target:
            return float(tolerance)
    return float(_TOLERANCES[-1])


def _seconds(plan: Plan, call: Callable[[], object]) -> float:
    """The least time of some calls."""
    call()
    times = []
    for _ in range(min(plan.repeats, 5)):
        begun = time.perf_counter()
        call()
        times.append(time.perf_counter() - begun)
    return min(times)
