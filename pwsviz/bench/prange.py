"""The time loop called for each member of an ensemble in a `prange` of numba."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba takes the types from the arguments.

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numba
import numpy as np
from numba import njit, prange, types
from numpy.typing import NDArray

import core
from core.integrate import checked_settings
from core.integration import HIT, ROW, Frame, Runner, compiled_march, march_signature

__all__ = ["ends_by_prange"]

#: Crossings that one call of the loop can record.
_HITS = 64
#: Parts of the members, each with memory of its own, for numba to share among its threads.
_PARTS = 64


def ends_by_prange(
    system: core.PiecewiseSystem, x0: NDArray[np.float64], tolerance: float, end: float
) -> NDArray[np.float64]:
    """Return the last states (n, d) of members that begin at x0 (n, d), by the Taylor method.

    A member whose run needs Python, as where a step fails, keeps the state at which that happens.
    """
    method = core.METHODS["taylor"]
    runner = Runner(system, method, 0.0, tuple(x0[0].tolist()), checked_settings(method, None, tolerance))
    blank, d = runner.blank(end), system.dimension
    one = blank.memory
    memory = (
        np.empty((_PARTS, 1), dtype=one.record.dtype), np.empty((_PARTS, one.w.size)), np.empty((_PARTS, 1), dtype=ROW),
        np.empty((_PARTS, 1, d)), np.empty((_PARTS, _HITS), dtype=HIT), np.empty((_PARTS, _HITS, 3, d)),
        *(
            np.empty((_PARTS, *a.shape))
            for a in (one.coefficients, one.nodes, one.pieces, one.samples, one.looks, one.passes)
        ),
        np.empty((_PARTS, *blank.envelope.shape)),
    )  # fmt: skip
    ends = np.empty_like(x0)
    arguments = (
        blank.functions, blank.guards, one.record, one.w, one.p, d, blank.budget, *memory, *blank.events, x0, ends,
    )  # fmt: skip
    _compiled(tuple(map(numba.typeof, arguments)))(compiled_march(), *arguments)
    return ends


@lru_cache(maxsize=1)
def _compiled(kinds: tuple[Any, ...]) -> Callable[..., None]:
    """Compile the loop over the members for arguments of some types; it calls the time loop by its address."""
    head = Frame(0, 0).x

    @njit(cache=True, nogil=True, error_model="numpy")
    def one_part(
        march, functions, guards, blank, frame, p, d, budget,
        record, w, rows, rows_x, hits, places, scratch, nodes, pieces, samples, looks, passes, envelope,
        events, found, found_x, located, series, x, ends, first, last,
    ):  # fmt: skip
        for k in range(first, last):
            record[0] = blank[0]
            w[:] = frame
            w[head : head + d] = x[k]
            status = 0
            while status == 0:
                status = march(
                    functions, guards, record, p, w, d, scratch, nodes, pieces, budget, rows, rows_x, hits, places,
                    envelope, samples, looks, passes, events, found, found_x, located, series,
                )  # fmt: skip
            ends[k] = w[head : head + d]

    @njit((types.FunctionType(march_signature()), *kinds), parallel=True, cache=True, error_model="numpy")
    def over_members(
        march, functions, guards, blank, frame, p, d, budget,
        records, w, rows, rows_x, hits, places, scratch, nodes, pieces, samples, looks, passes, envelopes,
        events, found, found_x, located, series, x, ends,
    ):  # fmt: skip
        parts, n = len(records), len(x)
        for part in prange(parts):
            one_part(
                march, functions, guards, blank, frame, p, d, budget, records[part], w[part], rows[part], rows_x[part],
                hits[part], places[part], scratch[part], nodes[part], pieces[part], samples[part], looks[part],
                passes[part], envelopes[part], events, found, found_x, located, series, x, ends,
                part * n // parts, (part + 1) * n // parts,
            )  # fmt: skip

    return over_members
