"""What the page calls the part of the plane where no state can be: no law is declared, or a wall is in the way."""

from __future__ import annotations

from collections.abc import Collection

import core

__all__ = ["bare_name"]

NO_LAW = "no law"
"""What the page calls a region for which no law is declared, where a run that reaches it ends."""

BEYOND = "beyond the wall"
"""What it calls one in which no state can be, as runs jump at all of its surfaces."""


def bare_name(system: core.PiecewiseSystem, there: Collection[int]) -> str:
    """Return what the page calls the part of the plane outside these regions; "" where they have names, or fill it."""
    count, declared = system.laws.sides.shape[1], len(system.laws.regions)
    walled = all(way.jump is not None for ways in system.laws.ways for way in ways if way.to is None)
    bare = [BEYOND if walled else NO_LAW] * (declared < 2**count) + [BEYOND] * (len(there) < declared)
    return " or ".join(dict.fromkeys(bare)) if count else ""
