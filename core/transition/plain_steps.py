"""Accept steps that end no mode, by the heights of its guards at both ends. Jitted; inlined into `time_loop`.

Heights and rates are as in `event_location`. Of a mode with several guards the run's record holds the height and the
rate of one, the guard looked at, and the frame those of the others (`abi.GUARDS`).
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `time_loop`.

from __future__ import annotations

import math

from core.kernels.abi import ENTERED, G_END, GUARDS, HEIGHT, KEPT, LEAVING, RATE, RATE_END, SIGN
from core.kernels.jit import inlined, internal

__all__ = [
    "accept_plain_step", "end_of_guard", "look_at", "rates_change", "set_guard", "take_guard", "update_other_guards",
]  # fmt: skip

#: Ratio of rates of g at both ends of a slide's step from which on it is asked whether it ends on the surface.
_UNLIKE = 2.0


@inlined
def stays_above(low, rate_low, height, rate, third):
    """Whether a height stays positive in a step between these heights and rates; third is a third of its length.

    The height is taken to be a cubic, which is positive if its Bernstein coefficients are. A step in which the rates
    show a minimum of the height is left to `advance`.
    """
    above = low + rate_low * third > 0.0 and height - rate * third > 0.0
    return above and 0.0 < height < math.inf and not (rate_low < 0.0 <= rate)


@internal
def accept_plain_step(run, h, w):
    """Accept the step just tried, of length h, if it has no crossing; returns whether it does so."""
    along = math.copysign(1.0, run.tau)
    height, rate, third = run.sign * w[G_END], along * (run.sign * w[RATE_END]), abs(h) / 3.0
    if not stays_above(run.height, run.rate, height, rate, third):
        return False
    if run.guards > 1 and not accept_at_other_guards(run, third, w):
        return False
    run.height, run.rate, run.leaving = height, rate, 0
    return True


@internal
def accept_at_other_guards(run, third, w):
    """As `accept_plain_step`, for the guards of a mode after the first."""
    for k in range(1, run.guards):
        kept = GUARDS + KEPT * k
        height, rate = end_of_guard(run, w, k)
        if not stays_above(w[kept + HEIGHT], w[kept + RATE], height, rate, third):
            return False
    update_other_guards(run, w)
    return True


@inlined
def rates_change(run, w):
    """Whether the rates of g at the end of the last trial step of a slide are unlike those at its start.

    Their difference, by which the field of sliding is divided, is the sum of the first two heights. The guard looked at
    is the first.
    """
    start = run.height + w[GUARDS + KEPT + HEIGHT]
    end = run.sign * w[G_END] + w[GUARDS + KEPT + SIGN] * w[G_END + 2]
    return not (start <= _UNLIKE * end and end <= _UNLIKE * start)


@inlined
def end_of_guard(run, w, k):
    """Height and rate, at the end of the last trial step, of a guard that is not looked at."""
    sign = w[GUARDS + KEPT * k + SIGN]
    return sign * w[G_END + 2 * k], math.copysign(1.0, run.tau) * (sign * w[RATE_END + 2 * k])


@inlined
def update_other_guards(run, w):
    """Take the heights and rates at the end of the last trial step for all guards but the one looked at."""
    for k in range(run.guards):
        if k != run.guard:
            kept = GUARDS + KEPT * k
            w[kept + HEIGHT], w[kept + RATE] = end_of_guard(run, w, k)
            if w[kept + HEIGHT] > 0.0:
                w[kept + LEAVING] = 0.0


@inlined
def set_guard(w, k, sign, height, rate, leaving):
    """Set what the frame keeps of a guard, as the mode is entered."""
    kept = GUARDS + KEPT * k
    w[kept + SIGN], w[kept + HEIGHT], w[kept + RATE] = sign, height, rate
    w[kept + ENTERED], w[kept + LEAVING] = rate, leaving


@internal
def look_at(run, w, k):
    """Look at another guard of the mode."""
    if k == run.guard:
        return
    kept = GUARDS + KEPT * run.guard
    w[kept + SIGN], w[kept + HEIGHT], w[kept + RATE] = run.sign, run.height, run.rate
    w[kept + ENTERED], w[kept + LEAVING] = run.entered, run.leaving
    take_guard(run, w, k)


@inlined
def take_guard(run, w, k):
    """Take from the frame what it keeps of a guard."""
    kept = GUARDS + KEPT * k
    run.guard, run.sign = k, int(w[kept + SIGN])
    run.height, run.rate = w[kept + HEIGHT], w[kept + RATE]
    run.entered, run.leaving = w[kept + ENTERED], int(w[kept + LEAVING])
