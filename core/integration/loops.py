"""The loops that are compiled once on a machine, for all systems and methods."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from core.integration.conserved_error import compiled_error
from core.integration.dense_output import compiled_between
from core.integration.growth_loop import compiled_follow
from core.integration.members_loop import compiled_members
from core.integration.psi_loop import compiled_psi
from core.integration.time_loop import compiled_march

__all__ = ["LOOPS_BESIDE"]

LOOPS_BESIDE: tuple[Callable[[], object], ...] = (
    compiled_between,
    compiled_error,
    compiled_psi,
    partial(compiled_march, True),
    compiled_members,
    compiled_follow,
)
"""What compiles each loop besides the time loop itself, which a first run waits for: those first that it needs next."""
