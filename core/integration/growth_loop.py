"""The loop that follows the solution of one mode by the steps of a run's method, to see whether it grows.

Each step is taken whole and in two halves: where both agree to a tolerance it is right, whatever the order of the
method, and the next one may be longer; else it is halved.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba takes the types from the signature below.

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any

from numba import njit, types

from core.kernels.abi import LEVELS_SET, PREPARE, SET_LEVELS, STEP, Frame, call
from core.kernels.digest import source_digest
from core.kernels.jit import OPTIONS, inlined, internal

__all__ = ["BOUNDED", "GROWTH", "LARGE", "POLE", "UNKNOWN", "compiled_follow", "follow"]

#: What is found: the steps do not tell; the solution grows by less than `GROWTH`; by more; without end, to a pole.
UNKNOWN, BOUNDED, LARGE, POLE = range(4)
#: Growth of the largest coordinate that counts as running away: to a pole, or by an exponential of no practical use.
GROWTH = 1e6
#: Growth that is surely more or less than that, whatever the errors of the steps.
_SURELY = 2.0
#: Difference of a step and its two halves, relative to the size of the state, …
_TOLERANCE = 1e-5
#: … of which a smaller part lets the next step be twice as long: one of order 2 has then eight times the difference.
_EASY = 1.0 / 16.0
#: Most steps tried: some hundred microseconds.
_ATTEMPTS = 2000


@inlined
def largest(x):
    """Largest coordinate, nan if one is nan."""
    size = 0.0
    for i in range(x.size):
        size = abs(x[i]) if not abs(x[i]) <= size else size
    return size


@inlined
def take_step(functions, row, t, h, p, w, scratch, x, increment):
    """Take a step from the state in the frame; returns whether it has a finite solution."""
    solved = call(functions[row, STEP], t, h, p, w, scratch) >= 0
    for i in range(x.size):
        x[i] += increment[i]
        solved = solved and abs(x[i]) < math.inf
    return solved


@inlined
def prepare(functions, row, t, h, p, w, scratch):
    """Prepare steps of a variable-step method from the state in the frame."""
    w[LEVELS_SET] = 0.0
    call(functions[row, PREPARE], t, h, p, w, scratch)


@internal
def compare(functions, row, adaptive, t, h, p, w, scratch, x, increment, room):
    """Take a step from room[0] whole, to room[1], and in two halves, to x; returns their largest difference, or nan."""
    for i in range(x.size):
        x[i] = room[0, i]
    if adaptive:
        prepare(functions, row, t, h, p, w, scratch)
    solved = take_step(functions, row, t, h, p, w, scratch, x, increment)
    for i in range(x.size):
        room[1, i], x[i] = x[i], room[0, i]
    solved = solved and take_step(functions, row, t, 0.5 * h, p, w, scratch, x, increment)
    if solved and adaptive:
        prepare(functions, row, t + 0.5 * h, 0.5 * h, p, w, scratch)
    if not (solved and take_step(functions, row, t + 0.5 * h, 0.5 * h, p, w, scratch, x, increment)):
        return math.nan
    for i in range(x.size):
        room[1, i] -= x[i]
    return largest(room[1])


@internal
def follow(functions, row, adaptive, conservative, p, w, head, scratch, room, t, t_end, h, size, most):
    """Follow the solution from room[0]; see `compiled_follow`."""
    d = room.shape[1]
    x, carry, increment = w[head : head + d], w[head + d : head + 2 * d], w[head + 2 * d : head + 3 * d]
    for i in range(d):
        x[i], carry[i] = room[0, i], 0.0
    if conservative:
        call(functions[row, SET_LEVELS], t, 0.0, p, w, scratch)
    peak = largest(x)
    size = max(size, peak)
    if size == 0.0:
        size = 1.0
    if most == 0.0:
        most = _SURELY * GROWTH * size
    for _ in range(_ATTEMPTS):
        last = not abs(h) < abs(t_end - t)
        if last:
            h = t_end - t
        if t + 0.5 * h == t:
            return POLE if peak > _SURELY * GROWTH * size else UNKNOWN
        error, allowed = compare(functions, row, adaptive, t, h, p, w, scratch, x, increment, room), 0.0
        if error >= 0.0:
            allowed = _TOLERANCE * max(size, largest(x))
        if not error <= allowed:
            h *= 0.5
            continue
        for i in range(d):
            room[0, i] = x[i]
        t += h
        peak = max(peak, largest(x))
        if peak >= most:
            return LARGE
        if last:
            if peak < GROWTH * size / _SURELY:
                return BOUNDED
            return LARGE if peak > _SURELY * GROWTH * size else UNKNOWN
        if error < _EASY * allowed:
            h *= 2.0
    return UNKNOWN


@lru_cache(maxsize=1)
def compiled_follow() -> Callable[..., int]:
    """Compile the loop, or load it from numba's cache.

    Returns
    -------
    follow(functions, row, adaptive, conservative, p, w, scratch, room, t, t_end, h, size, most) -> int
        One of the codes above, for the solution from the state room[0] of room (2, d) at time t to time t_end, with the
        field of the mode of a row. w is a frame for this alone, h the length of the first step, size the largest
        coordinate of the run's start. Once a coordinate reaches `most` the answer
        is LARGE; where that is 0, once it has surely grown by `GROWTH`.
    """
    vector, matrix = types.float64[::1], types.float64[:, ::1]
    addresses, number, whole = types.Array(types.int64, 2, "C"), types.float64, types.int64
    signature: Any = whole(
        addresses, whole, types.boolean, types.boolean, vector, vector, matrix, matrix,
        number, number, number, number, number,
    )  # fmt: skip
    sources, head = source_digest(__name__), Frame(0, 0).x

    @njit(signature, cache=True, nogil=True, **OPTIONS)
    def followed(functions, row, adaptive, conservative, p, w, scratch, room, t, t_end, h, size, most):
        _ = sources  # closed over, it enters the key of numba's cache
        return follow(functions, row, adaptive, conservative, p, w, head, scratch, room, t, t_end, h, size, most)

    return followed  # type: ignore[no-any-return]
