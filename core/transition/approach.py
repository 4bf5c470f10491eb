"""Approach a surface beyond which the field is not defined, so that a full step fails. Inlined into `time_loop`.

Heights and rates are as in `event_location`.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `time_loop`.

from __future__ import annotations

import math

from core.kernels.abi import LENGTH, PREPARE, RATES, ROUNDING_OF_G, G, call
from core.kernels.jit import inlined, internal
from core.transition.event_location import BOUND, FAILED, NONE, rate_at_end, try_step, write_end
from core.transition.plain_steps import look_at, rates_change
from core.transition.surface import MARGIN, evaluate_g, evaluate_rates, evaluate_switching

__all__ = [
    "check_at_surface", "cut_to_domain", "cut_to_prepared", "cut_to_surface", "lands_off_surface",
    "look_from_both_sides", "try_finite_step",
]  # fmt: skip

_EPS = 2.0**-52
#: Largest number of halvings of a step towards a surface beyond which the field is not defined.
_HALVINGS = 60
#: Change of g in such a step, as part of what the field of a side alone would make, that is off the surface.
_OFF = 0.25
#: Shortest step to where both rates vanish, as part of the one asked for.
_SHORTEST = 2.0**-20
#: Increment of a coordinate for the difference quotients of g, relative to the state.
_BESIDE = 2.0**-26
#: Largest displacement of a landing by the reflection at the surface, relative to the state: 16 eps.
_NOTHING = 2.0**-48


@inlined
def cut_to_prepared(context, t, h):
    """Prepare a step; returns the length that a variable-step method takes, at most h in size; nan if it finds none."""
    run = context.run
    run.evaluations += call(context.functions[run.row, PREPARE], t, h, context.p, context.w, context.scratch)
    length = context.w[LENGTH]
    if length >= abs(h):
        return h
    run.final = 0
    return math.copysign(length, h) if length > _EPS * _EPS * abs(t) else math.nan


@inlined
def try_finite_step(context, t, h):
    """Try a step of length h; returns whether state, height and rate at its end are finite."""
    height = try_step(context, t, h)
    return abs(height) < math.inf and abs(rate_at_end(context)) < math.inf and write_end(context) < BOUND


@inlined
def is_ahead(run, h):
    """Whether the surface looked at lies within two steps of length h, at the present rate."""
    return run.rate < 0.0 and run.height + 2.0 * run.rate * abs(h) <= 0.0


@internal
def cut_to_domain(context, t, h):
    """The longest of h/2, h/4 … for which the step succeeds; 0 if none does, or if a shorter step would not help.

    The field may not be defined beyond the surface, as of a spring that only pushes: the surface is then approached in
    ever shorter steps, until round-off hides the distance. And a variable-step method may have taken a step too long
    to be projected to the levels of ψ.
    """
    run = context.run
    ahead = is_ahead(run, h)
    for k in range(run.guards):
        if not ahead:
            look_at(run, context.w, k)
            ahead = is_ahead(run, h)
    if not ahead and run.adaptive == 0:
        return 0.0
    for _ in range(_HALVINGS):
        h *= 0.5
        if not ahead and abs(h) <= 4.0 * _EPS * abs(t):
            return 0.0
        if try_finite_step(context, t, h):
            run.final = run.final if run.adaptive == 0 else 0
            return h
    return 0.0


@internal
def cut_to_surface(context, t, h, asked):
    """The longest of h, h/2, h/4 … for which a step of a slide ends on the surface; in other modes, h.

    Where both rates of g vanish at once the field of sliding is 0/0: a step beyond leads anywhere. 0 if none does that
    is longer than a small part of the one asked for.
    """
    run, shortest = context.run, _SHORTEST * abs(asked)
    if not slides_in_steps(context):
        return h
    while abs(h) >= shortest and (run.tried == h or try_finite_step(context, t, h)):
        if not (rates_change(run, context.w) and leaves_surface(context, t, h)):
            return h
        h *= 0.5
    return 0.0


@internal
def lands_off_surface(context, t, on, found, length):
    """Whether a step of a slide leads off the surface: to where the slide ends, or shorter than one that does not."""
    run = context.run
    h = length if found == NONE else run.hit
    if found == FAILED or h == 0.0 or (found == NONE and h == on) or not slides_in_steps(context):
        return False
    return not (run.tried == h or try_finite_step(context, t, h)) or leaves_surface(context, t, h)


@inlined
def slides_in_steps(context):
    """Whether the run slides by a method whose steps are of one size."""
    return context.run.adaptive == 0 and context.guards[context.run.row].turns == 1


@internal
def leaves_surface(context, t, h):
    """Whether the last trial step of a slide, of length h, changes g as the field of a side would."""
    run, w, place = context.run, context.w, context.place
    rate, kept = context.guards[run.row], (w[G], w[RATES], w[RATES + 1], w[ROUNDING_OF_G])
    row = rate.to + rate.back  # of g, the guard of the region to which the slide leads if this rate of g vanishes
    for i in range(place.size):
        place[i] = context.x[i]
    into_minus, into_plus = evaluate_rates(context, row, t)
    start, most = w[G], max(abs(into_minus), abs(into_plus))
    write_end(context)
    evaluate_rates(context, row, t + h)
    off = not abs(w[G] - start) <= _OFF * most * abs(h) + MARGIN * w[ROUNDING_OF_G]
    w[G], w[RATES], w[RATES + 1], w[ROUNDING_OF_G] = kept
    return off


@internal
def look_from_both_sides(context, t, moves):
    """Evaluate each field on its own side of a surface within rounding of which the state is, as it may end there.

    The other side is that of the reflection at the surface. If the state may move and is not beyond the surface yet, it
    is put there, where the mode to be entered has a field.
    """
    run, x, place, g = context.run, context.x, context.place, context.w[G]
    own, other, beyond = run.own, run.other, run.sign * g < 0.0
    along, by = reflection(context, t)
    place[along] = x[along] - by
    evaluate_switching(context, t)
    if beyond:
        own = run.own
    else:
        other = run.other
        if moves:
            x[along] = place[along]
    place[along] = x[along]
    evaluate_switching(context, t)
    run.own, run.other = own, other


@internal
def reflection(context, t):
    """Number of a coordinate, and by how much less of it g changes its sign; 0.0 if g is not within rounding of zero.

    Rounding is that of the state, of the increment that led here, and of the time.
    """
    run, x, place, g = context.run, context.x, context.place, context.w[G]
    size, steepest, along = 0.0, 0.0, 0
    for i in range(x.size):
        size = max(size, abs(x[i]), abs(context.increment[i]))
    for i in range(x.size):
        place[i] = x[i] + _BESIDE * size
        slope = (evaluate_g(context, t) - g) / (place[i] - x[i])
        place[i] = x[i]
        if abs(slope) > abs(steepest):
            steepest, along = slope, i
    near = abs(2.0 * g) <= _NOTHING * (size * abs(steepest) + abs(run.rate * t))
    return along, 2.0 * g / steepest if near and steepest != 0.0 else 0.0


@internal
def check_at_surface(context, t):
    """Evaluate switching at the state; returns whether rounding of g and of time can explain its distance."""
    run, x = context.run, context.x
    for i in range(x.size):
        context.place[i] = x[i]
    evaluate_switching(context, t)
    return run.height <= MARGIN * (context.w[ROUNDING_OF_G] + _EPS * abs(run.own) * abs(t))
