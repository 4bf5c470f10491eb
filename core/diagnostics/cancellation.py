"""Warn where the terms of a field, or of a conserved quantity, cancel: what is left of their digits is rounding.

Their values in double precision are held against those in extended precision. Where NumPy has none, nothing is said.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from sympy import Expr, Integer

from core.diagnostics.encounters import by_number
from core.integration.trajectory import Trajectory
from core.kernels.arrays import Floats
from core.methods import METHODS
from core.symbolic.derivative import derivative

__all__ = ["cancelled"]

#: Error of a variable, or of a gradient of ψ, relative to its size, that is told: half the digits are lost.
_HALF = 2.0**-26
#: Number of states at which values are compared.
_STATES = 64
_ADVICE = "No step size helps: write {} so that its terms do not cancel, such as (x - a)**3 in place of powers of x"


def cancelled(run: Trajectory) -> Iterator[str]:
    """Say which rate of change, or of which ψ the gradient, is told to few digits only, as its terms cancel.

    Yields
    ------
    str
        A sentence without the last full stop.
    """
    lost, noise = _of_rates(run)
    if lost.max(initial=0.0) > _HALF:
        worst = int(np.argmax(lost))
        yield (
            f"The terms of {run.system.variables[worst]}' cancel, and their rounding changes it by {noise[worst]:.1g}. "
            f"{_ADVICE.format('the field')}"
        )
    if METHODS[run.method].conservative and run.system.laws.most_conserved:
        part = _of_gradients(run)
        if part > _HALF:
            yield (
                f"The terms of psi cancel, and their rounding changes its gradient by {part:.1g} of its size. "
                f"{_ADVICE.format('psi')}"
            )


def _of_rates(run: Trajectory) -> tuple[Floats, Floats]:
    """(d,) relative errors of the variables by the rounding of their rates, and that rounding.

    It acts for as long as the run lasts, or as the variable takes to change by its size, or to forget its errors.
    """
    laws = run.system.laws
    fields = [law.written.field for law in laws.regions]
    rates, noise = _and_rounding(run, "field", fields)
    with np.errstate(all="ignore"):
        size, rate = np.fmax.reduce(np.abs(run.x), axis=0), np.fmax.reduce(np.abs(rates), axis=0)
        lost = noise * np.fmin(np.abs(run.t[-1] - run.t[0]), size / rate) / size
        if np.nan_to_num(lost, posinf=0.0).max() > _HALF:  # the derivatives may take longer than all else
            slopes = [[derivative(f, v) for f, v in zip(field, laws.x, strict=True)] for field in fields]
            forgets = np.fmax.reduce(-_and_rounding(run, "own slopes of the field", slopes)[0], axis=0, initial=0.0)
            lost = np.fmin(lost, noise / forgets / size)
    return np.nan_to_num(lost, posinf=0.0), noise


def _of_gradients(run: Trajectory) -> float:
    """Largest relative error of a gradient of ψ, of which each entry counts by the range of its variable."""
    laws, m = run.system.laws, run.system.laws.most_conserved
    gradients = [[derivative(psi, v) for psi in law.written.conserved for v in laws.x] for law in laws.regions]
    missing = [[Integer(0)] * (m * len(laws.x) - len(one)) for one in gradients]
    values, noise = _and_rounding(run, "gradients", [a + b for a, b in zip(gradients, missing, strict=True)])
    extent = np.ptp(run.x, axis=0) if len(run.t) > 1 else np.ones(len(laws.x))
    with np.errstate(all="ignore"):
        sizes = (np.abs(values).reshape(-1, m, len(extent)) * extent).sum(axis=2)
        part = (noise.reshape(m, -1) * extent).sum(axis=1) / np.fmax.reduce(sizes, axis=0)
    return float(np.nan_to_num(part, posinf=0.0).max())


def _and_rounding(run: Trajectory, key: str, expressions: Sequence[Sequence[Expr]]) -> tuple[Floats, Floats]:
    """(n, k) values of the expressions of each region at states of a run, nan where it slides; (k,) their rounding."""
    laws, p = run.system.laws, run.system.parameter_array
    rows = np.unique(np.linspace(0, len(run.t) - 1, _STATES).astype(int))
    region = np.where(run.mode[rows] < len(laws.regions), run.mode[rows], -1)

    def of_one(number: int, t: Floats, x: Floats) -> Floats:
        return laws.evaluate((key, number), expressions[number], t, x, p)

    def at(precision: type[np.floating]) -> Floats:
        return by_number(region, of_one, run.t[rows].astype(precision), run.x[rows].astype(precision))

    values = at(np.float64)
    with np.errstate(all="ignore"):
        rounding = np.fmax.reduce(np.abs(at(np.longdouble) - values), axis=0, initial=0.0)
    return values, np.asarray(rounding, dtype=float)
