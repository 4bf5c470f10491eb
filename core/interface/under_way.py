"""What is being compiled at present, for whoever waits for it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["being_compiled", "compiling"]

_names: list[str] = []


@contextmanager
def compiling(name: str) -> Iterator[None]:
    """Note that something is being compiled, or loaded, as long as the block runs; blocks may run in many threads."""
    _names.append(name)
    try:
        yield
    finally:
        _names.remove(name)


def being_compiled() -> str:
    """Return the name of what is being compiled, the first of several that was begun; empty if nothing is."""
    names = _names.copy()
    return names[0] if names else ""
