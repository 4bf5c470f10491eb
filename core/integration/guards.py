"""The table of guards and transitions of a system for the time loop."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from core.symbolic.laws import Laws
from core.transition.records import (
    GUARD,
    JUMP_ANYWHERE,
    JUMP_TO_SURFACE,
    NO_JUMP,
    SIDES_OF_MODES,
    SLIDING_MODE,
)

__all__ = ["guard_table"]


@lru_cache(maxsize=256)
def guard_table(laws: Laws) -> NDArray[Any]:
    """Guards (modes + 1,) of `records.GUARD`: both sides end at the same surface, where each is followed by the other.

    Sliding ends where a field turns, on the side of that field; forward in time the heights of its guards are ġ₋, −ġ₊.
    """
    table = np.zeros(len(SIDES_OF_MODES) + 1, dtype=GUARD)
    table["sign"], table["to"], table["jump"] = [-1, 1, 1, -1], [1, 0, 0, 1], NO_JUMP
    if laws.jump is not None:
        table["jump"][:SLIDING_MODE] = JUMP_TO_SURFACE if laws.jump_stays else JUMP_ANYWHERE
    return table
