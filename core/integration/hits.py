"""The crossings that the compiled loop has recorded, as `Crossings`."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from core.integration.crossings import Crossings
from core.integration.recorded import Chunk
from core.kernels.arrays import Floats
from core.symbolic.laws import Laws
from core.transition.records import HIT
from core.transition.status import CROSSING_KINDS

__all__ = ["all_crossings", "crossings_of", "joined", "no_crossings"]

_KINDS = np.array(CROSSING_KINDS)


def crossings_of(hits: NDArray[Any], places: Floats, laws: Laws) -> Crossings:
    """Crossings from records `HIT` and their states (k, 3, d): on the surface, where moved to, and after a jump."""
    surface, x, after = (np.ascontiguousarray(places[:, k]) for k in range(3))
    columns = {name: np.ascontiguousarray(hits[name]) for name in ("t", "g", "rate_before", "rate_after")}
    mode, kind = np.ascontiguousarray(hits["mode"]), _KINDS[hits["kind"]]
    side, met = laws.sides[mode], np.ascontiguousarray(hits["surface"])
    side = side[:, 0] if side.shape[1] == 1 else side
    return Crossings(x=x, x_after=after, surface=surface, mode=mode, kind=kind, side=side, surface_met=met, **columns)


def all_crossings(chunks: list[Chunk], laws: Laws) -> Crossings:
    """Crossings from the chunks that the loop has written."""
    return crossings_of(*joined(chunks, len(laws.x)), laws) if chunks else no_crossings(laws)


def joined(chunks: list[Chunk], d: int) -> Chunk:
    """One chunk of all."""
    hits, places = zip((np.empty(0, dtype=HIT), np.empty((0, 3, d))), *chunks, strict=True)
    return np.concatenate(hits), np.concatenate(places)


@lru_cache(maxsize=256)
def no_crossings(laws: Laws) -> Crossings:
    """No crossings of a system."""
    return crossings_of(np.empty(0, dtype=HIT), np.empty((0, 3, len(laws.x))), laws)
