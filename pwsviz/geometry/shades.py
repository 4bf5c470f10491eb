"""The shade and the name of where a run is: two shades tell neighbouring regions apart, a third one is for sliding."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

import core
from core.symbolic import Laws, Mode

__all__ = ["SHADES", "SLIDING", "region_name", "regions_of", "shade_names", "shades_of"]

SLIDING = 0
"""The shade of sliding."""

SHADES = (-1, 1, SLIDING)
"""All shades. Of one surface they are its sides."""

MOST_NAMES = 2
"""Most regions that a name lists."""


def shades_of(system: core.PiecewiseSystem, mode: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return (n,) the shades of modes; that of a run which has stopped at a surface is `SLIDING`, too."""
    return _shades(system.laws)[mode]


def _shades(laws: Laws) -> NDArray[np.int64]:
    """Return the shade of each mode: the product of its signs, as neighbours differ in one of them."""
    if laws.sides.shape[1]:
        return np.asarray(laws.sides.prod(axis=1))
    shades = np.zeros(laws.count + 1, dtype=np.int64)
    shades[: len(laws.regions)] = np.resize([-1, 1], len(laws.regions))
    return shades


def regions_of(system: core.PiecewiseSystem, shade: int) -> list[int]:
    """Return the numbers of the regions that have a shade."""
    return np.flatnonzero(_shades(system.laws)[: len(system.laws.regions)] == shade).tolist()


def region_name(region: Mode) -> str:
    """Return the name of a region as it is printed: its signs, as “−+”, or the name it was given."""
    return region.name.replace("-", "−") if region.sides else region.name


def shade_names(system: core.PiecewiseSystem) -> Mapping[int, str]:
    """Return what a legend calls each shade: “g < 0”, or the regions that have it."""
    if system.two_sided:
        return {-1: "g < 0", 1: "g > 0", SLIDING: "sliding"}
    names = {}
    for shade in (-1, 1):
        regions = [region_name(system.laws.regions[k]) for k in regions_of(system, shade)]
        few = regions if len(regions) <= MOST_NAMES else [regions[0], "…"]
        names[shade] = f"region{'s' * (len(regions) > 1)} {', '.join(few)}"
    return {**names, SLIDING: "sliding"}
