"""Outcomes of runs over step sizes and one coordinate of the start."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from core.integration.tally import KINDS, Tally, crossed
from core.interface.cancelling import Cancel
from core.interface.summary import Brief
from core.interface.tasks import GivenUp, as_completed
from core.kernels.arrays import Floats
from core.studies.stability.plan import MAX_STEPS, Plan
from core.studies.stability.verdict import ENDINGS, NO_START, Verdict, expected_of, judge, start_at

__all__ = ["OutcomeMap", "count", "run"]

Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False, repr=False)
class OutcomeMap(Brief):
    """Outcome and error of runs over (τ, one coordinate of x₀)."""

    taus: Floats
    """(m,) step sizes, increasing; of a variable-step method, the largest allowed."""
    values: Floats
    """(n,) values of the coordinate, increasing."""
    outcome: Integers
    """(methods, m, n) values of `Status`, or WRONG_CROSSINGS, WENT_ON, NO_START, or NOT_YET; see `outcome_words`."""
    error: Floats
    """(methods, m, n) largest |Δψ|; nan where no ψ is known or has a value."""
    met: Integers
    """(methods, m, n, 4) how often the run met a surface: a `Tally` each."""
    expected: Integers
    """(n,) how the solution from that start ends: a value of `Status`, or UNCERTAIN, NO_START or NOT_YET."""
    expected_met: Integers
    """(n, 4) how often the solution met one, up to the time until which that is counted."""

    @property
    def crossings(self) -> Integers:
        """(methods, m, n) crossings and jumps of the run."""
        return crossed(self.met)

    @property
    def expected_crossings(self) -> Integers:
        """(n,) those of the solution."""
        return crossed(self.expected_met)

    @property
    def works(self) -> NDArray[np.bool_]:
        """(methods, m, n) whether a run ends as the solution does, with the same sequence of crossings."""
        works: NDArray[np.bool_] = (self.outcome == self.expected) & np.isin(self.expected, ENDINGS)
        return works


def count(plan: Plan) -> int:
    """Number of tasks."""
    return len(plan.methods) * len(plan.values)


def run(plan: Plan, executor: Executor | None, cancel: Cancel | None) -> Iterator[OutcomeMap]:
    """Yield the results so far after each start, from a coarse map to the fine one."""
    n, kinds, shape = len(plan.values), len(KINDS), (len(plan.methods), len(plan.taus), len(plan.values))
    found = OutcomeMap(
        plan.taus, plan.values, np.zeros(shape, dtype=np.int64), np.full(shape, np.nan),
        np.zeros((*shape, kinds), dtype=np.int64), np.zeros(n, dtype=np.int64), np.zeros((n, kinds), dtype=np.int64),
    )  # fmt: skip
    given_up = GivenUp()
    columns = [(which, row) for row in _coarse_to_fine(n) for which in range(len(plan.methods))]
    tasks = [
        (plan, start_at(plan.x0, plan.coordinate, plan.values[row]), plan.methods[which], given_up)
        for which, row in columns
    ]
    for k, (status, met, verdicts) in as_completed(_column, tasks, executor, cancel, given_up):
        which, row = columns[k]
        found.expected[row], found.expected_met[row] = status, met
        found.outcome[which, :, row] = [verdict.outcome for verdict in verdicts]
        found.error[which, :, row] = [verdict.error for verdict in verdicts]
        found.met[which, :, row] = [verdict.met for verdict in verdicts]
        yield replace(found, **{f.name: getattr(found, f.name).copy() for f in fields(found)})


def _coarse_to_fine(n: int) -> list[int]:
    """The numbers below n, so ordered that any first ones of them are spread evenly."""
    return sorted(range(n), key=lambda k: -(k & -k) if k else -n)


def _column(plan: Plan, x0: tuple[float, ...], method: str, given_up: GivenUp) -> tuple[int, Tally, list[Verdict]]:
    """How the solution from one start ends, how often it meets a surface, and a verdict for each step size."""
    try:
        expected = expected_of(plan.system, x0, plan.t_span, plan.sliding, given_up)
    except ValueError as why:  # f or g is undefined there
        return NO_START, Tally(), [Verdict(NO_START, Tally(), np.nan, str(why))] * len(plan.taus)
    options = (plan.transition, plan.sliding, given_up)
    verdicts = judge(plan.system, x0, plan.t_span[0], expected, method, plan.taus.tolist(), MAX_STEPS, *options)
    return int(expected.status), expected.crossings.tally, verdicts
