"""Keep the slightest passes of a surface, for `diagnostics.near_touches`: whether they cross it is decided by little.

A height that falls ever more slowly comes to its least near the surface: just beyond it, so that it crosses, or just
before it. Jitted; inlined into `time_loop`. Heights and rates are as in `event_location`.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `time_loop`.

from __future__ import annotations

import math

from core.kernels.abi import GUARDS, HEIGHT, KEPT, RATE
from core.kernels.jit import internal
from core.transition.plain_steps import end_of_guard

__all__ = ["PASSES", "keep_crossing", "keep_turns"]

#: Rows of the table of passes: one for each doubling of the number of steps. Its 4 + d columns: t, how slight the pass
#: is, row of the guard, time since the last crossing, x.
PASSES = 48


@internal
def keep_crossing(context, log):
    """Keep a crossing just made as a pass if its rate is slight, and the height would turn.

    How slight a pass is, in time squared: the least height, below the surface or above, by the rate of its rate.
    """
    run = context.run
    if run.shift == 0.0 and run.follow == 1 and run.own < 0.0:
        bend = (run.own - run.rate) / abs(run.hit) if run.hit != 0.0 else 0.0
        if bend > 0.0:
            keep_pass(context, log, 0.5 * (run.own / bend) ** 2)


@internal
def keep_turns(context, log, h, height, rate):
    """Keep where heights have turned within a step of length h, at whose end the guard looked at has these values."""
    run, w, looked_at = context.run, context.w, context.run.guard
    if run.shift != 0.0 or run.follow == 0:
        return
    for k in range(run.guards):
        low, rate_low, high, rate_high = run.height, run.rate, height, rate
        if k != looked_at:
            kept = GUARDS + KEPT * k
            low, rate_low = w[kept + HEIGHT], w[kept + RATE]
            high, rate_high = end_of_guard(run, w, k)
        if rate_low < 0.0 <= rate_high:
            bend = (rate_high - rate_low) / abs(h)
            least = min(low / bend - 0.5 * (rate_low / bend) ** 2, high / bend - 0.5 * (rate_high / bend) ** 2)
            run.guard = k
            keep_pass(context, log, abs(least))
            run.guard = looked_at


@internal
def keep_pass(context, log, slight):
    """Keep the state as that of a pass, if none as slight has been kept since the number of steps has last doubled."""
    run, passes = context.run, log.passes
    row = min(int(math.log2(run.steps + 1.0)), passes.shape[0] - 1)
    if (run.passes >> row) & 1 == 1 and passes[row, 1] <= slight:
        return
    run.passes |= 1 << row
    passes[row, 0], passes[row, 1], passes[row, 2] = run.t, slight, run.row + run.guard
    passes[row, 3] = abs((run.t - run.last_hit) + (run.t_carry - run.last_hit_carry))
    for i in range(context.x.size):
        passes[row, 4 + i] = context.x[i]
