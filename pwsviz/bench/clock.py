"""Wall-clock times of repeated calls."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable
from typing import TypeVar

__all__ = ["first_call", "timed"]

Result = TypeVar("Result")


def timed(
    call: Callable[[], Result], repeats: int, seconds: float, before: Callable[[], object] | None = None
) -> list[tuple[float, Result]]:
    """Wall time (s) and result of repeated calls, after one that is thrown away.

    The garbage collector rests meanwhile, as in `timeit`. Take the least time: what is above it is other processes.

    Parameters
    ----------
    repeats
        How many calls are kept at most, at least 1.
    seconds
        No further call is begun when those kept have taken this long.
    before
        Called before every call, and not timed.
    """
    prepare = before if before is not None else _nothing
    prepare()
    call()
    kept: list[tuple[float, Result]] = []
    collects = gc.isenabled()
    gc.disable()
    try:
        while len(kept) < max(repeats, 1) and sum(wall for wall, _ in kept) < seconds:
            prepare()
            started = time.perf_counter()
            result = call()
            kept.append((time.perf_counter() - started, result))
    finally:
        if collects:
            gc.enable()
    return kept


def first_call(call: Callable[[], object]) -> float:
    """Wall time (s) by which a first call is longer than a second: what is compiled, or loaded from disk."""
    started = time.perf_counter()
    call()
    between = time.perf_counter()
    call()
    return max(2 * between - started - time.perf_counter(), 0.0)


def _nothing() -> None:
    pass
