"""Dense output: states between recorded ones, by steps of the run's own method.

Each is reached by one step of the method (`abi` allows any length) from the last state recorded before it, or from the
state after the last crossing before it. So ψ is kept as well as along the run, the order is that of the method, and no
step reaches across a crossing.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba takes the types from the signature below.

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numba import njit, types
from numpy.typing import NDArray

from core.compilation.compiled import Compiled, compile_run, modes_entered
from core.compilation.guards import guard_table
from core.kernels.abi import LEVELS_SET, ORDER, PREPARE, SET_LEVELS, STEP, TOLERANCE, Frame, call
from core.kernels.arrays import Floats
from core.kernels.digest import source_digest
from core.kernels.doubledouble.error_free import two_sum
from core.kernels.jit import OPTIONS, internal
from core.kernels.taylor_coefficients import STRIDE, order_of
from core.methods import Method
from core.methods.taylor_step import coefficient_rows
from core.system import PiecewiseSystem

__all__ = ["Found", "Stepper", "Track", "compiled_between"]

Integers = NDArray[np.int64]

#: A step without solution is replaced by up to 2**_HALVINGS shorter ones, after about 2,000 trial steps in all.
_HALVINGS = 10


class Track(NamedTuple):
    """Part of a run: states at the ends of steps, and where it entered each segment between crossings."""

    t: Floats
    """(n,) times in the order of the run, which may go back in time."""
    x: Floats
    """(n, d) states."""
    mode: Integers
    """(n,) mode occupied."""
    segment: Integers
    """(n,) index of the segment in which each state lies."""
    entered_t: Floats
    """(s,) times at which the segments from number `first` on were entered."""
    entered_x: Floats
    """(s, d) states there."""
    entered_mode: Integers
    """(s,) modes entered."""
    first: int = 0


class Found(NamedTuple):
    """States at k times."""

    x: Floats
    """(k, d) states; nan where the step there has no solution, and at later times in that step."""
    mode: Integers
    """(k,) mode occupied."""
    segment: Integers
    """(k,) index of the segment in which each lies."""
    solved: int
    """Number of states before the first without a solution."""


class Stepper:
    """Takes steps of a method from recorded states of a run."""

    def __init__(self, system: PiecewiseSystem, method: Method, tolerance: float) -> None:
        d, m = system.dimension, system.laws.most_conserved_sliding
        self._laws, self._method = system.laws, method
        self._along, self._p, self._w = compiled_between(), system.parameter_array.copy(), Frame(d, m).empty()
        self._d, self._adaptive, self._conservative = d, method.adaptive, method.conservative
        if method.adaptive:
            self._w[ORDER], self._w[TOLERANCE] = order_of(tolerance), tolerance

    def find(self, track: Track, times: Floats) -> Found:
        """States at times within the track, which must be in the order of the run.

        At the time of a crossing this is the state after it, from which the run continued.
        """
        n = len(times)
        x, mode, segment = np.empty((n, self._d)), np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
        sign = 1.0 if track.t[-1] >= track.t[0] else -1.0
        arrays = (np.ascontiguousarray(a) for a in track[:-1])
        compiled, scratch = self._functions(np.unique(np.concatenate([track.mode, track.entered_mode])))
        solved = self._along(
            compiled.addresses, guard_table(self._laws).first_rows, self._p, self._w, scratch, self._d, self._adaptive,
            self._conservative,
            sign, *arrays, track.first, times, x, mode, segment,
        )  # fmt: skip
        return Found(x, mode, segment, int(solved))

    def _functions(self, modes: Integers) -> tuple[Compiled, Floats]:
        """The compiled functions of some modes, and memory for them."""
        needed = tuple(sorted({*modes_entered(self._laws, self._method), *modes[modes >= 0].tolist()}))
        rows = coefficient_rows(self._laws, needed) if self._adaptive else 1
        return compile_run(self._laws, self._method, modes=needed), np.empty((rows, STRIDE))


@internal
def expand(functions, t, h, mode, p, w, scratch):
    """Prepare a step of a variable-step method from the state in the frame."""
    w[LEVELS_SET] = 0.0  # its levels may have been set at another state
    call(functions[mode, PREPARE], t, h, p, w, scratch)


@internal
def try_step(functions, t, h, mode, p, w, scratch, increment):
    """Try a step from the state in the frame; returns whether it has a finite solution."""
    solved = call(functions[mode, STEP], t, h, p, w, scratch) >= 0
    for i in range(increment.size):
        solved = solved and abs(increment[i]) < math.inf
    return solved


@internal
def step_in_parts(functions, t, h, mode, adaptive, p, w, scratch, x, carry, increment, start):
    """Replace a step by 2, 4, 8 … shorter ones; returns whether that succeeds, with the state in x."""
    parts = 1
    for _ in range(_HALVINGS):
        parts *= 2
        for i in range(x.size):
            x[i], carry[i] = start[i], 0.0
        solved = True
        for k in range(parts):
            now = t + h * (k / parts)
            if adaptive:
                expand(functions, now, h / parts, mode, p, w, scratch)
            if not try_step(functions, now, h / parts, mode, p, w, scratch, increment):
                solved = False
                break
            for i in range(x.size):
                x[i], carry[i] = two_sum(x[i], carry[i] + increment[i])
        if solved:
            return True
    return False


@internal
def last_row(t, sign, row, time):
    """Last row, from `row` on, that is not after a time: by exponential and binary search."""
    stride = 1
    while row + stride < t.size and sign * t[row + stride] <= sign * time:
        row += stride
        stride *= 2
    while stride > 0:
        if row + stride < t.size and sign * t[row + stride] <= sign * time:
            row += stride
        stride //= 2
    return row


def _signature() -> Any:
    vector, matrix, whole = types.float64[::1], types.float64[:, ::1], types.int64[::1]
    times, states = types.Array(types.float64, 1, "C", readonly=True), types.Array(types.float64, 2, "C", readonly=True)
    numbers = types.Array(types.int64, 1, "C", readonly=True)
    addresses, first_rows = types.Array(types.int64, 2, "C", readonly=True), types.Array(types.int64, 1, "C")
    track = (times, states, numbers, numbers, times, states, numbers)
    return types.int64(
        addresses, first_rows, vector, vector, matrix, types.int64, types.boolean, types.boolean, types.float64,
        *track, types.int64, times, matrix, whole, whole,
    )  # fmt: skip


@lru_cache(maxsize=1)
def compiled_between() -> Callable[..., int]:
    """Compile the loop over times, or load it from numba's cache."""
    sources, head = source_digest(__name__), Frame(0, 0).x

    @njit(_signature(), cache=True, nogil=True, **OPTIONS)
    def along(
        functions, first_rows, p, w, scratch, d, adaptive, conservative, sign,
        t, x, modes, segment, entered_t, entered_x, entered_mode, first, times, found, found_modes, segments,
    ):  # fmt: skip
        _ = sources  # closed over, it enters the key of numba's cache
        place, carry, increment = w[head : head + d], w[head + d : head + 2 * d], w[head + 2 * d : head + 3 * d]
        row, now = -1, -1  # the row before, and the segment whose levels are set
        here, start, begin, mode, fresh = 0, x[0], t[0], first_rows[0], True  # the mode by its first row
        solved, fails = times.size, False
        for k in range(times.size):
            time = times[k]
            before = row
            row = last_row(t, sign, max(row, 0), time)
            if row != before:
                here, start, begin, fresh, fails = segment[row], x[row], t[row], True, False
                mode = first_rows[max(modes[row], 0)]  # where the run has stopped, no step is taken
            # A crossing displaced by a perturbation counts from its displaced time on, but within its step.
            while row + 1 < t.size and here < segment[row + 1]:
                entry = here + 1 - first
                ahead = sign * (entered_t[entry] - time) > 0.0
                if ahead or (time == t[row] and entered_t[entry] != time):
                    break
                here, start, begin, fresh, fails = here + 1, entered_x[entry], entered_t[entry], True, False
                mode = first_rows[max(entered_mode[entry], 0)]
            segments[k] = here
            found_modes[k] = modes[row] if here == segment[row] else entered_mode[here - first]
            h = time - begin
            if h == 0.0:
                for i in range(d):
                    found[k, i] = start[i]
                continue
            if fails:
                found[k] = math.nan
                continue
            if fresh:
                if conservative and now != here:
                    now = here
                    for i in range(d):
                        place[i], carry[i] = entered_x[here - first, i], 0.0
                    call(functions[mode, SET_LEVELS], entered_t[here - first], 0.0, p, w, scratch)
                for i in range(d):
                    place[i], carry[i] = start[i], 0.0
                if adaptive:
                    expand(functions, begin, h, mode, p, w, scratch)
                fresh = False
            if try_step(functions, begin, h, mode, p, w, scratch, increment):
                for i in range(d):
                    found[k, i] = place[i] + increment[i]
                continue
            fresh = True
            if not step_in_parts(functions, begin, h, mode, adaptive, p, w, scratch, place, carry, increment, start):
                solved, fails = min(solved, k), True
                found[k] = math.nan
                continue
            for i in range(d):
                found[k, i] = place[i]
        return solved

    return along  # type: ignore[no-any-return]
