"""The shade and the name of where a run is: regions between which a run may pass differ in it; sliding has its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

import core
from core.symbolic import Laws, Mode

__all__ = [
    "REGION_SHADES", "SHADES", "SLIDING", "coloured", "region_name", "regions_of", "shade_names", "shades_of",
]  # fmt: skip

SLIDING = 0
"""The shade of sliding."""

REGION_SHADES = (-1, 1, 2, 3)
"""Shades of regions, in the order of their use. Of one surface the first two are its sides."""

SHADES = (*REGION_SHADES, SLIDING)
"""All shades."""

LONGEST = 24
"""Most characters of the names of regions that a legend lists; beyond them, regions are counted or told by signs."""


def shades_of(system: core.PiecewiseSystem, mode: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return (n,) the shades of modes; that of a run which has stopped at a surface is `SLIDING`, too."""
    return _shades(system.laws)[mode]


def _shades(laws: Laws) -> NDArray[np.int64]:
    """Return the shade of each mode: the product of its signs, as neighbours differ in one of them.

    Regions that have names are shaded by the ways between them.
    """
    if laws.sides.shape[1]:
        return np.asarray(laws.sides.prod(axis=1))
    around: list[set[int]] = [set() for _ in laws.regions]
    for k, ways in enumerate(laws.ways[: len(around)]):
        for to in {way.to for way in ways if way.to is not None} - {k}:
            around[k].add(to)
            around[to].add(k)
    return np.array(coloured(around) + [SLIDING] * (laws.count + 1 - len(around)))


def coloured(around: Sequence[set[int]]) -> list[int]:
    """Return a shade for each region, given its neighbours: another one than theirs while there are enough.

    The next region is always the one with most shades around it, which needs only two shades where two suffice. Where
    all are taken around a region, it has the one that fewest of its neighbours have.
    """
    shades: dict[int, int] = {}
    while len(shades) < len(around):
        left = [k for k in range(len(around)) if k not in shades]
        region = max(left, key=lambda k: len({shades[n] for n in around[k] if n in shades}))
        taken = [shades[n] for n in around[region] if n in shades]
        shades[region] = min(REGION_SHADES, key=taken.count)
    return [shades[k] for k in range(len(around))]


def regions_of(system: core.PiecewiseSystem, shade: int) -> list[int]:
    """Return the numbers of the regions that have a shade."""
    return np.flatnonzero(_shades(system.laws)[: len(system.laws.regions)] == shade).tolist()


def region_name(region: Mode) -> str:
    """Return the name of a region as it is printed: its signs, as “−+”, or the name it was given."""
    return region.name.replace("-", "−") if region.sides else region.name


def shade_names(system: core.PiecewiseSystem) -> Mapping[int, str]:
    """Return what a legend calls each shade that is used: “g < 0”, or the regions that have it."""
    if system.two_sided:
        return {-1: "g < 0", 1: "g > 0", SLIDING: "sliding"}
    names = {}
    for shade in REGION_SHADES:
        regions = [region_name(system.laws.regions[k]) for k in regions_of(system, shade)]
        if not regions:
            continue
        if system.laws.sides.shape[1] and len(", ".join(regions)) > LONGEST:  # the product of their signs is the shade
            names[shade] = f"regions with an {'odd' if shade < 0 else 'even'} number of −"
        else:
            names[shade] = f"region{'s' * (len(regions) > 1)} {_listed(regions)}"
    return {**names, SLIDING: "sliding"}


def _listed(regions: Sequence[str]) -> str:
    """Return names of regions, as many as fit; the rest are counted."""
    fit = [k for k in range(1, len(regions) + 1) if len(", ".join(regions[:k])) <= LONGEST]
    count = max(fit, default=1)
    rest = len(regions) - count
    return ", ".join(regions[:count]) + (f" and {rest} more" if rest else "")
