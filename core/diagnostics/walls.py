"""Regions in which no state can be: beyond walls, at which every run bounces."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

import numpy as np
import sympy
from numpy.typing import NDArray

from core.codegen.rounding import with_roundings
from core.diagnostics.crossing_rates import constant_sign, rate_on_surface, ratio
from core.integration.trajectory import Trajectory
from core.kernels.arrays import Floats
from core.symbolic import Laws, eliminated
from core.symbolic.zero_testing import is_zero
from core.system import PiecewiseSystem

__all__ = ["beyond_walls", "inhabited", "start_warning", "starts_beyond_wall"]

_EPS = 2.0**-52


def inhabited(system: PiecewiseSystem, met: Iterable[int] = (), t: float = 0.0) -> frozenset[int]:
    """Return the numbers of the regions in which a state may be.

    These are the regions of the declared start and those that runs have met, and all to which ways lead from there. No
    way leads through a surface whose reset map sends every run back: there the field of a region always leaves the
    surface after the reset map as it came.

    Parameters
    ----------
    met
        Numbers of regions in which runs are known to be.
    t
        Time of the declared start.
    """
    regions = range(len(system.laws.regions))
    if not system.laws.jumps:
        return frozenset(regions)
    at_start = [mode for mode in regions if (system.heights(mode, t, system.x0) >= 0.0).all()]
    found, left = set[int](), [*met, *at_start]
    while left:
        mode = left.pop()
        if mode not in found:
            found.add(mode)
            ways = system.laws.ways[mode]
            left += [way.to for k, way in enumerate(ways) if way.to is not None and not _bounces(system, mode, k)]
    return frozenset(found)


def beyond_walls(system: PiecewiseSystem, t: float, x: Floats) -> NDArray[np.bool_]:
    """Return which of some states (..., d) lie in a region in which no state can be; not on its wall, to rounding."""
    laws, found = system.laws, np.zeros(x.shape[:-1], dtype=bool)
    both = laws.evaluate("surfaces", with_roundings(laws.surfaces), t, x, system.parameter_array)
    heights, roundings = np.split(both, 2, axis=-1)
    sides = np.where(np.abs(heights) <= _EPS * roundings, 0.0, np.sign(heights))
    for mode in frozenset(range(len(laws.regions))) - inhabited(system, t=t):
        found |= np.logical_and.reduce([way.sign * sides[..., way.surface] > 0.0 for way in laws.ways[mode]])
    return found


def starts_beyond_wall(run: Trajectory) -> bool:
    """Whether a run starts in a region in which, by the declared start of its system, no state can be."""
    return bool(beyond_walls(run.system, float(run.t[0]), run.x[0]))


def start_warning(run: Trajectory) -> str:
    """Say that a run starts beyond a wall, in a sentence; '' where it does not."""
    return "The start lies beyond a wall, at which every run bounces back." if starts_beyond_wall(run) else ""


def _bounces(system: PiecewiseSystem, mode: int, number: int) -> bool:
    """Whether a reset map sends every run that reaches a guard of a region back into the region."""
    back = _rate_back(system.laws, mode, number)
    return back is not None and constant_sign(system, back) == -1


@lru_cache(maxsize=256)
def _rate_back(laws: Laws, mode: int, number: int) -> sympy.Expr | None:
    """Return the rate after a reset map that leads from the surface to the surface, over that before it; else None."""
    way, region = laws.ways[mode][number], laws.regions[mode]
    if way.jump is None or way.back is None:  # a one-way guard leads on, wherever the reset map has led
        return None
    g, reset = laws.surfaces[way.surface], dict(zip(laws.x, way.jump, strict=True))
    if not is_zero(eliminated(g.xreplace(reset), g, laws.x)):
        return None
    before = rate_on_surface(laws, region, way)
    after = eliminated(region.rate_of(g).xreplace(reset), g, laws.x)
    return ratio(after, before)
