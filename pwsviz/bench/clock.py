"""Wall-clock times of repeated calls."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable
from typing import TypeVar

__all__ = ["first_call", "timed"]

Result = TypeVar("Result")


def timed(
    call: Callable[[], Result],
    repeats: int,
    seconds: float,
    before: Callable[[], object] | None = None,
    warm: bool = False,
) -> list[tuple[float, Result]]:
    """Wall time (s) and result of repeated calls, after a warm-up that is thrown away.

    The garbage collector rests meanwhile, as in `timeit`. Take the least time: what is above it is other processes.

    Parameters
    ----------
    repeats
        How many calls are kept at most, at least 2: a machine may stall once.
    seconds
        No third call, or later one, is begun when those kept have taken this long.
    before
        Called before every call, and not timed.
    warm
        Whether the warm-up is done already.
    """
    prepare = before if before is not None else _nothing
    if not warm:
        prepare()
        call()
    kept: list[tuple[float, Result]] = []
    collects = gc.isenabled()
    gc.disable()
    try:
        while len(kept) < 2 or (len(kept) < repeats and sum(wall for wall, _ in kept) < seconds):
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
