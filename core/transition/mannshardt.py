"""Land on the surface, perturb, jump, classify, switch: the paper's Algorithm 1.

`advance` takes a step, the part of a step up to the next crossing, or the rest of a step that a crossing has cut.
Jitted; inlined into `time_loop`. Heights and rates are as in `event_location`.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `time_loop`.

from __future__ import annotations

import math

from core.kernels.abi import (
    BESIDE,
    DELAY,
    G_END,
    JUMP,
    PROJECT,
    RATE_END,
    ROUNDING_OF_G,
    ROUNDING_OF_STATE,
    SET_LEVELS,
    STEP,
    G,
    call,
)
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
from core.transition.records import JUMP_TO_SURFACE, NO_JUMP, NO_MODE, SLIDING_MODE, mode_of
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

__all__ = ["RUNNING", "accept_plain_step", "advance", "enter_first_mode", "enter_sliding"]

RUNNING = int(Status.RUNNING)
_SLIDING, _REPELLING, _GRAZING = int(Status.SLIDING), int(Status.REPELLING), int(Status.GRAZING)
_NO_CONVERGENCE, _ESCAPED, _ZENO = int(Status.NO_CONVERGENCE), int(Status.ESCAPED), int(Status.ZENO)
_CROSSING_LIMIT, _CONTRADICTION = int(Status.CROSSING_LIMIT), int(Status.CONTRADICTION)
_UNSTABLE = int(Status.UNSTABLE)
(
    _TRANSVERSAL_KIND, _GRAZING_KIND, _SLIDING_KIND, _REPELLING_KIND, _JUMP_KIND, _LEAVING_KIND,
) = range(len(CROSSING_KINDS))  # fmt: skip

_EPS = 2.0**-52
#: Crossings accumulate if the times between them have shrunk this many times in a row …
_SHRUNK = 8
#: … and the sum of the times to come is below this part of the current time.
_SPENT = 2.0**-52
#: The surface is met against the field if the rate away from it exceeds this part of the rate at the start of the step,
#: or of the rate with which the mode was entered.
_AGAINST = 2.0**-7
#: After this many shrinking times in a row, a stay in a mode within rounding of the surface is Zeno and not a touch.
_COMING = 3


@inlined
def stays_above(low, rate_low, height, rate, third):
    """Whether a height stays positive in a step between these heights and rates; third is a third of its length.

    The height is taken to be a cubic, which is positive if its Bernstein coefficients are. A step in which the rates
    show a minimum of the height is left to `advance`.
    """
    above = low + rate_low * third > 0.0 and height - rate * third > 0.0
    return above and 0.0 < height < math.inf and not (rate_low < 0.0 < rate)


@internal
def accept_plain_step(run, h, w):
    """Accept the step just tried, of length h, if it has no crossing; returns whether it does so."""
    along = math.copysign(1.0, run.tau)
    height, rate, third = run.sign * w[G_END], along * (run.sign * w[RATE_END]), abs(h) / 3.0
    if not stays_above(run.height, run.rate, height, rate, third):
        return False
    if run.mode == SLIDING_MODE:
        height_beside, rate_beside = end_beside(run, w)
        if not stays_above(run.beside_height, run.beside_rate, height_beside, rate_beside, third):
            return False
        run.beside_height, run.beside_rate = height_beside, rate_beside
    run.height, run.rate, run.leaving = height, rate, 0
    return True


@inlined
def end_beside(run, w):
    """Height and rate at the end of the last trial step of the second guard of sliding, while the first is looked at.

    The guards are the rates of g with the fields of both sides, which have opposite signs.
    """
    along = math.copysign(1.0, run.tau)
    return -run.sign * w[G_END + BESIDE], -along * (run.sign * w[RATE_END + BESIDE])


@inlined
def swap_guards(run):
    """Look at the other guard of sliding."""
    run.guard, run.sign = 1 - run.guard, -run.sign
    run.height, run.beside_height = run.beside_height, run.height
    run.rate, run.beside_rate = run.beside_rate, run.rate


@inlined
def enter_mode(context, mode, rate):
    """Enter a mode at its surface, with this rate away from it."""
    run = context.run
    run.mode, run.guard, run.sign = mode, 0, context.guards[mode].sign
    run.height, run.rate, run.entered = 0.0, rate, rate
    run.leaving = 1
    if run.conservative == 1 or run.monitored > 0:
        call(context.functions[mode, SET_LEVELS], run.t, 0.0, context.p, context.w, context.scratch)


@internal
def enter_sliding(context):
    """Enter the mode of sliding, where both fields point to the surface; it stays pending until compiled."""
    run, w = context.run, context.w
    if context.functions[SLIDING_MODE, STEP] == 0:
        return RUNNING
    run.pending = 0
    for i in range(context.x.size):
        context.place[i] = context.x[i]
    run.mode, run.leaving, run.guard = SLIDING_MODE, 0, 1
    run.sign = -1 if run.tau > 0.0 else 1
    for _ in range(2):  # the second guard, then the first
        evaluate_switching(context, run.t)
        run.height, run.rate = run.sign * w[G], run.own
        swap_guards(run)
    swap_guards(run)
    run.entered = run.rate
    if not (run.height > 0.0 and run.beside_height > 0.0):
        return _GRAZING  # one of the fields is tangent to the surface
    if run.conservative == 1 or run.monitored > 0:
        call(context.functions[SLIDING_MODE, SET_LEVELS], run.t, 0.0, context.p, w, context.scratch)
    return RUNNING


@internal
def enter_first_mode(context):
    """Enter the mode of the initial value, given by the sign of g; on the surface, by the directions of the fields."""
    run, w = context.run, context.w
    for i in range(context.x.size):
        context.place[i] = context.x[i]
    into_minus, into_plus = evaluate_rates(context, 0, run.t)
    g = w[G]
    if not abs(g) < math.inf:
        return _NO_CONVERGENCE
    mode = mode_of(g)
    if run.first_mode != NO_MODE:  # `Runner` has found it by the second derivative of g
        mode = run.first_mode
        enter_mode(context, mode, max(into_plus if mode == 1 else into_minus, 0.0))
    elif abs(g) <= w[ROUNDING_OF_STATE]:  # on the surface to round-off
        if into_plus > 0.0 and into_minus > 0.0:
            return _REPELLING
        if into_plus < 0.0 and into_minus < 0.0:
            if run.slides == 0:
                return _SLIDING
            run.mode = run.first_mode = SLIDING_MODE
            run.pending = 1
            return RUNNING
        if not (into_plus * into_minus < 0.0):
            return _GRAZING
        mode = mode_of(into_plus)
        enter_mode(context, mode, into_plus if mode == 1 else into_minus)
    else:
        enter_mode(context, mode, into_plus if mode == 1 else into_minus)
        run.height, run.leaving = run.sign * g, 0
    run.first_mode = mode
    return RUNNING


@internal
def is_met_against_the_field(context, found, own):
    """Whether the scheme meets the surface, other than by a touch, where its field leads away from it.

    Such a step is too long: the field changes in it by more than its own size. After a crossing, a touch is genuine
    only if the state has stayed within rounding of the surface.
    """
    run = context.run
    if run.follow == 0 or run.shift != 0.0:
        return False
    if found == TOUCH:
        return run.leaving == 1 and run.rate * abs(run.hit) > 8.0 * MARGIN * context.w[ROUNDING_OF_G]
    least = min(abs(run.rate), abs(run.entered))
    return own > _AGAINST * (least if least > 0.0 else abs(run.other))  # from a fold the rates say nothing


@inlined
def classify(run):
    """Status and kind of a crossing by the rates at the surface: a transversal one arrives and leaves."""
    if run.own < 0.0 and run.other < 0.0:
        return _SLIDING, _SLIDING_KIND
    if run.own < 0.0 < run.other or run.follow == 0:  # without a transition the place is too inaccurate to tell a touch
        return RUNNING, _TRANSVERSAL_KIND
    return _GRAZING, _GRAZING_KIND


@internal
def jump(context):
    """Jump, and find where the fields lead from there: status, kind, mode entered, and the rate into it.

    If the declared jump leads from the surface to the surface and the run has landed on it, the sign of g after the
    jump is round-off, and the fields decide. Otherwise the sign of g decides, unless g is within rounding of zero.
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
    """Time since the last crossing, or the start."""
    return abs((run.t - run.last_hit) + (run.t_carry - run.last_hit_carry))


@internal
def is_lost_in_rounding(context, found, own, rate):
    """Whether the segments before and after a jump both stay within rounding of the surface.

    A segment of duration T that arrives with rate r has reached the height r·T/4, if its path is a parabola. Below the
    rounding of g neither place nor rates are known, so that where a touch leads is undetermined.
    """
    run = context.run
    if context.guards[run.mode].jump == NO_JUMP or run.follow == 0 or run.shift != 0.0:
        return False
    return found == TOUCH or max(-own, rate) * elapsed(run) <= 4.0 * MARGIN * context.w[ROUNDING_OF_G]


@inlined
def accumulates(run):
    """Update the times between crossings; returns whether they accumulate within round-off of the current time (Zeno).

    The gaps yet to come of a geometric sequence with ratio q add up to gap·q/(1 − q).
    """
    gap = elapsed(run)
    ratio = gap / run.gap if run.gap > 0.0 else math.inf
    run.shrinking = run.shrinking + 1 if ratio < 1.0 else 0
    run.gap, run.last_hit, run.last_hit_carry = gap, run.t, run.t_carry
    return run.shrinking >= _SHRUNK and gap * ratio <= _SPENT * abs(run.t) * (1.0 - ratio)


@inlined
def switch_mode(context, log, found):
    """At the surface: jump, classify, record the crossing, and enter the next mode."""
    run, x = context.run, context.x
    if run.mode == SLIDING_MODE:
        return leave_sliding(context, log, found)
    hit, along = log.hits[run.hits], math.copysign(1.0, context.run.tau)
    guard = context.guards[run.mode]
    hit.t = run.t
    hit.rate_before, hit.rate_after = along * run.sign * run.own, -along * run.sign * run.other
    own, other = run.own, run.other
    if run.shift != 0.0 or run.follow == 0:  # the state is not where the surface was met
        for i in range(x.size):
            context.place[i] = x[i]
        evaluate_switching(context, run.t)
    hit.g, rate = context.w[G], run.other
    run.own, run.other = own, other
    record_place(context, log, 1)
    if run.monitored > 0:  # with the error of ψ at the end of the segment
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
        if status == _SLIDING and run.slides == 1:
            status, mode = RUNNING, SLIDING_MODE
    leaving = run.leaving
    record_place(context, log, 2)
    record_crossing(run, hit, kind, mode, status)
    if status != RUNNING:
        return status
    if mode == SLIDING_MODE:
        run.mode, run.pending = mode, 1
    else:
        enter_mode(context, mode, rate)
        if leaving == 0:  # it has jumped off the surface
            run.height, run.leaving = run.sign * context.w[G], 0
        elif is_contradicted(context, run.hit):  # the step is so stiff that its rounding hides the surface
            return _UNSTABLE
    return limit_crossings(run)


@internal
def leave_sliding(context, log, found):
    """Where sliding ends: find the field that has turned, record the crossing, and enter the mode of its side.

    Its rate, a guard, vanishes there, as at a fold. If both rates vanish to round-off, or the one that does so does not
    change its sign, the rates do not tell where the solution leads.
    """
    run, x, w = context.run, context.x, context.w
    hit, along = log.hits[run.hits], math.copysign(1.0, context.run.tau)
    for i in range(x.size):
        context.place[i] = x[i]
    mode = context.guards[SLIDING_MODE + run.guard].to
    swap_guards(run)
    evaluate_switching(context, run.t)
    attracts = run.sign * w[G] > MARGIN * w[ROUNDING_OF_G]
    swap_guards(run)
    into_minus, into_plus = evaluate_rates(context, 0, run.t)
    rate = into_minus if mode == 0 else into_plus
    hit.t, hit.g = run.t, w[G]
    hit.rate_before, hit.rate_after = 0.0, along * context.guards[mode].sign * rate
    record_place(context, log, 1)
    record_place(context, log, 2)
    if run.monitored > 0:
        widen_envelope(context, log)
    tangent = found == TOUCH or not attracts
    status = _GRAZING if tangent else RUNNING
    record_crossing(run, hit, _GRAZING_KIND if tangent else _LEAVING_KIND, mode, status)
    if status != RUNNING:
        return status
    enter_mode(context, mode, 0.0 if run.shift == 0.0 and run.follow == 1 else rate)
    return limit_crossings(run)


@inlined
def record_crossing(run, hit, kind, mode, status):
    """Record how a crossing ends, and count it."""
    hit.kind, hit.mode = kind, mode if status == RUNNING else NO_MODE
    run.hits += 1
    run.crossings += 1


@inlined
def limit_crossings(run):
    """Status after a crossing: Zeno, at the limit of crossings, or running."""
    if accumulates(run):
        return _ZENO
    return _CROSSING_LIMIT if run.crossings >= run.max_crossings else RUNNING


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
