"""What a person waits for who moves the slider of the step size, or of the tolerance."""

from __future__ import annotations

import time
from collections.abc import Iterable

import numpy as np

import core
from pwsviz.bench.plan import Plan
from pwsviz.bench.tables import aligned, milliseconds

__all__ = ["moved_slider"]

_MOVES = 12


def moved_slider(plan: Plan) -> Iterable[str]:
    """Lines on the time from a moved slider to the arrays."""
    yield f"Moved slider, in ms: from a new tau to the arrays of {plan.steps:,} steps and their error of psi (taylor:"
    yield f"from a new tolerance, to the same time); median of {_MOVES}."
    rows = []
    for name in plan.seeds:
        for method in plan.methods:
            moves = [_moved(core.CATALOGUE[name], method, plan.steps, 1 + k / 1e4) for k in range(_MOVES + 1)]
            rows.append([name, method, *(milliseconds(float(v)) for v in np.median(moves[1:], axis=0))])
    yield from aligned(("system", "method", "run + errors", "loop"), rows, left=2)


def _moved(system: core.PiecewiseSystem, method: str, steps: int, factor: float) -> tuple[float, float]:
    chosen = {"tolerance": 1e-12 * factor} if core.METHODS[method].adaptive else {"tau": 1e-3 * factor}
    started = time.perf_counter()
    run = core.integrate(system, (0.0, 1e-3 * factor * steps), method=method, **chosen)  # type: ignore[arg-type]
    run.conserved_error()
    return time.perf_counter() - started, run.seconds
