"""Come to the surface where a step does not: a field may have no value beyond it. Jitted; inlined into `time_loop`.

Heights and rates are as in `event_location`.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `time_loop`.

from __future__ import annotations

import math

from core.kernels.abi import DOUBT, LENGTH, PREPARE, RATE_END, G, call
from core.kernels.jit import inlined, internal
from core.transition.event_location import BOUND, try_step, write_end
from core.transition.surface import MARGIN, evaluate_g, evaluate_switching

__all__ = ["cut_to_domain", "cut_to_prepared", "has_end", "is_at_surface", "move_across"]

_EPS = 2.0**-52
#: Of a step to the surface beyond which the field has no value.
_HALVINGS = 60
#: How far beside a state, in parts of its size, the slopes of g are taken.
_BESIDE = 2.0**-26
#: Of the size of a state: what a landing may be moved by, and be the same landing.
_NOTHING = 2.0**-48


@inlined
def cut_to_prepared(context, t, h):
    """The length that a variable-step method takes, at most h; nan where there is none."""
    run = context.run
    run.evaluations += call(context.functions[run.mode, PREPARE], t, h, context.p, context.w, context.scratch)
    length = context.w[LENGTH]
    if length >= abs(h):
        return h
    run.final = 0
    return math.copysign(length, h) if length > _EPS * _EPS * abs(t) else math.nan


@inlined
def has_end(context, t, h):
    """Whether a step of length h has an end that is a state, with a height and a rate."""
    height = try_step(context, t, h)
    return abs(height) < math.inf and abs(context.w[RATE_END]) < math.inf and write_end(context) < BOUND


@internal
def cut_to_domain(context, t, h):
    """The longest of h/2, h/4 … that is a step, where a shorter one may help; 0 where there is none.

    A field may have no value beyond the surface, as a spring that only pushes: the surface is then approached in ever
    shorter steps, the last of which cannot be told from it. And a variable-step method may have taken too long a step,
    that does not lead back to the levels of ψ.
    """
    run = context.run
    ahead = run.rate < 0.0 and run.height + 2.0 * run.rate * abs(h) <= 0.0
    if not ahead and run.adaptive == 0:
        return 0.0
    for _ in range(_HALVINGS):
        h *= 0.5
        if not ahead and abs(h) <= 4.0 * _EPS * abs(t):
            return 0.0
        if has_end(context, t, h):
            run.final = run.final if run.adaptive == 0 else 0
            return h
    return 0.0


@internal
def move_across(context, t):
    """Move a state that is on the surface but for rounding, by less than that, to where g has the sign to come.

    A field that has a value on its own side alone has none at a state whose g is wrong by the last digit.
    """
    x, place, g = context.x, context.place, context.w[G]
    size, steepest, along = 0.0, 0.0, 0
    for i in range(x.size):
        size = max(size, abs(x[i]))
    for i in range(x.size):
        place[i] = x[i] + _BESIDE * size
        slope = (evaluate_g(context, t) - g) / (place[i] - x[i])
        place[i] = x[i]
        if abs(slope) > abs(steepest):
            steepest, along = slope, i
    if abs(2.0 * g) <= _NOTHING * size * abs(steepest):
        x[along] -= 2.0 * g / steepest
    place[along] = x[along]
    evaluate_switching(context, t)


@internal
def is_at_surface(context, t):
    """Whether the state is as near to the surface as the rounding of time lets it come."""
    run, x = context.run, context.x
    for i in range(x.size):
        context.place[i] = x[i]
    evaluate_switching(context, t)
    return run.height <= MARGIN * (context.w[DOUBT] + _EPS * abs(run.own) * abs(t))
