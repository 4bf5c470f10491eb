"""A cache of bounded size, in which no two threads compute the same value."""

from __future__ import annotations

from collections import Counter, OrderedDict
from collections.abc import Callable, Hashable
from concurrent.futures import Future
from dataclasses import fields, is_dataclass
from threading import Lock
from typing import Any, TypeVar

import numpy as np

import core
from pwsviz.tasks.cancellation import Cancelled

Value = TypeVar("Value")


MAX_VALUES = 10_000
"""Most values kept, however small."""


class Cache:
    """Drops the least recently used values once the arrays exceed `max_bytes`, or there are more than `MAX_VALUES`.

    Parameters
    ----------
    max_bytes : int
        Bound on the bytes of all arrays kept. A value larger than this is returned but not kept.
    """

    def __init__(self, max_bytes: int = 256_000_000) -> None:
        self.max_bytes = max_bytes
        self.computed: Counter[str] = Counter()
        """How often a value of each kind was computed, not found."""
        self._lock = Lock()
        self._computing: dict[Hashable, Future[Any]] = {}
        self._kept: OrderedDict[Hashable, tuple[Any, int]] = OrderedDict()  # values and their bytes, by their last use
        self._held = 0

    def get(self, kind: str, inputs: Hashable, compute: Callable[[], Value]) -> Value:
        """Return the value for (`kind`, `inputs`), computing it unless it is kept or another thread is computing it.

        If that other computation is cancelled, this thread computes the value.
        """
        key = (kind, inputs)
        while True:
            with self._lock:
                if key in self._kept:
                    kept: Value = self._recall(key)
                    return kept
                future = self._computing.get(key)
                mine = future is None
                if future is None:
                    future = self._computing[key] = Future()
                    self.computed[kind] += 1
            if mine:
                return self._fill(key, future, compute)
            try:
                value: Value = future.result()
            except Cancelled:
                continue
            return value

    def found(self, kind: str, inputs: Hashable) -> Any:
        """Return the value for (`kind`, `inputs`) if it is kept, else None; nothing is computed or waited for."""
        key = (kind, inputs)
        with self._lock:
            return self._recall(key) if key in self._kept else None

    def _recall(self, key: Hashable) -> Any:
        self._kept.move_to_end(key)
        return self._kept[key][0]

    def _fill(self, key: Hashable, future: Future[Any], compute: Callable[[], Value]) -> Value:
        try:
            value = compute()
        except BaseException as reason:
            with self._lock:
                del self._computing[key]
            future.set_exception(reason)
            raise
        future.set_result(value)
        size = nbytes(value)  # the arrays of a run may be made only now
        with self._lock:
            del self._computing[key]
            if size <= self.max_bytes:
                self._kept[key] = value, size
                self._held += size
            while self._held > self.max_bytes or len(self._kept) > MAX_VALUES:
                _, (_, freed) = self._kept.popitem(last=False)
                self._held -= freed
        return value


def nbytes(value: object) -> int:
    """Return the bytes of the arrays in a dataclass, a sequence or an array, nested ones included."""
    if isinstance(value, np.ndarray | core.Trajectory):
        return value.nbytes
    if isinstance(value, list | tuple):
        return sum(nbytes(item) for item in value)
    if is_dataclass(value):
        return sum(nbytes(getattr(value, field.name)) for field in fields(value))
    return 0
