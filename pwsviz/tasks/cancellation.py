"""Cancelling a computation, and reporting its progress."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from core.interface import Cancel, Cancelled

__all__ = ["Cancel", "Cancelled", "Report", "never", "silent"]

Report = Callable[[int, int, Any], object]
"""Called with the number of parts done, the number of all parts, and the partial result."""


def silent(_done: int, _total: int, _partial: object) -> None:
    """Ignore progress."""


def never() -> bool:
    """Return False: the computation is never cancelled."""
    return False
