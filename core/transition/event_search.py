"""Find the events of a run in the steps that it has taken, which they do not change. Jitted; called by `time_loop`.

An event is a zero of an event function h(t, x) at which its sign changes. Along a step, or the part of it up to a
crossing, the run is smooth. There zeros are located on the scheme itself, as crossings are, by a record and a frame of
their own. The *height* is side·h, with the sign that h has before its next zero.

At a crossing h may vanish to rounding, as where its zeros are the surface. The event is then at the crossing, if the
rate of h before it is not zero, and the next piece begins at a zero that has been passed.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `time_loop`.

from __future__ import annotations

import math
from typing import Any, NamedTuple

from core.kernels.abi import PER_UNIT, ROUNDING_OF_G, UNIT, Frame
from core.kernels.doubledouble.error_free import two_sum
from core.kernels.jit import inlined, internal
from core.transition.event_location import FAILED, FOUND, NONE, TOUCH, locate_crossing, rate_at_end, try_step
from core.transition.event_series import locate_between, locate_by_series, make_ready
from core.transition.event_watch import (
    evaluate,
    keep_levels,
    passes_none,
    put_place,
    row_in,
    sign_beyond,
    take_ends,
)
from core.transition.status import Status
from core.transition.surface import MARGIN, accept_step, advance_time

__all__ = ["examine_piece", "examine_plain_step"]

_RUNNING, _EVENT, _EVENT_LIMIT = int(Status.RUNNING), int(Status.EVENT), int(Status.EVENT_LIMIT)
_EPS = 2.0**-52
#: Number of scalars at the head of a frame, before the state.
_HEAD = Frame(0, 0).x
#: A height that stands for one whose sign rounding hides.
_HIDDEN = 1e-300
#: Beyond a pole the search goes on after this part of the step …
_BEYOND = 2.0**-20
#: … but after so many poles in one step no more.
_MOST_POLES = 16
#: So does it beyond more zeros in a row than this that rounding does not separate.
_CLOSE = 4
#: An event function that is zero along a piece of this part of the longest step vanishes along an arc.
_LONG = 1e-3


class Piece(NamedTuple):
    """What a run has just passed: a step, or a part of it."""

    row: Any  # that of the first event function in its mode
    t: Any  # its start
    h: Any  # its length
    plain: Any  # whether it is a plain step
    crossed: Any  # whether it ends at a crossing


@inlined
def examine_plain_step(context, watch, x, carry, w, h, hits, places):
    """As `examine_piece`, of a plain step."""
    main, run = watch.records[0], context.run
    run.adaptive = 0
    put_place(context, x)
    if passes_none(context, watch, row_in(watch, main.mode), run.t + run.t_carry, h):
        take_ends(watch)
        return _RUNNING
    return examine_piece(context, watch, x, carry, w, h, h, True, hits, places)


@internal
def examine_piece(context, watch, x, carry, w, asked, h, plain, hits, places):
    """Find the events in the piece of length h that the run has just taken, in a plain step or in `advance`.

    `asked` is the length of which `advance` was asked.

    Returns RUNNING, or the Status of a run that an event ends; it is then put back to there.
    """
    main, run, saved = watch.records[0], context.run, watch.records[2]
    if not h * main.tau > 0.0:  # a perturbation has moved the crossing back
        main.watching = 0
        return _RUNNING
    crossed = not plain and main.hits > saved.hits
    if crossed:
        put_place(context, places[saved.hits, 1])
    else:
        put_place(context, x)
    row = row_in(watch, main.mode if plain else saved.mode)
    piece, before = Piece(row, run.t + run.t_carry, h, plain, crossed), main.found
    run.adaptive = main.adaptive
    if plain or not passes_none(context, watch, row, piece.t, h):
        set_frame(context, watch, w, plain, asked)
        end = hits[saved.hits].t if crossed else main.t
        for k in range(watch.events.size):
            if not find_events(context, watch, piece, k):
                main.crowded = 1
                return _RUNNING
        sort_found(watch, before)
        for j in range(before, main.found):
            if abs(watch.found[j].length) == abs(h):
                watch.found[j].t = end
                for i in range(x.size):
                    watch.found_x[j, 0, i] = places[saved.hits, 1, i] if crossed else x[i]
    take_ends(watch)
    return count_found(context, watch, piece, x, carry, before)


@inlined
def set_frame(context, watch, w, plain, asked):
    """Make record and frame ready for the location of events."""
    run, v, main = context.run, context.w, watch.records[0]
    run.guard, run.guards, run.follow, run.shift, run.locating, run.rest = 0, 1, 1, 0.0, 1, asked
    if plain:  # before any other, `keep_start` has been called
        keep_levels(w, v, context.x.size)
    if main.adaptive == 1:
        v[UNIT], v[PER_UNIT] = w[UNIT], w[PER_UNIT]
        if main.monitored == 0:  # the residual of the levels is still that of the start
            count = (w.size - _HEAD - 4 * context.x.size) // 3
            for i in range(w.size - count, w.size):
                v[i] = w[i]
            run.locating = 2


@internal
def take_side(watch, event, h):
    """Sign that a function takes which begins a piece at zero; 0 if it stays there."""
    if abs(event.rate * h) > event.noise:
        return 1 if event.rate > 0.0 else -1
    main = watch.records[0]
    longest = abs(main.tau) if main.adaptive == 0 else main.longest
    side = sign_beyond(event.end_value, event.end_noise)
    if side == 0 and abs(h) >= _LONG * longest:
        event.vanishes = 1
    return side


@internal
def find_events(context, watch, piece, k):
    """Find the zeros of an event function in a piece, and write the events; returns whether there is room for them."""
    run, event, h = context.run, watch.events[k], piece.h
    value, rate, noise = event.end_value, event.end_rate, event.end_noise
    run.row = piece.row + k
    if not (abs(event.value) < math.inf and abs(value) < math.inf and abs(rate) < math.inf):
        event.undefined, event.side = 1, sign_beyond(value, noise)
        return True
    side, before = event.side, event.before
    event.before = 0
    height, slope, leaving = side * event.value, side * event.rate, 0
    hidden = abs(value) <= noise and (piece.crossed or abs(rate * h) <= noise)
    arrives = hidden and abs(rate * h) > noise
    passed_before = False
    if side == 0:
        side = take_side(watch, event, h)
        if side == 0:
            return True
        passed_before, leaving, slope = before == -side, 1, max(side * event.rate, 0.0)
    elif height <= 0.0:
        leaving = 1
        if slope * abs(h) <= event.noise:
            slope = 0.0
            if not hidden and side * value < -noise:  # it has stayed at zero, and goes on to the other side
                passed_before, side = True, -side
    if passed_before:
        put_place(context, context.x)
        if not write_event(context, watch, piece, k, -side, 0.0, event.value, event.rate):
            return False
    begin, steepness, mark, poles, close = 0.0, math.inf, watch.records[0].found, 0, 0
    while abs(begin) < abs(h):
        run.sign, run.height, run.rate, run.leaving = side, height, slope, leaving
        found = locate(context, watch, piece, begin, _HIDDEN if hidden else side * value, side * rate, noise)
        lost = close > _CLOSE if found == FOUND else found == FAILED and run.adaptive == 1
        if lost and poles < _MOST_POLES:
            begin, poles, close, event.undefined, run.sign = run.hit + _BEYOND * h, poles + 1, 0, 1, 1
            height = try_step(context, piece.t, begin) if abs(begin) < abs(h) else math.nan
            if not abs(height) < math.inf:
                break
            side, leaving = 1 if height > 0.0 else -1, 0
            height, slope = abs(height), side * rate_at_end(context)
            continue
        if found != FOUND or lost:
            break
        if arrives and abs(h - run.hit) * abs(rate) <= 2.0 * noise:
            break  # at the crossing
        hit, rest, slope = run.hit, try_step(context, piece.t, run.hit), rate_at_end(context)
        doubt = _EPS * (abs(piece.t) + abs(hit)) * abs(slope)
        if not abs(rest) <= MARGIN * context.w[ROUNDING_OF_G] + 4.0 * doubt:
            event.undefined = 1  # a pole
            break
        # At the same place the product may be nan.
        if not max(steepness, abs(slope)) * abs(hit - begin) > MARGIN * context.w[ROUNDING_OF_G]:
            watch.records[0].found, steepness, close = mark, math.inf, close + 1  # a touch, and no two zeros
        else:
            mark, steepness, close = watch.records[0].found, abs(slope), 0
            if not write_event(context, watch, piece, k, side, hit, side * rest, side * slope):
                return False
        side, begin, leaving, height, slope = -side, hit, 1, 0.0, max(-slope, 0.0)
    if arrives and side * rate < 0.0:
        if not write_event(context, watch, piece, k, side, h, value, rate):
            return False
        side = -side
    known = sign_beyond(value, noise)
    if known == -side:  # its sign has changed, and no zero was found
        event.undefined, side = 1, known
    event.side = side
    return True


@internal
def locate(context, watch, piece, begin, end, end_rate, noise):
    """Locate the next zero after a length; it goes to run.hit. Returns FOUND, NONE, or FAILED, as at a pole."""
    run, h = context.run, piece.h
    if run.adaptive == 1:
        found = locate_by_series(context, watch.series, piece.t, begin, h)
    else:
        if run.leaving == 1 and begin == 0.0:  # the bounds on rounding are those of the start
            put_place(context, context.x)
            evaluate(context, run.row, piece.t, 0.0)
        found = locate_crossing(context, piece.t, begin, h, end, end_rate)
    if found != NONE or end < -noise:
        make_ready(context, piece.t)
    if found in (FOUND, TOUCH) or (found == FAILED and run.adaptive == 1):
        return FOUND if found == TOUCH else found
    if not end < -noise:
        return NONE
    low = begin if run.leaving == 0 else begin + 0.5 * (h - begin)  # the sign has changed all the same
    return locate_between(context, piece.t, low, h)


@internal
def write_event(context, watch, piece, k, side, length, value, rate):
    """Write a zero, with the state in `place`, if it is an event; returns whether there is room for it."""
    main, run, event = watch.records[0], context.run, watch.events[k]
    along = math.copysign(1.0, run.tau)
    if event.way * (side * along) > 0.0:
        return True
    if main.found >= watch.found.size - 1:
        return False
    hit = watch.found[main.found]
    hit.t, hit.length, hit.surface, hit.kind = two_sum(run.t, length + run.t_carry)[0], length, k, int(-side * along)
    hit.g, hit.rate_before, hit.rate_after = value, along * rate, along * rate
    hit.mode = main.mode if piece.plain else watch.records[2].mode
    for i in range(context.x.size):
        watch.found_x[main.found, 0, i] = context.place[i]
    main.found += 1
    return True


@internal
def sort_found(watch, first):
    """Sort the events from number `first` on by their time along the run; the last place is spare."""
    found, x, spare = watch.found, watch.found_x, watch.found.size - 1
    for j in range(first + 1, watch.records[0].found):
        k = j
        while k > first and abs(found[k - 1].length) > abs(found[k].length):
            found[spare], found[k] = found[k], found[k - 1]
            found[k - 1] = found[spare]
            for i in range(x.shape[2]):
                x[k, 0, i], x[k - 1, 0, i] = x[k - 1, 0, i], x[k, 0, i]
            k -= 1


@internal
def count_found(context, watch, piece, x, carry, first):
    """Count the events from number `first` on; returns RUNNING, or the Status of a run that one of them ends."""
    main = watch.records[0]
    for j in range(first, main.found):
        main.passed += 1
        ends = watch.events[watch.found[j].surface].ends == 1
        if ends or main.passed >= main.max_events:
            main.found = j + 1
            stop_at(context, watch, piece, j, x, carry)
            return _EVENT if ends else _EVENT_LIMIT
    return _RUNNING


@internal
def stop_at(context, watch, piece, j, x, carry):
    """Put the run back to an event."""
    records, run, length = watch.records, context.run, watch.found[j].length
    main = records[0]
    at_end = abs(length) == abs(piece.h)
    t, t_carry = main.t, main.t_carry
    if not at_end:
        run.row = piece.row + watch.found[j].surface
        make_ready(context, piece.t)
        try_step(context, piece.t, length)
        accept_step(context)
        advance_time(run, length)
        t, t_carry = run.t, run.t_carry
        for i in range(x.size):
            x[i], carry[i] = context.x[i], context.carry[i]
    elif piece.crossed:
        for i in range(x.size):
            x[i], carry[i] = watch.found_x[j, 0, i], 0.0
    if not piece.plain and (piece.crossed or not at_end):
        evaluations, found, passed = main.evaluations, main.found, main.passed
        records[0] = records[2]
        main.evaluations, main.found, main.passed = evaluations, found, passed
    main.t, main.t_carry, main.watching = t, t_carry, 0
