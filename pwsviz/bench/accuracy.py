"""Accuracy: errors of conserved quantities, in long runs too, and orders across the surface."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

import core
from pwsviz.bench.plan import Plan
from pwsviz.bench.table import UNKNOWN, Table

__all__ = ["conservation", "drift", "orders"]

#: Exact values of ψ on each side, from x0 of the system.
_LEVELS = {
    "harmonic_oscillator": {-1: 3.0, 1: 1.0},
    "elliptic_curve": {-1: 2 * np.cos(4 * np.pi / 7), 1: 0.0},
}
#: Step size of the long runs.
_DRIFT_TAU = 0.1
#: Order -> coarsest and finest step size: errors range from about 1e-2 to round-off.
_WINDOWS = {2: (3e-2, 1e-4), 4: (0.12, 5e-4), 6: (0.35, 8e-3), 8: (0.6, 2e-2)}
#: The same for dmm2 with crossing times moved by τ: finer, as the errors are then of order one.
_FIRST_ORDER_WINDOW = (3e-3, 1e-5)
#: Number of step sizes of an order study.
_SIZES = 33
#: Crossings after which orders are measured, where there are so many.
_CROSSINGS = (10, 20, 30)


def conservation(plan: Plan) -> Table:
    """Largest errors of ψ, by system, method and side."""
    rows = []
    for name in plan.seeds:
        for method in plan.methods:
            tau = None if core.METHODS[method].adaptive else 1e-3
            run = core.integrate(core.CATALOGUE[name], (0.0, 1e-3 * plan.steps), tau=tau, method=method)
            rows.append([name, method, *(f"{_largest_error(run, side, _LEVELS[name][side]):.1e}" for side in (-1, 1))])
    return Table(
        "Conservation",
        f"largest |psi - exact level| on each side in {plan.steps} steps of tau = 1e-3 (taylor: to the same time with "
        "tolerance = 1e-12). eps is 2.2e-16.",
        ("system", "method", "side -1", "side +1"),
        rows,
    )


def _largest_error(run: core.Trajectory, side: int, level: float) -> float:
    rows = run.side == side
    return float(np.abs(run.system.conserved(side, run.t[rows], run.x[rows]) - level).max(initial=0.0))


def drift(plan: Plan) -> Table:
    """Errors of ψ in runs of more and more steps."""
    system = core.CATALOGUE["elliptic_curve"]
    rows = []
    for method in (m for m in core.METHODS.values() if m.conservative):
        tau = None if method.adaptive else _DRIFT_TAU
        for steps in plan.drift_steps:
            span = (0.0, _DRIFT_TAU * steps)
            run = core.integrate(system, span, tau=tau, method=method, record="end", envelope=1)
            segments = 0.0 if run.envelope is None else float(np.abs(run.envelope).max())
            side = int(run.side[-1])
            end = abs(float(system.conserved(side, run.t[-1], run.x[-1])[0]) - _LEVELS["elliptic_curve"][side])
            rows.append([method.name, f"{run.steps:.0e}", f"{run.crossing_count:.0e}", f"{segments:.1e}", f"{end:.1e}"])
    return Table(
        "Drift",
        f"elliptic curve, tau = {_DRIFT_TAU:g} (taylor: tolerance = 1e-12, to the same time). segments: the largest "
        "|psi - level of its segment| over the whole run, in double-double; end: |psi - exact level| of the rounded "
        "state at the end.",
        ("method", "steps", "crossings", "segments", "end"),
        rows,
    )


def orders(plan: Plan) -> Table:
    """Fitted orders of every fixed-step method across crossings."""
    rows = [row for name in plan.orders for row in _orders(name, plan.perturbation_orders)]
    return Table(
        "Orders",
        "fitted slopes of the errors of crossing times and of states, before the first crossing and after 10, 20 and "
        "30 (where there are fewer: after as many as there are); p: crossing times are moved by tau**p. nan: fewer "
        "than three step sizes leave an error above round-off. Each fit starts at the finest such step size.",
        ("system", "method", "p", "crossing time", "state: before, after", "crossings", "against"),
        rows,
    )


def _orders(name: str, perturbation_orders: Sequence[int]) -> list[list[str]]:
    system = core.CATALOGUE[name]
    numbers = _reached(system)
    if not numbers:
        return [[name, *[UNKNOWN] * 4, "no second one", UNKNOWN]]
    methods = [method for method in core.METHODS.values() if not method.adaptive and _admits(system, method)]
    studies = [_order(system, method, None, numbers) for method in methods]
    if core.METHODS["dmm2"] in methods:
        studies += [_order(system, core.METHODS["dmm2"], p, numbers) for p in perturbation_orders]
    return [[name, *row] for row in studies]


def _admits(system: core.PiecewiseSystem, method: core.Method) -> bool:
    return system.laws.most_conserved > 0 or not method.needs_conserved


def _order(system: core.PiecewiseSystem, method: core.Method, p: int | None, numbers: Sequence[int]) -> list[str]:
    window = _FIRST_ORDER_WINDOW if p == 1 else _WINDOWS[method.order or 0]
    sizes = np.geomspace(*window, _SIZES)
    study = core.order_study(system, sizes, method=method.name, crossings=numbers, perturbation_order=p)
    slopes = [" ".join(f"{s:5.2f}" for s in row) for row in (study.time_slope, study.state_slope)]
    moved = UNKNOWN if p is None else str(p)
    return [method.name, moved, *slopes, " ".join(map(str, numbers)), study.reference.split()[0]]


def _reached(system: core.PiecewiseSystem) -> tuple[int, ...]:
    """Those of `_CROSSINGS` that another crossing follows; if there are none, the last such crossing."""
    exact = core.reference_solution(system)
    count = 0
    try:
        for k in range(1, _CROSSINGS[-1] + 2):
            exact.crossing(k)
            count = k
    except ValueError:  # the solution ends, or never meets the surface again
        pass
    return tuple(k for k in _CROSSINGS if k < count) or ((count - 1,) if count > 1 else ())
