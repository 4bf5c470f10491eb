"""Giving up a computation whose result is no longer wanted."""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["Cancel", "Cancelled", "raise_if"]

Cancel = Callable[[], bool]
"""Returns True once the work should be given up."""


class Cancelled(Exception):  # noqa: N818 - not an error of the program
    """A computation was given up because its `cancel` returned True."""


def raise_if(cancel: Cancel | None) -> None:
    """Raise `Cancelled` if the work should be given up."""
    if cancel is not None and cancel():
        raise Cancelled
