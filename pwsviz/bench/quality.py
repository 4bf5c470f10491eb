"""What is exact and should stay so: conserved quantities and orders."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

import core
from pwsviz.bench.plan import Plan
from pwsviz.bench.tables import aligned

__all__ = ["conservation", "orders"]

#: Exact levels of ψ on the sides −1 and +1, from x0 of the system.
_LEVELS = {"harmonic_oscillator": (3.0, 1.0), "elliptic_curve": (2 * np.cos(4 * np.pi / 7), 0.0)}
#: Step sizes that show the order of each perturbation: errors from 1e-2 down, far above round-off.
_WINDOWS = {None: (3e-2, 1e-4), 1: (3e-3, 1e-5), 2: (3e-2, 1e-4), 3: (3e-2, 1e-4)}


def conservation(plan: Plan) -> Iterable[str]:
    """Lines on the largest errors of ψ."""
    yield f"Conservation: largest |psi - exact level| of {plan.steps:,} steps of tau = 1e-3 (taylor: to the same time"
    yield "with tolerance = 1e-12). eps is 2.2e-16."
    rows = []
    for name in plan.seeds:
        for method in plan.methods:
            tau = None if core.METHODS[method].adaptive else 1e-3
            run = core.integrate(core.CATALOGUE[name], (0.0, 1e-3 * plan.steps), tau=tau, method=method)
            worst = (f"{_loss(run, side, level):.1e}" for side, level in zip((-1, 1), _LEVELS[name], strict=True))
            rows.append([name, method, *worst, f"{len(run.crossings)}"])
    yield from aligned(("system", "method", "side -1", "side +1", "crossings"), rows, left=2)


def _loss(run: core.Trajectory, side: int, level: float) -> float:
    rows = run.side == side
    return float(np.abs(run.system.conserved(side, run.t[rows], run.x[rows]) - level).max(initial=0.0))


def orders(plan: Plan) -> Iterable[str]:
    """Lines on the fitted orders of dmm2."""
    yield "Order of dmm2 across crossings 10, 20, 30, crossing times moved by tau**p: fitted slopes of the errors of"
    yield "the crossing time and of the state, before the first crossing and after these."
    rows, references = [], []
    for name in plan.seeds:
        for p in plan.orders:
            study = core.order_study(core.CATALOGUE[name], np.geomspace(*_WINDOWS[p], 11), perturbation_order=p)
            slopes = (f"{slope:.3f}" for slope in (*study.time_slope, *study.state_slope))
            fit = f"{study.window[1:, 0].min():.1e} ... {study.window[1:, 1].max():.1e}"
            rows.append([name, str(p), *slopes, fit])
        references.append(f"  {name} is measured against: {study.reference}; round-off floor {study.floor:.0e}")
    header = ("system", "p", "time 10", "20", "30", "state before", "10", "20", "30", "fit window")
    yield from aligned(header, rows, left=2)
    yield from references
