"""Locate zeros of an event function in a step of a variable-step method, by its Taylor polynomial. Jitted.

The event function is expanded along the polynomial of the state that the step follows. Where it varies faster than
the state, so that the expansion does not reach to the end of the step, it is expanded anew from where it ends.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `time_loop`.

from __future__ import annotations

import math

from core.kernels.abi import ORDER, PER_UNIT, PREPARE, SERIES, TOLERANCE, UNIT, call
from core.kernels.doubledouble.arithmetic import fma
from core.kernels.jit import inlined, internal
from core.kernels.root_isolation import NONE as NO_ROOT
from core.kernels.root_isolation import ROOT, first_root
from core.kernels.taylor_coefficients import step_length_of_height
from core.transition.event_location import (
    FAILED,
    FOUND,
    NONE,
    g_rounding,
    newton,
    polynomial_root,
    rate_at_end,
    root,
    try_step,
)
from core.transition.surface import MARGIN

__all__ = ["locate_between", "locate_by_series", "make_ready"]

#: Expansions that reach less far than this part of the step approach a pole.
_SHORTEST = 2.0**-40
#: Most expansions on the way to a zero; a function that needs more varies too fast for the step.
_MOST = 4096


@inlined
def make_ready(context, t):
    """Prepare the step again, whose length the record holds, so that it can be tried."""
    run = context.run
    if run.adaptive == 1 and run.locating == 1:
        call(context.functions[run.row, PREPARE], t, run.rest, context.p, context.w, context.scratch)
        run.locating = 2


@internal
def expand(context, series, t, s, h):
    """Expand the event function from length s of a step of length h on.

    Returns how far that reaches, nan if a coefficient is not finite.
    """
    w, d, order = context.w, context.x.size, int(context.w[ORDER])
    for i in range(d):
        for k in range(order + 1):
            series[i, k] = context.scratch[i, k]
    reach = expand_here(context, series, t)
    if s != 0.0:
        moved = s * w[PER_UNIT]
        if reach >= abs(h):
            move_origin(series[d], order, moved)
            return reach - abs(s)
        for i in range(d):
            move_origin(series[i], order, moved)
        reach = expand_here(context, series, t + s)
    return reach


@inlined
def expand_here(context, series, t):
    """Expand the height along the polynomials of the state in `series`; returns how far that reaches."""
    w, d, order = context.w, context.x.size, int(context.w[ORDER])
    call(context.functions[context.run.row, SERIES], t, 0.0, context.p, w, series)
    for k in range(order + 1):
        series[d, k] *= context.run.sign
    return w[UNIT] * step_length_of_height(series, d, order, w[TOLERANCE])


@inlined
def move_origin(row, order, s):
    """Rewrite a polynomial in powers of its argument less s."""
    for j in range(order):
        for k in range(order - 1, j - 1, -1):
            row[k] = fma(row[k + 1], s, row[k])


@internal
def locate_between(context, t, low, high):
    """Locate a zero between two lengths at which the height has different signs; FAILED if it has not."""
    run = context.run
    f_high, r_high = try_step(context, t, high), rate_at_end(context)
    f_low, r_low = try_step(context, t, low), rate_at_end(context)
    if not f_low > 0.0 >= f_high:
        return FAILED
    run.hit = root(context, t, low, high, f_low, f_high, r_low, r_high)
    return FOUND if run.hit == run.hit else FAILED


@internal
def locate_in_bracket(context, series, t, begin, kind, low, high):
    """Locate the zero of a bracket of `first_root` on the scheme itself; NONE if it has none there."""
    run, unit = context.run, context.w[UNIT]
    make_ready(context, t)
    first, last = begin + unit * low, begin + unit * high
    if kind == ROOT:
        order = int(context.w[ORDER])
        run.hit = begin + unit * polynomial_root(series[context.x.size], order, low, high)
        # The start may itself be a zero, smaller in size than any height that rounding leaves at the one wanted.
        near = first if low != 0.0 else first + 0.5 * (run.hit - first)
        if newton(context, t, first, last) or locate_between(context, t, near, last) == FOUND:
            return FOUND
        return NONE
    middle = first + 0.5 * (last - first)  # two zeros, or a touch
    height = try_step(context, t, middle)
    if height < -MARGIN * g_rounding(context, t + middle) and locate_between(context, t, first, middle) == FOUND:
        return FOUND
    return NONE


@internal
def locate_by_series(context, series, t, begin, h):
    """Locate the first zero of the event function in a step between two lengths, begin and h; it goes to run.hit.

    FAILED: at run.hit it has a pole, or it varies too fast.
    """
    run, w, d, leaving = context.run, context.w, context.x.size, context.run.leaving
    order, along, skipped = int(w[ORDER]), math.copysign(1.0, h), _SHORTEST * abs(h)
    for _ in range(_MOST):
        if not along * begin < along * h:
            return NONE
        reach, rest = expand(context, series, t, begin, h), h - begin
        if reach < abs(rest):
            rest = math.copysign(reach, rest)
        if not reach > _SHORTEST * abs(h):
            run.hit = begin
            return FAILED
        end = h if rest == h - begin else begin + rest
        if leaving == 0 and series[d, 0] <= 0.0:
            make_ready(context, t)
            run.hit = begin
            return FOUND
        kind, low, high = first_root(series[d], order, rest * w[PER_UNIT], leaving, context.pieces)
        if kind != NO_ROOT:
            if locate_in_bracket(context, series, t, begin, kind, low, high) == FOUND:
                return FOUND
            if w[UNIT] * abs(high) > 0.0:  # go on behind what rounding hides, further each time
                further, skipped = max(w[UNIT] * abs(high), skipped), 2.0 * skipped
                end = begin + math.copysign(further, h) if further < abs(end - begin) else end
        begin, leaving = end, 0
    run.hit = begin
    return FAILED
