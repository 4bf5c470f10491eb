"""Orders of every fixed-step method across crossings, for every system of the catalogue."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

import core
from pwsviz.bench.digits import slopes_in_digits
from pwsviz.bench.plan import Plan
from pwsviz.bench.tables import aligned

__all__ = ["catalogue_orders", "orders_in_digits"]

#: Coarsest and finest step size by order: errors from about 1e-2 to round-off.
_WINDOWS = {2: (3e-2, 1e-4), 4: (0.12, 5e-4), 6: (0.35, 8e-3), 8: (0.6, 2e-2)}
_SIZES = 33
_CROSSINGS = (10, 20, 30)
#: Where errors in a double would be round-off long since.
_FINE = (0.01, 0.005, 0.0025, 0.00125)


def catalogue_orders(plan: Plan) -> Iterable[str]:
    """Lines on the fitted slopes of methods × systems."""
    yield "Orders across the catalogue: fitted slopes of the errors of crossing times and of states, before the first"
    yield "crossing and after 10, 20 and 30 (where there are fewer: after as many as there are). nan: fewer than three"
    yield "step sizes leave an error above round-off. Each fit starts at the finest such step size."
    rows, passed = [], []
    for name in plan.catalogue:
        system = core.CATALOGUE[name]
        numbers = _reached(system)
        if not numbers:
            passed.append(name)
            continue
        for method in core.METHODS.values():
            if method.order is None or (method.needs_conserved and not (system.psi_minus or system.psi_plus)):
                continue
            sizes = np.geomspace(*_WINDOWS[method.order], _SIZES)
            study = core.order_study(system, sizes, method=method.name, crossings=numbers)
            slopes = [" ".join(f"{s:5.2f}" for s in row) for row in (study.time_slope, study.state_slope)]
            rows.append([name, method.name, *slopes, ",".join(map(str, numbers)), study.reference.split()[0]])
    yield from aligned(
        ("system", "method", "crossing time", "state: before, after", "crossings", "against"), rows, left=6
    )
    if passed:
        yield f"  no second crossing, so nothing to fit: {', '.join(passed)}"


def orders_in_digits(plan: Plan) -> Iterable[str]:
    """Lines on the order of rk8 where its drift, of order nine, hides it from a double."""
    if not plan.in_digits:
        return
    yield "Orders of rk8 in 34 digits, minutes each: slopes of the crossing times of runs with step sizes from"
    yield f"{_FINE[0]:g} to {_FINE[-1]:g}, each half of the one before."
    yield f"  system           crossing   {'   '.join(f'to {tau:<7g}' for tau in _FINE[2:])}"
    for name in plan.in_digits:
        table = slopes_in_digits(core.CATALOGUE[name], "rk8", _FINE, _CROSSINGS[:2])
        for number, slopes in zip(_CROSSINGS, table, strict=False):
            yield f"  {name:<15}  {number:>8}   {'   '.join(f'{slope:<10.2f}' for slope in slopes)}"


def _reached(system: core.PiecewiseSystem) -> tuple[int, ...]:
    """Which of the crossings wanted, or else the last one, have another after them."""
    exact = core.reference_solution(system)
    count = 0
    try:
        for k in range(1, _CROSSINGS[-1] + 2):
            exact.crossing(k)
            count = k
    except ValueError:  # the solution ends, or never meets the surface again
        pass
    found = tuple(k for k in _CROSSINGS if k < count)
    return found or ((count - 1,) if count > 1 else ())
