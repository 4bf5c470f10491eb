"""Work that can be given up, and that says how far it has come."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

__all__ = ["Cancel", "Cancelled", "Report", "never", "silent"]

Cancel = Callable[[], bool]
"""Asked whether to give up."""

Report = Callable[[int, int, Any], object]
"""Told how much of a study is done, of how much, and the study as far as it has come."""


class Cancelled(Exception):  # noqa: N818  (not an error: the person has moved on)
    """A computation was given up because nobody waits for it any more."""


def silent(_done: int, _total: int, _partial: object) -> None:
    """Leave progress unsaid."""


def never() -> bool:
    """Answer the question whether to give up with no."""
    return False
