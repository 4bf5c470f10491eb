"""The largest step size with which a run agrees with the solution in ending and sequence of crossings."""

from __future__ import annotations

import math
from collections.abc import Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from core.integration.tally import Tally, crossed
from core.interface.cancelling import Cancel
from core.interface.summary import Brief
from core.interface.tasks import GivenUp, as_completed
from core.kernels.arrays import Floats
from core.methods import METHODS
from core.studies.stability.plan import MAX_STEPS, Plan
from core.studies.stability.verdict import ENDINGS, UNCERTAIN, Expected, expected_of, judge

__all__ = ["LargestTau", "count", "run"]

#: Largest |Δψ|, relative to the size of ψ’s terms, with which a conservative method counts as conserving it.
_KEPT = 1e-10
#: Ratio of a step size that fails to one that works at which bisection ends.
_BRACKET = 1.01


@dataclass(frozen=True, eq=False, repr=False)
class LargestTau(Brief):
    """The largest step size that works, per method; all smaller ones that were tried work, too.

    A step size works if the run ends as the solution does, with the same sequence of crossings, and a conservative
    method conserves ψ.
    """

    taus: Floats
    """(m,) step sizes tried first; bisection follows between the last that works and the first that fails."""
    tau: Floats
    """(methods,) the largest that works; nan where none does, or where not computed yet."""
    beyond: Floats
    """(methods,) the smallest that fails, at most 1 % larger; nan where all work."""
    reason: tuple[str, ...]
    """(methods,) why that one fails, in words; empty where all work."""
    done: NDArray[np.bool_]
    """(methods,) whether computed."""
    expected: int
    """How the solution itself ends: a value of `Status`, or UNCERTAIN."""
    expected_met: Tally
    """How often it meets a surface up to `horizon`."""
    horizon: float
    """Time up to which that is counted."""

    @property
    def found(self) -> NDArray[np.bool_]:
        """(methods,) whether a step size was found up to which all work, and beyond which one fails."""
        return np.isfinite(self.tau) & np.isfinite(self.beyond)

    @property
    def expected_crossings(self) -> int:
        """Number of its crossings and jumps."""
        return int(crossed(np.array(self.expected_met)))


def count(plan: Plan) -> int:
    """Number of tasks."""
    return len(plan.methods)


def run(plan: Plan, executor: Executor | None, cancel: Cancel | None) -> Iterator[LargestTau]:
    """Yield the results so far after each method."""
    expected = expected_of(plan.system, plan.x0, plan.t_span, plan.sliding, cancel)
    n, given_up = len(plan.methods), GivenUp()
    found = LargestTau(
        plan.taus, np.full(n, np.nan), np.full(n, np.nan), ("",) * n, np.zeros(n, dtype=bool),
        expected.status, expected.crossings.tally, expected.horizon,
    )  # fmt: skip
    tasks = [(plan, expected, name, given_up) for name in plan.methods]
    for k, (tau, beyond, reason) in as_completed(_largest, tasks, executor, cancel, given_up):
        at = np.arange(n) == k
        found = replace(
            found,
            tau=np.where(at, tau, found.tau),
            beyond=np.where(at, beyond, found.beyond),
            reason=(*found.reason[:k], reason, *found.reason[k + 1 :]),
            done=found.done | at,
        )
        yield found


def _largest(plan: Plan, expected: Expected, method: str, given_up: GivenUp) -> tuple[float, float, str]:
    """The largest step size that works, the smallest that fails, and why."""

    def trouble(tau: float) -> str:
        start, options = (plan.x0, plan.t_span[0]), (plan.transition, plan.sliding)
        (verdict,) = judge(plan.system, *start, expected, method, [tau], MAX_STEPS, *options, given_up)
        if verdict.outcome != expected.status:
            return verdict.message
        if METHODS[method].conservative and verdict.error > _KEPT * expected.size:
            return f"ψ is not conserved: |Δψ| = {verdict.error:.1e}"
        return ""

    if expected.status not in ENDINGS:
        early = "" if expected.status == UNCERTAIN else "the reference ends early: "
        return np.nan, np.nan, f"nothing to compare with, as {early}{expected.reason}"
    works, beyond, reason = np.nan, np.nan, ""
    for tau in plan.taus:
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
