"""What is looked at and written down at the surface: g, its rates, its rounding. Jitted; inlined into `time_loop`.

Heights and rates are as in `event_location`.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types from the one signature in `time_loop`.

from __future__ import annotations

import math
from typing import Any, NamedTuple

from core.kernels.abi import DOUBT, EXCESS, LOOK, RATES, G, call
from core.kernels.doubledouble.error_free import two_sum
from core.kernels.jit import inlined, internal

__all__ = [
    "MARGIN", "Log", "accept", "contradicts", "is_contradicted", "is_on_surface", "look", "look_at", "note",
    "pass_time", "widen_envelope",
]  # fmt: skip

_EPS = 2.0**-52
MARGIN = 16.0  #: by how much g may contradict the side, in units of a first-order bound on its rounding


class Log(NamedTuple):
    """Where crossings are written."""

    hits: Any
    places: Any  # (…, 3, d): on the surface, where the run landed, where it went on from
    excess: Any  # of ψ over its levels, a part of the frame
    envelope: Any  # (columns, m, 2) least and greatest excess in equal parts of the time


@inlined
def accept(motion):
    """Add the increment to the state, keeping what rounding would lose (compensated summation)."""
    x, carry, increment = motion.x, motion.carry, motion.increment
    for i in range(x.size):
        x[i], carry[i] = two_sum(x[i], carry[i] + increment[i])


@inlined
def pass_time(run, h):
    """Go on in time, compensated likewise."""
    run.t, run.t_carry = two_sum(run.t, h + run.t_carry)


@inlined
def look(motion, t):
    """Look at `place`: g to w[G], and to run.own and run.other the rates into the side occupied and into the other."""
    run, w = motion.run, motion.w
    call(motion.functions[LOOK], t, 0.0, motion.p, w, motion.memo)
    along = math.copysign(1.0, run.tau) * run.side
    run.own = along * w[RATES + (run.side > 0)]
    run.other = -along * w[RATES + (run.side < 0)]


@inlined
def look_at(motion, t):
    """G at `place`."""
    call(motion.functions[LOOK], t, 0.0, motion.p, motion.w, motion.memo)
    return motion.w[G]


@inlined
def note(motion, log, which):
    """Write `place` down as where the surface was met (0), where the run landed (1), or went on from (2)."""
    for i in range(motion.place.size):
        log.places[motion.run.hits, which, i] = motion.place[i]


@internal
def widen_envelope(motion, log):
    """Take the excess of ψ over its levels into the column of this time."""
    run, excess, envelope = motion.run, log.excess, log.envelope
    call(motion.functions[EXCESS + (run.side > 0)], run.t, 0.0, motion.p, motion.w, motion.memo)
    columns = envelope.shape[0]
    column = min(int(columns * ((run.t - run.t_start) / (run.t_end - run.t_start))), columns - 1)
    for j in range(excess.size):
        if excess[j] < envelope[column, j, 0]:  # never so where a side has fewer ψ, and its excess is nan
            envelope[column, j, 0] = excess[j]
        if excess[j] > envelope[column, j, 1]:
            envelope[column, j, 1] = excess[j]


@inlined
def is_on_surface(motion):
    """Whether g, where it has been looked at last, may be zero but for rounding."""
    return abs(motion.w[G]) <= MARGIN * motion.w[DOUBT]


@internal
def contradicts(motion, h):
    """Whether g at the state has the sign of the other side than that occupied, by more than rounding can explain.

    A step of length h rounds its increment, and a time is rounded too: both move g by so much of its rate. Where a
    perturbation, or a step over the surface, has left the state on purpose there is nothing to compare.
    """
    for i in range(motion.x.size):
        motion.place[i] = motion.x[i]
    look_at(motion, motion.run.t)
    return is_contradicted(motion, h)


@inlined
def is_contradicted(motion, h):
    """The same, where the state has been looked at already."""
    run, w = motion.run, motion.w
    if run.leaving == 1 and (run.shift != 0.0 or run.follow == 0):
        return False
    moved = _EPS * (abs(run.t) + abs(h)) * max(abs(w[RATES]), abs(w[RATES + 1]))
    return -run.side * w[G] > MARGIN * (w[DOUBT] + moved)
