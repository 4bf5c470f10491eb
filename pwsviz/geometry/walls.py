"""What the page calls the part of the plane where no state can be: no law is declared, or a wall is in the way."""

from __future__ import annotations

from collections.abc import Collection

import core

__all__ = ["bare_name"]

NO_LAW = "no law"
"""What the page calls a region for which no law is declared."""

BEYOND = "beyond the wall"
"""What it calls one in which no state can be."""


def bare_name(system: core.PiecewiseSystem, there: Collection[int]) -> str:
    """Return what the page calls the part of the plane outside these regions; "" where they have names, or fill it."""
    count, declared = system.laws.sides.shape[1], len(system.laws.regions)
    bare = [NO_LAW] * (declared < 2**count) + [BEYOND] * (len(there) < declared)
    return " or ".join(bare) if count else ""
