"""Watch g, locate the crossing, land on the surface, perturb, switch, classify: the paper's Algorithm 1.

Jitted; inlined into `march`. Throughout, σ = side·g is the height over the surface on the side occupied (positive
there), and a *rate* is dσ/dt counted along the run: negative while it approaches the surface.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `march`.

from __future__ import annotations

import math

from numba import njit

from core.trajectory import CROSSING_KINDS, Status

__all__ = ["BOUND", "RUNNING", "is_plain", "take_step", "two_sum"]

_inline = njit(error_model="numpy")

RUNNING = int(Status.RUNNING)
_SLIDING, _REPELLING, _GRAZING = int(Status.SLIDING), int(Status.REPELLING), int(Status.GRAZING)
_NO_CONVERGENCE, _ESCAPED, _ZENO = int(Status.NO_CONVERGENCE), int(Status.ESCAPED), int(Status.ZENO)
_CROSSING_LIMIT = int(Status.CROSSING_LIMIT)
_TRANSVERSAL_KIND, _GRAZING_KIND, _SLIDING_KIND, _REPELLING_KIND, _JUMP_KIND = range(len(CROSSING_KINDS))

_EPS = 2.0**-52
BOUND = 1e150  #: beyond it the square of a state overflows
_MAX_CROSSINGS_A_STEP = 64
_MAX_PROBES = 200
_NONE, _FOUND, _TOUCH, _FAILED = 0, 1, 2, 3
_HEIGHT, _RATE = 0, 1


@_inline
def two_sum(a, b):
    """a + b and what rounding lost of it, exactly (Knuth)."""
    total = a + b
    back = total - a
    return total, (a - (total - back)) + (b - back)


@_inline
def advance(x, carry, dx, out):
    """State after an increment, rounded."""
    for i in range(x.size):
        out[i] = x[i] + (carry[i] + dx[i])


@_inline
def accept(x, carry, dx):
    """Add an increment to the state, keeping what rounding would lose (compensated summation)."""
    for i in range(x.size):
        x[i], carry[i] = two_sum(x[i], carry[i] + dx[i])


@_inline
def is_lost(x):
    """Whether a state is beyond any bound, or none at all."""
    for i in range(x.size):
        if not abs(x[i]) < BOUND:
            return True
    return False


@_inline
def is_plain(run, height_end, rate_end):
    """Whether nothing happens in a step that ends at this height and rate; if so, the rate is taken over."""
    rate_end = math.copysign(rate_end, rate_end * run.tau)
    turns = run.rate < 0.0 and rate_end > 0.0
    if not (0.0 < height_end < math.inf and abs(rate_end) < math.inf) or (run.leaving == 0 and turns):
        return False
    run.rate = rate_end
    run.leaving = 0
    return True


@_inline
def outward_rate(run, rate, side, t, x, p):
    """Rate at which the height over a side grows along the run."""
    return math.copysign(1.0, run.tau) * side * rate(side, t, x, p)


@_inline
def probe(quantity, step, switching, rate, run, t, h, x, carry, p, dx, trial):
    """Height or rate after a step of length h, on the scheme itself; nan where there is none."""
    count = step(t, h, x, carry, p, dx)
    if count < 0:
        return math.nan
    run.evaluations += count
    advance(x, carry, dx, trial)
    if quantity == _HEIGHT:
        return run.side * switching(t + h, trial, p)
    return outward_rate(run, rate, run.side, t + h, trial, p)


@_inline
def root(quantity, low, high, f_low, f_high, step, switching, rate, run, t, x, carry, p, dx, trial):
    """Step length in [low, high] where a height or a rate changes sign, to the last digit.

    Regula falsi (Illinois) with a bisection every third probe: superlinear, and never more than 3 × 104 probes. A
    probe keeps an ulp's distance from either end, so that the end it has nearly reached is soon passed. Of the two
    sides that remain, the one where the quantity is smaller.
    """
    best, f_best = (low, f_low) if abs(f_low) < abs(f_high) else (high, f_high)
    for k in range(_MAX_PROBES):
        ulp = _EPS * max(abs(high), abs(low), _EPS * abs(run.tau))
        if abs(high - low) <= 2.0 * ulp or f_best == 0.0:
            break
        middle = low + 0.5 * (high - low)
        if k % 3 < 2:
            secant = high - f_high * ((high - low) / (f_high - f_low))
            secant = min(max(secant, min(low, high) + ulp), max(low, high) - ulp)
            if secant == secant:
                middle = secant
        f = probe(quantity, step, switching, rate, run, t, middle, x, carry, p, dx, trial)
        if not abs(f) < math.inf:
            return math.nan
        if abs(f) < abs(f_best):
            best, f_best = middle, f
        if (f > 0.0) == (f_high > 0.0):
            high, f_high, f_low = middle, f, 0.5 * f_low
        else:
            low, f_low, f_high = middle, f, 0.5 * f_high
    return best


@_inline
def first_crossing(step, switching, rate, run, t, h, height_end, rate_end, x, carry, p, dx, trial):
    """Look for the first crossing in a step of length h; its place goes to run.hit.

    A change of sign shows itself. Two crossings in a step do not, but the extremum between them does, by the signs
    of the rate at the two ends; and a state that is leaving the surface has to turn back before it can cross again.
    """
    height = 0.0
    if run.leaving == 0:
        if height_end > 0.0 and not (run.rate < 0.0 and rate_end > 0.0):
            return _NONE
        height = run.side * switching(t, x, p)
        if height_end <= 0.0:
            run.hit = root(
                _HEIGHT, 0.0, h, height, height_end, step, switching, rate, run, t, x, carry, p, dx, trial
            )
            return _FOUND if run.hit == run.hit else _FAILED
        if min(height, height_end) > 2.0 * max(-run.rate, rate_end) * abs(h):
            return _NONE  # it turns too far from the surface to have met it
    elif height_end > 0.0 or rate_end >= 0.0:
        return _NONE
    turn = root(_RATE, 0.0, h, run.rate, rate_end, step, switching, rate, run, t, x, carry, p, dx, trial)
    height_turn = probe(_HEIGHT, step, switching, rate, run, t, turn, x, carry, p, dx, trial)
    if not abs(height_turn) < math.inf:
        return _FAILED
    if run.leaving == 0 and height_turn > 0.0:
        return _NONE
    if run.leaving == 1 and height_turn <= 0.0:
        run.hit = turn
        return _TOUCH
    low, f_low, high, f_high = (0.0, height, turn, height_turn)
    if run.leaving == 1:
        low, f_low, high, f_high = (turn, height_turn, h, height_end)
    run.hit = root(_HEIGHT, low, high, f_low, f_high, step, switching, rate, run, t, x, carry, p, dx, trial)
    return _FOUND if run.hit == run.hit else _FAILED


@_inline
def classify(run, before, into_minus, into_plus):
    """Status and kind of a crossing from the side's own rate before it and the rates into either side after it."""
    into_other = into_minus if run.side > 0 else into_plus
    if run.has_jump == 1:
        if into_minus > 0.0 and into_plus > 0.0:
            return _REPELLING, _REPELLING_KIND
        if into_minus > 0.0 or into_plus > 0.0:
            return RUNNING, _JUMP_KIND
        return _SLIDING, _SLIDING_KIND
    if before < 0.0 and into_other > 0.0:
        return RUNNING, _TRANSVERSAL_KIND
    if before < 0.0 and into_other < 0.0:
        return _SLIDING, _SLIDING_KIND
    return _GRAZING, _GRAZING_KIND


@_inline
def switch_side(switching, rate, jump, run, t, before, x, carry, p, trial, hits, hits_x, hits_after):
    """At the surface: jump, classify, take the other side, write the crossing down."""
    k = run.hits
    hits_x[k, :] = x
    hits[k].t = t
    hits[k].g = switching(t, x, p)
    hits[k].rate_before = rate(run.side, t, x, p)
    if run.has_jump == 1:
        jump(t, x, p, trial)
        x[:] = trial
        carry[:] = 0.0
    hits_after[k, :] = x
    into_minus = outward_rate(run, rate, -1, t, x, p)
    into_plus = outward_rate(run, rate, 1, t, x, p)
    status, kind = classify(run, before, into_minus, into_plus)
    entered = -run.side
    if run.has_jump == 1:
        entered = 1 if into_plus > 0.0 else -1
    hits[k].rate_after = rate(entered, t, x, p)
    hits[k].kind = kind
    hits[k].side = entered if status == RUNNING else 0
    run.hits = k + 1
    run.crossings += 1
    if status != RUNNING:
        return status
    run.side = entered
    run.rate = into_plus if entered > 0 else into_minus
    return _CROSSING_LIMIT if run.crossings >= run.max_crossings else RUNNING


@_inline
def land(step, switching, rate, run, t, x, carry, p, dx, trial):
    """Move the state to the crossing found, or by the perturbation beyond it; returns its rate on arrival, or nan.

    Paper: solve (eq:to-interface), (eq:interface) for (t̂, x̂); with a perturbation, t̂ ← t̂ + c·τᵖ and x̂ anew there.
    """
    before = probe(_RATE, step, switching, rate, run, t, run.hit, x, carry, p, dx, trial)
    if run.shift != 0.0:
        run.hit += run.shift
        if not abs(probe(_HEIGHT, step, switching, rate, run, t, run.hit, x, carry, p, dx, trial)) < math.inf:
            return math.nan
    accept(x, carry, dx)
    return before


@_inline
def stop_at(run, t):
    """Leave the run where it stopped."""
    run.t, run.t_carry = t, 0.0


@_inline
def take_step(
    step_minus, step_plus, switching, rate, jump, p, run, h, x, carry, dx, trial, spare, turned, hits, hits_x, hits_after
):
    """One step of length h, with as many crossings as lie in it (Algorithm 1)."""
    done = 0.0
    for _ in range(_MAX_CROSSINGS_A_STEP):
        step = step_plus if run.side > 0 else step_minus
        t, left = run.t + (run.t_carry + done), h - done
        count = step(t, left, x, carry, p, dx)
        if count < 0:
            stop_at(run, t)
            return _NO_CONVERGENCE
        run.evaluations += count
        advance(x, carry, dx, trial)
        if is_lost(trial):
            stop_at(run, t)
            return _ESCAPED
        height_end = run.side * switching(t + left, trial, p)
        rate_end = outward_rate(run, rate, run.side, t + left, trial, p)
        if not abs(height_end) < math.inf or not abs(rate_end) < math.inf:
            stop_at(run, t)
            return _NO_CONVERGENCE
        # A perturbed crossing may lie beyond the end of the step; going back from there is no motion to be watched.
        found = _NONE
        if run.follow == 1 and left * run.tau > 0.0:
            found = first_crossing(
                step, switching, rate, run, t, left, height_end, rate_end, x, carry, p, spare, turned
            )
        if found == _NONE:
            accept(x, carry, dx)
            run.rate = rate_end
            if height_end > 0.0:
                run.leaving = 0
            if run.follow == 1 or height_end > 0.0:
                return RUNNING
            status = switch_side(
                switching, rate, jump, run, t + left, rate_end, x, carry, p, trial, hits, hits_x, hits_after
            )
            if status != RUNNING:
                stop_at(run, t + left)
            return status
        before = math.nan
        if found != _FAILED:  # a touch has no rate of arrival
            before = land(step, switching, rate, run, t, x, carry, p, spare, turned)
        if before != before:
            stop_at(run, t)
            return _NO_CONVERGENCE
        if found == _TOUCH:
            before = 0.0
        done += run.hit
        t = run.t + (run.t_carry + done)
        status = switch_side(switching, rate, jump, run, t, before, x, carry, p, trial, hits, hits_x, hits_after)
        if status != RUNNING:
            stop_at(run, t)
            return status
        run.leaving = 1
        if done == h:
            return RUNNING
    stop_at(run, run.t + (run.t_carry + done))
    return _ZENO
