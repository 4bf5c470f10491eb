"""Watch g, locate the crossing, land on the surface, perturb, switch, classify: the paper's Algorithm 1.

Jitted; inlined into `march`. Throughout, σ = side·g is the height over the surface on the side occupied (positive
there), and a *rate* is dσ/dt counted along the run: negative while it approaches the surface.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `march`.

from __future__ import annotations

import math
from typing import Any, NamedTuple

from numba import njit

from core.arithmetic import two_sum
from core.trajectory import CROSSING_KINDS, Status

__all__ = ["BOUND", "RUNNING", "Log", "Scheme", "is_plain", "take_step"]

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


class Scheme(NamedTuple):
    """One side's scheme at the start of a step: the compiled functions, the run, and scratch for a trial step."""

    step: Any
    switching: Any
    rate: Any
    run: Any
    x: Any
    carry: Any
    p: Any
    dx: Any
    trial: Any


class Log(NamedTuple):
    """Where crossings are written."""

    hits: Any
    places: Any  # (…, 3, d): on the surface, where the run landed, where it went on from


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
    largest = 0.0
    for i in range(x.size):
        largest = max(largest, abs(x[i])) if x[i] == x[i] else math.inf
    return not largest < BOUND


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
def probe(quantity, scheme, t, h):
    """Height or rate after a step of length h, on the scheme itself; nan where there is none."""
    run, trial = scheme.run, scheme.trial
    count = scheme.step(t, h, scheme.x, scheme.carry, scheme.p, scheme.dx)
    if count < 0:
        return math.nan
    run.evaluations += count
    advance(scheme.x, scheme.carry, scheme.dx, trial)
    if quantity == _HEIGHT:
        return run.side * scheme.switching(t + h, trial, scheme.p)
    return outward_rate(run, scheme.rate, run.side, t + h, trial, scheme.p)


@_inline
def root(quantity, scheme, t, low, high, f_low, f_high):
    """Step length in [low, high] where a height or a rate changes sign, to the last digit.

    Regula falsi (Illinois) with a bisection every third probe: superlinear, and never more than 3 × 104 probes. A
    probe keeps an ulp's distance from either end, so that the end it has nearly reached is soon passed. Of the two
    sides that remain, the one where the quantity is smaller.
    """
    best, f_best = (low, f_low) if abs(f_low) < abs(f_high) else (high, f_high)
    for k in range(_MAX_PROBES):
        ulp = _EPS * max(abs(high), abs(low), _EPS * abs(scheme.run.tau))
        if abs(high - low) <= 2.0 * ulp or f_best == 0.0:
            break
        middle = low + 0.5 * (high - low)
        if k % 3 < 2:
            secant = high - f_high * ((high - low) / (f_high - f_low))
            secant = min(max(secant, min(low, high) + ulp), max(low, high) - ulp)
            if secant == secant:
                middle = secant
        f = probe(quantity, scheme, t, middle)
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
def first_crossing(scheme, t, h, height_end, rate_end):
    """Look for the first crossing in a step of length h; its place goes to run.hit.

    A change of sign shows itself. Two crossings in a step do not, but the extremum between them does, by the signs
    of the rate at the two ends; and a state that is leaving the surface has to turn back before it can cross again.
    """
    run, height = scheme.run, 0.0
    if run.leaving == 0:
        if height_end > 0.0 and not (run.rate < 0.0 and rate_end > 0.0):
            return _NONE
        height = run.side * scheme.switching(t, scheme.x, scheme.p)
        if height_end <= 0.0:
            return settle(scheme, t, 0.0, h, height, height_end)
        if min(height, height_end) > 2.0 * max(-run.rate, rate_end) * abs(h):
            return _NONE  # it turns too far from the surface to have met it
    elif height_end > 0.0 or rate_end >= 0.0:
        return _NONE
    turn = root(_RATE, scheme, t, 0.0, h, run.rate, rate_end)
    height_turn = probe(_HEIGHT, scheme, t, turn)
    if not abs(height_turn) < math.inf:
        return _FAILED
    if run.leaving == 0:
        return settle(scheme, t, 0.0, turn, height, height_turn) if height_turn <= 0.0 else _NONE
    if height_turn > 0.0:
        return settle(scheme, t, turn, h, height_turn, height_end)
    run.hit = turn
    return _TOUCH


@_inline
def settle(scheme, t, low, high, f_low, f_high):
    """Locate the crossing between low and high."""
    scheme.run.hit = root(_HEIGHT, scheme, t, low, high, f_low, f_high)
    return _FOUND if scheme.run.hit == scheme.run.hit else _FAILED


@_inline
def look_around(scheme, log, t, place):
    """Rates at a place on the surface: into the side occupied (negative on arrival), and into the other."""
    run = scheme.run
    for i in range(place.size):
        log.places[run.hits, 0, i] = place[i]
    run.own = outward_rate(run, scheme.rate, run.side, t, place, scheme.p)
    run.other = outward_rate(run, scheme.rate, -run.side, t, place, scheme.p)


@_inline
def classify(run):
    """Status and kind of a crossing by the rates at the surface: a transversal one arrives and leaves."""
    if run.own < 0.0 and run.other < 0.0:
        return _SLIDING, _SLIDING_KIND
    if run.own < 0.0 < run.other or run.follow == 0:  # without a transition the place is too rough to tell a touch
        return RUNNING, _TRANSVERSAL_KIND
    return _GRAZING, _GRAZING_KIND


@_inline
def leap(scheme, jump, t):
    """Jump, and look where the fields lead from there: status, kind and side entered."""
    run, x = scheme.run, scheme.x
    jump(t, x, scheme.p, scheme.trial)
    for i in range(x.size):
        x[i], scheme.carry[i] = scheme.trial[i], 0.0
    into_minus = outward_rate(run, scheme.rate, -1, t, x, scheme.p)
    into_plus = outward_rate(run, scheme.rate, 1, t, x, scheme.p)
    if into_minus > 0.0 and into_plus > 0.0:
        return _REPELLING, _REPELLING_KIND, 0
    if into_minus > 0.0 or into_plus > 0.0:
        return RUNNING, _JUMP_KIND, 1 if into_plus > 0.0 else -1
    return _SLIDING, _SLIDING_KIND, 0


@_inline
def switch_side(scheme, jump, log, t):
    """At the surface: jump, classify, take the other side, write the crossing down."""
    run, x, p = scheme.run, scheme.x, scheme.p
    k = run.hits
    hit = log.hits[k]
    hit.t = t
    hit.g = scheme.switching(t, x, p)
    hit.rate_before = math.copysign(1.0, run.tau) * run.side * run.own
    hit.rate_after = -math.copysign(1.0, run.tau) * run.side * run.other
    for i in range(x.size):
        log.places[k, 1, i] = x[i]
    if run.has_jump == 1:
        status, kind, entered = leap(scheme, jump, t)
        if status == RUNNING:
            hit.rate_after = scheme.rate(entered, t, x, p)
    else:
        status, kind = classify(run)
        entered = -run.side
    for i in range(x.size):
        log.places[k, 2, i] = x[i]
    hit.kind = kind
    hit.side = entered if status == RUNNING else 0
    run.hits = k + 1
    run.crossings += 1
    if status != RUNNING:
        return status
    run.side = entered
    run.rate = outward_rate(run, scheme.rate, entered, t, x, p)
    return _CROSSING_LIMIT if run.crossings >= run.max_crossings else RUNNING


@_inline
def land(scheme, log, t):
    """Move the state to the crossing found, or by the perturbation beyond it; returns whether that could be done.

    Paper: solve (eq:to-interface), (eq:interface) for (t̂, x̂); with a perturbation, t̂ ← t̂ + c·τᵖ and x̂ anew there.
    """
    run = scheme.run
    height = probe(_HEIGHT, scheme, t, run.hit)
    look_around(scheme, log, t + run.hit, scheme.trial)
    if run.shift != 0.0:
        run.hit += run.shift
        height = probe(_HEIGHT, scheme, t, run.hit)
    if not abs(height) < math.inf:
        return False
    accept(scheme.x, scheme.carry, scheme.dx)
    return True


@_inline
def stop_at(run, t, status):
    """Leave the run where it stopped."""
    run.t, run.t_carry = t, 0.0
    return status


@_inline
def step_over(scheme, jump, log, t, h, height_end, rate_end):
    """Without a transition: the step stands, and only then is the side looked at."""
    run, x = scheme.run, scheme.x
    if height_end <= 0.0:  # the fields are compared where the chord of the step meets the surface
        height = run.side * scheme.switching(t, x, scheme.p)
        part = height / (height - height_end) if height > 0.0 else 0.0
        for i in range(x.size):
            scheme.trial[i] = x[i] + part * scheme.dx[i]
        look_around(scheme, log, t + part * h, scheme.trial)
    accept(x, scheme.carry, scheme.dx)
    run.rate = rate_end
    if height_end > 0.0:
        run.leaving = 0
        return RUNNING
    status = switch_side(scheme, jump, log, t + h)
    return status if status == RUNNING else stop_at(run, t + h, status)


@_inline
def take_step(step_minus, step_plus, jump, frame, log, h):
    """One step of length h, with as many crossings as lie in it (Algorithm 1)."""
    run, done = frame.run, 0.0
    for _ in range(_MAX_CROSSINGS_A_STEP):
        step = step_plus if run.side > 0 else step_minus
        scheme = Scheme(step, frame.switching, frame.rate, run, frame.x, frame.carry, frame.p, frame.dx, frame.trial)
        t, left = run.t + (run.t_carry + done), h - done
        height_end = probe(_HEIGHT, scheme, t, left)
        if is_lost(scheme.trial):
            return stop_at(run, t, _ESCAPED if height_end == height_end else _NO_CONVERGENCE)
        rate_end = outward_rate(run, scheme.rate, run.side, t + left, scheme.trial, scheme.p)
        if not abs(height_end) < math.inf or not abs(rate_end) < math.inf:
            return stop_at(run, t, _NO_CONVERGENCE)
        if run.follow == 0:
            return step_over(scheme, jump, log, t, left, height_end, rate_end)
        # A perturbed crossing may lie beyond the end of the step; going back from there is no motion to be watched.
        found = first_crossing(scheme, t, left, height_end, rate_end) if left * run.tau > 0.0 else _NONE
        if found == _NONE:
            probe(_HEIGHT, scheme, t, left)  # looking for a crossing may have moved the increment
            accept(scheme.x, scheme.carry, scheme.dx)
            run.rate = rate_end
            if height_end > 0.0:
                run.leaving = 0
            return RUNNING
        if found == _FAILED or not land(scheme, log, t):
            return stop_at(run, t, _NO_CONVERGENCE)
        if found == _TOUCH:
            run.own = 0.0  # it turns at the surface, and does not arrive
        done += run.hit
        t = run.t + (run.t_carry + done)
        status = switch_side(scheme, jump, log, t)
        if status != RUNNING:
            return stop_at(run, t, status)
        run.leaving = 1
        if done == h:
            return RUNNING
    return stop_at(run, run.t + (run.t_carry + done), _ZENO)
