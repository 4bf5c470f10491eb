"""Many runs at once: core.ensemble compared with a prange of numba, and with heyoka's ensembles."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

import core
from pwsviz.bench.heyoka import HeyokaBatches, HeyokaEnsemble, has_heyoka
from pwsviz.bench.plan import Plan
from pwsviz.bench.prange import ends_by_prange
from pwsviz.bench.problems import Problem, drawn_problems, named_problem
from pwsviz.bench.table import UNKNOWN, Table

__all__ = ["ensembles"]

Floats: TypeAlias = NDArray[np.float64]

_Kind: TypeAlias = type[HeyokaEnsemble] | type[HeyokaBatches]
#: heyoka's two ways, in the order of the columns.
_KINDS: tuple[_Kind, ...] = (HeyokaEnsemble, HeyokaBatches)
#: End time, and the errors for which times are stated.
_END, _TARGETS = 20.0, (1e-6, 1e-9)
#: Tolerances tried, from coarse to fine.
_TOLERANCES = 10.0 ** -np.arange(2.0, 15.0, 0.5)
#: Members by whose median error a tolerance is chosen.
_JUDGED = 30
#: Wall-clock and processor time of what was not measured.
_NOT_MEASURED: Floats = np.full(2, np.nan)
#: Size of the cube around the system's own start in which the members begin, and the seed.
_SPREAD, _SEED = 0.1, 20261123


def ensembles(plan: Plan) -> Table:
    """Time of a member at equal error, and of one that takes a single step."""
    problems = [*map(named_problem, plan.ensembles), *drawn_problems(plan.drawn_ensembles, _SEED)]
    rows = [row for problem in problems for row in _rows(problem, plan)]
    return Table(
        "Ensembles",
        f"wall-clock microseconds a member of {plan.members:,} to t = {_END:g}, by taylor on {os.cpu_count()} "
        f"processors, at the tolerance that brings the median of {_JUDGED} members to an error; in parentheses "
        "processor time of all threads. Beside it the time loop called by a prange of numba, without crossings kept "
        f"or runs looked into that fail; heyoka's ensemble_propagate_until, which copies its integrator for each "
        "member, and ensemble_propagate_until_batch (a fiftieth of the members); the ratios of wall-clock times to "
        "heyoka's; members a second; and what a member of a single step takes, the check of its start included. "
        f"Members begin in a cube of side {_SPREAD:g}; the last systems are drawn at random.",
        ("system", "error", "taylor", "prange", "heyoka", "batch", "/ heyoka", "/ batch", "members a second",
         "single step"),
        rows,
    )  # fmt: skip


def _rows(problem: Problem, plan: Plan) -> Iterator[list[str]]:
    system, rng = problem.system, np.random.default_rng(_SEED)
    x0 = np.array(system.x0) + _SPREAD * rng.uniform(-0.5, 0.5, (plan.members, system.dimension))
    judged, few = x0[:_JUDGED], x0[: max(plan.members // 50, _JUDGED)]
    exact = np.array([core.reference_solution(system, tuple(x)).state(_END) for x in judged])
    single = _times(plan, partial(_ends, system, x0, 1e-9, 1e-6))[0] / len(x0)
    for target in _TARGETS:
        tolerance = _coarsest(partial(_ends, system, judged), exact, target)
        own, theirs = _times(plan, partial(_ends, system, x0, tolerance)) / len(x0), [_NOT_MEASURED] * 3
        if plan.prange:
            theirs[0] = _times(plan, partial(ends_by_prange, system, x0, tolerance, _END)) / len(x0)
        for k, kind in enumerate(_KINDS if has_heyoka() else (), start=1):
            tolerance = _coarsest(partial(_ends_by_heyoka, kind, problem, judged), exact, target)
            theirs[k] = _times(plan, partial(kind(problem, tolerance).ends, few, _END)) / len(few)
        cells = [_cell(times) for times in (own, *theirs)]
        ratios = [f"{own[0] / times[0]:.2g}" if np.isfinite(times[0]) else UNKNOWN for times in theirs[1:]]
        yield [problem.name, f"{target:.0e}", *cells, *ratios, f"{1 / own[0]:,.0f}", f"{1e6 * single:.2f}"]


def _cell(times: Floats) -> str:
    """Wall-clock and processor time in microseconds."""
    return f"{1e6 * times[0]:.3g} ({1e6 * times[1]:.3g})" if np.isfinite(times[0]) else UNKNOWN


def _ends(system: core.PiecewiseSystem, x0: Floats, tolerance: float, end: float = _END) -> Floats:
    return core.ensemble(system, (0.0, end), x0, method="taylor", tolerance=tolerance).x


def _ends_by_heyoka(kind: _Kind, problem: Problem, x0: Floats, tolerance: float) -> Floats:
    return kind(problem, tolerance).ends(x0, _END)


def _coarsest(ends: Callable[[float], Floats], exact: Floats, target: float) -> float:
    """Return the coarsest tolerance whose median error is below a target; the finest if none is."""
    for tolerance in _TOLERANCES.tolist():
        if np.median(np.abs(ends(tolerance) - exact).max(axis=1)) < target:
            return float(tolerance)
    return float(_TOLERANCES[-1])


def _times(plan: Plan, call: Callable[[], object]) -> Floats:
    """The least wall-clock time of some calls, and the least processor time, in seconds."""
    call()
    times = []
    for _ in range(min(plan.repeats, 5)):
        begun, used = time.perf_counter(), time.process_time()
        call()
        times.append((time.perf_counter() - begun, time.process_time() - used))
    return np.asarray(np.min(times, axis=0))
