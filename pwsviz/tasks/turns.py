"""Short computations of all pages take turns: threads that keep switching take longer together."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Condition
from time import monotonic

__all__ = ["Turns"]

LONGEST = 0.05
"""Seconds after which a turn is over even if its computation is not, which then runs beside the next."""


class Turns:
    """Lets one thread compute at a time, but keeps nobody waiting for a long computation."""

    def __init__(self) -> None:
        self._changed = Condition()
        self._latest = 0
        self._ends: float | None = None

    @contextmanager
    def one(self) -> Iterator[None]:
        """Wait for a turn, and end it with the block."""
        with self._changed:
            while self._ends is not None and (left := self._ends - monotonic()) > 0:
                self._changed.wait(left)
            self._latest = number = self._latest + 1
            self._ends = monotonic() + LONGEST
        try:
            yield
        finally:
            with self._changed:
                if number == self._latest:  # else another turn has begun, as this one was long
                    self._ends = None
                    self._changed.notify()
