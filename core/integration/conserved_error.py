"""The error of ψ at every recorded state of a run, evaluated in double-double by compiled functions."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba takes the types from the signature below.

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
import sympy
from numba import njit, types
from numpy.typing import ArrayLike, NDArray

from core.compilation.compiled import compile_run, modes_entered
from core.compilation.guards import guard_table
from core.kernels.abi import LEVEL_RESIDUAL, SET_LEVELS, VECTORS, Frame, call
from core.kernels.arrays import Floats
from core.kernels.digest import source_digest
from core.kernels.jit import OPTIONS
from core.methods import METHODS
from core.system import PiecewiseSystem
from core.transition.records import NO_MODE

__all__ = ["compiled_error", "largest_size", "level_residual_along", "psi_size", "with_exits"]


def level_residual_along(
    system: PiecewiseSystem,
    method: str,
    t: Floats,
    x: Floats,
    mode: NDArray[np.int64],
    segment: NDArray[np.int64],
    entered_t: Floats,
    entered_x: Floats,
    sliding: bool = False,
) -> Floats:
    """ψ of the mode occupied, less its value where that mode was entered; of sliding's g, that within rounding is zero.

    Parameters
    ----------
    method
        Name of the run's method, whose compiled functions are used here.
    t, x, mode, segment
        (n,), (n, d), (n,), (n,) as in `Trajectory`.
    entered_t, entered_x
        (s,), (s, d) as in `Trajectory`.
    sliding
        Whether the run may slide, so that there is a column for g where it may be a further conserved quantity.

    Returns
    -------
    (n, m) with m the largest number of conserved quantities; nan where the mode has fewer.
    """
    laws, frame = system.laws, Frame(system.dimension, system.laws.most_conserved_sliding)
    d, m = frame.d, frame.m if sliding else laws.most_conserved
    residual = np.full((len(t), m), np.nan)
    if m and len(t):
        known = modes_entered(laws, METHODS[method], True)
        known.update(np.flatnonzero(np.bincount(mode[mode != NO_MODE])).tolist())  # np.unique takes ten times as long
        modes = tuple(sorted(known))
        functions, table = compile_run(laws, METHODS[method], levels=True, modes=modes), guard_table(laws)
        w, scratch = frame.empty(), np.empty((1, 1))
        rows = (np.ascontiguousarray(a) for a in (t, x, mode, segment, entered_t, entered_x))
        compiled_error()(
            functions.addresses, table.first_rows, system.parameter_array.copy(), w, scratch, d, *rows, residual
        )
    return residual


def largest_size(error: Floats) -> Floats:
    """Return (n,) the largest |error| over m conserved quantities, of (n, m) errors; nan where all of them are."""
    largest = np.full(len(error), np.nan)
    for column in error.T:  # numpy's reduction over a short axis takes ten times as long
        np.fmax(largest, np.abs(column), out=largest)
    return largest


def with_exits(error: Floats, segment: NDArray[np.int64], exits: Floats) -> Floats:
    """Replace the error at the last row before a crossing by that at the crossing, where that is larger in size.

    If a segment has no rows, being between two crossings in one step, its exit counts for the row that follows.

    Parameters
    ----------
    error
        (n, m) at the rows; changed in place.
    segment
        (n,) index of the segment between crossings in which each row lies.
    exits
        (k, m) errors at the end of the k-th segment.
    """
    numbers = np.arange(len(exits))
    after = np.searchsorted(segment, numbers, side="right")  # the first row that lies in a later segment
    has_rows = np.searchsorted(segment, numbers, side="left") < after
    row = np.where(has_rows, after - 1, after)
    row = row[row < len(error)]
    for j in range(error.shape[1]):
        found = exits[: len(row), j]
        larger = np.flatnonzero(np.abs(found) > np.nan_to_num(np.abs(error[row, j])))
        larger = larger[np.argsort(np.abs(found[larger]))]  # of several for one row the last, the largest, stays
        error[row[larger], j] = found[larger]
    return error


def psi_size(system: PiecewiseSystem, mode: int, t: ArrayLike, x: ArrayLike) -> Floats:
    """Scale of the round-off of ψ, which may be a small difference of large terms: |ψ| + Σₖ |xₖ ∂ψ/∂xₖ|.

    Rounding the state and ψ to doubles changes ψ by up to eps/2 times this.

    Parameters
    ----------
    mode
        Number of the mode whose ψ is taken: of sliding, what that keeps.
    t, x
        (...) times and (..., d) states.

    Returns
    -------
    (...), the largest over the conserved quantities; 0 where none is known, or where it is not finite.
    """
    laws = system.laws
    sizes = _sizes(laws.mode(mode).conserved, laws.x)
    values = laws.evaluate(("size of psi", mode), sizes, t, x, system.parameter_array)
    largest: Floats = np.where(np.isfinite(values), values, 0.0).max(axis=-1, initial=0.0)
    return largest


@lru_cache(maxsize=256)
def _sizes(conserved: tuple[sympy.Expr, ...], x: tuple[sympy.Symbol, ...]) -> list[sympy.Expr]:
    """Return |ψ| + Σₖ |xₖ ∂ψ/∂xₖ| for each ψ."""
    return [abs(psi) + sum(abs(v * psi.diff(v)) for v in x) for psi in conserved]


@lru_cache(maxsize=1)
def compiled_error() -> Callable[..., None]:
    """Compile the loop over the rows, or load it from numba's cache."""
    vector, matrix, whole = types.float64[::1], types.float64[:, ::1], types.int64[::1]
    signature: Any = types.void(
        types.int64[:, ::1],
        whole,
        vector,
        vector,
        matrix,
        types.int64,
        vector,
        matrix,
        whole,
        whole,
        vector,
        matrix,
        matrix,
    )
    sources, head = source_digest(__name__), Frame(0, 0).x

    @njit(signature, cache=True, nogil=True, **OPTIONS)
    def along(functions, first_rows, p, w, scratch, d, t, x, modes, segment, entered_t, entered_x, residual):
        _ = sources  # closed over, it enters the key of numba's cache
        place, found = w[head : head + d], w[w.size - (w.size - head - VECTORS * d) // 3 :]
        now = -1
        for row in range(t.size):
            mode = modes[row]
            if mode == NO_MODE:  # the run has stopped at the surface
                continue
            if segment[row] != now:
                now = segment[row]
                for i in range(d):
                    place[i] = entered_x[now, i]
                call(functions[first_rows[mode], SET_LEVELS], entered_t[now], 0.0, p, w, scratch)
            for i in range(d):
                place[i] = x[row, i]
            call(functions[first_rows[mode], LEVEL_RESIDUAL], t[row], 0.0, p, w, scratch)
            for j in range(residual.shape[1]):
                residual[row, j] = found[j]

    return along  # type: ignore[no-any-return]
