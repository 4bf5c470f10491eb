"""Land on the surface, perturb, jump, classify, switch: the paper's Algorithm 1, one move at a time.

A *move* is a step, or the part of one up to the next crossing, or what a crossing has left of one. Jitted; inlined into
`time_loop`. Heights and rates are as in `event_location`.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `time_loop`.

from __future__ import annotations

import math

from core.kernels.abi import DELAY, DOUBT, G_END, JUMP, LOOK, POLISH, RATES, SETTLE, SLACK, G, call
from core.kernels.jit import inlined, internal
from core.kernels.root_isolation import NONE as NO_ROOT
from core.kernels.root_isolation import ROOT
from core.transition.approach import cut_to_domain, cut_to_reach, has_end, is_at_surface, move_across
from core.transition.event_location import (
    BOUND,
    FAILED,
    FOUND,
    NONE,
    SHORT,
    TOUCH,
    arrive,
    climb,
    first_beside_series,
    first_crossing,
    meets,
    probe,
    root_of_series,
)
from core.transition.records import JUMP_TO_SURFACE, NO_JUMP
from core.transition.status import CROSSING_KINDS, Status
from core.transition.surface import (
    MARGIN,
    accept,
    contradicts,
    is_contradicted,
    is_on_surface,
    look,
    note,
    pass_time,
    widen_envelope,
)

__all__ = ["RUNNING", "enter", "is_plain", "move"]

RUNNING = int(Status.RUNNING)
_SLIDING, _REPELLING, _GRAZING = int(Status.SLIDING), int(Status.REPELLING), int(Status.GRAZING)
_NO_CONVERGENCE, _ESCAPED, _ZENO = int(Status.NO_CONVERGENCE), int(Status.ESCAPED), int(Status.ZENO)
_CROSSING_LIMIT, _CONTRADICTION = int(Status.CROSSING_LIMIT), int(Status.CONTRADICTION)
_UNSTABLE = int(Status.UNSTABLE)
_TRANSVERSAL_KIND, _GRAZING_KIND, _SLIDING_KIND, _REPELLING_KIND, _JUMP_KIND = range(len(CROSSING_KINDS))

_EPS = 2.0**-52
#: Gaps between crossings that have shrunk so many times in a row, and whose sum to come is below this part of the
#: time, accumulate.
_SHRUNK, _SPENT = 8, 2.0**-52
#: A surface is met against the field where the rate away from it is this part of that at the start of the step, or of
#: that with which the side was entered.
_AGAINST = 2.0**-7
#: Gaps that have shrunk in a row, after which a visit that is lost in rounding is the end of a sequence, and no touch.
_COMING = 3


@internal
def is_plain(run, h, height, rate):
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
def take_side(motion, side, rate):
    """Occupy a side, from its surface on."""
    run = motion.run
    run.side, run.height, run.rate, run.entered = side, 0.0, rate, rate
    run.leaving = 1
    if run.conservative == 1 or run.watched > 0:
        call(motion.functions[SETTLE + (side > 0)], run.t, 0.0, motion.p, motion.w, motion.memo)


@internal
def enter(motion):
    """Find the side of the initial value: by the sign of g, on the surface by where the fields lead."""
    run, w = motion.run, motion.w
    for i in range(motion.x.size):
        motion.place[i] = motion.x[i]
    run.side = 1
    look(motion, run.t)
    g, into_plus, into_minus = w[G], run.own, run.other
    run.side = 0
    if not abs(g) < math.inf:
        return _NO_CONVERGENCE
    side = 1 if g > 0.0 else -1
    if run.first_side != 0:  # it has been found by other means
        side = run.first_side
        take_side(motion, side, max(into_plus if side > 0 else into_minus, 0.0))
    elif abs(g) <= w[SLACK]:  # on the surface as exactly as floating point can say
        if into_plus > 0.0 and into_minus > 0.0:
            return _REPELLING
        if not (into_plus * into_minus < 0.0):
            return _SLIDING if into_plus < 0.0 and into_minus < 0.0 else _GRAZING
        side = 1 if into_plus > 0.0 else -1
        take_side(motion, side, into_plus if side > 0 else into_minus)
    else:
        take_side(motion, side, into_plus if side > 0 else into_minus)
        run.height, run.leaving = side * g, 0
    run.first_side = side
    return RUNNING


@internal
def is_met_against_the_field(motion, found, own):
    """Whether the scheme meets the surface where its field leads away from it, and does not just touch it.

    Such a step is too long: the field changes in it by more than it is. A touch is one where the state, if it has just
    left the surface, has stayed within rounding of it.
    """
    run = motion.run
    if run.follow == 0 or run.shift != 0.0:
        return False
    if found == TOUCH:
        return run.leaving == 1 and run.rate * abs(run.hit) > 8.0 * MARGIN * motion.w[DOUBT]
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
def leap(motion):
    """Jump, and look where the fields lead from there: status, kind, side entered, and the rate into it.

    A jump that leads from the surface to the surface is known by its declaration: g is rounding there, and its sign
    means nothing. Where the surface was not landed on, or of any other jump, g tells.
    """
    run, x, w = motion.run, motion.x, motion.w
    call(motion.functions[JUMP], run.t, 0.0, motion.p, w, motion.memo)
    for i in range(x.size):
        x[i], motion.carry[i] = motion.place[i], 0.0
    call(motion.functions[LOOK], run.t, 0.0, motion.p, w, motion.memo)
    along = math.copysign(1.0, run.tau)
    into_minus, into_plus = -along * w[RATES], along * w[RATES + 1]
    landed = run.follow == 1 and run.shift == 0.0
    run.leaving = 1 if (landed and run.jump == JUMP_TO_SURFACE) or is_on_surface(motion) else 0
    if run.leaving == 0:
        side = 1 if w[G] > 0.0 else -1
        return RUNNING, _JUMP_KIND, side, into_plus if side > 0 else into_minus
    if into_minus > 0.0 and into_plus > 0.0:
        return _REPELLING, _REPELLING_KIND, 0, 0.0
    if into_plus > 0.0:
        return RUNNING, _JUMP_KIND, 1, into_plus
    if into_minus > 0.0:
        return RUNNING, _JUMP_KIND, -1, into_minus
    return _SLIDING, _SLIDING_KIND, 0, 0.0


@inlined
def elapsed(run):
    """Time since the crossing before, or the start."""
    return abs((run.t - run.met) + (run.t_carry - run.met_carry))


@internal
def is_lost_in_rounding(motion, found, own, rate):
    """Whether the visit that a jump ends here, and the next one, stay within rounding of the surface.

    A visit of length T that arrives at the rate r has been r·T/4 away, if its path is a parabola. Below the rounding
    of g neither the place nor the rates of a visit are known, and so neither is where a touch leads.
    """
    run = motion.run
    if run.jump == NO_JUMP or run.follow == 0 or run.shift != 0.0:
        return False
    return found == TOUCH or max(-own, rate) * elapsed(run) <= 4.0 * MARGIN * motion.w[DOUBT]


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
def switch_side(motion, log, found):
    """At the surface: jump, classify, take the other side, write the crossing down."""
    run, x = motion.run, motion.x
    hit, along = log.hits[run.hits], math.copysign(1.0, motion.run.tau)
    hit.t = run.t
    hit.rate_before, hit.rate_after = along * run.side * run.own, -along * run.side * run.other
    own, other = run.own, run.other
    if run.shift != 0.0 or run.follow == 0:  # it is not where the surface was met
        for i in range(x.size):
            motion.place[i] = x[i]
        look(motion, run.t)
    hit.g, rate = motion.w[G], run.other
    run.own, run.other = own, other
    note(motion, log, 1)
    if run.watched > 0:  # what the side that is left has lost
        widen_envelope(motion, log)
    against = is_met_against_the_field(motion, found, own)
    run.leaving = 1
    if run.jump != NO_JUMP:
        status, kind, entered, rate = leap(motion)
        if status == RUNNING and run.leaving == 1 and is_lost_in_rounding(motion, found, own, rate):
            status = _ZENO if run.shrinking >= _COMING and elapsed(run) < run.gap else _GRAZING
            kind = _GRAZING_KIND
        elif status == RUNNING and against:
            status, kind = _UNSTABLE, _GRAZING_KIND
        hit.rate_after = along * entered * rate
    else:
        status, kind = classify(run)
        status = _UNSTABLE if status == _GRAZING and against else status
        entered = -run.side
    leaving = run.leaving
    note(motion, log, 2)
    hit.kind = kind
    hit.side = entered if status == RUNNING else 0
    run.hits += 1
    run.crossings += 1
    if status != RUNNING:
        return status
    take_side(motion, entered, rate)
    if leaving == 0:  # it has jumped off the surface
        run.height, run.leaving = entered * motion.w[G], 0
    elif is_contradicted(motion, run.hit):  # a step so stiff that its own rounding hides the surface
        return _UNSTABLE
    if accumulates(run):
        return _ZENO
    return _CROSSING_LIMIT if run.crossings >= run.max_crossings else RUNNING


@inlined
def land(motion, log, t):
    """Move the state to the crossing found, or by the perturbation beyond it; returns whether that could be done.

    Paper: solve (eq:to-interface), (eq:interface) for (t̂, x̂); with a perturbation, t̂ ← t̂ + c·τᵖ and x̂ anew there.
    """
    run, x, place = motion.run, motion.x, motion.place
    if run.shift != 0.0:
        probe(motion, t, run.hit)
        arrive(motion)
        note(motion, log, 0)
        look(motion, t + run.hit)
        run.hit += run.shift
    if run.probed != run.hit and not abs(probe(motion, t, run.hit)) < math.inf:
        return False
    accept(motion)
    if run.shift == 0.0:
        call(motion.functions[POLISH + (run.side > 0)], t + run.hit, 0.0, motion.p, motion.w, motion.memo)
        run.hit += motion.w[DELAY]
        if run.hit * math.copysign(1.0, run.tau) < 0.0:
            run.hit = 0.0  # a start on the surface is not moved back in time
    pass_time(run, run.hit)
    if run.shift == 0.0:
        for i in range(x.size):
            place[i] = x[i]
        look(motion, run.t)
        if run.edged == 1 and run.jump == NO_JUMP and run.side * motion.w[G] > 0.0:
            move_across(motion, run.t)
        note(motion, log, 0)
    return True


@internal
def step_over(motion, log, t, h, height, rate):
    """Without a transition: the step stands, and only then is the side looked at."""
    run, x, place = motion.run, motion.x, motion.place
    if height <= 0.0:  # the fields are compared where the chord of the step meets the surface
        part = run.height / (run.height - height) if run.height > 0.0 else 0.0
        for i in range(x.size):
            place[i] = x[i] + part * motion.increment[i]
        note(motion, log, 0)
        look(motion, t + part * h)
    accept(motion)
    pass_time(run, h)
    run.height, run.rate = height, rate
    if height > 0.0:
        run.leaving = 0
        return RUNNING
    status = switch_side(motion, log, FOUND)
    run.leaving, run.height = 0, run.side * motion.w[G]
    return status


@inlined
def move(motion, log, h):
    """Go on by h, or to the first crossing before that and onto its other side; run.rest is what is left of h."""
    run, whole = motion.run, h
    t, found = run.t + run.t_carry, NONE
    kind, low, high = NO_ROOT, 0.0, 0.0
    run.rest = 0.0
    if run.adaptive == 1:
        h = whole = cut_to_reach(motion, t, h)
        if run.follow == 1:
            kind, low, high = root_of_series(motion, h)
    if kind == ROOT and meets(motion, t, low, high):
        found = FOUND  # and the end of the step need not be looked at
    else:
        if not has_end(motion, t, h):
            if arrive(motion) >= BOUND:
                return _ESCAPED
            found = FAILED
        height, rate = run.side * motion.w[G_END], climb(motion)
        if found == FAILED:
            pass
        elif run.follow == 0:
            return step_over(motion, log, t, h, height, rate)
        elif run.adaptive == 1:
            found = first_beside_series(motion, t, h, height, rate, kind, low, high)
        elif (h > 0.0) == (run.tau > 0.0):  # going back from a perturbed crossing is no motion to be watched
            found = first_crossing(motion, t, h, height, rate)
        if found == FAILED and run.follow == 1:
            h = cut_to_domain(motion, t, h)
            if h == 0.0:
                return _NO_CONVERGENCE
            height, rate = run.side * motion.w[G_END], climb(motion)
            if run.leaving == 0 and is_at_surface(motion, t):
                run.hit, found = 0.0, FOUND
            else:
                found = first_crossing(motion, t, h, height, rate)
        if found == SHORT:
            h, run.final = run.hit, 0
            height, rate = probe(motion, t, h), climb(motion)
            found = NONE
        if found == NONE:
            if run.probed != h:  # looking for a crossing has moved the increment
                probe(motion, t, h)
            accept(motion)
            pass_time(run, h)
            run.height, run.rate = height, rate
            run.leaving = 0 if height > 0.0 else run.leaving
            run.longest = max(run.longest, abs(h))
            run.rest = whole - h if run.adaptive == 0 else 0.0
            return _CONTRADICTION if height < 0.0 and contradicts(motion, h) else RUNNING
    if found == FAILED or not land(motion, log, t):
        return _NO_CONVERGENCE
    if found == TOUCH:
        run.own = 0.0  # it turns at the surface, and does not arrive
    run.rest = whole - run.hit if run.adaptive == 0 else 0.0
    run.final = run.final if run.adaptive == 0 else 0
    return switch_side(motion, log, found)
