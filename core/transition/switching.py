"""At the surface: jump, classify, record the crossing, enter the next mode. Jitted; inlined into `time_loop`.

Heights and rates are as in `event_location`.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `time_loop`.

from __future__ import annotations

import math

from core.kernels.abi import (
    EVALUATE,
    GAP,
    JUMP,
    LAST,
    LAST_CARRY,
    MAX_VISITS,
    ROUNDING_OF_G,
    SHRINKING,
    VISIT,
    VISITS,
    G,
    call,
)
from core.kernels.jit import inlined, internal
from core.transition.entering import begin_mode, enter_mode, set_mode
from core.transition.event_location import TOUCH
from core.transition.passes import keep_crossing
from core.transition.plain_steps import look_at
from core.transition.records import JUMP_TO_SURFACE, NO_JUMP, NO_MODE
from core.transition.status import CROSSING_KINDS, Status
from core.transition.surface import (
    MARGIN,
    evaluate_rates,
    evaluate_switching,
    is_contradicted,
    is_on_surface,
    is_wanted,
    record_place,
    widen_envelope,
)

__all__ = ["switch_mode"]

_RUNNING, _SLIDING, _REPELLING = int(Status.RUNNING), int(Status.SLIDING), int(Status.REPELLING)
_GRAZING, _ZENO, _UNSTABLE = int(Status.GRAZING), int(Status.ZENO), int(Status.UNSTABLE)
_CROSSING_LIMIT = int(Status.CROSSING_LIMIT)
_CORNER, _UNDECLARED = int(Status.CORNER), int(Status.UNDECLARED)
(
    _TRANSVERSAL_KIND, _GRAZING_KIND, _SLIDING_KIND, _REPELLING_KIND, _JUMP_KIND, _LEAVING_KIND, _CORNER_KIND,
) = range(len(CROSSING_KINDS))  # fmt: skip

_EPS = 2.0**-52
#: Crossings accumulate if the times between them have shrunk this many times in a row …
_SHRUNK = 8
#: … and the sum of the times to come is below this part of the current time.
_SPENT = 2.0**-52
#: Crossings of whatever surfaces accumulate, too, if so many lie within this rounding, the later half of them nearer.
_CLUSTERED = 128
#: Bounces accumulate, too, if the time between two is below this part of the time by which each is moved.
_CROWDED = 2.0**-4
#: The surface is met against the field if the rate away from it exceeds this part of the rate at the start of the step,
#: or of the rate with which the mode was entered.
_AGAINST = 2.0**-7
#: After this many shrinking times in a row, a stay in a mode within rounding of the surface is Zeno and not a touch.
_COMING = 3
#: Two lengths in a step are the same if they differ by no more than this part.
_SAME = 2.0**-20
#: A guard of sliding vanishes as a power of time if its rate is then below this part of its mean rate in the step.
_FLAT = 2.0**-26
#: Both rates vanish at once if the other is below this part of what the first loses in a time as long as the slide, as
#: where g = 0 crosses itself: there the rates are round-off of the state, and not of their own terms.
_AT_ONCE = 2.0**-44


@internal
def is_met_against_the_field(context, found, own):
    """Whether the scheme meets the surface, other than by a touch, where its field leads away from it.

    Such a step is too long: the field changes in it by more than its own size. After a crossing, a touch is genuine
    only if the state has stayed within rounding of the surface. A path that has turned within rounding of the surface,
    and is located on its way back, meets it by a touch.
    """
    run = context.run
    if run.follow == 0 or run.shift != 0.0:
        return False
    turned = own * own * abs(run.hit)  # twice the depth of a parabola below the surface, times the change of its rate
    if turned <= 2.0 * MARGIN * context.w[ROUNDING_OF_G] * (own - run.rate):
        return False
    if found == TOUCH:
        return run.leaving == 1 and run.rate * abs(run.hit) > 8.0 * MARGIN * context.w[ROUNDING_OF_G]
    least = min(abs(run.rate), abs(run.entered))
    return own > _AGAINST * (least if least > 0.0 else abs(run.other))  # from a fold the rates say nothing


@inlined
def classify(run, guard):
    """Status and kind of a crossing by the rates at the surface: a transversal one arrives and leaves."""
    at_once = run.chain > 0  # the mode was entered beyond its guard, and ends whatever the rates are
    if guard.back == NO_MODE:  # a one-way guard, or no law beyond
        if run.own < 0.0 or run.follow == 0 or at_once:
            return _RUNNING if guard.to != NO_MODE else _UNDECLARED, _TRANSVERSAL_KIND
        return _GRAZING, _GRAZING_KIND
    if run.own < 0.0 and run.other < 0.0:
        return _SLIDING, _SLIDING_KIND
    if run.own < 0.0 < run.other or run.follow == 0 or at_once:  # without a transition the place is too inaccurate
        return _RUNNING, _TRANSVERSAL_KIND
    return _GRAZING, _GRAZING_KIND


@internal
def is_at_corner(context):
    """Whether the state, where switching has just been evaluated, is within rounding of another surface, too.

    Rounding is that of the state here and of the increment that led here, which is of the size of the state before.
    The guards that vanish here go to the bits of run.corner.
    """
    run, w, x, place = context.run, context.w, context.x, context.place
    here = run.guard
    run.corner = 1 << here
    for k in range(run.guards):
        if k != here and context.guards[run.row + k].turns == 0:
            for i in range(x.size):
                place[i] = x[i] - context.increment[i]
            call(context.functions[run.row + k, EVALUATE], run.t, 0.0, context.p, w, context.scratch)
            before = w[ROUNDING_OF_G]
            for i in range(x.size):
                place[i] = x[i]
            call(context.functions[run.row + k, EVALUATE], run.t, 0.0, context.p, w, context.scratch)
            if abs(w[G]) <= MARGIN * (w[ROUNDING_OF_G] + before):
                run.corner |= 1 << k
    own, other = run.own, run.other
    evaluate_switching(context, run.t)
    run.own, run.other = own, other
    return run.corner != 1 << here


@internal
def jump(context):
    """Jump, and find where the fields lead from there: status, kind, row of the mode entered, and the rate into it.

    If the declared jump leads from the surface to the surface, the sign of g after the jump tells nothing: it is
    round-off, or the state was beside the surface before. The fields decide, of a state beside it if one of them leads
    away. Otherwise the sign of g decides, unless g is within rounding of zero. A one-way guard leads to its mode from
    wherever the jump has led.
    """
    run, x, w = context.run, context.x, context.w
    row = run.row + run.guard
    guard, here = context.guards[row], run.row
    call(context.functions[row, JUMP], run.t, 0.0, context.p, w, context.scratch)
    for i in range(x.size):
        x[i], context.carry[i] = context.place[i], 0.0
    into_minus, into_plus = evaluate_rates(context, row, run.t)
    landed = run.follow == 1 and run.shift == 0.0
    into_here = into_plus if run.sign > 0 else into_minus
    away = into_here > 0.0 if guard.to == NO_MODE else into_minus > 0.0 or into_plus > 0.0
    run.leaving = 1 if (guard.jump == JUMP_TO_SURFACE and (landed or away)) or is_on_surface(context) else 0
    if guard.to == NO_MODE:  # a wall: no law is declared beyond
        if run.leaving == 0:
            return (_RUNNING if run.sign * w[G] > 0.0 else _UNDECLARED), _JUMP_KIND, here, into_here
        return (_RUNNING, _JUMP_KIND, here, into_here) if into_here > 0.0 else (_SLIDING, _SLIDING_KIND, here, 0.0)
    if guard.back == NO_MODE:
        run.leaving = 0
        return _RUNNING, _JUMP_KIND, guard.to, 0.0
    minus, plus = (guard.to, here) if run.sign > 0 else (here, guard.to)
    if run.leaving == 0:
        return (_RUNNING, _JUMP_KIND, plus, into_plus) if w[G] > 0.0 else (_RUNNING, _JUMP_KIND, minus, into_minus)
    if into_minus > 0.0 and into_plus > 0.0:
        return _REPELLING, _REPELLING_KIND, here, 0.0
    if into_plus > 0.0:
        return _RUNNING, _JUMP_KIND, plus, into_plus
    if into_minus > 0.0:
        return _RUNNING, _JUMP_KIND, minus, into_minus
    return _SLIDING, _SLIDING_KIND, here, 0.0


@inlined
def elapsed(run):
    """Time since the last crossing, or the start."""
    return abs((run.t - run.last_hit) + (run.t_carry - run.last_hit_carry))


@internal
def touch(context, surface):
    """Status and kind where the state meets a surface at which it jumps if it arrives: whether it does, rounding hides.

    Where it came in ever shorter times this is one more of its jumps, else it touches the surface.
    """
    w, visit = context.w, visit_of(surface)
    comes_closer = w[visit + SHRINKING] >= _COMING and since_visit(context.run, w, visit) < w[visit + GAP]
    return (_ZENO, _JUMP_KIND) if comes_closer else (_GRAZING, _GRAZING_KIND)


@internal
def is_lost_in_rounding(context, own, rate):
    """Whether the segments before and after a jump on the surface both stay within rounding of it.

    A segment of duration T that arrives with rate r has reached the height r·T/4, if its path is a parabola. Below the
    rounding of g neither place nor rates are known, so that where a touch leads is undetermined.
    """
    run = context.run
    if run.leaving == 0 or run.follow == 0 or run.shift != 0.0:
        return False
    return max(-own, rate) * elapsed(run) <= 4.0 * MARGIN * context.w[ROUNDING_OF_G]


@inlined
def visit_of(surface):
    """Place in the frame of what it keeps of the crossings of a surface."""
    return VISITS + VISIT * (surface % MAX_VISITS)


@internal
def start_clocks(run, w):
    """Let the run begin now."""
    run.t_start = run.last_hit = run.t
    for surface in range(MAX_VISITS):
        w[visit_of(surface) + LAST] = run.t


@inlined
def since_visit(run, w, visit):
    """Time since the last crossing of a surface, or the start."""
    return abs((run.t - w[visit + LAST]) + (run.t_carry - w[visit + LAST_CARRY]))


@inlined
def is_cluster(run):
    """Count a crossing; returns whether as many as accumulate lie within rounding of now, in whatever order.

    An orbit that spirals into a corner meets each surface at times that shrink from turn to turn, not from one to the
    next.
    """
    since = abs((run.t - run.cluster) + (run.t_carry - run.cluster_carry))
    if since > _SPENT * abs(run.t) or run.clustered >= _CLUSTERED:
        run.cluster, run.cluster_carry, run.clustered = run.t, run.t_carry, 0
        return False
    run.clustered += 1
    if run.clustered == _CLUSTERED // 2:
        run.cluster_half = since
    return run.clustered == _CLUSTERED and since < 2.0 * run.cluster_half


@inlined
def accumulates(run, w, surface):
    """Update the times between crossings of a surface; returns whether they accumulate within round-off of now (Zeno).

    The gaps yet to come of a geometric sequence with ratio q add up to gap·q/(1 − q). Several surfaces may be met in
    turn, at unequal distances, so that each is looked at by itself.
    """
    visit = visit_of(surface)
    gap = since_visit(run, w, visit)
    clusters = is_cluster(run)
    ratio = gap / w[visit + GAP] if w[visit + GAP] > 0.0 else math.inf
    w[visit + SHRINKING] = w[visit + SHRINKING] + 1.0 if ratio < 1.0 else 0.0
    w[visit + GAP], w[visit + LAST], w[visit + LAST_CARRY] = gap, run.t, run.t_carry
    run.last_hit, run.last_hit_carry = run.t, run.t_carry
    return clusters or (w[visit + SHRINKING] >= _SHRUNK and gap * ratio <= _SPENT * abs(run.t) * (1.0 - ratio))


@internal
def switch_mode(context, log, found):
    """At the surface: jump, classify, record the crossing, and enter the next mode."""
    run, x = context.run, context.x
    if run.chain == 0:
        keep_crossing(context, log)
    if run.sliding == 1:
        return leave_sliding(context, log, found)
    hit, along = log.hits[run.hits], math.copysign(1.0, context.run.tau)
    here, guard = run.row, context.guards[run.row + run.guard]
    hit.t, hit.surface = run.t, guard.surface
    hit.rate_before, hit.rate_after = along * run.sign * run.own, -along * run.sign * run.other
    own, other = run.own, run.other
    if run.shift != 0.0 or run.follow == 0:  # the state is not where the surface was met
        for i in range(x.size):
            context.place[i] = x[i]
        evaluate_switching(context, run.t)
    corner = run.guards > 1 and run.follow == 1 and run.shift == 0.0 and is_at_corner(context)
    hit.g, rate = context.w[G], run.other
    run.own, run.other = own, other
    record_place(context, log, 1)
    if run.monitored > 0:  # with the error of ψ at the end of the segment
        widen_envelope(context, log)
    against = run.chain == 0 and is_met_against_the_field(context, found, own)
    stayed = has_stayed(context, guard.surface)
    run.leaving = 1
    row, at = guard.to, 0 if guard.back == NO_MODE else 1 << guard.back
    if corner:
        status, kind = _CORNER, _CORNER_KIND
    elif guard.jump != NO_JUMP:
        if run.follow == 1 and run.chain == 0 and not own < 0.0:  # it touches the surface: see `touch`
            status, kind = (_UNSTABLE, _GRAZING_KIND) if against else touch(context, guard.surface)
            row, rate = here, own
        else:
            status, kind, row, rate = jump(context)
            if status == _RUNNING and is_lost_in_rounding(context, own, rate):
                status, kind = touch(context, guard.surface)
        at = 0 if run.leaving == 0 else 1 << run.guard if row == here else at
        hit.rate_after = along * (-run.sign if row == guard.to else run.sign) * rate
    else:
        status, kind = classify(run, guard)
        status = _UNSTABLE if status == _GRAZING and against else status
        if status == _SLIDING and run.slides == 1 and guard.slide != NO_MODE:
            status, row, at, rate = _RUNNING, guard.slide, 0, math.nan
    record_place(context, log, 2)
    jumped = run.leaving == 0 or guard.jump != NO_JUMP
    if stayed and status == _GRAZING:  # nor has it crossed
        retract_crossing(context, log)
        hit = log.hits[run.hits]
    record_crossing(run, hit, kind, context.guards[max(row, 0)].mode, status)
    if status != _RUNNING:
        return status
    sign, leaving = run.sign, run.leaving
    set_mode(context, row, at, rate if at > 0 else math.nan)
    run.jumped = 1 if jumped else 0
    if leaving == 1 and at > 0 and guard.back != NO_MODE:  # one that has jumped off the surface contradicts nothing
        run.sign = sign if row == here else -sign
        if is_contradicted(context, run.hit):  # the step is so stiff that its rounding hides the surface
            return _UNSTABLE
    status = begin_mode(context)
    hit.mode = run.mode if status == _RUNNING else NO_MODE  # a jump may have led beyond other surfaces
    return limit_crossings(context, hit.surface) if status == _RUNNING else status


@inlined
def has_stayed(context, surface):
    """Whether the step began where the state crossed this surface, within rounding of which it has stayed since.

    How high it has been follows as in `is_lost_in_rounding`.
    """
    run = context.run
    crossed = run.leaving == 1 and run.entered > 0.0 and run.jumped == 0 and run.crossings > 0 and run.chain == 0
    located = run.follow == 1 and run.shift == 0.0
    since = since_visit(run, context.w, visit_of(surface))
    low = run.entered * since <= 4.0 * MARGIN * context.w[ROUNDING_OF_G]
    return crossed and located and low and since == elapsed(run) and since <= abs(run.hit) * (1.0 + _SAME)


@internal
def retract_crossing(context, log):
    """Let the touch just written take the place of the crossing before it, as the state has not left g = 0 since then.

    The run is back in the mode before that crossing. If that was written by an earlier call of the loop, run.retracted
    tells so.
    """
    run, hits, places = context.run, log.hits, log.places
    before = context.guards[context.guards[run.row + run.guard].to]
    run.mode, run.crossings = before.mode, run.crossings - 1
    if run.hits == 0:
        run.retracted = 1
        return
    run.hits -= 1
    rate = hits[run.hits].rate_before
    hits[run.hits], hits[run.hits].rate_before = hits[run.hits + 1], rate
    for k in range(3):
        for i in range(context.x.size):
            places[run.hits, k, i] = places[run.hits + 1, k, i]


@internal
def leave_sliding(context, log, found):
    """Where sliding ends: find the field that has turned, record the crossing, and enter the mode of its side.

    Its rate, a guard, vanishes there, as at a fold. If both rates vanish to round-off, or the one that does so does not
    change its sign, or only as a power of the time, the rates do not tell where the solution leads. Where another
    surface is reached, no field is given along both.
    """
    run, x, w = context.run, context.x, context.w
    guard, guard_left = context.guards[run.row + run.guard], run.guard
    known = run.follow == 1 and run.height > MARGIN * w[ROUNDING_OF_G]
    flat = known and -run.own * abs(run.hit - run.shift) <= _FLAT * run.height
    hit, along = log.hits[run.hits], math.copysign(1.0, context.run.tau)
    for i in range(x.size):
        context.place[i] = x[i]
    hit.t, hit.surface = run.t, guard.surface
    record_place(context, log, 1)
    record_place(context, log, 2)
    if run.monitored > 0:
        widen_envelope(context, log)
    if guard.turns == 0 or (run.guards > 2 and is_at_corner(context)):
        evaluate_switching(context, run.t)
        hit.g, hit.rate_before, hit.rate_after = w[G], along * run.sign * run.own, 0.0
        record_crossing(run, hit, _CORNER_KIND, NO_MODE, _CORNER)
        return _CORNER
    look_at(run, w, 1 - guard_left)
    evaluate_switching(context, run.t)
    lost = run.height * elapsed(run) / abs(run.hit) if known and run.hit != 0.0 else 0.0
    attracts = run.sign * w[G] > max(MARGIN * w[ROUNDING_OF_G], _AT_ONCE * lost)
    look_at(run, w, guard_left)
    into_minus, into_plus = evaluate_rates(context, guard.to + guard.back, run.t)
    rate = into_minus if guard_left == 0 else into_plus
    hit.g = w[G]
    hit.rate_before, hit.rate_after = 0.0, along * (-rate if guard_left == 0 else rate)
    tangent = found == TOUCH or flat or not attracts
    status = _GRAZING if tangent else _RUNNING
    record_crossing(run, hit, _GRAZING_KIND if tangent else _LEAVING_KIND, context.guards[guard.to].mode, status)
    if status != _RUNNING:
        return status
    status = enter_mode(context, guard.to, 1 << guard.back, 0.0 if run.shift == 0.0 and run.follow == 1 else rate)
    return limit_crossings(context, hit.surface) if status == _RUNNING else status


@inlined
def record_crossing(run, hit, kind, mode, status):
    """Record how a crossing ends, and count it; whether a corner is wanted, `Runner` tells."""
    hit.kind, hit.mode, hit.length = kind, mode if status == _RUNNING else NO_MODE, run.hit
    run.hits += 1
    run.crossings += 1
    if kind != _CORNER_KIND and is_wanted(hit, run.wanted_surface, run.wanted_way):
        run.wanted += 1


@inlined
def limit_crossings(context, surface):
    """Status after a crossing: Zeno, at the limit of crossings, or running."""
    run = context.run
    # Bounces moved to just behind the last one: they are far nearer to each other than the perturbation moves them.
    gap = since_visit(run, context.w, visit_of(surface))
    crowded = run.jumped == 1 and run.crossings > 1 and gap < _CROWDED * abs(run.shift)
    if accumulates(run, context.w, surface) or crowded:
        return _ZENO
    return _CROSSING_LIMIT if run.crossings >= run.max_crossings or run.wanted >= run.max_wanted else _RUNNING
