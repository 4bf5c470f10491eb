"""The largest step size with which a method does what the solution does."""

from __future__ import annotations

import math
from collections.abc import Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from core.integration.trajectory import Status
from core.interface.summary import Brief
from core.kernels.arrays import Floats
from core.methods import METHODS
from core.studies.stability.plan import MAX_STEPS, Plan
from core.studies.stability.verdict import ENDINGS, Expected, expected_of, judge
from core.studies.tasks import Cancel, as_completed
from core.system import PiecewiseSystem

__all__ = ["LargestTau", "count", "run"]

_KEPT = 1e-10  #: of the size of ψ: what a conservative method may make of it and still be said to keep it
_BRACKET = 1.01  #: the limit is known to lie within this factor


@dataclass(frozen=True, eq=False, repr=False)
class LargestTau(Brief):
    """The largest step size that works, per method: it and every smaller one tried.

    A step size works if the run ends as the solution does, with as many crossings, and a conservative method keeps ψ.
    """

    taus: Floats
    """(m,) ladder of step sizes tried first; between the last that works and the first that does not, bisection."""
    tau: Floats
    """(methods,) the largest that works; nan where none does, or where not computed yet."""
    beyond: Floats
    """(methods,) the smallest that does not, at most one hundredth larger; nan where all work."""
    reason: tuple[str, ...]
    """(methods,) what goes wrong there, in words; empty where all work."""
    done: NDArray[np.bool_]
    """(methods,) whether computed."""
    expected: Status
    """How the solution itself ends."""
    expected_crossings: int
    """How many crossings it has up to `horizon`."""
    horizon: float
    """When they are counted."""


def count(plan: Plan) -> int:
    """Number of tasks."""
    return len(plan.methods)


def run(plan: Plan, executor: Executor | None, cancel: Cancel | None) -> Iterator[LargestTau]:
    """Yield what is known after each method."""
    expected = expected_of(plan.system, plan.x0, plan.t_span)
    n = len(plan.methods)
    found = LargestTau(
        plan.taus, np.full(n, np.nan), np.full(n, np.nan), ("",) * n, np.zeros(n, dtype=bool),
        expected.status, expected.crossings, expected.horizon,
    )  # fmt: skip
    tasks = [(plan.system, plan.x0, plan.t_span[0], expected, name, plan.taus) for name in plan.methods]
    for k, (tau, beyond, reason) in as_completed(_largest, tasks, executor, cancel):
        at = np.arange(n) == k
        found = replace(
            found,
            tau=np.where(at, tau, found.tau),
            beyond=np.where(at, beyond, found.beyond),
            reason=(*found.reason[:k], reason, *found.reason[k + 1 :]),
            done=found.done | at,
        )
        yield found


def _largest(
    system: PiecewiseSystem, x0: tuple[float, ...], t0: float, expected: Expected, method: str, taus: Floats
) -> tuple[float, float, str]:
    """The largest step size that works, the smallest that does not, and why it does not."""

    def trouble(tau: float) -> str:
        verdict = judge(system, x0, t0, expected, method, tau, MAX_STEPS)
        if verdict.outcome != expected.status:
            return verdict.message
        if METHODS[method].conservative and verdict.error > _KEPT * expected.size:
            return f"ψ is not kept: |Δψ| = {verdict.error:.1e}"
        return ""

    if expected.status not in ENDINGS:
        return np.nan, np.nan, f"the reference itself gives up: {expected.status.reason}"
    works, beyond, reason = np.nan, np.nan, ""
    for tau in taus:
        reason = trouble(tau)
        if reason:
            beyond = float(tau)
            break
        works = float(tau)
    while beyond > _BRACKET * works:
        middle = math.sqrt(works * beyond)
        if why := trouble(middle):
            beyond, reason = middle, why
        else:
            works = middle
    return works, beyond, reason
