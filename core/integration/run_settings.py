"""Settings of a run other than its method."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.integration.events import NOTHING, Watched
from core.transition.records import ANY_SURFACE, NO_MODE
from core.transition.status import CROSSING_KINDS

__all__ = ["ALL", "Asked", "CrossingsOf", "Settings"]

_CORNER = CROSSING_KINDS.index("corner")


class CrossingsOf(NamedTuple):
    """The first crossings of a surface."""

    surface: int = -1
    """Its number; `records.ANY_SURFACE`: of any; −1: all, also where sliding ends by itself."""
    way: int = 0
    """1: those where its switching function rises, −1: where it falls, 0: both."""
    most: int = 2**62
    """How many."""

    def among(self, hits: NDArray[Any], before: NDArray[np.int64] | int, sides: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return which crossings of a run are of that surface and way.

        A corner is a crossing of each surface of which it changes the side.

        Parameters
        ----------
        hits
            (k,) of `records.HIT`.
        before
            Mode occupied before each of them.
        sides
            `Laws.sides`.
        """
        of_it = (self.surface == -1) | (hits["surface"] == self.surface)
        of_it |= (self.surface == ANY_SURFACE) & (hits["surface"] >= 0)
        which: NDArray[np.bool_] = (hits["rate_before"] * self.way >= 0.0) & of_it
        if 0 <= self.surface < sides.shape[1]:
            change = sides[hits["mode"], self.surface] - sides[before, self.surface]
            which = np.where(hits["kind"] == _CORNER, (change != 0) & (change * self.way >= 0), which)
        return np.asarray(which)


ALL = CrossingsOf()
"""All crossings."""


@dataclass(frozen=True)
class Settings:
    """Settings of a run other than its method."""

    tau: float
    """Step size; infinite where the method chooses it."""
    tolerance: float = math.nan
    """Tolerance of a method that chooses its step size; else nan."""
    transition: bool = True
    """Whether crossings are located; else the surface is stepped over."""
    shift: float = 0.0
    """Perturbation c·τᵖ, added to every crossing time."""
    max_crossings: int = 5_000_000
    max_wanted: CrossingsOf = ALL
    """The run ends with the last of them, too."""
    max_steps: int = 10**9
    max_events: int = 1_000_000
    slides: bool = False
    """Whether the run slides along the surface where both fields point to it; else it stops there."""
    region: int = NO_MODE
    """Number of the region in which the run begins; NO_MODE: one in which its initial state lies."""
    events: Watched = NOTHING
    """The events to be found."""
    cancel: Callable[[], bool] | None = None


class Asked(NamedTuple):
    """What a run was asked for, besides its system and its method."""

    t0: float
    x0: tuple[float, ...]
    t_end: float
    settings: Settings
