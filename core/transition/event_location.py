"""Find the first crossing in a step, on the scheme itself. Jitted; inlined into `time_loop`.

Throughout, σ = sign·g is the height of the guard of the mode occupied (positive inside), and a *rate* is dσ/dt counted
along the run: negative while it approaches the surface. Lengths s along a step have the sign of the step.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `time_loop`.

from __future__ import annotations

import math
from typing import Any, NamedTuple

from core.kernels.abi import DOUBT, EVALUATE, G_END, ORDER, PER_UNIT, RATE_END, SLACK, STEP, UNIT, call
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
    "isolate_root_of_series",
    "locate_beside_series",
    "locate_crossing",
    "locate_near_root",
    "rate_at_end",
    "try_step",
    "write_end",
]

NONE, FOUND, TOUCH, SHORT, FAILED = 0, 1, 2, 3, 4
_EPS = 2.0**-52
BOUND = 1e150  #: of a state: beyond it the square overflows
MAX_NODES = 64  #: of one step: lengths at which it has been tried
_MAX_TRIALS = 100  # for one root
_MAX_NEWTON = 6
_ROUGH = 1e-4  # relative accuracy of a polynomial's root that is only a first guess
_NARROW = 2.5 * NARROW  # of a bracket in the middle of which the root is known to be
_MARGIN = 16.0  # what g may be wrong by, in units of a first-order bound on its rounding


class StepContext(NamedTuple):
    """What a step is taken with: the compiled functions, the guards, the run's record and frame, and scratch."""

    functions: Any  # (modes, functions) addresses, in the order of `abi.FUNCTIONS`
    guards: Any  # (modes,) `records.GUARD`
    run: Any  # `records.RUN`
    p: Any
    w: Any  # frame; x, carry, increment, place are parts of it
    scratch: Any  # (rows, STRIDE) of a variable-step method
    x: Any
    carry: Any
    increment: Any
    place: Any
    nodes: Any  # (MAX_NODES, 3): lengths, heights and rates of the steps tried
    pieces: Any  # scratch of `first_root`


@inlined
def try_step(context, t, s):
    """Height after a step of length s, on the scheme itself; nan where there is none."""
    run = context.run
    count = call(context.functions[run.mode, STEP], t, s, context.p, context.w, context.scratch)
    if count < 0:
        return math.nan
    run.evaluations += count
    run.tried = s
    return run.sign * context.w[G_END]


@inlined
def write_end(context):
    """Write the end of the step tried last to `place`; returns the sum of its sizes, nan where one is no number."""
    x, place, size = context.x, context.place, 0.0
    for i in range(x.size):
        place[i] = x[i] + (context.carry[i] + context.increment[i])
        size += abs(place[i])
    return size


@inlined
def slack(context, t):
    """What rounding of the state alone can do to g at the end of the step tried last."""
    write_end(context)
    call(context.functions[context.run.mode, EVALUATE], t, 0.0, context.p, context.w, context.scratch)
    return context.w[SLACK]


@inlined
def doubt(context, t):
    """What rounding can do to g at most at the end of the step tried last."""
    slack(context, t)
    return context.w[DOUBT]


@inlined
def rate_at_end(context):
    """Rate at the end of the step tried last."""
    return math.copysign(1.0, context.run.tau) * context.run.sign * context.w[RATE_END]


@inlined
def _inverse_interpolant(low, high, f_low, f_high, r_low, r_high):
    """Where the cubic in σ that has the lengths and slopes ds/dσ of both ends is at σ = 0."""
    width, drop = abs(high - low), f_high - f_low
    z = -f_low / drop
    at_low, at_high = drop / (r_low * width), drop / (r_high * width)
    part = z * z * (3.0 - 2.0 * z) + z * (1.0 - z) * ((1.0 - z) * at_low - z * at_high)
    return low + part * (high - low)


@inlined
def root(context, t, low, high, f_low, f_high, r_low, r_high):
    """Step length between low and high, where the height changes sign, at which it vanishes: to the last digit.

    Inverse cubic interpolation of heights and rates, with a bisection every fourth trial; ends when no trial could be
    better. Returns the length at which the height is smallest in size, of either sign; nan if there is none.
    """
    # Where the height rises to zero at the far end, it has crossed it before.
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
        noise = slack(context, t + guess)
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
    """Look for a place between low and high, where the height falls and rises again, at which it is not positive.

    Returns (length, height, rate) there, or at the lowest place found. Looking ends once the tangents of both ends
    meet above the surface.
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
def peak(context, t, high, r_low, r_high):
    """Length in (0, high) at which the height stops rising: by regula falsi (Illinois) on the rate, and bisection."""
    low, s, f, r = 0.0, high, 0.0, r_high
    for k in range(_MAX_TRIALS):
        part = r_low / (r_low - r_high) if k % 3 < 2 else 0.5
        s = low + part * (high - low)
        f, r = try_step(context, t, s), rate_at_end(context)
        if not f <= 0.0 or s in (low, high):
            break  # well above the surface is all that is asked for
        if r > 0.0:
            low, r_low, r_high = s, r, 0.5 * r_high
        else:
            high, r_high, r_low = s, r, 0.5 * r_low
    return s, f, r


@inlined
def locate_crossing(context, t, h, f_end, r_end):
    """Look for the first crossing in a step of length h; its place goes to run.hit.

    Between two places that have been looked at, the height is taken for a cubic (Hermite): its Bernstein coefficients
    tell by their signs (Descartes) whether it has a root there, and whether just one. Where it may have more, or the
    rates show a minimum between, the scheme itself is looked at in between.
    """
    run, nodes = context.run, context.nodes
    s, f, r = 0.0, 0.0 if run.leaving == 1 else run.height, run.rate
    noise = _MARGIN * context.w[DOUBT]  # at the crossing before
    if run.leaving == 1 and -noise <= f_end <= 0.0 and 0.0 < r * abs(h) <= noise:
        return NONE  # too short a way to tell whether it has left
    if run.leaving == 1 and run.shift != 0.0 and (f_end > 0.0 or r_end >= 0.0 or r <= 0.0):
        return NONE  # it was moved off the surface, to either side, and is not back
    depth = 0
    nodes[0, 0], nodes[0, 1], nodes[0, 2] = h, f_end, r_end
    for _ in range(MAX_NODES):
        s1, f1, r1 = nodes[depth, 0], nodes[depth, 1], nodes[depth, 2]
        third = abs(s1 - s) / 3.0
        low, high = f + r * third, f1 - r1 * third  # with f and f1 the coefficients of the cubic
        if f1 <= 0.0 < f and not low < 0.0 < high:
            run.hit = root(context, t, s, s1, f, f1, r, r1)
            return FOUND if run.hit == run.hit else FAILED
        if f == 0.0 and f1 <= 0.0 and r1 <= 0.0:  # it has left the surface, and is back
            s, f, r = peak(context, t, s1, r, r1)
            if not f > 0.0:
                run.hit = s
                return TOUCH if -f <= _MARGIN * doubt(context, t + s) else FAILED
            continue
        above = f1 > 0.0 and high > 0.0 and (low > 0.0 or f == r == 0.0)  # a start at a fold rises like s²
        s2, f2, r2 = s1, f1, r1
        if f1 > 0.0 and r < 0.0 < r1 and f > 0.0:
            s2, f2, r2 = dip(context, t, s, s1, f, f1, r, r1)
            above = above or (f - 2.0 * low + high >= 0.0 and low - 2.0 * high + f1 >= 0.0)  # convex: tangents bound it
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


@inlined
def _polynomial_root(row, order, low, high):
    """Root of Σ row[k] sᵏ between low and high, where it falls from positive values: by Newton's method, bisecting."""
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


@inlined
def _newton(context, t, low, high):
    """Move run.hit to where the scheme itself meets the surface; returns whether it does so between low and high."""
    run = context.run
    best, f_best, s, noise = run.hit, math.inf, run.hit, 0.0
    for k in range(_MAX_NEWTON):
        f = try_step(context, t, s)
        if not abs(f) < abs(f_best):
            break
        best, f_best = s, f
        if k == 0:  # so near the surface the rounding of one state is that of another
            noise = slack(context, t + s)
        if abs(f) <= noise:
            break
        s -= math.copysign(1.0, s) * f / rate_at_end(context)
        if s == best or not min(low, high) <= s <= max(low, high):
            break
    run.hit = best
    return abs(f_best) < math.inf and (abs(f_best) <= _MARGIN * context.w[DOUBT] or s == best)


@inlined
def isolate_root_of_series(context, h):
    """What `first_root` says of the Taylor polynomial of the height, in its own unit of time."""
    run, order, w = context.run, int(context.w[ORDER]), context.w
    return first_root(context.scratch[context.x.size], order, h * w[PER_UNIT], run.leaving, context.pieces)


@inlined
def locate_near_root(context, t, low, high):
    """Locate a root of the Taylor polynomial on the scheme itself; returns whether that has one beside it."""
    unit, order = context.w[UNIT], int(context.w[ORDER])
    context.run.hit = unit * _polynomial_root(context.scratch[context.x.size], order, low, high)
    return _newton(context, t, unit * low, unit * high)


@inlined
def locate_beside_series(context, t, h, f_end, r_end, kind, low, high):
    """Look for the first crossing where the Taylor polynomial of the height leaves it open.

    SHORT: nothing up to run.hit, which is as far as can be said.
    """
    run, unit = context.run, context.w[UNIT]
    if kind == DOUBLE:  # two crossings or none, as round-off will have it
        run.hit = unit * (low + 0.5 * (high - low))
        height = try_step(context, t, run.hit)
        if height > 0.0:
            return SHORT
        return TOUCH if -height <= _MARGIN * doubt(context, t + run.hit) else FAILED
    if kind == ROOT:  # the scheme, whose polynomial is projected to ψ, meets the surface a little earlier or later
        h = unit * high
        f_end, r_end = try_step(context, t, h), rate_at_end(context)
        if f_end > 0.0:
            run.hit = h
            return SHORT
    elif f_end > 0.0:  # else round-off hides a root at the very end
        return NONE
    return locate_crossing(context, t, h, f_end, r_end)
