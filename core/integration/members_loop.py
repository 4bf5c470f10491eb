"""The loop over the members of an ensemble: it begins each from a blank record, and calls the time loop."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba takes the types from the signature below.

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numba
import numpy as np
from numba import njit, types

from core.integration.psi_loop import PSI_TYPES, begin_psi, follow_psi, psi_of
from core.integration.run import SHORTER
from core.integration.time_loop import march_signature
from core.kernels.abi import STEP, Frame
from core.kernels.digest import source_digest
from core.kernels.jit import OPTIONS, internal
from core.transition.records import EVENT, GUARD, HIT, NO_MODE, ROW, RUN
from core.transition.status import Status
from core.transition.surface import is_wanted

__all__ = [
    "ABANDONED", "ASKS", "COUNTERS", "DONE", "END", "FAILED", "FAILURES", "NEXT", "ROOM", "USED", "WANTED",
    "compiled_members",
]  # fmt: skip

#: What the loop returns: all members are done; it was told to stop; the member needs what only `Runner` knows; the
#: buffer of crossings is used up, or that of failures.
DONE, ABANDONED, ASKS, ROOM, FAILURES = range(5)

#: How a member ended; its state is kept apart.
END = np.dtype(
    [
        ("t", np.float64),
        ("status", np.int64),
        ("mode", np.int64),
        ("steps", np.int64),
        ("evaluations", np.int64),
        ("crossings", np.int64),
        ("kept", np.int64),  # crossings kept
        ("first_mode", np.int64),
        ("change_of_psi", np.float64),  # the largest, if it is wanted
        ("unlike", np.float64),  # as in the record of the run
    ],
    align=True,
)

#: Which crossings, or events, are kept.
WANTED = np.dtype(
    [
        ("events", np.int64),  # 1: events; 0: crossings
        ("surface", np.int64),  # those of this surface; ANY_SURFACE: of any; −1: all
        ("way", np.int64),  # 1: where its switching function rises, −1: where it falls, 0: both
        ("discard", np.int64),  # but for so many of the first of each member
        ("most", np.int64),  # at most so many of each, which ends with the last
        ("psi", np.int64),  # 1: the largest |Δψ| is wanted, too, for which all crossings are kept
    ],
    align=True,
)

#: Indices into the counters of a block: the next member, how many crossings its buffers hold of those before, how many
#: of its own, how many wanted ones it has had, discarded ones included, and how many members have failed.
NEXT, USED, OWN, HAD, FAILED = range(5)
COUNTERS = 5

_RUNNING, _STEP_LIMIT = int(Status.RUNNING), int(Status.STEP_LIMIT)
_NO_CONVERGENCE, _ESCAPED, _CORNER = int(Status.NO_CONVERGENCE), int(Status.ESCAPED), int(Status.CORNER)
_UNDECLARED = int(Status.UNDECLARED)
_SLIDING, _REPELLING, _GRAZING = int(Status.SLIDING), int(Status.REPELLING), int(Status.GRAZING)


@internal
def is_settled(status, run, jumps):
    """Whether a run ends with a status, and does not go on with what only `Runner` knows."""
    if (status == _SLIDING and jumps == 1) or run.retracted == 1:
        return False
    undecided = status in (_SLIDING, _REPELLING, _GRAZING)
    return status != _CORNER and not (undecided and run.first_mode == NO_MODE)


@internal
def stops_at_surface(status):
    """Whether a run of this status stops at a surface."""
    return status in (_SLIDING, _REPELLING, _GRAZING, _CORNER, _UNDECLARED)


@internal
def is_getting_shorter(status, run, since, made, budget):
    """Whether a call of the loop that made all its steps went so short a way that a pole may lie ahead.

    `Runner` looks for it; no step of fixed size enters `longest`.
    """
    steps = run.steps - made
    return status == _RUNNING and steps == budget and abs(run.t - since) < SHORTER * steps * run.longest


@internal
def begin(blank, frame, row, guard, tau, shift, x, records, w, head):
    """Make a run that has not begun from the blank one; row and guard are those of its first region."""
    records[0] = blank[0]
    records[0].row, records[0].guard = row, guard
    for k in range(records.size):  # the other one locates events
        records[k].tau, records[k].shift = math.copysign(tau, blank[0].tau), math.copysign(1.0, blank[0].tau) * shift
    for i in range(w.size):
        w[i] = frame[i]
    for i in range(x.size):
        w[head + i] = x[i]


@internal
def keep(number, wanted, hits, places, first, kept, kept_places, counters):
    """Keep the crossings of the last call of the loop that are wanted, but for the first ones of the member.

    The states that are kept are those from column `first` of places on.

    Returns
    -------
    How many wanted ones it has had in all; −1 where there is no room.
    """
    count, used = counters[HAD], counters[USED] + counters[OWN]
    for j in range(number):
        if count - wanted.discard == wanted.most:
            break
        if not is_wanted(hits[j], wanted.surface, wanted.way):
            continue
        count += 1
        if count <= wanted.discard:
            continue
        if used == kept.size:
            return -1
        kept[used] = hits[j]
        for i in range(places.shape[2]):
            for column in range(kept_places.shape[1]):  # with states after jumps
                kept_places[used, column, i] = places[j, first + column, i]
        used += 1
    counters[HAD], counters[OWN] = count, used - counters[USED]
    return count


def _signature() -> Any:
    blank, guards, run, row, hit = (numba.from_dtype(d)[::1] for d in (RUN, GUARD, RUN, ROW, HIT))
    ends, wanted, events = (numba.from_dtype(d)[::1] for d in (END, WANTED, EVENT))
    vector, matrix, places = types.float64[::1], types.float64[:, ::1], types.float64[:, :, ::1]
    whole = types.int64
    return whole(
        types.FunctionType(march_signature()), whole[:, ::1], guards, blank, vector, whole, matrix, matrix, matrix,
        run, vector, row, matrix, hit, places, places, matrix, matrix, matrix, events, hit, places, vector, matrix,
        whole, whole, whole[::1], whole[::1], vector, vector, matrix, matrix, ends, matrix, wanted, hit, places,
        whole[::1], whole[::1], *PSI_TYPES, whole, whole, whole[::1], run, matrix, hit, places,
    )  # fmt: skip


@lru_cache(maxsize=1)
def compiled_members() -> Callable[..., int]:
    """Compile the loop, or load it from numba's cache.

    Returns
    -------
    members(march, functions, guards, blank, frame, d, scratch, nodes, pieces,
            records, w, rows, rows_x, hits, places, envelope, samples, looks, passes, events, found, found_x, v, series,
            budget, max_steps, first_rows, first_guards, tau, shift, p, x, ends, x_ends, wanted, kept, kept_places,
            counters, told, *PsiArrays, regions, jumps, failed, failed_records, failed_w, failed_hits,
            failed_places) -> int
        One of the codes above. It takes the members from counters[NEXT] on, until told[0] is not 0. `march` is the time
        loop, and the names of its arguments are those there. `blank` and `frame` are the record and the frame of a run
        that has not begun. first_rows (n,) are the rows of the members' first regions, `NO_MODE` where `Runner` has to
        find it, and first_guards (n,) the guards at which they begin; tau (n,) and shift (n,) are their step sizes and
        perturbations; p (n, parameters) and x (n, d) their parameters and states, and x_ends (n, d) their last states.
        A member that has had all crossings, or events, that are wanted of it ends there, as the time loop ends it. Then
        come those of `psi_loop`, and whether the system has jumps. The
        last are the numbers of the members of which a step has failed, with their records and frames then, and their
        last crossings: why, `Runner` has to find out.
    """
    sources, head = source_digest(__name__), Frame(0, 0).x

    @njit(_signature(), cache=True, nogil=True, **OPTIONS)
    def members(
        march, functions, guards, blank, frame, d, scratch, nodes, pieces,
        records, w, rows, rows_x, hits, places, envelope, samples, looks, passes, events, found, found_x, v, series,
        budget, max_steps, first_rows, first_guards, tau, shift, p, x, ends, x_ends, wanted, kept, kept_places,
        counters, told, levels, level_rows, level_frame, sums, followed, regions, jumps,
        failed, failed_records, failed_w, failed_hits, failed_places,
    ):  # fmt: skip
        _ = sources  # closed over, it enters the key of numba's cache
        run = records[0]
        for k in range(counters[NEXT], first_rows.size):
            counters[NEXT] = k
            fails = counters[FAILED]
            if fails == failed.size:
                return FAILURES
            if first_rows[k] == NO_MODE or functions[first_rows[k], STEP] == 0:
                return ASKS
            begin(blank, frame, first_rows[k], first_guards[k], tau[k], shift[k], x[k], records, w, head)
            psi = psi_of(levels, level_rows, level_frame, sums, followed, regions, p[k], scratch, d)
            run.record, begun = wanted[0].psi, 0
            counters[OWN], counters[HAD], status = 0, 0, _RUNNING
            while status == _RUNNING:
                if told[0] != 0:
                    return ABANDONED
                if run.steps >= max_steps:
                    status = _STEP_LIMIT
                    break
                if run.pending == 1 and (run.asked != 0 or functions[run.row, STEP] == 0):
                    return ASKS
                part, since, made = min(budget, max_steps - run.steps), run.t, run.steps
                status = march(
                    functions, guards, records, p[k], w, d, scratch, nodes, pieces, part,
                    rows, rows_x, hits, places, envelope, samples, looks, passes, events, found, found_x, v, series,
                )  # fmt: skip
                if run.crowded == 1 or is_getting_shorter(status, run, since, made, budget):
                    return ASKS
                if wanted[0].events == 1:
                    count = keep(run.found, wanted[0], found, found_x, 0, kept, kept_places, counters)
                else:
                    first = 1 - wanted[0].psi
                    count = keep(run.hits, wanted[0], hits, places, first, kept, kept_places, counters)
                if count < 0:
                    return ROOM
                if run.hits > 0:
                    failed_hits[fails] = hits[run.hits - 1]
                    for i in range(d):
                        failed_places[fails, 2, i] = places[run.hits - 1, 2, i]
                if wanted[0].psi == 1:
                    own = counters[USED]
                    if begun == 0 and not begin_psi(psi, run.first_mode, blank[0].t, x[k]):
                        return ASKS
                    begun = 1
                    if not follow_psi(psi, run.rows, rows, rows_x, kept[own:], kept_places[own:]):
                        return ASKS
            if not is_settled(status, run, jumps):
                return ASKS
            if run.pending == 1 and stops_at_surface(status) and counters[OWN] > 0 and wanted[0].events == 0:
                kept[counters[USED] + counters[OWN] - 1].mode = NO_MODE  # the mode that followed could not be begun
            if wanted[0].psi == 1:
                own, stays = counters[USED], stops_at_surface(status) and jumps == 0
                rows[0].t, rows[0].mode, rows[0].segment = run.t, run.mode, max(run.crossings - stays, 0)
                for i in range(d):
                    rows_x[0, i] = w[head + i]
                if not follow_psi(psi, 1, rows, rows_x, kept[own:], kept_places[own:]):
                    return ASKS
                ends[k].change_of_psi = followed[0].largest
            end = ends[k]
            end.t, end.status, end.mode, end.steps = run.t, status, run.mode, run.steps
            end.evaluations, end.crossings, end.kept = run.evaluations, run.crossings, counters[OWN]
            end.first_mode, end.unlike = run.first_mode, run.unlike
            for i in range(d):
                x_ends[k, i] = w[head + i]
            if status in (_NO_CONVERGENCE, _ESCAPED):
                failed[fails], failed_records[fails] = k, run
                for i in range(w.size):
                    failed_w[fails, i] = w[i]
                counters[FAILED] += 1
            counters[USED] += counters[OWN]
            counters[NEXT] = k + 1
        return DONE

    return members  # type: ignore[no-any-return]
