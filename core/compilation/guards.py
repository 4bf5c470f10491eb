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
    counts = [len(laws.ways_from(mode)) for mode in range(laws.count)]
    first = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    table = np.zeros(first[-1], dtype=GUARD)
    table["mode"], table["count"] = np.repeat(np.arange(len(counts)), counts), np.repeat(counts, counts)
    table["to"] = table["back"] = table["slide"] = table["surface"] = NO_MODE
    for region, ways in enumerate(laws.ways):
        for k, way in enumerate(ways):
            _write_way(laws, table[first[region] + k : first[region] + k + 1], way, first)
    for mode in range(len(laws.regions), laws.count):
        _write_sliding(table[first[mode] : first[mode + 1]], laws.ways_from(mode), first)
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


def _write_sliding(guards: NDArray[Any], ways: tuple[Way, ...], first: NDArray[np.int64]) -> None:
    guards["slides"] = 1
    for guard, way in zip(guards, ways, strict=True):
        guard["sign"] = way.sign
        if way.to is None:
            guard["surface"] = way.surface
        else:
            guard["turns"], guard["to"], guard["back"] = 1, first[way.to], way.back
