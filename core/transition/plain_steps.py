"""Accept steps that end no mode, by the heights of its guards at both ends. Jitted; inlined into `time_loop`.

Heights and rates are as in `event_location`. Most modes have one guard; sliding has two.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `time_loop`.

from __future__ import annotations

import math

from core.kernels.abi import BESIDE, G_END, RATE_END
from core.kernels.jit import inlined, internal
from core.transition.records import SLIDING_MODE

__all__ = ["accept_plain_step", "end_beside", "swap_guards"]


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
