"""Land on the surface, perturb, switch: the paper's Algorithm 1.

`advance` takes a step, the part of a step up to the next crossing, or the rest of a step that a crossing has cut.
Jitted; inlined into `time_loop`. Heights and rates are as in `event_location`.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `time_loop`.

from __future__ import annotations

import math

from core.kernels.abi import (
    DELAY,
    G_END,
    GUARDS,
    HEIGHT,
    KEPT,
    LEAVING,
    PROJECT,
    RATE_END,
    SINGULAR_FROM,
    SINGULAR_LENGTH,
    G,
    call,
)
from core.kernels.jit import inlined, internal
from core.kernels.root_isolation import NONE as NO_ROOT
from core.kernels.root_isolation import ROOT
from core.transition.approach import (
    check_at_surface,
    cut_to_domain,
    cut_to_prepared,
    cut_to_surface,
    lands_off_surface,
    look_from_both_sides,
    try_finite_step,
)
from core.transition.event_location import (
    BOUND,
    FAILED,
    FOUND,
    NONE,
    SHORT,
    TOUCH,
    height_at_end,
    isolate_root_of_series,
    locate_by_scheme,
    locate_crossing,
    locate_near_root,
    rate_at_end,
    try_step,
    write_end,
)
from core.transition.flat_roots import cut_where_flat, go_nearer, is_flat
from core.transition.passes import keep_turns
from core.transition.plain_steps import end_of_guard, look_at, update_other_guards
from core.transition.records import NO_JUMP
from core.transition.status import Status
from core.transition.surface import accept_step, advance_time, contradicts, evaluate_switching, record_place
from core.transition.switching import switch_mode

__all__ = ["RUNNING", "advance", "end_at_once"]

RUNNING = int(Status.RUNNING)
_NO_CONVERGENCE, _ESCAPED, _CONTRADICTION = int(Status.NO_CONVERGENCE), int(Status.ESCAPED), int(Status.CONTRADICTION)
_GRAZING = int(Status.GRAZING)
_ZENO = int(Status.ZENO)
#: Length of the rest of a step in which sliding has ended, relative to the time, that is the rounding of its end.
_REST = 2.0**-50
#: Most modes in a row that end where they are entered.
_LONGEST_CHAIN = 16


@internal
def land(context, log, t):
    """Advance the state to the crossing found, displaced by the perturbation if any; returns whether the step succeeds.

    Paper: solve (eq:to-interface), (eq:interface) for (t̂, x̂); with a perturbation, t̂ ← t̂ + c·τᵖ, and x̂ is the state
    at that time.
    """
    run, x, place = context.run, context.x, context.place
    if run.shift != 0.0:
        try_step(context, t, run.hit)
        write_end(context)
        record_place(context, log, 0)
        evaluate_switching(context, t + run.hit)
        run.hit += run.shift
    if run.tried != run.hit and not abs(try_step(context, t, run.hit)) < math.inf:
        return False
    if not write_end(context) < math.inf:
        return False
    for i in range(x.size):
        place[i] = x[i]
    accept_step(context)
    if run.shift == 0.0:
        project = context.functions[run.row + run.guard, PROJECT]
        if call(project, t + run.hit, 0.0, context.p, context.w, context.scratch) < 0:
            for i in range(x.size):
                x[i] = place[i]
            context.w[SINGULAR_FROM], context.w[SINGULAR_LENGTH] = t, run.hit
            return False
        run.hit += context.w[DELAY]
        if run.hit * math.copysign(1.0, run.tau) < 0.0:
            run.hit = 0.0  # a start on the surface is not moved back in time
    advance_time(run, run.hit)
    run.taken = run.hit
    run.longest = max(run.longest, abs(run.hit))
    if run.shift == 0.0:
        for i in range(x.size):
            place[i] = x[i]
        evaluate_switching(context, run.t)
        if run.partly_defined == 1 and context.w[G] != 0.0:
            look_from_both_sides(context, run.t, context.guards[run.row + run.guard].jump == NO_JUMP)
        record_place(context, log, 0)
    return True


@internal
def step_over(context, log, t, h):
    """Without a transition: accept the step, and switch modes at its end if a guard has changed sign."""
    run, x, w, place = context.run, context.x, context.w, context.place
    passed = look_at_first_passed(run, w)
    height, rate = height_at_end(context), rate_at_end(context)
    if passed:  # the fields are compared where the chord of the step meets the surface
        part = chord_to_zero(run.height, height)
        for i in range(x.size):
            place[i] = x[i] + part * context.increment[i]
        record_place(context, log, 0)
        evaluate_switching(context, t + part * h)
    else:
        update_other_guards(run, w)
    accept_step(context)
    advance_time(run, h)
    run.height, run.rate, run.chain, run.taken = height, rate, 0, h
    if passed:
        return switch_mode(context, log, FOUND)
    run.leaving = 0 if height > 0.0 else run.leaving
    return RUNNING


@inlined
def chord_to_zero(height, end):
    """Part of a step at which the chord between two heights, the second not positive, is zero."""
    return height / (height - end) if height > 0.0 else 0.0


@internal
def look_at_first_passed(run, w):
    """Look at the guard that the chord of the step passes first; returns whether it passes any.

    One behind which the state has been put, as by a jump at a wall after a step through it, is not passed on the way
    back.
    """
    passed, first, least = False, 0, math.inf
    for k in range(run.guards):
        kept = GUARDS + KEPT * k
        if k == run.guard:
            height, leaving = run.height, run.leaving
            end, rate = run.sign * w[G_END + 2 * k], math.copysign(1.0, run.tau) * (run.sign * w[RATE_END + 2 * k])
        else:
            height, leaving = w[kept + HEIGHT], int(w[kept + LEAVING])
            end, rate = end_of_guard(run, w, k)
        if end <= 0.0 and not (leaving == 1 and rate > 0.0) and chord_to_zero(height, end) < least:
            passed, first, least = True, k, chord_to_zero(height, end)
    look_at(run, w, first)
    return passed


@internal
def locate_in_shorter_step(context, t, h):
    """Locate a crossing in a shorter step, after one of length h has failed; returns the result and its length."""
    run = context.run
    h = cut_to_domain(context, t, h)
    if h == 0.0:
        return FAILED, h
    if run.leaving == 0 and check_at_surface(context, t):
        run.hit = 0.0
        return FOUND, h
    return locate_crossing(context, t, 0.0, h, height_at_end(context), rate_at_end(context)), h


@inlined
def locate(context, t, h, kind, low, high):
    """Locate the first crossing in a step of length h that succeeds; returns the result and the length searched."""
    run = context.run
    height, rate, found = height_at_end(context), rate_at_end(context), NONE
    if run.adaptive == 1:
        found = locate_by_scheme(context, t, h, height, rate, kind, low, high)
    elif (h > 0.0) == (run.tau > 0.0):  # a step back from a perturbed crossing is not searched
        found = locate_crossing(context, t, 0.0, h, height, rate)
    if found == SHORT:
        h, run.final = run.hit, 0
        found = NONE
    return found, h


@inlined
def end_step(context, log, t, h):
    """Accept a step of length h in which no crossing has been found."""
    run, w = context.run, context.w
    if run.tried != h:  # the search has changed the increment
        try_step(context, t, h)
    height, rate = height_at_end(context), rate_at_end(context)
    accept_step(context)
    advance_time(run, h)
    keep_turns(context, log, h, height, rate)
    if run.guards > 1:
        update_other_guards(run, w)
    run.height, run.rate, run.taken = height, rate, h
    run.leaving = 0 if height > 0.0 else run.leaving
    run.longest = max(run.longest, abs(h))
    run.chain = 0
    contradicted = height < 0.0 and contradicts(context, h)
    for k in range(1, run.guards):
        if w[GUARDS + KEPT * k + HEIGHT] < 0.0:
            look_at(run, w, k)
            contradicted = contradicted or contradicts(context, h)
            look_at(run, w, 0)
    return _CONTRADICTION if contradicted else RUNNING


@internal
def compare_guards(context, t, found, length):
    """Search for a zero of each other guard before the one found, or in the length searched.

    Returns the result and the length searched; the guard looked at is the one whose zero is the first.
    """
    run, w = context.run, context.w
    searched, best, hit = run.guard, run.guard, run.hit
    for k in range(run.guards):
        if k == searched:
            continue
        look_at(run, w, k)
        until = hit if found != NONE else length
        kind, low, high = NO_ROOT, 0.0, 0.0
        if run.adaptive == 1:
            kind, low, high = isolate_root_of_series(context, until)
            if kind == ROOT and locate_near_root(context, t, low, high):
                if not is_flat(context):
                    found, best, hit = FOUND, k, run.hit
                else:
                    found, length = go_nearer(context)
                continue
        if run.tried != until and not try_finite_step(context, t, until):
            return FAILED, until
        if not (abs(height_at_end(context)) < math.inf and abs(rate_at_end(context)) < math.inf):
            return FAILED, until
        result, shorter = locate(context, t, until, kind, low, high)
        if result == FAILED:
            return FAILED, shorter
        if result == FOUND and run.adaptive == 1 and is_flat(context):
            found, length = go_nearer(context)
        elif result != NONE:
            found, best, hit, length = result, k, run.hit, shorter
        elif shorter != until:
            found, length = NONE, shorter
    look_at(run, w, best if found != NONE else 0)
    run.hit = hit
    return found, length


@internal
def end_at_once(context, log):
    """End a mode that was entered beyond, or at, the zero of one of its guards and leads further."""
    run = context.run
    look_at(run, context.w, run.past - 1)
    run.past, run.hit, run.chain = 0, 0.0, run.chain + 1
    if run.chain > _LONGEST_CHAIN:
        return _ZENO
    for i in range(context.x.size):
        context.place[i] = context.x[i]
    evaluate_switching(context, run.t)
    record_place(context, log, 0)
    return switch_mode(context, log, FOUND)


@inlined
def advance(context, log, h):
    """Advance by h, or to the first crossing before that and into the next mode; run.rest is the rest of h."""
    run = context.run
    t, found = run.t + run.t_carry, FAILED
    kind, low, high = NO_ROOT, 0.0, 0.0
    run.rest, run.tried, run.taken = 0.0, math.nan, 0.0
    if run.adaptive == 1:
        h = cut_to_prepared(context, t, h)
        if run.follow == 1:
            h = cut_where_flat(context, h)
            kind, low, high = isolate_root_of_series(context, h)
    asked = length = h
    if kind == ROOT and locate_near_root(context, t, low, high):
        found = FOUND  # the end of the step is not needed
    elif try_finite_step(context, t, h):
        if run.follow == 0:
            return step_over(context, log, t, h)
        h = cut_to_surface(context, t, h, asked)
        if h == 0.0:
            return _GRAZING
        found, length = locate(context, t, h, kind, low, high)
    elif write_end(context) >= BOUND:
        return _ESCAPED
    if found == FAILED and run.follow == 1:
        found, length = locate_in_shorter_step(context, t, h)
    if found == FOUND and run.adaptive == 1 and is_flat(context):
        found, length = go_nearer(context)
    if run.guards > 1 and found != FAILED:
        found, length = compare_guards(context, t, found, length)
    while lands_off_surface(context, t, h, found, length):
        look_at(run, context.w, 0)
        h = cut_to_surface(context, t, 0.5 * (length if found == NONE else run.hit), asked)
        if h == 0.0:
            return _GRAZING
        found, length = locate(context, t, h, NO_ROOT, 0.0, 0.0)
        if found != FAILED:
            found, length = compare_guards(context, t, found, length)
    if found == NONE:
        run.rest = asked - length if run.adaptive == 0 else 0.0
        return end_step(context, log, t, length)
    if found == FAILED or not land(context, log, t):
        return _NO_CONVERGENCE
    if found == TOUCH:
        run.own = 0.0  # the height turns at the surface: its rate is zero
    run.rest = asked - run.hit if run.adaptive == 0 else 0.0
    if run.sliding == 1 and abs(run.rest) <= _REST * abs(t + run.hit):
        run.rest = 0.0  # from the fold at which it leaves, so short a step leads by less than rounding, to either side
    run.final = run.final if run.adaptive == 0 else 0
    run.chain = 0
    return switch_mode(context, log, found)
