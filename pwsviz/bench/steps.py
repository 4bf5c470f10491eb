"""Cost of a step, and whether time and memory stay in proportion over many."""

from __future__ import annotations

from collections.abc import Iterable

import core
from pwsviz.bench.clock import timed
from pwsviz.bench.memory import peak_memory
from pwsviz.bench.plan import Plan
from pwsviz.bench.tables import aligned

__all__ = ["linearity", "step_costs"]

_TAU = 1e-3
_MANY = 10**6  #: steps beside which no warm-up counts


def step_costs(plan: Plan) -> Iterable[str]:
    """Lines on the cost of a step of every method."""
    yield f"Cost of a step: {plan.steps:,} steps of tau = {_TAU:g}, nothing recorded; least time of the loop. taylor"
    yield "chooses its steps by tolerance = 1e-12, to the same time."
    rows = []
    for name in plan.seeds:
        costs = {method: _cost(core.CATALOGUE[name], method, plan) for method in plan.methods}
        least = min(nanoseconds for nanoseconds, _, _ in costs.values())
        for method, (nanoseconds, evaluations, steps) in costs.items():
            cells = (f"{nanoseconds:.1f}", f"{nanoseconds / least:.2f}", f"{evaluations:.2f}", f"{steps:,}")
            rows.append([name, method, *cells])
    yield from aligned(("system", "method", "ns a step", "times least", "evaluations a step", "steps"), rows, left=2)


def _cost(system: core.PiecewiseSystem, method: str, plan: Plan) -> tuple[float, float, int]:
    """Least ns a step, evaluations a step, steps."""
    tau = None if core.METHODS[method].adaptive else _TAU
    end = plan.steps * _TAU
    runs = timed(
        lambda: core.integrate(system, (0.0, end), tau=tau, method=method, record="end"),
        plan.repeats, plan.repeat_seconds,
    )  # fmt: skip
    run = runs[0][1]
    return min(r.seconds for _, r in runs) / run.steps * 1e9, run.evaluations / run.steps, run.steps


def linearity(plan: Plan) -> Iterable[str]:
    """Lines on cost and memory against the number of steps."""
    yield f"Cost in proportion to steps: dmm2 with tau = {_TAU:g}, record='end'; least processor"
    yield "time of the loop, least wall time, and by how much the runs raised the greatest memory ever held."
    rows = []
    for name in plan.seeds:
        system = core.CATALOGUE[name]
        for steps in plan.step_counts:
            before = peak_memory()
            runs = timed(
                lambda: core.integrate(system, (0.0, steps * _TAU), tau=_TAU, record="end"),  # noqa: B023 - called here
                plan.repeats, plan.repeat_seconds, warm=steps > _MANY,
            )  # fmt: skip
            wall, run = min(runs, key=lambda timing: timing[0])
            loop = min(r.seconds for _, r in runs)
            grown = (peak_memory() - before) / 2**20
            rows.append([name, f"{run.steps:,}", f"{loop / run.steps * 1e9:.1f}", f"{wall:.4f}", f"{grown:.1f}",
                         f"{run.crossing_count:,}"])  # fmt: skip
    yield from aligned(("system", "steps", "ns a step", "wall (s)", "memory (MiB)", "crossings"), rows)
