"""Coordinates that a run's law keeps at zero: what they show is round-off, of no size of its own.

An orbit in an invariant plane, as z = 0 of a planar one in space, leaves it by rounding alone. If errors grow from
there, they matter once they are as large as the other coordinates.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from sympy import Expr, Symbol

from core.integration.trajectory import Trajectory
from core.kernels.arrays import Floats
from core.symbolic.laws import Laws

__all__ = ["with_units_of_others"]


def with_units_of_others(run: Trajectory, units: Floats) -> Floats:
    """Units (..., d) of the coordinates; of those that the law keeps at zero, the largest of the others, ∞ if none."""
    zero = _kept_at_zero(run)
    if not zero.any():
        return units
    known = np.where(np.isfinite(units) & ~zero, units, 0.0).max(axis=-1, keepdims=True)
    return np.asarray(np.where(zero, np.where(known > 0.0, known, np.inf), units))


def _kept_at_zero(run: Trajectory) -> NDArray[np.bool_]:
    """(d,) which coordinates the law keeps at zero, where they are at the start."""
    laws, at_zero = run.system.laws, run.x[0] == 0.0
    zeros = frozenset(x for x, is_zero in zip(laws.x, at_zero, strict=True) if is_zero)
    values = tuple(run.system.values[q.name] for q in run.system.parameters)
    kept = _kept(laws, zeros, values) if zeros else frozenset()
    return np.array([x in kept for x in laws.x])


@lru_cache(maxsize=64)
def _kept(laws: Laws, zeros: frozenset[Symbol], values: tuple[float, ...]) -> frozenset[Symbol]:
    """The variables, of some that are zero, whose rates and jumps vanish wherever all of these are zero."""
    parameters = dict(zip(laws.p, values, strict=True))
    while zeros:
        there = {**parameters, **dict.fromkeys(zeros, 0)}
        moved = {x for x, change in _changes(laws) if x in zeros and change.subs(there) != 0}
        if not moved:
            break
        zeros -= moved
    return zeros


def _changes(laws: Laws) -> Iterator[tuple[Symbol, Expr]]:
    """Each variable with its rate in each region, and with what each jump makes of it."""
    jumps = [way.jump for ways in laws.ways for way in ways if way.jump is not None]
    for changes in (*(region.field for region in laws.regions), *jumps):
        yield from zip(laws.x, changes, strict=True)
