"""Follow event functions along the steps of a run, which they do not change. Jitted; inlined into `time_loop`.

Where an event may be in a step, `event_search` finds it, by a record and a frame of its own.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `time_loop`.

from __future__ import annotations

import math
from typing import Any, NamedTuple

from core.kernels.abi import EVALUATE, LEVELS_SET, RATES, ROUNDING_OF_G, VECTORS, Frame, G, call
from core.kernels.jit import inlined, internal
from core.transition.plain_steps import stays_above
from core.transition.surface import MARGIN

__all__ = [
    "Watch", "evaluate", "keep_levels", "keep_start", "note_transitions", "passes_none", "put_place", "row_in",
    "sign_beyond", "take_ends", "watch_start",
]  # fmt: skip

_EPS = 2.0**-52
#: Number of scalars at the head of a frame, before the state.
_HEAD = Frame(0, 0).x


class Watch(NamedTuple):
    """The event functions, and where events are written to."""

    records: Any  # (3,) `records.RUN`: of the run, of the location of events, and of the run before a step
    events: Any  # (n,) `records.EVENT`
    found: Any  # (size,) `records.HIT`, of which the last is spare
    found_x: Any  # (size, 1, d) states there
    series: Any  # (rows, STRIDE) Taylor coefficients
    first: Any  # row of the first event function in the first mode


@inlined
def evaluate(context, row, t, span):
    """Evaluate an event function at `place`; returns its value, its rate along the run, and a bound on its rounding.

    That is by rounding the time, of size `span`, too.
    """
    w = context.w
    call(context.functions[row, EVALUATE], t, 0.0, context.p, w, context.scratch)
    noise = MARGIN * (w[ROUNDING_OF_G] + _EPS * span * abs(w[RATES]))
    return w[G], math.copysign(1.0, context.run.tau) * w[RATES], noise


@inlined
def sign_beyond(value, noise):
    """Sign of a value that rounding does not hide; 0 of others, and of nan."""
    return (1 if value > 0.0 else -1) if noise < abs(value) < math.inf else 0


@inlined
def put_place(context, x):
    """Write a state to `place`."""
    for i in range(x.size):
        context.place[i] = x[i]


@inlined
def watch_start(context, watch, x, carry):
    """Keep the start of a step, and evaluate the event functions there unless they are known.

    `context` is that of the location of events, with a record and a frame of its own.
    """
    main, run = watch.records[0], context.run
    run.t, run.t_carry, run.tau = main.t, main.t_carry, main.tau
    for i in range(x.size):
        context.x[i], context.carry[i] = x[i], carry[i]
    if main.watching != 1:
        evaluate_start(context, watch)


@internal
def evaluate_start(context, watch):
    """Evaluate the event functions at the start of a step."""
    main = watch.records[0]
    stays = main.watching == 2  # in another mode, at the same state
    put_place(context, context.x)
    t, first = main.t + main.t_carry, row_in(watch, main.mode)
    span = 0.0 if main.crossings == 0 else abs(t) + abs(main.taken)  # an initial state is exact
    for k in range(watch.events.size):
        event = watch.events[k]
        event.value, event.rate, noise = evaluate(context, first + k, t, span)
        event.noise = max(noise, event.noise) if stays else noise
        event.side = event.side if stays else sign_beyond(event.value, event.noise)
    main.watching = 1


@inlined
def row_in(watch, mode):
    """Row of the first event function in a mode."""
    return watch.first + mode * watch.events.size


@inlined
def keep_levels(w, v, d):
    """Copy the levels of ψ, and what there is of their residual, to the frame of the location of events."""
    v[LEVELS_SET] = w[LEVELS_SET]
    for i in range(_HEAD + VECTORS * d, w.size):
        v[i] = w[i]


@inlined
def keep_start(watch, w, v, d):
    """Keep what `advance` may change at a crossing: the record of the run, and its levels."""
    watch.records[2] = watch.records[0]
    keep_levels(w, v, d)


@internal
def note_transitions(run, places, first):
    """Note that the crossings from number `first` on have led to other modes, with jumps or without."""
    for k in range(first, run.hits):
        run.watching = 2 if run.watching > 0 else 0
        for i in range(places.shape[2]):
            if places[k, 1, i] != places[k, 2, i]:
                run.watching = 0


@inlined
def passes_none(context, watch, row, t, h):
    """Evaluate all event functions at the end of a piece, in `place`; returns whether clearly no event is in it."""
    plain, third, end = context.run.adaptive == 0, abs(h) / 3.0, t + h
    for k in range(watch.events.size):
        event = watch.events[k]
        event.end_value, event.end_rate, event.end_noise = evaluate(context, row + k, end, abs(end) + abs(h))
        side = event.side
        low, high = side * event.value, side * event.end_value
        plain = plain and low > 0.0 and high > event.end_noise
        plain = plain and stays_above(low, side * event.rate, high, side * event.end_rate, third)
    return plain


@inlined
def take_ends(watch):
    """The end of a piece is the start of the next."""
    for k in range(watch.events.size):
        event = watch.events[k]
        event.value, event.rate, event.noise = event.end_value, event.end_rate, event.end_noise
