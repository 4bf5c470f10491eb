"""Enter a mode: the first one, the one beyond a surface, or sliding. Jitted; inlined into `time_loop`.

Heights and rates are as in `event_location`.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `time_loop`.

from __future__ import annotations

import math

from core.kernels.abi import ROUNDING_OF_G, SET_LEVELS, SINGULARITY, STEP, G, call
from core.kernels.jit import inlined, internal
from core.transition.plain_steps import set_guard, take_guard
from core.transition.records import NO_JUMP, NO_MODE
from core.transition.status import Status
from core.transition.surface import MARGIN, evaluate_rates, evaluate_switching

__all__ = ["begin_mode", "enter_first_mode", "enter_mode", "set_mode"]

_RUNNING, _SLIDING, _REPELLING = int(Status.RUNNING), int(Status.SLIDING), int(Status.REPELLING)
_GRAZING, _NO_CONVERGENCE, _UNDECLARED = int(Status.GRAZING), int(Status.NO_CONVERGENCE), int(Status.UNDECLARED)
_CORNER = int(Status.CORNER)
#: Result of `examine_guard`: the state is beyond a surface after a jump, so that the mode is another one.
_BEYOND = -1
#: Another one: the state is at the zero of a guard, where rounding may hide whether the field leads into the mode.
_ASK = -2


@inlined
def set_mode(context, row, at, rate):
    """Take a mode, by the row of its first guard, as the one to be entered at the zeros of some guards.

    at holds their bits; rate is that away from the surface, nan where it has to be evaluated.
    """
    run, guard = context.run, context.guards[row]
    run.row, run.mode, run.guards, run.sliding = row, guard.mode, guard.count, guard.slides
    run.at, run.entered, run.pending, run.jumped, run.past = at, rate, 1, 0, 0
    run.near, run.asked, run.inward, run.outward, run.folded = 0, 0, 0, 0, 0
    context.w[SINGULARITY] = 0.0  # it was one of the mode before


@inlined
def enter_mode(context, row, at, rate):
    """Enter a mode at the zeros of some guards: see `set_mode`."""
    set_mode(context, row, at, rate)
    return begin_mode(context)


@internal
def begin_mode(context):
    """Begin the mode that has been set; it stays pending until it is compiled.

    Every guard gets its height and rate. A guard at or beyond whose zero the mode is entered, other than by the way
    that led here, ends it at once (run.past); at its zero if the field leads out of the mode, of which `Runner` is
    asked. The mode stays pending until that is known, too.
    """
    run, w = context.run, context.w
    if context.functions[run.row, STEP] == 0:
        return _RUNNING
    for i in range(context.x.size):
        context.place[i] = context.x[i]
    rate, k, tries = run.entered, 0, 0
    known = run.at > 0 and rate == rate and (run.follow == 1 or run.crossings == 0)
    if known and run.guards == 1:
        run.guard, run.sign, run.height, run.rate, run.leaving = 0, guard_sign(context, 0), 0.0, rate, 1
        k = 1
    while k < run.guards:
        sign = guard_sign(context, k)
        if known and (run.at >> k) & 1 == 1:
            set_guard(w, k, sign, 0.0, rate, 1.0)
            k += 1
            continue
        status = examine_guard(context, k, sign)
        if status == _BEYOND:  # followed from surface to surface, each at most once
            tries += 1
            to = context.guards[run.row + k].to
            if to == NO_MODE or tries > run.guards:
                return _UNDECLARED
            run.near = same_surfaces(context, run.at | run.near, to)
            run.row, run.mode, run.guards = to, context.guards[to].mode, context.guards[to].count
            run.at, k = 0, 0
            if context.functions[run.row, STEP] == 0:
                return _RUNNING
        elif status == _ASK:
            run.asked, run.entered = k + 1, rate
            return _RUNNING
        elif status != _RUNNING:
            return status
        else:
            k += 1
    run.pending = 0
    if run.guards > 1 or not known:
        take_guard(run, w, 0)
    if run.conservative == 1 or run.monitored > 0:
        call(context.functions[run.row, SET_LEVELS], run.t, 0.0, context.p, w, context.scratch)
    return _RUNNING


@inlined
def guard_sign(context, k):
    """Sign that makes a guard of the mode positive inside it, in the direction of time of the run."""
    guard = context.guards[context.run.row + k]
    return -guard.sign if guard.turns == 1 and context.run.tau < 0.0 else guard.sign


@inlined
def same_surfaces(context, bits, row):
    """Bits of the guards of another region, by its first row, whose surfaces are those of some guards of this one."""
    run, found = context.run, 0
    for k in range(run.guards):
        for j in range(context.guards[row].count):
            if (bits >> k) & 1 == 1 and context.guards[row + j].surface == context.guards[run.row + k].surface:
                found |= 1 << j
    return found


@internal
def examine_guard(context, k, sign):
    """Evaluate a guard as its mode is entered, and set it; returns a Status, RUNNING if the mode can be entered."""
    run, w, guard = context.run, context.w, context.guards[context.run.row + k]
    run.guard, run.sign = k, sign
    evaluate_switching(context, run.t)
    height, noise = sign * w[G], MARGIN * w[ROUNDING_OF_G]
    if not abs(height) < math.inf:
        return _NO_CONVERGENCE
    if (run.at >> k) & 1 == 1:
        if run.follow == 1 or run.crossings == 0:
            set_guard(w, k, sign, 0.0, max(run.own, 0.0), 1.0)
        else:  # the surface has been stepped over; after a jump on it, the state is behind it
            set_guard(w, k, sign, height, run.own, 1.0 if run.jumped == 1 and run.own > 0.0 else 0.0)
        return _RUNNING
    if (run.near >> k) & 1 == 1:  # a jump on this surface has led across another one
        if run.own > 0.0:
            run.inward |= 1 << k
        elif run.own < 0.0:
            run.outward |= 1 << k
        height = 0.0
    if guard.turns == 1:
        if not height > 0.0:
            return _GRAZING  # one of the fields is tangent to the surface
    elif height < -noise:
        if run.jumped == 1 and guard.back != NO_MODE:
            return _BEYOND
        if run.past > 0 and not lead_alike(context.guards[run.row + run.past - 1], guard):
            run.corner = 1 << k | 1 << run.past - 1
            return _CORNER
        run.past = k + 1
    elif height <= noise:
        if (run.inward >> k) & 1 == 1:
            if guard.back != NO_MODE and run.other > 0.0:
                return _REPELLING
            set_guard(w, k, sign, 0.0, 0.0 if (run.folded >> k) & 1 == 1 else run.own, 1.0)
            return _RUNNING
        if (run.outward >> k) & 1 == 0:
            return _ASK
        run.past = k + 1
    set_guard(w, k, sign, height, run.own, 0.0)
    return _RUNNING


@inlined
def lead_alike(guard, other):
    """Whether it is no matter which of two guards, beyond both of which a mode is entered, ends it."""
    crossed = guard.back != NO_MODE and other.back != NO_MODE
    return guard.jump == NO_JUMP and other.jump == NO_JUMP and (crossed or guard.to == other.to)


@internal
def enter_first_mode(context):
    """Enter the mode of the initial value, given by the sign of g; on the surface, by the directions of the fields.

    run.row is that of a region whose guard `run.guard`, g, bounds it where the initial value is.
    """
    run, w, row = context.run, context.w, context.run.row
    guard = context.guards[row + run.guard]
    if run.first_mode != NO_MODE:  # `Runner` has found it by the second derivative of g, or at a corner
        return enter_mode(context, row, run.at, math.nan)
    for i in range(context.x.size):
        context.place[i] = context.x[i]
    into_minus, into_plus = evaluate_rates(context, row + run.guard, run.t)
    g = w[G]
    if not abs(g) < math.inf:
        return _NO_CONVERGENCE
    at_here, at_there, beyond = 1 << run.guard, 1 << max(guard.back, 0), guard.to
    into_here, into_there = (into_minus, into_plus) if guard.sign < 0 else (into_plus, into_minus)
    if guard.back == NO_MODE:
        status = enter_mode(context, row, 0, math.nan)
    elif abs(g) <= w[ROUNDING_OF_G]:  # on the surface to round-off
        if into_here > 0.0 and into_there > 0.0:
            return _REPELLING
        if into_here < 0.0 and into_there < 0.0:
            if run.slides == 0 or guard.slide == NO_MODE:
                return _SLIDING
            status = enter_mode(context, guard.slide, 0, math.nan)
        elif not (into_here * into_there < 0.0):
            return _GRAZING
        elif into_here > 0.0:
            status = enter_mode(context, row, at_here, into_here)
        else:
            status = enter_mode(context, beyond, at_there, into_there)
    else:
        status = enter_mode(context, row if guard.sign * g > 0.0 else beyond, 0, math.nan)
    run.first_mode = run.mode
    return status
