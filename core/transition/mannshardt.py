"""Land on the surface, perturb, jump, classify, switch: the paper's Algorithm 1.

`advance` takes a step, or the part of one up to the next crossing, or what a crossing has left of one. Jitted; inlined
into `time_loop`. Heights and rates are as in `event_location`.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `time_loop`.

from __future__ import annotations

import math

from core.kernels.abi import DELAY, DOUBT, G_END, JUMP, PROJECT, SET_LEVELS, SLACK, G, call
from core.kernels.jit import inlined, internal
from core.kernels.root_isolation import NONE as NO_ROOT
from core.kernels.root_isolation import ROOT
from core.transition.approach import cut_to_domain, cut_to_prepared, has_end, is_at_surface, move_across
from core.transition.event_location import (
    BOUND,
    FAILED,
    FOUND,
    NONE,
    SHORT,
    TOUCH,
    isolate_root_of_series,
    locate_beside_series,
    locate_crossing,
    locate_near_root,
    rate_at_end,
    try_step,
    write_end,
)
from core.transition.records import JUMP_TO_SURFACE, NO_JUMP, NO_MODE, mode_of
from core.transition.status import CROSSING_KINDS, Status
from core.transition.surface import (
    MARGIN,
    accept_step,
    advance_time,
    contradicts,
    evaluate_rates,
    evaluate_switching,
    is_contradicted,
    is_on_surface,
    record_place,
    widen_envelope,
)

__all__ = ["RUNNING", "accept_plain_step", "advance", "enter_first_mode"]

RUNNING = int(Status.RUNNING)
_SLIDING, _REPELLING, _GRAZING = int(Status.SLIDING), int(Status.REPELLING), int(Status.GRAZING)
_NO_CONVERGENCE, _ESCAPED, _ZENO = int(Status.NO_CONVERGENCE), int(Status.ESCAPED), int(Status.ZENO)
_CROSSING_LIMIT, _CONTRADICTION = int(Status.CROSSING_LIMIT), int(Status.CONTRADICTION)
_UNSTABLE = int(Status.UNSTABLE)
_TRANSVERSAL_KIND, _GRAZING_KIND, _SLIDING_KIND, _REPELLING_KIND, _JUMP_KIND = range(len(CROSSING_KINDS))

_EPS = 2.0**-52
#: Crossings accumulate where the gaps between them have shrunk so many times in a row …
_SHRUNK = 8
#: … and the sum of the gaps to come is below this part of the time.
_SPENT = 2.0**-52
#: The surface is met against the field where the rate away from it exceeds this part of the rate at the start of the
#: step, or of the rate with which the mode was entered.
_AGAINST = 2.0**-7
#: After so many gaps that have shrunk in a row, a visit below rounding ends a sequence of them, and is no touch.
_COMING = 3


@internal
def accept_plain_step(run, h, height, rate):
    """Whether nothing happens in a step of length h that ends at this height and rate; if so, they are taken over.

    The height is taken for a cubic, which is positive where its Bernstein coefficients are; and a minimum between,
    which shows in the signs of the rates, is looked at.
    """
    rate, third = math.copysign(1.0, run.tau) * rate, abs(h) / 3.0
    above = run.height + run.rate * third > 0.0 and height - rate * third > 0.0
    if not (above and 0.0 < height < math.inf) or (run.rate < 0.0 < rate):
        return False
    run.height, run.rate, run.leaving = height, rate, 0
    return True


@inlined
def enter_mode(context, mode, rate):
    """Enter a mode at its surface, from which it leads with this rate."""
    run = context.run
    run.mode, run.sign = mode, context.guards[mode].sign
    run.height, run.rate, run.entered = 0.0, rate, rate
    run.leaving = 1
    if run.conservative == 1 or run.watched > 0:
        call(context.functions[mode, SET_LEVELS], run.t, 0.0, context.p, context.w, context.scratch)


@internal
def enter_first_mode(context):
    """Enter the mode of the initial value: by the sign of g, on the surface by where the fields lead."""
    run, w = context.run, context.w
    for i in range(context.x.size):
        context.place[i] = context.x[i]
    into_minus, into_plus = evaluate_rates(context, 0, run.t)
    g = w[G]
    if not abs(g) < math.inf:
        return _NO_CONVERGENCE
    mode = mode_of(g)
    if run.first_mode != NO_MODE:  # it has been found by other means
        mode = run.first_mode
        enter_mode(context, mode, max(into_plus if mode == 1 else into_minus, 0.0))
    elif abs(g) <= w[SLACK]:  # on the surface as exactly as floating point can say
        if into_plus > 0.0 and into_minus > 0.0:
            return _REPELLING
        if not (into_plus * into_minus < 0.0):
            return _SLIDING if into_plus < 0.0 and into_minus < 0.0 else _GRAZING
        mode = mode_of(into_plus)
        enter_mode(context, mode, into_plus if mode == 1 else into_minus)
    else:
        enter_mode(context, mode, into_plus if mode == 1 else into_minus)
        run.height, run.leaving = run.sign * g, 0
    run.first_mode = mode
    return RUNNING


@internal
def is_met_against_the_field(context, found, own):
    """Whether the scheme meets the surface where its field leads away from it, and does not just touch it.

    Such a step is too long: the field changes in it by more than it is. A touch is one where the state, if it has just
    left the surface, has stayed within rounding of it.
    """
    run = context.run
    if run.follow == 0 or run.shift != 0.0:
        return False
    if found == TOUCH:
        return run.leaving == 1 and run.rate * abs(run.hit) > 8.0 * MARGIN * context.w[DOUBT]
    return own > _AGAINST * min(abs(run.rate), abs(run.entered))


@inlined
def classify(run):
    """Status and kind of a crossing by the rates at the surface: a transversal one arrives and leaves."""
    if run.own < 0.0 and run.other < 0.0:
        return _SLIDING, _SLIDING_KIND
    if run.own < 0.0 < run.other or run.follow == 0:  # without a transition the place is too rough to tell a touch
        return RUNNING, _TRANSVERSAL_KIND
    return _GRAZING, _GRAZING_KIND


@internal
def jump(context):
    """Jump, and find where the fields lead from there: status, kind, mode entered, and the rate into it.

    A jump that leads from the surface to the surface is known by its declaration: g is rounding there, and its sign
    means nothing. Where the surface was not landed on, or of any other jump, g tells.
    """
    run, x, w = context.run, context.x, context.w
    guard = context.guards[run.mode]
    call(context.functions[run.mode, JUMP], run.t, 0.0, context.p, w, context.scratch)
    for i in range(x.size):
        x[i], context.carry[i] = context.place[i], 0.0
    into_minus, into_plus = evaluate_rates(context, run.mode, run.t)
    minus, plus = (guard.to, run.mode) if run.sign > 0 else (run.mode, guard.to)
    landed = run.follow == 1 and run.shift == 0.0
    run.leaving = 1 if (landed and guard.jump == JUMP_TO_SURFACE) or is_on_surface(context) else 0
    if run.leaving == 0:
        return (RUNNING, _JUMP_KIND, plus, into_plus) if w[G] > 0.0 else (RUNNING, _JUMP_KIND, minus, into_minus)
    if into_minus > 0.0 and into_plus > 0.0:
        return _REPELLING, _REPELLING_KIND, run.mode, 0.0
    if into_plus > 0.0:
        return RUNNING, _JUMP_KIND, plus, into_plus
    if into_minus > 0.0:
        return RUNNING, _JUMP_KIND, minus, into_minus
    return _SLIDING, _SLIDING_KIND, run.mode, 0.0


@inlined
def elapsed(run):
    """Time since the crossing before, or the start."""
    return abs((run.t - run.met) + (run.t_carry - run.met_carry))


@internal
def is_lost_in_rounding(context, found, own, rate):
    """Whether the visit that a jump ends here, and the next one, stay within rounding of the surface.

    A visit of length T that arrives at the rate r has been r·T/4 away, if its path is a parabola. Below the rounding
    of g neither the place nor the rates of a visit are known, and so neither is where a touch leads.
    """
    run = context.run
    if context.guards[run.mode].jump == NO_JUMP or run.follow == 0 or run.shift != 0.0:
        return False
    return found == TOUCH or max(-own, rate) * elapsed(run) <= 4.0 * MARGIN * context.w[DOUBT]


@inlined
def accumulates(run):
    """Whether crossings come ever closer and their accumulation point is no more than round-off away (Zeno).

    A geometric sequence of gaps with ratio q has the sum gap·q/(1 − q) to come.
    """
    gap = elapsed(run)
    ratio = gap / run.gap if run.gap > 0.0 else math.inf
    run.shrinking = run.shrinking + 1 if ratio < 1.0 else 0
    run.gap, run.met, run.met_carry = gap, run.t, run.t_carry
    return run.shrinking >= _SHRUNK and gap * ratio <= _SPENT * abs(run.t) * (1.0 - ratio)


@inlined
def switch_mode(context, log, found):
    """At the surface: jump, classify, enter the mode behind, write the crossing down."""
    run, x = context.run, context.x
    hit, along = log.hits[run.hits], math.copysign(1.0, context.run.tau)
    guard = context.guards[run.mode]
    hit.t = run.t
    hit.rate_before, hit.rate_after = along * run.sign * run.own, -along * run.sign * run.other
    own, other = run.own, run.other
    if run.shift != 0.0 or run.follow == 0:  # it is not where the surface was met
        for i in range(x.size):
            context.place[i] = x[i]
        evaluate_switching(context, run.t)
    hit.g, rate = context.w[G], run.other
    run.own, run.other = own, other
    record_place(context, log, 1)
    if run.watched > 0:  # what the mode that is left has lost
        widen_envelope(context, log)
    against = is_met_against_the_field(context, found, own)
    run.leaving = 1
    if guard.jump != NO_JUMP:
        status, kind, mode, rate = jump(context)
        if status == RUNNING and run.leaving == 1 and is_lost_in_rounding(context, found, own, rate):
            status = _ZENO if run.shrinking >= _COMING and elapsed(run) < run.gap else _GRAZING
            kind = _GRAZING_KIND
        elif status == RUNNING and against:
            status, kind = _UNSTABLE, _GRAZING_KIND
        hit.rate_after = along * context.guards[mode].sign * rate
    else:
        status, kind = classify(run)
        status = _UNSTABLE if status == _GRAZING and against else status
        mode = guard.to
    leaving = run.leaving
    record_place(context, log, 2)
    hit.kind, hit.mode, hit.passed = kind, mode, status == RUNNING
    run.hits += 1
    run.crossings += 1
    if status != RUNNING:
        return status
    enter_mode(context, mode, rate)
    if leaving == 0:  # it has jumped off the surface
        run.height, run.leaving = run.sign * context.w[G], 0
    elif is_contradicted(context, run.hit):  # a step so stiff that its own rounding hides the surface
        return _UNSTABLE
    if accumulates(run):
        return _ZENO
    return _CROSSING_LIMIT if run.crossings >= run.max_crossings else RUNNING


@inlined
def land(context, log, t):
    """Move the state to the crossing found, or by the perturbation beyond it; returns whether that could be done.

    Paper: solve (eq:to-interface), (eq:interface) for (t̂, x̂); with a perturbation, t̂ ← t̂ + c·τᵖ and x̂ anew there.
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
        call(context.functions[run.mode, PROJECT], t + run.hit, 0.0, context.p, context.w, context.scratch)
        run.hit += context.w[DELAY]
        if run.hit * math.copysign(1.0, run.tau) < 0.0:
            run.hit = 0.0  # a start on the surface is not moved back in time
    advance_time(run, run.hit)
    if run.shift == 0.0:
        for i in range(x.size):
            place[i] = x[i]
        evaluate_switching(context, run.t)
        if run.edged == 1 and context.guards[run.mode].jump == NO_JUMP and run.sign * context.w[G] > 0.0:
            move_across(context, run.t)
        record_place(context, log, 0)
    return True


@inlined
def step_over(context, log, t, h):
    """Without a transition: the step stands, and only then is g evaluated."""
    run, x, place = context.run, context.x, context.place
    height, rate = run.sign * context.w[G_END], rate_at_end(context)
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
    """Locate a crossing where a step of length h has failed: what is found, and the length of a shorter one."""
    run = context.run
    h = cut_to_domain(context, t, h)
    if h == 0.0:
        return FAILED, h
    if run.leaving == 0 and is_at_surface(context, t):
        run.hit = 0.0
        return FOUND, h
    return locate_crossing(context, t, h, run.sign * context.w[G_END], rate_at_end(context)), h


@inlined
def locate(context, t, h, kind, low, high):
    """Locate the first crossing in a step of length h that ends: what is found, and the length if it is nothing."""
    run = context.run
    height, rate, found = run.sign * context.w[G_END], rate_at_end(context), NONE
    if run.adaptive == 1:
        found = locate_beside_series(context, t, h, height, rate, kind, low, high)
    elif (h > 0.0) == (run.tau > 0.0):  # going back from a perturbed crossing is no motion to be watched
        found = locate_crossing(context, t, h, height, rate)
    if found == SHORT:
        h, run.final = run.hit, 0
        found = NONE
    return found, h


@inlined
def end_step(context, t, h):
    """A step of length h in which no crossing has been found stands."""
    run = context.run
    if run.tried != h:  # to look for a crossing has changed the increment
        try_step(context, t, h)
    height, rate = run.sign * context.w[G_END], rate_at_end(context)
    accept_step(context)
    advance_time(run, h)
    run.height, run.rate = height, rate
    run.leaving = 0 if height > 0.0 else run.leaving
    run.longest = max(run.longest, abs(h))
    return _CONTRADICTION if height < 0.0 and contradicts(context, h) else RUNNING


@inlined
def advance(context, log, h):
    """Go on by h, or to the first crossing before that and into the mode behind; run.rest is what is left of h."""
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
        found = FOUND  # and the end of the step is of no use
    elif has_end(context, t, h):
        if run.follow == 0:
            return step_over(context, log, t, h)
        found, length = locate(context, t, h, kind, low, high)
    elif write_end(context) >= BOUND:
        return _ESCAPED
    if found == FAILED and run.follow == 1:
        found, length = locate_in_shorter_step(context, t, h)
    if found == NONE:
        run.rest = h - length if run.adaptive == 0 else 0.0
        return end_step(context, t, length)
    if found == FAILED or not land(context, log, t):
        return _NO_CONVERGENCE
    if found == TOUCH:
        run.own = 0.0  # it turns at the surface, and does not arrive
    run.rest = h - run.hit if run.adaptive == 0 else 0.0
    run.final = run.final if run.adaptive == 0 else 0
    return switch_mode(context, log, found)
