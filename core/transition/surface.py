"""Evaluations and records at the surface: g, its rates, its rounding. Jitted; inlined into `time_loop`.

Heights and rates are as in `event_location`.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `time_loop`.

from __future__ import annotations

import math
from typing import Any, NamedTuple

from core.kernels.abi import EVALUATE, LEVEL_RESIDUAL, RATES, ROUNDING_OF_G, G, call
from core.kernels.doubledouble.error_free import two_sum
from core.kernels.jit import inlined, internal
from core.transition.plain_steps import look_at
from core.transition.records import ANY_SURFACE

__all__ = [
    "MARGIN", "Log", "accept_step", "advance_time", "contradicts", "evaluate_g", "evaluate_rates", "evaluate_switching",
    "guards_contradict", "is_contradicted", "is_on_surface", "is_wanted", "record_place", "widen_envelope",
]  # fmt: skip

_EPS = 2.0**-52
MARGIN = 16.0  #: error of g that counts as round-off, in units of the first-order bound on its rounding


class Log(NamedTuple):
    """Arrays to which crossings and errors of ψ are written."""

    hits: Any
    places: Any  # (…, 3, d): states on the surface, where the run landed, from which it continued
    residual: Any  # (m,) level residual, a part of the frame
    envelope: Any  # (columns, m, 2) least and greatest level residual in equal parts of the time
    passes: Any  # (PASSES, 4 + d): see `passes`


@inlined
def accept_step(context):
    """Add the increment to the state by compensated summation."""
    x, carry, increment = context.x, context.carry, context.increment
    for i in range(x.size):
        x[i], carry[i] = two_sum(x[i], carry[i] + increment[i])


@inlined
def advance_time(run, h):
    """Add a step length to the time by compensated summation."""
    run.t, run.t_carry = two_sum(run.t, h + run.t_carry)


@inlined
def evaluate_g(context, t):
    """Evaluate g at `place`."""
    run = context.run
    call(context.functions[run.row + run.guard, EVALUATE], t, 0.0, context.p, context.w, context.scratch)
    return context.w[G]


@inlined
def evaluate_rates(context, row, t):
    """Rates at `place` with which the fields lead into g < 0 and into g > 0; writes g to w[G].

    `row` is that of the guard, which takes the place of g.
    """
    w, along = context.w, math.copysign(1.0, context.run.tau)
    call(context.functions[row, EVALUATE], t, 0.0, context.p, w, context.scratch)
    return -along * w[RATES], along * w[RATES + 1]


@inlined
def evaluate_switching(context, t):
    """Write the rates at `place` into the mode occupied and the other one to run.own and run.other, and g to w[G]."""
    run = context.run
    into_minus, into_plus = evaluate_rates(context, run.row + run.guard, t)
    run.own, run.other = (into_plus, into_minus) if run.sign > 0 else (into_minus, into_plus)


@inlined
def record_place(context, log, which):
    """Record `place` as the state on the surface (0), where the run landed (1), or from which it continued (2)."""
    for i in range(context.place.size):
        log.places[context.run.hits, which, i] = context.place[i]


@internal
def widen_envelope(context, log):
    """Widen the envelope at this time by the level residual."""
    run, residual, envelope = context.run, log.residual, log.envelope
    call(context.functions[run.row, LEVEL_RESIDUAL], run.t, 0.0, context.p, context.w, context.scratch)
    columns = envelope.shape[0]
    column = min(int(columns * ((run.t - run.t_start) / (run.t_end - run.t_start))), columns - 1)
    for j in range(residual.size):
        if residual[j] < envelope[column, j, 0]:  # false for nan, where the mode has fewer ψ
            envelope[column, j, 0] = residual[j]
        if residual[j] > envelope[column, j, 1]:
            envelope[column, j, 1] = residual[j]


@inlined
def is_on_surface(context):
    """Whether g, as evaluated last, is zero within rounding."""
    return abs(context.w[G]) <= MARGIN * context.w[ROUNDING_OF_G]


@internal
def guards_contradict(context, h):
    """Whether the state contradicts any guard of the mode: see `contradicts`."""
    run = context.run
    found = contradicts(context, h)
    for k in range(1, run.guards):
        look_at(run, context.w, k)
        found = found or contradicts(context, h)
    look_at(run, context.w, 0)
    return found


@internal
def contradicts(context, h):
    """Evaluate g at the state; returns whether it has the sign of the other mode by more than rounding can explain.

    Rounding of the increment of a step of length h and of the time change g by eps times h and t times its rate. A
    state left on the other side on purpose, by a perturbation or a step over the surface, contradicts nothing.
    """
    for i in range(context.x.size):
        context.place[i] = context.x[i]
    evaluate_g(context, context.run.t)
    return is_contradicted(context, h)


@inlined
def is_contradicted(context, h):
    """As `contradicts`, where switching has been evaluated at the state already."""
    run, w = context.run, context.w
    if run.leaving == 1 and (run.shift != 0.0 or run.follow == 0):
        return False
    moved = _EPS * (abs(run.t) + abs(h)) * max(abs(w[RATES]), abs(w[RATES + 1]))
    return -run.sign * w[G] > MARGIN * (w[ROUNDING_OF_G] + moved)


@internal
def is_wanted(hit, surface, way):
    """Whether a crossing is of a surface, and its switching function has the sign `way` then (any: 0).

    For `ANY_SURFACE`, one of any surface; for −1 all crossings, also where sliding ends by itself.
    """
    of_it = surface == -1 or hit.surface == surface or (surface == ANY_SURFACE and hit.surface >= 0)
    return of_it and hit.rate_before * way >= 0.0
