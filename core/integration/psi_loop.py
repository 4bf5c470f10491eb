"""The largest |Δψ| of a run, found as its steps are taken: the compiled part. See `Trajectory.change_of_psi`."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba takes the types from the signatures of the loops.

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numba
import numpy as np
from numba import njit, types
from numpy.typing import NDArray

from core.kernels.abi import LEVEL_RESIDUAL, SET_LEVELS, VECTORS, Frame, call
from core.kernels.arrays import Floats
from core.kernels.digest import source_digest
from core.kernels.jit import OPTIONS, inlined, internal
from core.transition.records import HIT, NO_MODE, ROW
from core.transition.status import CROSSING_KINDS

__all__ = ["FOLLOWED", "PSI_TYPES", "PsiArrays", "begin_psi", "compiled_psi", "follow_psi", "psi_of"]

_JUMP, _LEAVING = CROSSING_KINDS.index("jump"), CROSSING_KINDS.index("leaving")
#: Place of the state in a frame.
_HEAD = Frame(0, 0).x

#: What is known of ψ along a run.
FOLLOWED = np.dtype(
    [
        ("largest", np.float64),  # |Δψ| off the surface so far; nan where ψ has had no value
        ("segment", np.int64),  # index of the segment between crossings
        ("mode", np.int64),  # mode occupied in it
    ],
    align=True,
)


class PsiArrays(NamedTuple):
    """Arguments of the loop that have to do with ψ."""

    levels: NDArray[np.int64]
    """As `Compiled.addresses`, with the functions of ψ."""
    first_rows: NDArray[np.int64]
    """(modes,) rows of the modes in it."""
    frame: Floats
    """A frame of its own, in which ψ is evaluated."""
    sums: Floats
    """(2, m) change of ψ in the segments before, and at the last crossing."""
    followed: NDArray[Any]
    """(1,) of `FOLLOWED`."""


#: Types of `PsiArrays` as arguments of a compiled loop.
PSI_TYPES: Any = (
    types.int64[:, ::1], types.int64[::1], types.float64[::1], types.float64[:, ::1], numba.from_dtype(FOLLOWED)[::1],
)  # fmt: skip


class Psi(NamedTuple):
    """The same in the loop: views of the frame and of the sums, and the parameters of the run."""

    levels: Any
    first_rows: Any
    regions: Any
    p: Any
    w: Any
    scratch: Any
    place: Any
    residual: Any
    total: Any
    change: Any
    followed: Any


@inlined
def psi_of(levels, first_rows, frame, sums, followed, regions, p, scratch, d):
    """Make a `Psi`; regions is the number of modes that do not slide."""
    m = (frame.size - _HEAD - VECTORS * d) // 3  # quantities for which the frame has room
    place, residual = frame[_HEAD : _HEAD + d], frame[frame.size - m :]
    return Psi(levels, first_rows, regions, p, frame, scratch, place, residual, sums[0], sums[1], followed)


@inlined
def evaluate(psi, function, mode, t, x):
    """Call a function of ψ at a state."""
    for i in range(x.size):
        psi.place[i] = x[i]
    call(psi.levels[psi.first_rows[mode], function], t, 0.0, psi.p, psi.w, psi.scratch)


@internal
def enter(psi, mode, t, x):
    """Take the values of ψ in a mode at a state as its levels; returns whether the functions are compiled."""
    psi.followed[0].mode = mode
    if mode != NO_MODE:
        if psi.levels[psi.first_rows[mode], SET_LEVELS] == 0:
            return False
        evaluate(psi, SET_LEVELS, mode, t, x)
    return True


@internal
def count_state(psi, mode, t, x):
    """Let a state count for the largest |Δψ|, unless it slides, or has stopped at a surface."""
    followed = psi.followed[0]
    if mode == NO_MODE or mode >= psi.regions:
        return
    evaluate(psi, LEVEL_RESIDUAL, mode, t, x)
    for j in range(psi.total.size):
        size = abs(psi.residual[j] + psi.total[j])
        if size > followed.largest or (followed.largest != followed.largest and size == size):
            followed.largest = size


@inlined
def add_residual(psi, mode, t, x):
    """Add the level residual at a state to the change at the crossing, where it has a value."""
    evaluate(psi, LEVEL_RESIDUAL, mode, t, x)
    for j in range(psi.total.size):
        if psi.residual[j] == psi.residual[j]:
            psi.change[j] += psi.residual[j]


@internal
def pass_crossing(psi, hit, places):
    """Add up the changes of ψ at the end of a segment, and enter the next one: see `Trajectory.carried_error`."""
    followed, on, moved = psi.followed[0], hit.mode != NO_MODE, False
    for j in range(psi.total.size):
        psi.change[j] = 0.0
    if hit.kind != _LEAVING and followed.mode != NO_MODE:
        add_residual(psi, followed.mode, hit.t, places[1])
    for i in range(places.shape[1]):
        moved = moved or places[2, i] != places[0, i]
    if on and moved and hit.kind != _JUMP and hit.mode < psi.regions:  # the run goes on from a state off the surface
        if not enter(psi, hit.mode, hit.t, places[0]):
            return False
        add_residual(psi, hit.mode, hit.t, places[2])
    for j in range(psi.total.size):
        psi.total[j] += psi.change[j]
    followed.segment += 1
    return enter(psi, hit.mode, hit.t, places[2])


@internal
def begin_psi(psi, mode, t, x):
    """Begin at the start of a run; returns whether the functions of its mode are compiled."""
    followed = psi.followed[0]
    followed.largest, followed.segment = np.nan, 0
    for j in range(psi.total.size):
        psi.total[j] = 0.0
    if not enter(psi, mode, t, x):
        return False
    count_state(psi, mode, t, x)
    return True


@internal
def follow_psi(psi, count, rows, rows_x, hits, places):
    """Follow ψ through some recorded steps, and the crossings between them.

    hits and places (crossings, 3, d) are all of the run so far. Returns whether the functions of ψ are compiled in all
    modes that are entered.
    """
    followed = psi.followed[0]
    for k in range(count):
        mode = rows[k].mode
        while followed.segment < rows[k].segment:
            last = followed.segment
            if not pass_crossing(psi, hits[last], places[last]):
                return False
            if mode != NO_MODE and hits[last].mode == NO_MODE and not enter(psi, mode, hits[last].t, places[last, 2]):
                return False  # after a jump the run could not begin the mode of which its state is
        count_state(psi, mode, rows[k].t, rows_x[k])
    return True


@lru_cache(maxsize=1)
def compiled_psi() -> Callable[..., None]:
    """Compile the loop over the recorded steps of a whole run, or load it from numba's cache.

    Returns
    -------
    through(*PsiArrays, regions, p, scratch, d, t0, x0, first_mode, rows, rows_x, hits, places)
        It leaves the largest |Δψ| in `PsiArrays.followed`.
    """
    vector, matrix, places = types.float64[::1], types.float64[:, ::1], types.float64[:, :, ::1]
    whole, row, hit = types.int64, numba.from_dtype(ROW)[::1], numba.from_dtype(HIT)[::1]
    signature = types.void(
        *PSI_TYPES, whole, vector, matrix, whole, types.float64, vector, whole, row, matrix, hit, places
    )
    sources = source_digest(__name__)

    @njit(signature, cache=True, nogil=True, **OPTIONS)
    def through(
        levels, first_rows, frame, sums, followed, regions, p, scratch, d, t0, x0, mode, rows, rows_x, hits, places
    ):
        _ = sources  # closed over, it enters the key of numba's cache
        psi = psi_of(levels, first_rows, frame, sums, followed, regions, p, scratch, d)
        begin_psi(psi, mode, t0, x0)
        follow_psi(psi, rows.size, rows, rows_x, hits, places)

    return through
