"""Enter a mode: the first one, the other side of the surface, or sliding. Jitted; inlined into `time_loop`.

Heights and rates are as in `event_location`.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `time_loop`.

from __future__ import annotations

import math

from core.kernels.abi import ROUNDING_OF_STATE, SET_LEVELS, STEP, G, call
from core.kernels.jit import inlined, internal
from core.transition.plain_steps import swap_guards
from core.transition.records import NO_MODE, SLIDING_MODE, mode_of
from core.transition.status import Status
from core.transition.surface import evaluate_rates, evaluate_switching

__all__ = ["enter_first_mode", "enter_mode", "enter_sliding"]

_RUNNING, _SLIDING, _REPELLING = int(Status.RUNNING), int(Status.SLIDING), int(Status.REPELLING)
_GRAZING, _NO_CONVERGENCE = int(Status.GRAZING), int(Status.NO_CONVERGENCE)


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
        return _RUNNING
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
    return _RUNNING


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
            return _RUNNING
        if not (into_plus * into_minus < 0.0):
            return _GRAZING
        mode = mode_of(into_plus)
        enter_mode(context, mode, into_plus if mode == 1 else into_minus)
    else:
        enter_mode(context, mode, into_plus if mode == 1 else into_minus)
        run.height, run.leaving = run.sign * g, 0
    run.first_mode = mode
    return _RUNNING
