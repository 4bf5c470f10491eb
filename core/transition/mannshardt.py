"""Land on the surface, perturb, switch: the paper's Algorithm 1.

`advance` takes a step, the part of a step up to the next crossing, or the rest of a step that a crossing has cut.
Jitted; inlined into `time_loop`. Heights and rates are as in `event_location`.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `time_loop`.

from __future__ import annotations

import math

from core.kernels.abi import DELAY, PROJECT, G, call
from core.kernels.jit import inlined, internal
from core.kernels.root_isolation import NONE as NO_ROOT
from core.kernels.root_isolation import ROOT
from core.transition.approach import check_at_surface, cut_to_domain, cut_to_prepared, reflect_across, try_finite_step
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
from core.transition.plain_steps import end_beside, swap_guards
from core.transition.records import NO_JUMP, SLIDING_MODE
from core.transition.status import Status
from core.transition.surface import accept_step, advance_time, contradicts, evaluate_switching, record_place
from core.transition.switching import switch_mode

__all__ = ["RUNNING", "advance"]

RUNNING = int(Status.RUNNING)
_NO_CONVERGENCE, _ESCAPED, _CONTRADICTION = int(Status.NO_CONVERGENCE), int(Status.ESCAPED), int(Status.CONTRADICTION)


@inlined
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
    accept_step(context)
    if run.shift == 0.0:
        call(context.functions[run.mode + run.guard, PROJECT], t + run.hit, 0.0, context.p, context.w, context.scratch)
        run.hit += context.w[DELAY]
        if run.hit * math.copysign(1.0, run.tau) < 0.0:
            run.hit = 0.0  # a start on the surface is not moved back in time
    advance_time(run, run.hit)
    if run.shift == 0.0:
        for i in range(x.size):
            place[i] = x[i]
        evaluate_switching(context, run.t)
        if run.partly_defined == 1 and context.guards[run.mode].jump == NO_JUMP and run.sign * context.w[G] > 0.0:
            reflect_across(context, run.t)
        record_place(context, log, 0)
    return True


@inlined
def step_over(context, log, t, h):
    """Without a transition: accept the step, and switch modes at its end if g has changed sign."""
    run, x, place = context.run, context.x, context.place
    if run.mode == SLIDING_MODE and height_at_end(context) > 0.0:
        if end_beside(run, context.w)[0] <= 0.0:
            swap_guards(run)
        else:
            run.beside_height, run.beside_rate = end_beside(run, context.w)
    height, rate = height_at_end(context), rate_at_end(context)
    if height <= 0.0:  # the fields are compared where the chord of the step meets the surface
        part = run.height / (run.height - height) if run.height > 0.0 else 0.0
        for i in range(x.size):
            place[i] = x[i] + part * context.increment[i]
        record_place(context, log, 0)
        evaluate_switching(context, t + part * h)
    accept_step(context)
    advance_time(run, h)
    run.height, run.rate = height, rate
    if height > 0.0:
        run.leaving = 0
        return RUNNING
    status = switch_mode(context, log, FOUND)
    run.leaving, run.height = 0, run.sign * context.w[G]
    return status


@inlined
def locate_in_shorter_step(context, t, h):
    """Locate a crossing in a shorter step, after one of length h has failed; returns the result and its length."""
    run = context.run
    h = cut_to_domain(context, t, h)
    if h == 0.0:
        return FAILED, h
    if run.leaving == 0 and check_at_surface(context, t):
        run.hit = 0.0
        return FOUND, h
    return locate_crossing(context, t, h, height_at_end(context), rate_at_end(context)), h


@inlined
def locate(context, t, h, kind, low, high):
    """Locate the first crossing in a step of length h that succeeds; returns the result and the length searched."""
    run = context.run
    height, rate, found = height_at_end(context), rate_at_end(context), NONE
    if run.adaptive == 1:
        found = locate_by_scheme(context, t, h, height, rate, kind, low, high)
    elif (h > 0.0) == (run.tau > 0.0):  # a step back from a perturbed crossing is not searched
        found = locate_crossing(context, t, h, height, rate)
    if found == SHORT:
        h, run.final = run.hit, 0
        found = NONE
    return found, h


@inlined
def end_step(context, t, h):
    """Accept a step of length h in which no crossing has been found."""
    run = context.run
    if run.tried != h:  # the search has changed the increment
        try_step(context, t, h)
    height, rate = height_at_end(context), rate_at_end(context)
    beside = math.inf
    if run.mode == SLIDING_MODE:
        run.beside_height, run.beside_rate = end_beside(run, context.w)
        beside = run.beside_height
    accept_step(context)
    advance_time(run, h)
    run.height, run.rate = height, rate
    run.leaving = 0 if height > 0.0 else run.leaving
    run.longest = max(run.longest, abs(h))
    if beside < 0.0:
        swap_guards(run)
        contradicted = contradicts(context, h)
        swap_guards(run)
        if contradicted:
            return _CONTRADICTION
    return _CONTRADICTION if height < 0.0 and contradicts(context, h) else RUNNING


@internal
def compare_guards(context, t, found, length):
    """Search for a zero of the second guard of sliding before that of the first, or in the length searched for it.

    Returns the result and the length searched; the guard looked at is that which has been found.
    """
    run = context.run
    hit, until = run.hit, run.hit if found != NONE else length
    swap_guards(run)
    kind, low, high = NO_ROOT, 0.0, 0.0
    if run.adaptive == 1:
        kind, low, high = isolate_root_of_series(context, until)
        if kind == ROOT and locate_near_root(context, t, low, high):
            return FOUND, until
    if not try_finite_step(context, t, until):
        return FAILED, until
    beside, shorter = locate(context, t, until, kind, low, high)
    if beside != NONE:
        return beside, shorter
    swap_guards(run)
    if shorter != until:
        return NONE, shorter
    run.hit = hit
    return found, length


@inlined
def advance(context, log, h):
    """Advance by h, or to the first crossing before that and into the next mode; run.rest is the rest of h."""
    run = context.run
    t, found = run.t + run.t_carry, FAILED
    kind, low, high = NO_ROOT, 0.0, 0.0
    run.rest = 0.0
    if run.adaptive == 1:
        h = cut_to_prepared(context, t, h)
        if run.follow == 1:
            kind, low, high = isolate_root_of_series(context, h)
    length = h
    if kind == ROOT and locate_near_root(context, t, low, high):
        found = FOUND  # the end of the step is not needed
    elif try_finite_step(context, t, h):
        if run.follow == 0:
            return step_over(context, log, t, h)
        found, length = locate(context, t, h, kind, low, high)
    elif write_end(context) >= BOUND:
        return _ESCAPED
    if found == FAILED and run.follow == 1:
        found, length = locate_in_shorter_step(context, t, h)
    if run.mode == SLIDING_MODE and found != FAILED:
        found, length = compare_guards(context, t, found, length)
    if found == NONE:
        run.rest = h - length if run.adaptive == 0 else 0.0
        return end_step(context, t, length)
    if found == FAILED or not land(context, log, t):
        return _NO_CONVERGENCE
    if found == TOUCH:
        run.own = 0.0  # the height turns at the surface: its rate is zero
    run.rest = h - run.hit if run.adaptive == 0 else 0.0
    run.final = run.final if run.adaptive == 0 else 0
    return switch_mode(context, log, found)
