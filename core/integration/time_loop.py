"""The time loop, compiled once for all systems and methods: it calls their functions by address."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba takes the types from the signature below.

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numba
from numba import njit, types

from core.integration.unlike import STEPS_BETWEEN, look
from core.interface.under_way import compiling
from core.kernels.abi import STEP, VECTORS, Frame, call
from core.kernels.by_reference import by_reference
from core.kernels.digest import source_digest
from core.kernels.doubledouble.error_free import two_sum
from core.kernels.jit import OPTIONS, inlined, internal
from core.transition.entering import begin_mode, enter_first_mode
from core.transition.event_location import BOUND, StepContext
from core.transition.event_search import examine_piece, examine_plain_step
from core.transition.event_watch import Watch, keep_start, note_transitions, watch_start
from core.transition.mannshardt import RUNNING, advance, end_at_once
from core.transition.plain_steps import accept_plain_step, rates_change
from core.transition.records import EVENT, GUARD, HIT, NO_MODE, ROW, RUN
from core.transition.status import Status
from core.transition.surface import Log, guards_contradict, widen_envelope
from core.transition.switching import start_clocks

__all__ = ["compiled_march", "march_signature"]

_COMPLETED, _CONTRADICTION = int(Status.COMPLETED), int(Status.CONTRADICTION)

#: Largest length of the last step in units of τ: rounding then leaves no tiny step at the end.
_STRETCH = 1.0 + 1e-9


@internal
def write_sample(run, x, samples):
    """Sample the start of a step; if the samples are full, drop every second and double the stride."""
    if run.samples == samples.shape[0]:
        run.samples //= 2
        run.stride *= 2
        for k in range(run.samples):
            for i in range(samples.shape[1]):
                samples[k, i] = samples[2 * k, i]
    samples[run.samples, 0], samples[run.samples, 1], samples[run.samples, 2] = run.t, run.mode, 0.0
    for i in range(x.size):
        samples[run.samples, 3 + i] = x[i]
    run.samples += 1
    run.next_sample = run.steps + run.stride


@internal
def end_sample(run, t, samples):
    """End the sample of a step, if there is one, at the crossing found in it."""
    if run.samples == 0 or run.next_sample != run.steps + run.stride or samples[run.samples - 1, 2] != 0.0:
        return
    length = t - samples[run.samples - 1, 0]
    if length == 0.0 or run.shift != 0.0 or run.follow == 0:  # empty, or not a step of the scheme to g = 0
        run.samples -= 1
        run.next_sample = run.steps
    else:
        samples[run.samples - 1, 2] = length


@internal
def write_row(run, x, rows, rows_x):
    """Record a step."""
    row = rows[run.rows]
    row.t, row.mode, row.segment = run.t, run.mode, run.crossings
    for i in range(x.size):
        rows_x[run.rows, i] = x[i]
    run.rows += 1


@inlined
def finish_step(run, x, rows, rows_x, samples):
    """Count a step that has ended, end its sample, and record it."""
    sampled = run.samples > 0 and run.next_sample == run.steps + run.stride
    if sampled and samples[run.samples - 1, 2] == 0.0:
        samples[run.samples - 1, 2] = (run.t - samples[run.samples - 1, 0]) + run.t_carry
    run.steps += 1
    if run.final == 1:
        run.t, run.t_carry = run.t_end, 0.0
    if run.record == 1:
        write_row(run, x, rows, rows_x)


def march_signature() -> Any:
    """Types of the arguments and of the result of the loop, see `compiled_march`."""
    guards, run, row, hit, events = (numba.from_dtype(d)[::1] for d in (GUARD, RUN, ROW, HIT, EVENT))
    vector, matrix, places = types.float64[::1], types.float64[:, ::1], types.float64[:, :, ::1]
    whole = types.int64
    return whole(
        whole[:, ::1], guards, run, vector, vector, whole, matrix, matrix, matrix, whole,
        row, matrix, hit, places, places, matrix, matrix, matrix, events, hit, places, vector, matrix,
    )  # fmt: skip


def compiled_march(watching: bool = False) -> Callable[..., int]:
    """Compile the loop, or load it from numba's cache.

    Parameters
    ----------
    watching
        Whether the runs have event functions. Without what locates events the loop compiles in little more than half
        the time, and most runs have none.

    Returns
    -------
    march(functions, guards, run, p, w, d, scratch, nodes, pieces, budget,
          rows, rows_x, hits, places, envelope, samples, looks, passes, events, found, found_x, v, series) -> int
        A Status. Takes up to `budget` steps or parts of steps, and leaves the records ready for the next call; RUNNING
        means that the budget or a buffer is used up, or that the mode to be entered is not compiled yet. See `abi` for
        functions (rows, functions), p, the frame w and scratch, `records` for the guards (rows,) and records. Without
        events, there is one record, and v and series are not used; for events see `event_search.Watch`, with the frame
        v of their location.
    """
    with compiling("the time loop"):
        return _compiled(bool(watching))


@lru_cache(maxsize=2)
def _compiled(watching: bool) -> Callable[..., int]:
    sources, head = source_digest(__name__), Frame(0, 0).x

    def march(
        functions, guards, records, p, w, d, scratch, nodes, pieces, budget,
        rows, rows_x, hits, places, envelope, samples, looks, passes, events, found, found_x, v, series,
    ):  # fmt: skip
        # Closed over, both enter the key of numba's cache; where `watching` is False, numba leaves out what it guards.
        _ = sources
        run = records[0]
        x, carry = w[head : head + d], w[head + d : head + 2 * d]
        increment, place = w[head + 2 * d : head + 3 * d], w[head + 3 * d : head + 4 * d]
        m = (w.size - head - VECTORS * d) // 3  # quantities for which the frame has room: see `Frame`
        residual = w[w.size - m : w.size - m + envelope.shape[1]]
        context = by_reference(
            StepContext(functions, guards, run, p, w, scratch, x, carry, increment, place, nodes, pieces)
        )
        log = by_reference(Log(hits, places, residual, envelope, passes))
        other = (
            v[head : head + d],
            v[head + d : head + 2 * d],
            v[head + 2 * d : head + 3 * d],
            v[head + 3 * d : head + 4 * d],
        )
        locating = by_reference(
            StepContext(functions, guards, records[records.size // 2], p, v, scratch, *other, nodes, pieces)
        )
        watch = by_reference(Watch(records, events, found, found_x, series, guards.size))
        run.rows = run.hits = run.found = 0
        if run.mode == NO_MODE:
            start_clocks(run, w)
            status = enter_first_mode(context)
            if status != RUNNING:
                return status
        elif run.pending == 1:
            status = begin_mode(context)
            if status != RUNNING or run.pending == 1:
                return status
            if run.rest == 0.0 and run.steps > 0 and run.monitored > 0:
                widen_envelope(context, log)
        while run.past > 0 and run.pending == 0:
            status = end_at_once(context, log)
            if status != RUNNING:
                return status
        if watching:
            note_transitions(run, places, 0)
        if run.pending == 1:
            return RUNNING
        for _ in range(budget):
            if run.rows == rows.size or run.hits == hits.size:
                return RUNNING
            h = run.rest
            if h == 0.0:
                run.final = 0
                if run.steps >= run.next_sample:
                    write_sample(run, x, samples)
                h = (run.t_end - run.t) - run.t_carry
                if h == 0.0:
                    return _CONTRADICTION if guards_contradict(context, 0.0) else _COMPLETED
                if abs(h) <= abs(run.tau) * _STRETCH:
                    run.final = 1
                else:
                    h = run.tau
            if watching:
                if 2 * run.found > found.size or run.crowded == 1:
                    return RUNNING
                watch_start(locating, watch, x, carry)
            # Nearly every step is plain and taken here: passing so many arrays to `advance` costs more than the step.
            t, plain = run.t + run.t_carry, False
            if run.adaptive == 0:
                if run.steps & (STEPS_BETWEEN - 1) == 0:
                    look(run, x, looks)
                count = call(functions[run.row, STEP], t, h, p, w, scratch)
                plain = count >= 0
                for i in range(d):
                    plain = plain and abs(x[i] + increment[i]) < BOUND
                plain = plain and not (guards[run.row].turns == 1 and rates_change(run, w))
                plain = plain and accept_plain_step(run, h, w)
            if plain:
                run.evaluations += count
                for i in range(d):
                    x[i], carry[i] = two_sum(x[i], carry[i] + increment[i])
                run.t, run.t_carry = two_sum(run.t, h + run.t_carry)
                run.rest = 0.0
                if watching:
                    status = examine_plain_step(locating, watch, x, carry, w, h, hits, places)
                    if status != RUNNING:
                        end_sample(run, run.t, samples)
                        return status
            else:
                hits_before = run.hits
                if watching:
                    keep_start(watch, w, v, d)
                status = advance(context, log, h)
                if watching:
                    ended = RUNNING
                    if run.taken != 0.0:
                        ended = examine_piece(locating, watch, x, carry, w, h, run.taken, False, hits, places)
                    if ended != RUNNING:
                        end_sample(run, run.t, samples)
                        return ended
                if run.hits != hits_before:
                    end_sample(run, hits[run.hits - 1].t, samples)
                while status == RUNNING and run.past > 0 and run.pending == 0 and run.hits < hits.size:
                    status = end_at_once(context, log)
                if watching:
                    note_transitions(run, places, hits_before)
                if status == RUNNING and (run.pending == 1 or run.past > 0):
                    if run.rest == 0.0:
                        finish_step(run, x, rows, rows_x, samples)
                    return status
                if status != RUNNING:
                    return status
            if run.rest != 0.0:
                continue
            finish_step(run, x, rows, rows_x, samples)
            if run.monitored > 0:
                widen_envelope(context, log)
            if run.final == 1:
                return _CONTRADICTION if guards_contradict(context, h) else _COMPLETED
        return RUNNING

    # By its name the linker tells one from the other: loaded from the cache, both would be the first one.
    march.__qualname__ += "_watching" if watching else ""
    return njit(march_signature(), cache=True, nogil=True, **OPTIONS)(march)  # type: ignore[no-any-return]
