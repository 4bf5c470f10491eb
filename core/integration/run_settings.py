"""Settings of a run other than its method."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from core.integration.events import NOTHING, Watched

__all__ = ["Asked", "Settings"]


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
    max_steps: int = 10**9
    max_events: int = 1_000_000
    slides: bool = False
    """Whether the run slides along the surface where both fields point to it; else it stops there."""
    events: Watched = NOTHING
    """The events to be found."""
    cancel: Callable[[], bool] | None = None


class Asked(NamedTuple):
    """What a run was asked for, besides its system and its method."""

    t0: float
    x0: tuple[float, ...]
    t_end: float
    settings: Settings
