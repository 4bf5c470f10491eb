"""Locate the first crossing, or event, in a step, on the scheme itself. Jitted; inlined into `time_loop`.

Throughout, the *height* is σ = sign·g, the guard height of the mode occupied (positive inside), and the *rate* is dσ/dt
in the direction of the run, negative while it approaches the surface. Of a mode with several guards, g stands for the
one that is looked at, `run.guard`. Lengths s along a step have the sign of the step. An event function takes the place
of the guard where `run.locating` is set.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `time_loop`.

from __future__ import annotations

import math
from typing import Any, NamedTuple

from core.kernels.abi import (
    EVALUATE,
    G_END,
    ORDER,
    PER_UNIT,
    RATE_END,
    RATES,
    ROUNDING_OF_G,
    ROUNDING_OF_STATE,
    STEP,
    UNIT,
    G,
    call,
)
from core.kernels.doubledouble.arithmetic import fma
from core.kernels.jit import inlined, internal
from core.kernels.root_isolation import DOUBLE, NARROW, ROOT, first_root

__all__ = [
    "BOUND",
    "FAILED",
    "FOUND",
    "MAX_NODES",
    "NONE",
    "SHORT",
    "TOUCH",
    "StepContext",
    "g_rounding",
    "height_at_end",
    "isolate_root_of_series",
    "locate_by_scheme",
    "locate_crossing",
    "locate_near_root",
    "newton",
    "polynomial_root",
    "rate_at_end",
    "root",
    "try_step",
    "write_end",
]

#: Results of a search: no crossing; a crossing; a touch; no crossing up to run.hit, unknown beyond; no decision.
NONE, FOUND, TOUCH, SHORT, FAILED = 0, 1, 2, 3, 4
_EPS = 2.0**-52
#: A state of this size has escaped: the square of a larger one may overflow.
BOUND = 1e150
#: Largest number of trial lengths kept at a time: halving down to rounding takes 53.
MAX_NODES = 64
#: Largest number of parts of a step that are looked at: several a halving where the height vanishes as a power of time.
_MAX_PARTS = 1024
#: Largest number of trial steps for one root.
_MAX_TRIALS = 100
#: Largest number of trial steps of Newton's method.
_MAX_NEWTON = 6
#: Relative accuracy of the root of a Taylor polynomial, which is only a first guess.
_ROUGH = 1e-4
#: Brackets up to this relative width are those that `first_root` sets around a root it has found, in their middle.
_NARROW = 2.5 * NARROW
#: Largest error of g, in units of the first-order bound on its rounding.
_MARGIN = 16.0


class StepContext(NamedTuple):
    """Everything a step needs: the compiled functions, the guards, the run's record and frame, and scratch."""

    functions: Any  # (rows, functions) addresses, in the order of `abi.FUNCTIONS`
    guards: Any  # (rows,) `records.GUARD`
    run: Any  # `records.RUN`
    p: Any
    w: Any  # frame; x, carry, increment, place are parts of it
    scratch: Any  # (rows, STRIDE) Taylor coefficients of a variable-step method
    x: Any
    carry: Any
    increment: Any
    place: Any
    nodes: Any  # (MAX_NODES, 3): lengths, heights and rates of trial steps
    pieces: Any  # scratch of `first_root`


@inlined
def try_step(context, t, s):
    """Try a step of length s; returns the height at its end, nan if the step fails."""
    run = context.run
    count = call(context.functions[run.row, STEP], t, s, context.p, context.w, context.scratch)
    if count < 0:
        return math.nan
    run.evaluations += count
    run.tried = s
    if run.locating > 0:
        evaluate_event_at_end(context, t + s)
    return height_at_end(context)


@inlined
def height_at_end(context):
    """Height at the end of the last trial step."""
    return context.run.sign * context.w[G_END + 2 * context.run.guard]


@inlined
def write_end(context):
    """Write the end of the last trial step to `place`; returns Σ|xᵢ| there, nan if a coordinate is nan."""
    x, place, size = context.x, context.place, 0.0
    for i in range(x.size):
        place[i] = x[i] + (context.carry[i] + context.increment[i])
        size += abs(place[i])
    return size


@internal
def evaluate_event_at_end(context, t):
    """Evaluate an event function and its rate at the end of the last trial step."""
    run, w = context.run, context.w
    write_end(context)
    call(context.functions[run.row, EVALUATE], t, 0.0, context.p, w, context.scratch)
    w[G_END], w[RATE_END] = w[G], w[RATES]


@inlined
def state_rounding(context, t):
    """Bound on the change of g by rounding the state alone, at the end of the last trial step."""
    write_end(context)
    run = context.run
    call(context.functions[run.row + run.guard, EVALUATE], t, 0.0, context.p, context.w, context.scratch)
    return context.w[ROUNDING_OF_STATE]


@inlined
def g_rounding(context, t):
    """Bound on the change of g by all rounding, at the end of the last trial step."""
    state_rounding(context, t)
    return context.w[ROUNDING_OF_G]


@inlined
def rate_at_end(context):
    """Rate at the end of the last trial step."""
    run = context.run
    return math.copysign(1.0, run.tau) * run.sign * context.w[RATE_END + 2 * run.guard]


@internal
def _inverse_interpolant(low, high, f_low, f_high, r_low, r_high):
    """Value at σ = 0 of the cubic s(σ) that has the lengths and slopes ds/dσ of both ends."""
    width, drop = abs(high - low), f_high - f_low
    z = -f_low / drop
    at_low, at_high = drop / (r_low * width), drop / (r_high * width)
    part = z * z * (3.0 - 2.0 * z) + z * (1.0 - z) * ((1.0 - z) * at_low - z * at_high)
    return low + part * (high - low)


@internal
def root(context, t, low, high, f_low, f_high, r_low, r_high):
    """Step length between low and high, where the height changes sign, at which it vanishes to round-off.

    Inverse cubic interpolation of heights and rates, with a bisection every fourth trial; ends when no other length can
    be better. Returns the length with the smallest height in size, of either sign; nan if a trial step fails.
    """
    # Where the height rises at the far end, it has crossed zero before: low is the first guess.
    best, f_best = (low, f_low) if abs(f_low) < abs(f_high) or r_high > 0.0 else (high, f_high)
    for k in range(_MAX_TRIALS):
        guess = _inverse_interpolant(low, high, f_low, f_high, r_low, r_high)
        if k % 4 == 3 or not min(low, high) < guess < max(low, high):
            guess = low + 0.5 * (high - low)
        if f_best == 0.0 or not abs(guess - best) > _EPS * abs(best) or guess in (low, high):
            break
        f = try_step(context, t, guess)
        if not abs(f) < math.inf:
            return math.nan
        noise = state_rounding(context, t + guess)
        stalled = abs(f_best) <= abs(f) <= _MARGIN * noise
        if abs(f) < abs(f_best):
            best, f_best = guess, f
        if stalled or abs(f) <= noise:
            break
        if f > 0.0:
            low, f_low, r_low = guess, f, rate_at_end(context)
        else:
            high, f_high, r_high = guess, f, rate_at_end(context)
    return best


@internal
def dip(context, t, low, high, f_low, f_high, r_low, r_high):
    """Search for a length between low and high, where the height falls and rises again, at which it is not positive.

    Returns (length, height, rate) there, or at the last trial. The search ends once the tangents of both ends meet
    above the surface.
    """
    s, f, r = high, f_high, r_high
    for k in range(_MAX_TRIALS):
        width = abs(high - low)
        meet = (f_high - f_low - r_high * width) / (r_low - r_high)  # where the two tangents do, from low
        if f_low + r_low * meet > 0.0 or width <= 4.0 * _EPS * max(abs(low), abs(high)):
            break
        part = r_low / (r_low - r_high) if k % 3 < 2 else 0.5
        s = low + part * (high - low)
        f, r = try_step(context, t, s), rate_at_end(context)
        if not f > 0.0:
            break
        if r < 0.0:
            low, f_low, r_low = s, f, r
        else:
            high, f_high, r_high = s, f, r
    return s, f, r


@internal
def peak(context, t, low, high, r_low, r_high):
    """Length in (low, high) with positive height or zero rate, by regula falsi (Illinois) and bisection on the rate."""
    s, f, r = high, 0.0, r_high
    for k in range(_MAX_TRIALS):
        part = r_low / (r_low - r_high) if k % 3 < 2 and r_low > 0.0 else 0.5  # at a fold r_low is 0
        s = low + part * (high - low)
        f, r = try_step(context, t, s), rate_at_end(context)
        if not f <= 0.0 or s in (low, high):
            break  # a positive height is all that is needed
        if r > 0.0:
            low, r_low, r_high = s, r, 0.5 * r_high
        else:
            high, r_high, r_low = s, r, 0.5 * r_low
    return s, f, r


@internal
def locate_crossing(context, t, begin, h, f_end, r_end):
    """Locate the first crossing in a step between two lengths, begin and h; the length up to it goes to run.hit.

    Between two trial lengths the height is taken to be a cubic (Hermite). The signs of its Bernstein coefficients tell
    whether it has no root or one root there (Descartes). Where it may have more, or the rates show a minimum between,
    trial steps are taken in between.
    """
    run, nodes = context.run, context.nodes
    s, f, r = begin, 0.0 if run.leaving == 1 else run.height, run.rate
    if run.leaving == 1 and run.guards > 1:  # another guard may have been evaluated last
        for i in range(context.x.size):
            context.place[i] = context.x[i]
        call(context.functions[run.row + run.guard, EVALUATE], t, 0.0, context.p, context.w, context.scratch)
    # Rounding of g, and of rates over the step, as evaluated at the last crossing.
    rates = max(abs(context.w[RATES]), abs(context.w[RATES + 1]))
    noise = _MARGIN * (context.w[ROUNDING_OF_G] + _EPS * abs(h) * rates)
    if run.leaving == 1 and abs(f_end) <= noise and 0.0 <= r * abs(h) <= noise:
        return NONE  # the step is too short to tell whether the state has left the surface
    if run.leaving == 1 and run.shift != 0.0 and (f_end > 0.0 or r_end >= 0.0 or r <= 0.0):
        return NONE  # the perturbation has moved it off the surface, to either side, and it is not back
    depth = 0
    nodes[0, 0], nodes[0, 1], nodes[0, 2] = h, f_end, r_end
    for _ in range(_MAX_PARTS):
        s1, f1, r1 = nodes[depth, 0], nodes[depth, 1], nodes[depth, 2]
        third = abs(s1 - s) / 3.0
        low, high = f + r * third, f1 - r1 * third  # with f and f1 the coefficients of the cubic
        if f1 <= 0.0 < f and not low < 0.0 < high:
            run.hit = root(context, t, s, s1, f, f1, r, r1)
            return FOUND if run.hit == run.hit else FAILED
        if f == 0.0 and abs(f1) <= noise and 0.0 <= r * abs(s1 - s) <= noise and depth > 0:
            s, r = s1, max(r1, 0.0)  # the part is too short to tell whether the state has left the surface
            depth -= 1
            continue
        if f == 0.0 and f1 <= 0.0 and r1 <= 0.0:  # the state has left the surface and returned
            s, f, r = peak(context, t, s, s1, r, r1)
            if not f > 0.0:
                run.hit = s
                return TOUCH if -f <= _MARGIN * g_rounding(context, t + s) else FAILED
            continue
        above = f1 > 0.0 and high > 0.0 and (low > 0.0 or f == r == 0.0)  # at a fold the height rises like s²
        s2, f2, r2 = s1, f1, r1
        if f1 > 0.0 and r < 0.0 < r1 and f > 0.0:
            s2, f2, r2 = dip(context, t, s, s1, f, f1, r, r1)
            above = above or (f - 2.0 * low + high >= 0.0 and low - 2.0 * high + f1 >= 0.0)  # convex: tangents bound it
        if third <= _EPS * abs(h) and f1 <= 0.0 < f:  # the height vanishes as a power of time: its rate does, too
            run.hit = s1
            return TOUCH
        if (f2 > 0.0 and above) or third <= _EPS * abs(h):
            if depth == 0:
                return NONE
            s, f, r = s1, f1, r1
            depth -= 1
            continue
        if f2 > 0.0 or f1 <= 0.0:
            s2 = s + 0.5 * (s1 - s)
            f2, r2 = try_step(context, t, s2), rate_at_end(context)
        if not abs(f2) < math.inf:
            return FAILED
        depth += 1
        nodes[depth, 0], nodes[depth, 1], nodes[depth, 2] = s2, f2, r2
    return FAILED


@internal
def polynomial_root(row, order, low, high):
    """Root of Σ row[k] sᵏ between low, where it is positive, and high: by Newton's method, safeguarded by bisection."""
    s = low + 0.5 * (high - low)
    if abs(high - low) <= _NARROW * abs(high):
        return s
    for _ in range(_MAX_TRIALS):
        f, r = row[order], 0.0
        for k in range(order - 1, -1, -1):
            r = fma(r, s, f)
            f = fma(f, s, row[k])
        low, high = (s, high) if f > 0.0 else (low, s)
        near = s - f / r
        if not min(low, high) < near < max(low, high):
            near = low + 0.5 * (high - low)
        if abs(near - s) <= _ROUGH * abs(s):
            return near
        s = near
    return s


@internal
def newton(context, t, low, high):
    """Correct run.hit by Newton's method on the scheme itself; returns whether a root between low and high is found."""
    run = context.run
    best, f_best, s, noise = run.hit, math.inf, run.hit, 0.0
    for k in range(_MAX_NEWTON):
        f = try_step(context, t, s)
        if not abs(f) < abs(f_best):
            break
        best, f_best = s, f
        if k == 0:  # near the surface it is the same for all trials
            noise = state_rounding(context, t + s)
        if abs(f) <= noise:
            break
        s -= math.copysign(1.0, s) * f / rate_at_end(context)
        if s == best or not min(low, high) <= s <= max(low, high):
            break
    run.hit = best
    return abs(f_best) < math.inf and (abs(f_best) <= _MARGIN * context.w[ROUNDING_OF_G] or s == best)


@inlined
def isolate_root_of_series(context, h):
    """Isolate the first root of the Taylor polynomial of the height by `first_root`, in its own unit of time."""
    run, order, w = context.run, int(context.w[ORDER]), context.w
    if run.leaving == 1 and run.rate == 0.0:
        context.scratch[context.x.size + run.guard, 1] = 0.0  # at a fold the rate is zero, and not its rounding
    return first_root(context.scratch[context.x.size + run.guard], order, h * w[PER_UNIT], run.leaving, context.pieces)


@internal
def locate_near_root(context, t, low, high):
    """Locate a root of the Taylor polynomial on the scheme itself; returns whether the scheme has one nearby."""
    unit, order = context.w[UNIT], int(context.w[ORDER])
    row = context.scratch[context.x.size + context.run.guard]
    context.run.hit = unit * polynomial_root(row, order, low, high)
    return newton(context, t, unit * low, unit * high)


@internal
def locate_by_scheme(context, t, h, f_end, r_end, kind, low, high):
    """Locate the first crossing where the Taylor polynomial of the height does not decide.

    Returns SHORT if there is none up to run.hit and nothing is known beyond.
    """
    run, unit = context.run, context.w[UNIT]
    if kind == DOUBLE:  # two crossings or none: round-off hides which
        run.hit = unit * (low + 0.5 * (high - low))
        height = try_step(context, t, run.hit)
        if height > 0.0:
            return SHORT
        if -height <= _MARGIN * g_rounding(context, t + run.hit):
            return TOUCH
        h, f_end, r_end = run.hit, height, rate_at_end(context)
    elif kind == ROOT:  # the scheme, projected to the levels of ψ, meets the surface a little earlier or later
        h = unit * high
        f_end, r_end = try_step(context, t, h), rate_at_end(context)
        if f_end > 0.0:
            run.hit = h
            return SHORT
    elif f_end > 0.0:  # else round-off hides a root at the end of the step
        return NONE
    return locate_crossing(context, t, 0.0, h, f_end, r_end)
