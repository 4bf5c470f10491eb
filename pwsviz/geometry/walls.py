"""Where no state can be: where no law is declared, and beyond walls, at which every run bounces."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from functools import lru_cache

import sympy

import core
from core.symbolic import Laws, eliminated
from pwsviz.geometry.crossing_rates import constant_sign, rate_on_surface, ratio

__all__ = ["bare_name", "inhabited"]

NO_LAW = "no law"
"""What the page calls a region for which no law is declared."""

BEYOND = "beyond the wall"
"""What it calls one in which no state can be."""


def inhabited(system: core.PiecewiseSystem, met: Iterable[int] = ()) -> frozenset[int]:
    """Return the numbers of the regions in which a state may be.

    These are the regions of the declared start and those that runs have met, and all to which ways lead from there. No
    way leads through a surface whose reset map sends every run back: there the field of a region always leaves the
    surface after the reset map as it came.

    Parameters
    ----------
    met
        Numbers of regions in which runs are known to be.
    """
    regions = range(len(system.laws.regions))
    if not system.laws.jumps:
        return frozenset(regions)
    at_start = [mode for mode in regions if (system.heights(mode, 0.0, system.x0) >= 0.0).all()]
    found, left = set[int](), [*met, *at_start]
    while left:
        mode = left.pop()
        if mode not in found:
            found.add(mode)
            ways = system.laws.ways[mode]
            left += [way.to for k, way in enumerate(ways) if way.to is not None and not _bounces(system, mode, k)]
    return frozenset(found)


def bare_name(system: core.PiecewiseSystem, there: Collection[int]) -> str:
    """Return what the page calls the part of the plane outside these regions; "" where they have names, or fill it."""
    count, declared = system.laws.sides.shape[1], len(system.laws.regions)
    bare = [NO_LAW] * (declared < 2**count) + [BEYOND] * (len(there) < declared)
    return " or ".join(bare) if count else ""


def _bounces(system: core.PiecewiseSystem, mode: int, number: int) -> bool:
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
    if sympy.simplify(eliminated(g.xreplace(reset), g, laws.x)) != 0:
        return None
    before = rate_on_surface(laws, region, way)
    after = eliminated(region.rate_of(g).xreplace(reset), g, laws.x)
    return ratio(after, before)
