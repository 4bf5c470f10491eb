"""Cancelling a computation, and reporting its progress."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

__all__ = ["Cancel", "Cancelled", "Report", "never", "silent"]

Cancel = Callable[[], bool]
"""Returns whether the computation should stop."""

Report = Callable[[int, int, Any], object]
"""Called with the number of parts done, the number of all parts, and the partial result."""


class Cancelled(Exception):  # noqa: N818  (not an error)
    """A computation was stopped because its result is no longer needed."""


def silent(_done: int, _total: int, _partial: object) -> None:
    """Ignore progress."""


def never() -> bool:
    """Return False: the computation is never cancelled."""
    return False
