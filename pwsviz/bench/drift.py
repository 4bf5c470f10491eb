"""Whether round-off adds up: conserved quantities after up to 10⁸ steps, and forward and back in time."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

import core
from pwsviz.bench.plan import Plan
from pwsviz.bench.tables import aligned

__all__ = ["drift"]

_TAU = 0.1
_LEVELS = {-1: 2 * np.cos(4 * np.pi / 7), 1: 0.0}
_EPS = 2.0**-52


def drift(plan: Plan) -> Iterable[str]:
    """Lines on the error of ψ in runs of more and more steps."""
    yield f"Drift: elliptic curve, tau = {_TAU:g} (taylor: tolerance = 1e-12, to the same time). Over the whole run the"
    yield "largest |psi - level| of a visit, in double-double; at its end |psi - exact level| of the rounded state."
    rows = []
    system = core.CATALOGUE["elliptic_curve"]
    for method in (m for m in core.METHODS.values() if m.conservative):
        for steps in plan.drift_steps:
            run = core.integrate(
                system, (0.0, _TAU * steps), tau=None if method.adaptive else _TAU, method=method.name,
                record="end", envelope=1,
            )  # fmt: skip
            psi = float(system.conserved(int(run.side[-1]), run.t[-1], run.x[-1])[0])
            end = abs(psi - _LEVELS[int(run.side[-1])])
            visit = 0.0 if run.envelope is None else float(np.abs(run.envelope).max())
            rows.append([method.name, f"{run.steps:,}", f"{run.crossing_count:,}", f"{visit:.1e}", f"{end:.1e}",
                         f"{1e9 * run.seconds / run.steps:.0f}"])  # fmt: skip
    yield from aligned(("method", "steps", "crossings", "visits", "end", "ns a step"), rows)
    yield f"  There and back, {plan.steps_back:,} steps of 0.01 each way on one side: error of the state, in eps"
    yield from aligned(("method", "oscillator", "elliptic curve"), _there_and_back(plan))


def _there_and_back(plan: Plan) -> Iterable[list[str]]:
    starts = {"harmonic_oscillator": (1.0, 1.0), "elliptic_curve": (-1.0, -0.5)}
    one_sided = [(_smooth(name), x0) for name, x0 in starts.items()]
    for method in (m.name for m in core.METHODS.values() if m.symmetric):
        row = [method]
        for system, x0 in one_sided:
            end = 0.01 * plan.steps_back
            there = core.integrate(system, (0.0, end), x0, tau=0.01, method=method, record="end")
            back = core.integrate(system, (end, 0.0), there.x[-1], tau=0.01, method=method, record="end")
            row.append(f"{np.abs(back.x[-1] - x0).max() / _EPS:.0f}")
        yield row


def _smooth(name: str) -> core.PiecewiseSystem:
    """One side's law of a system, everywhere."""
    system = core.CATALOGUE[name]
    return core.PiecewiseSystem(
        name, system.variables, system.f_plus, system.f_plus, "x - 10", system.psi_plus, system.psi_plus,
        system.parameters,
    )  # fmt: skip
