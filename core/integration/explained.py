"""Causes with words: why a run ends, and what to do about it."""

from __future__ import annotations

from enum import Enum

__all__ = ["Explained"]


class Explained(Enum):
    """A cause whose value is why the run ends, in plain words, and what to do about it."""

    @property
    def reason(self) -> str:
        """Why the run ends."""
        return str(self.value[0])

    @property
    def advice(self) -> str:
        """What to do about it."""
        return str(self.value[1])
