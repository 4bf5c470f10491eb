"""Warn where the terms of a field, of a reset map or of a ψ cancel: what is left of their digits is rounding.

Their values in double precision are held against those in extended precision. Where NumPy has none, nothing is said.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sympy import Expr, Integer

from core.diagnostics.encounters import by_number
from core.integration.trajectory import Trajectory
from core.kernels.arrays import Floats
from core.methods import METHODS
from core.symbolic.derivative import derivative

__all__ = ["cancelled"]

Precision = type[np.floating[Any]]

#: Error of a variable, relative to its range, or of a gradient of ψ, to its size, that is told: half the digits.
_HALF = 2.0**-26
#: Least range of a variable, relative to its size: one that hardly moves is told to fewer digits of its range.
_MOVES = 2.0**-10
#: Number of states at which values are compared.
_STATES = 64
_ADVICE = "No step size helps: write {} so that its terms do not cancel, such as (x - a)**3 in place of powers of x"


def cancelled(run: Trajectory) -> Iterator[str]:
    """Say which rate of change, which reset, or of which ψ the gradient, is told to few digits only.

    Yields
    ------
    str
        A sentence without the last full stop.
    """
    extent = np.fmax(np.ptp(run.x, axis=0), _MOVES * np.abs(run.x).max(axis=0))
    yield from _told(run, "' cancel", "the field", *_by_rates(run, extent), extent)
    resets, moved = _rounding_of_resets(run)
    told = tuple(_told(run, " after a reset cancel", "the reset map", resets, resets, extent))
    yield from told or _told_of_steep_resets(run, moved, extent)
    if METHODS[run.method].conservative and run.system.laws.most_conserved:
        part = _of_gradients(run)
        if part > _HALF:
            yield (
                f"The terms of psi cancel, and their rounding changes its gradient by {part:.1g} of its size. "
                f"{_ADVICE.format('psi')}"
            )


def _told(run: Trajectory, what: str, where: str, moved: Floats, noise: Floats, extent: Floats) -> Iterator[str]:
    """Tell the variable that rounding moves farthest, relative to its range, if that is half its digits."""
    with np.errstate(all="ignore"):
        lost = np.nan_to_num(moved / extent, posinf=0.0)
    if lost.max() > _HALF:
        worst = int(np.argmax(lost))
        yield (
            f"The terms of {run.system.variables[worst]}{what}, and their rounding changes it by {noise[worst]:.1g}. "
            f"{_ADVICE.format(where)}"
        )


def _told_of_steep_resets(run: Trajectory, moved: Floats, extent: Floats) -> Iterator[str]:
    """Tell the variable that the rounding of the state before a reset moves farthest, if that is half its digits."""
    lost = np.divide(moved, extent, out=np.zeros_like(extent), where=extent > 0.0)
    if lost.max() > _HALF:
        worst = int(np.argmax(lost))
        by = f"by {moved[worst]:.1g}" if np.isfinite(moved[worst]) else "without bound"
        yield (
            f"Rounding of the state before a reset changes {run.system.variables[worst]} after it {by}: the reset map "
            "varies too fast there. No step size helps: write the reset map otherwise, or start elsewhere"
        )


def _by_rates(run: Trajectory, extent: Floats) -> tuple[Floats, Floats]:
    """(d,) how far the rounding of its rate moves each variable, and that rounding.

    It acts for as long as the run lasts, or as the variable takes to pass its range, or to forget its errors.
    """
    laws = run.system.laws
    fields = [law.written.field for law in laws.regions]
    rates, noise = _along(run, "field", fields)
    with np.errstate(all="ignore"):
        rate = np.fmax.reduce(np.abs(rates), axis=0)
        moved = noise * np.fmin(np.abs(run.t[-1] - run.t[0]), extent / rate)
        if np.nan_to_num(moved / extent, posinf=0.0).max() > _HALF:  # the derivatives may take longer than all else
            slopes = [[derivative(f, v) for f, v in zip(field, laws.x, strict=True)] for field in fields]
            forgets = np.fmax.reduce(-_along(run, "own slopes of the field", slopes)[0], axis=0, initial=0.0)
            moved = np.fmin(moved, noise / forgets)
    return moved, noise


def _rounding_of_resets(run: Trajectory) -> tuple[Floats, Floats]:
    """(d,) the rounding of the reset maps at the first jumps at each surface, and (d,) what that of the state makes."""
    laws, met, p = run.system.laws, run.crossings, run.system.parameter_array
    rounding, moved = np.zeros((2, len(laws.x)))
    for surface, jump in {(way.surface, way.jump) for ways in laws.ways for way in ways if way.jump is not None}:
        rows = np.flatnonzero(met.surface_met == surface)[:_STATES]

        def after(precision: Precision, rows: NDArray[np.intp] = rows, jump: Sequence[Expr] = jump) -> Floats:
            t, x = met.t[rows].astype(precision), met.x[rows].astype(precision)
            return laws.evaluate(("reset map", jump), jump, t, x, p)

        values, noise = _and_rounding(after)
        rounding = np.fmax(rounding, noise)
        for k in range(len(laws.x)):
            for way in (-np.inf, np.inf):
                x = met.x[rows].copy()
                x[:, k] = np.nextafter(x[:, k], way)
                other = laws.evaluate(("reset map", jump), jump, met.t[rows], x, p)
                with np.errstate(all="ignore"):
                    moved = np.fmax(moved, np.fmax.reduce(np.abs(other - values), axis=0, initial=0.0))
    return rounding, moved


def _of_gradients(run: Trajectory) -> float:
    """Largest relative error of a gradient of ψ, of which each entry counts by the range of its variable."""
    laws, m = run.system.laws, run.system.laws.most_conserved
    gradients = [[derivative(psi, v) for psi in law.written.conserved for v in laws.x] for law in laws.regions]
    missing = [[Integer(0)] * (m * len(laws.x) - len(one)) for one in gradients]
    values, noise = _along(run, "gradients", [a + b for a, b in zip(gradients, missing, strict=True)])
    extent = np.ptp(run.x, axis=0) if len(run.t) > 1 else np.ones(len(laws.x))
    with np.errstate(all="ignore"):
        sizes = (np.abs(values).reshape(-1, m, len(extent)) * extent).sum(axis=2)
        part = (noise.reshape(m, -1) * extent).sum(axis=1) / np.fmax.reduce(sizes, axis=0)
    return float(np.nan_to_num(part, posinf=0.0).max())


def _along(run: Trajectory, key: str, expressions: Sequence[Sequence[Expr]]) -> tuple[Floats, Floats]:
    """(n, k) values of the expressions of each region at states of a run, nan where it slides; (k,) their rounding."""
    laws, p = run.system.laws, run.system.parameter_array
    rows = np.unique(np.linspace(0, len(run.t) - 1, _STATES).astype(int))
    region = np.where(run.mode[rows] < len(laws.regions), run.mode[rows], -1)

    def of_one(number: int, t: Floats, x: Floats) -> Floats:
        return laws.evaluate((key, number), expressions[number], t, x, p)

    return _and_rounding(
        lambda precision: by_number(region, of_one, run.t[rows].astype(precision), run.x[rows].astype(precision))
    )


def _and_rounding(evaluate: Callable[[Precision], Floats]) -> tuple[Floats, Floats]:
    """(n, k) values in double precision, and (k,) the largest difference from those in extended precision."""
    values = evaluate(np.float64)
    with np.errstate(all="ignore"):
        rounding = np.fmax.reduce(np.abs(evaluate(np.longdouble) - values), axis=0, initial=0.0)
    return values, np.asarray(rounding, dtype=float)
