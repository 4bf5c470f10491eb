"""How a system meets the surface of a section: in one direction or both, and with a reset map or none."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import core
from core.diagnostics import constant_sign, rate_on_surface, ratio
from core.maps import own_surface
from core.symbolic import Mode, Way

__all__ = ["chosen_direction", "has_reset", "is_one_way", "may_slide", "usual_direction"]


@lru_cache(maxsize=256)
def has_reset(system: core.PiecewiseSystem, of: str) -> bool:
    """Return whether a reset map acts at the surface of a section; `of` is h, or "" for the switching surfaces."""
    return any(way.jump is not None for _, way in _ways(system, of))


@lru_cache(maxsize=256)
def is_one_way(system: core.PiecewiseSystem, of: str) -> bool:
    """Return whether the declaration lets runs meet the surface, or every one of several, in one direction only.

    So it is with a reset map or a wall, and where a region with a name ends.
    """
    surfaces = {way.surface for _, way in _ways(system, of)}
    return bool(surfaces) and surfaces == _one_way(system, of)


def _one_way(system: core.PiecewiseSystem, of: str) -> set[int]:
    """Return the numbers of the surfaces that runs meet in one direction only."""
    return {way.surface for _, way in _ways(system, of) if way.jump is not None or way.back is None}


def chosen_direction(system: core.PiecewiseSystem, of: str, direction: int) -> int:
    """Return a direction as it is counted: 0, for both, where runs meet the surface in one direction only."""
    return 0 if is_one_way(system, of) else direction


@lru_cache(maxsize=256)
def usual_direction(system: core.PiecewiseSystem, of: str, slides: bool) -> int:
    """Return the direction in which the points of a closed curve are counted: 1 where h rises, 0 for both.

    Where h rises a simple loop has one point. Both are needed if runs may meet the surface in one direction only: also
    where they may slide along it, as sliding begins there and is left without crossing.

    Parameters
    ----------
    slides
        Whether runs slide along the surface where it attracts.
    """
    ways = list(_ways(system, of))
    surfaces = {way.surface for _, way in ways}
    both = all(_signs(system, [one for one in ways if one[1].surface == k]) >= {-1, 1} for k in surfaces)
    return int(both and not _one_way(system, of) and not (slides and any(_may_slide(system, *one) for one in ways)))


@lru_cache(maxsize=256)
def may_slide(system: core.PiecewiseSystem) -> bool:
    """Return whether runs may slide along a surface: false where the rates of g always have one sign on both sides."""
    return any(_may_slide(system, *one) for one in _ways(system, ""))


def _ways(system: core.PiecewiseSystem, of: str) -> Iterator[tuple[Mode, Way]]:
    """Yield region and transition for each way across the surface; none where nothing switches there.

    A region that is not declared is left out: no run goes on there.
    """
    own = own_surface(system, of or None)
    for mode, ways in zip(system.laws.regions, system.laws.ways, strict=True):
        for way in ways:
            if own is not None and own.has(way.surface) and (way.to is not None or way.jump is not None):
                yield mode, way


def _signs(system: core.PiecewiseSystem, ways: list[tuple[Mode, Way]]) -> set[int]:
    """Return the signs that the rates of a switching function may have on its surface."""
    found: set[int] = set()
    for mode, way in ways:
        sign = constant_sign(system, rate_on_surface(system.laws, mode, way))
        found |= {-1, 1} if sign is None else {sign}
    return found


def _may_slide(system: core.PiecewiseSystem, mode: Mode, way: Way) -> bool:
    """Whether the rates on both sides of a way may differ in sign."""
    if way.to is None:
        return False
    before, after = (rate_on_surface(system.laws, one, way) for one in (mode, system.laws.regions[way.to]))
    return before != after and constant_sign(system, ratio(before, after)) != 1
