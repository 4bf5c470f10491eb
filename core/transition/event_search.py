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

from core.kernels.abi import PER_UNIT, ROUNDING_OF_G, UNIT, VECTORS, Frame
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
#: An event function that is zero along a piece of this part of the longest step vanishes along an arc.
_LONG = 1e-3


class Piece(NamedTuple):
    """What a run has just passed: a step, or a part of it."""

    row: Any  # that of the first event function in its mode
    t: Any  # its start
    h: Any  # its length
    plain: Any  # whether it is a plain step
    crossed: Any  # whether it ends at a crossing
    last: Any  # whether no other piece follows in its mode
    longest: Any  # length of the longest step


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
    last, longest = crossed or (main.final == 1 and main.rest == 0.0), abs(main.tau)
    longest = longest if main.adaptive == 0 else max(main.longest, abs(h))
    piece, before = Piece(row, run.t + run.t_carry, h, plain, crossed, last, longest), main.found
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
        v[UNIT], v[PER_UNIT], d = w[UNIT], w[PER_UNIT], context.x.size
        extent = _HEAD + (VECTORS - 1) * d  # as `prepare_step` has left it: see `Frame`
        for i in range(extent, extent + d):
            v[i] = w[i]
        if main.monitored == 0:  # the residual of the levels is still that of the start
            count = (w.size - _HEAD - VECTORS * d) // 3
            for i in range(w.size - count, w.size):
                v[i] = w[i]
            run.locating = 2


@internal
def find_events(context, watch, piece, k):
    """Pass the zeros of an event function in a piece, each once; returns whether there is room for its events.

    `event.side` is its sign since the last zero. It changes in `pass_zero`, which writes an event, and nowhere else,
    but for where its zeros cannot be told: beyond a pole. So between two signs that rounding does not hide there is an
    odd number of events if they differ, and an even number if not. A zero that rounding does not tell from an end of
    the piece is passed at the start of the next piece, or at the end of this one if its mode ends there, or the run.
    """
    run, event = context.run, watch.events[k]
    run.row = piece.row + k
    event.zero = math.nan
    if not (abs(event.value) < math.inf and abs(event.end_value) < math.inf and abs(event.end_rate) < math.inf):
        event.undefined, event.side = 1, sign_beyond(event.end_value, event.end_noise)
        return True
    known, moves = sign_beyond(event.value, event.noise), way_of(piece, event.rate, event.noise)
    side = known or moves or sign_beyond(event.end_value, event.end_noise)  # right after the start
    if side == 0:
        event.vanishes = 1 if abs(piece.h) >= _LONG * piece.longest else event.vanishes
        return True
    if event.side == -side:
        put_place(context, context.x)
        if not pass_zero(context, watch, piece, k, 0.0, event.value, event.rate, event.noise):
            return False
    event.side = side
    run.leaving, run.height = (1, 0.0) if known == 0 else (0, abs(event.value))
    run.rate = side * event.rate if known or moves else 0.0
    return pass_inside(context, watch, piece, k) and reach_end(context, watch, piece, k)


@inlined
def way_of(piece, rate, noise):
    """Sign of a rate; 0 if even in the longest step it changes h by no more than rounding does."""
    return sign_beyond(rate * piece.longest, noise)


@internal
def pass_inside(context, watch, piece, k):
    """Pass the zeros inside a piece; returns as `find_events` does."""
    run, event, h = context.run, watch.events[k], piece.h
    begin, poles = 0.0, 0
    while abs(begin) < abs(h):
        run.sign = event.side
        found = locate(context, watch, piece, event, begin)
        again = found == FOUND and run.leaving == 1 and run.hit == begin
        if (again and math.isnan(event.zero)) or (found == FAILED and run.adaptive == 1):
            begin, poles = run.hit + _BEYOND * h, poles + 1
            if poles > _MOST_POLES or not go_on_beyond(context, event, piece, begin):
                break
            continue
        if found != FOUND:
            break
        begin, height, rate = run.hit, try_step(context, piece.t, run.hit), event.side * rate_at_end(context)
        noise = MARGIN * context.w[ROUNDING_OF_G] + 4.0 * _EPS * (abs(piece.t) + abs(begin)) * abs(rate)
        if not abs(height) <= noise:
            event.undefined, poles = 1, poles + 1
            if run.adaptive == 0 or poles > _MOST_POLES:
                event.zero = math.nan  # a pole
                break
            if height < 0.0:
                correct_side(watch, event)
            run.leaving, run.height, run.rate = 0, abs(height), event.side * rate
            continue
        if rounding_hides(event.end_value, h - begin, max(abs(rate), abs(event.end_rate)), event.end_noise):
            break
        if not pass_zero(context, watch, piece, k, begin, event.side * height, rate, noise):
            return False
        run.leaving, run.height, run.rate = 1, 0.0, max(event.side * rate, 0.0)
    return True


@inlined
def rounding_hides(value, length, rate, noise):
    """Whether rounding hides what h does between a zero and another place, at this length and with this value."""
    return abs(value) <= noise and rate * abs(length) <= 4.0 * noise  # 4: between two zeros of a parabola


@internal
def go_on_beyond(context, event, piece, begin):
    """Go on at a length beyond a pole, or beyond zeros too close to be told apart; returns whether that is possible."""
    run = context.run
    event.undefined, run.sign = 1, 1
    value = try_step(context, piece.t, begin) if abs(begin) < abs(piece.h) else math.nan
    if not abs(value) < math.inf:
        return False
    event.side, event.zero = 1 if value > 0.0 else -1, math.nan
    run.leaving, run.height, run.rate = 0, abs(value), event.side * rate_at_end(context)
    return True


@internal
def correct_side(watch, event):
    """Take the other sign, which the function has: the last zero in the piece was a touch, or one has been missed."""
    event.undefined, event.side = 1, -event.side
    if not math.isnan(event.zero):
        watch.records[0].found, event.zero = event.mark, math.nan


@internal
def reach_end(context, watch, piece, k):
    """Pass the zero at the end of a piece that is the last in its mode; returns as `find_events` does."""
    event = watch.events[k]
    known = sign_beyond(event.end_value, event.end_noise)
    if known == -event.side:
        correct_side(watch, event)
    if known == 0 and piece.last and way_of(piece, event.end_rate, event.end_noise) == -event.side:
        return pass_zero(context, watch, piece, k, piece.h, event.end_value, event.end_rate, event.end_noise)
    return True


@internal
def pass_zero(context, watch, piece, k, length, value, rate, noise):
    """Pass a zero, with the state in `place`, and write it as an event; returns whether there is room for that.

    Two zeros between which rounding hides the sign are a touch, and no events.
    """
    main, event = watch.records[0], watch.events[k]
    if rounding_hides(0.0, length - event.zero, max(abs(rate), event.steepness), max(noise, event.doubt)):
        main.found, event.zero = event.mark, math.nan
    else:
        event.zero, event.steepness, event.doubt, event.mark = length, abs(rate), noise, main.found
        if not write_event(context, watch, piece, k, event.side, length, value, rate):
            return False
    event.side = -event.side
    return True


@internal
def locate(context, watch, piece, event, begin):
    """Locate the next zero after a length; it goes to run.hit. Returns FOUND, NONE, or FAILED, as at a pole."""
    run, h, noise = context.run, piece.h, event.end_noise
    end = _HIDDEN if abs(event.end_value) <= noise else event.side * event.end_value
    if run.adaptive == 1:
        found = locate_by_series(context, watch.series, piece.t, begin, h)
    else:
        if run.leaving == 1 and begin == 0.0:  # the bounds on rounding are those of the start
            put_place(context, context.x)
            evaluate(context, run.row, piece.t, 0.0)
        found = locate_crossing(context, piece.t, begin, h, end, event.side * event.end_rate)
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
