"""The table of guards and transitions of a system for the time loop."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.symbolic.impacts import stays_on_surface
from core.symbolic.laws import Laws, Way
from core.transition.records import GUARD, JUMP_ANYWHERE, JUMP_TO_SURFACE, NO_JUMP, NO_MODE

__all__ = ["GuardTable", "guard_table"]


class GuardTable(NamedTuple):
    """The guards of all modes."""

    guards: NDArray[Any]
    """(rows,) of `records.GUARD`, one for each guard of each mode."""
    first_rows: NDArray[np.int64]
    """(modes,) row of the first guard of each mode."""


@lru_cache(maxsize=256)
def guard_table(laws: Laws) -> GuardTable:
    """Build the table of a system: what follows where a guard falls to zero.

    Two regions that share a surface follow each other there. Sliding ends where a field turns, in the region of that
    field; where it reaches another surface, nothing follows.
    """
    counts = [len(ways) for ways in laws.ways] + [2 + len(_others(laws, pair)) for pair in laws.pairs]
    first = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    table = np.zeros(first[-1], dtype=GUARD)
    table["mode"], table["count"] = np.repeat(np.arange(len(counts)), counts), np.repeat(counts, counts)
    table["to"] = table["back"] = table["slide"] = table["surface"] = NO_MODE
    for region, ways in enumerate(laws.ways):
        for k, way in enumerate(ways):
            _write_way(laws, table[first[region] + k : first[region] + k + 1], way, first)
    for k, pair in enumerate(laws.pairs):
        _write_sliding(laws, table[first[len(laws.regions) + k] :], pair, first)
    return GuardTable(table, first[:-1])


def _write_way(laws: Laws, guard: NDArray[Any], way: Way, first: NDArray[np.int64]) -> None:
    guard["sign"], guard["surface"], guard["jump"] = way.sign, way.surface, NO_JUMP
    if way.to is not None:
        guard["to"] = first[way.to]
    if way.back is not None:
        guard["back"] = way.back
    if way.jump is not None:
        stays = stays_on_surface(laws.surfaces[way.surface], laws.x, way.jump)
        guard["jump"] = JUMP_TO_SURFACE if stays else JUMP_ANYWHERE
    elif way.sliding is not None:
        guard["slide"] = first[way.sliding]


def _write_sliding(laws: Laws, guards: NDArray[Any], pair: tuple[int, int, int], first: NDArray[np.int64]) -> None:
    minus, plus, surface = pair
    for k, (region, sign) in enumerate(((minus, 1), (plus, -1))):
        back = next(n for n, way in enumerate(laws.ways[region]) if way.surface == surface)
        guards[k]["sign"], guards[k]["turns"], guards[k]["to"], guards[k]["back"] = sign, 1, first[region], back
    others = _others(laws, pair)
    for k, (other, sign) in enumerate(others.items(), start=2):
        guards[k]["sign"], guards[k]["surface"] = sign, other
    guards["slides"][: 2 + len(others)] = 1


def _others(laws: Laws, pair: tuple[int, int, int]) -> dict[int, int]:
    """Number -> sign of the other surfaces that bound the regions of a pair, in the order of the guards of sliding."""
    minus, plus, surface = pair
    ways = (*laws.ways[minus], *laws.ways[plus])
    return {way.surface: way.sign for way in ways if way.surface != surface}
