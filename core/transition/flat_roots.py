"""Roots of a height beside which its series may hide others: several sheets of one surface, close together. Jitted.

Heights and rates are as in `event_location`. Between an odd number of roots that are close together the height is far
below its size in the rest of the step, and so is its rate at each of them. A step ends before the first such root, and
one that begins there is shortened, until the height expanded in it tells the roots apart.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `time_loop`.

from __future__ import annotations

from core.kernels.abi import GUARDS, KEPT, LEAVING, ORDER, PER_UNIT, RATE
from core.kernels.jit import inlined, internal
from core.transition.event_location import NONE, rate_at_end, try_step

__all__ = ["cut_where_flat", "go_nearer", "is_flat"]

#: A height is flat at a root if at its rate there it would change in the whole step by less than this part of its size.
_FLAT = 2.0**-10
#: The same at the root where a step begins: near it the series is exact, but for rounding of the whole step.
_HIDDEN = 2.0**-36
#: Part of the way to a flat root that is taken as a step, from whose end the height is expanded anew …
_NEARER = 0.875
#: … unless that way is this part of the longest step: rounding then hides whether there are several roots.
_NEAREST = 2.0**-30


@internal
def is_flat(context):
    """Whether the height is flat at the root found, before which the error of its series may hide others."""
    run = context.run
    if run.tried != run.hit:
        try_step(context, run.t + run.t_carry, run.hit)
    flat = abs(rate_at_end(context) * run.hit) < _FLAT * size_of_height(context, run.guard, run.hit)
    return flat and abs(run.hit) > _NEAREST * run.longest


@inlined
def size_of_height(context, guard, h):
    """Bound on how much the height of a guard changes in a step of length h, by its series."""
    row, part, size = context.scratch[context.x.size + guard], abs(h) * context.w[PER_UNIT], 0.0
    for k in range(int(context.w[ORDER]), 0, -1):
        size = (size + abs(row[k])) * part
    return size


@inlined
def cut_where_flat(context, h):
    """Shorten a step that begins at a flat root of a height, soon after which rounding may hide others.

    A rate so small that it may be rounding tells of no other root, but of a fold, as where sliding ends.
    """
    run, w = context.run, context.w
    for k in range(run.guards):
        kept = GUARDS + KEPT * k
        leaving, rate = (run.leaving, run.rate) if k == run.guard else (w[kept + LEAVING], w[kept + RATE])
        shorter = h
        while leaving == 1 and abs(rate * shorter) < _HIDDEN * size_of_height(context, k, shorter):
            shorter *= 0.5
            if not abs(shorter) > _NEAREST * max(run.longest, abs(h)):
                shorter = h
                break
        if shorter != h:
            h, run.final = shorter, 0
    return h


@inlined
def go_nearer(context):
    """End the step before the root found, from where the height is expanded anew."""
    context.run.final = 0
    return NONE, _NEARER * context.run.hit
