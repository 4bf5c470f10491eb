"""The value of a coordinate of the start at which the trajectory touches the surface without crossing it."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from core.integration.trajectory import Trajectory
from core.interface.cancelling import Cancel, raise_if
from core.interface.summary import Brief
from core.kernels.arrays import Floats
from core.reference import Solution, reference_solution
from core.studies.stability.plan import Plan
from core.studies.stability.verdict import ENDINGS, reference_run, start_at
from core.studies.target import crossing_times
from core.system import PiecewiseSystem

__all__ = ["Tangency", "exact_times", "find_tangency"]

#: Spacing of doubles at 1: relative width of the bracket at which bisection ends.
_EPS = 2.0**-52
#: Distance from a tangency at which trajectories on both sides are compared, relative to the size of the coordinate.
_NEARBY = 1e-9
#: |ġ|, relative to its largest value on the trajectory, below which the surface is met (nearly) tangentially; likewise
#: |f| below which the state is near an equilibrium.
_FLAT = 1e-3
#: Least |g| of a start off the surface, relative to the largest on the trajectory.
_OFF = 1e-5
#: Most changes between two neighbouring values that are tested for a tangency.
_CHANGES = 6
#: Difference in time, relative to the time span, above which two crossings are different ones.
_APART = 1e-3
#: Time ahead, relative to the time or 1, over which the slope of ġ is taken.
_AHEAD = 1e-6
#: Half-width of the first bracket for the exact solution around a tangency, relative to the size of the coordinate.
_NARROW = 1e-13
#: Half-width beyond which no bracket is tried.
_WIDE = 1e-9


#: Change of a start, relative to the size of the coordinate, that is a few roundings.
_ROUNDINGS = 2.0**-50


@dataclass(frozen=True, eq=False, repr=False)
class Tangency(Brief):
    """A start, and the time and state at which its trajectory touches the surface."""

    value: float
    """Value of the coordinate of x₀."""
    time: float
    """Time of the touch."""
    state: Floats
    """(d,) state on the surface."""
    horizon: float
    """Halfway between the touch and the crossing that follows, on either side, or the end of the trajectory."""
    size: float
    """Size of the coordinate: its value, or half the range of the values tried if that is larger."""


def find_tangency(plan: Plan, cancel: Cancel | None) -> Tangency | None:
    """Return the tangency nearest to the start among those between the values of a plan, or None.

    A tangency separates trajectories that differ in their crossings. Where those of neighbouring values differ,
    bisection finds the value at which they change. This is a tangency if the trajectory meets the surface nearly
    tangentially there, and not if its start or its end, or an equilibrium, lies on the surface. Once `cancel` returns
    True, `Cancelled` is raised.
    """
    runs = [_run(plan, value, cancel) for value in plan.values]
    here = plan.x0[plan.coordinate]
    gaps = [(a, b) for a, b in pairwise(range(len(runs))) if _differ(runs[a], runs[b])]
    for a, b in sorted(gaps, key=lambda gap: abs(plan.values[gap[0]] + plan.values[gap[1]] - 2 * here)):
        tangency = _in_gap(plan, float(plan.values[a]), float(plan.values[b]), cancel)
        if tangency is not None:
            return _there(plan, _refined(plan, tangency, cancel), cancel)
    return None


def _in_gap(plan: Plan, low: float, high: float, cancel: Cancel | None) -> Tangency | None:
    """Return the first tangency among the first few changes between two values, or None."""
    at_high = _run(plan, high, cancel)
    for _ in range(_CHANGES):
        at_low = _run(plan, low, cancel)
        if not _differ(at_low, at_high):
            return None
        before, after = _bisect(plan, low, high, at_low, _NEARBY, cancel)
        if _tangency(plan, (before + after) / 2, cancel) is not None:  # tested before the bracket is narrowed further
            before, after = _bisect(plan, before, after, at_low, _EPS, cancel)
            return _tangency(plan, (before + after) / 2, cancel)
        low = after
    return None


def _run(plan: Plan, value: float, cancel: Cancel | None) -> Trajectory | None:
    """Return the reference run from a value of the coordinate; None where it cannot start, or does not finish."""
    try:
        start = start_at(plan.x0, plan.coordinate, value)
        run = reference_run(plan.system, start, plan.t_span, sliding=plan.sliding, cancel=cancel)
    except ValueError:  # f or g is undefined there
        return None
    raise_if(cancel)
    return run if run.status in ENDINGS else None


def _differ(a: Trajectory | None, b: Trajectory | None) -> bool:
    """Whether two trajectories end differently, or have different numbers of crossings."""
    return a is not None and b is not None and (a.status, a.crossing_count) != (b.status, b.crossing_count)


def _bisect(
    plan: Plan, low: float, high: float, at_low: Trajectory | None, precision: float, cancel: Cancel | None
) -> tuple[float, float]:
    """Narrow the bracket of the value at which crossings or ending of the trajectory change."""
    while high - low > precision * _size(plan, low):
        middle = low + (high - low) / 2
        if _differ(_run(plan, middle, cancel), at_low):
            high = middle
        else:
            low = middle
    return low, high


def _size(plan: Plan, value: float) -> float:
    """Return the size of the coordinate: the value, or half the range of the values tried if that is larger."""
    return max(abs(value), float(np.ptp(plan.values)) / 2)


def _tangency(plan: Plan, value: float, cancel: Cancel | None) -> Tangency | None:
    """The tangency at a value, or None if the change there is of another kind."""
    size = _size(plan, value)
    below, above = (_run(plan, value + side * _NEARBY * size, cancel) for side in (-1, 1))
    if below is None or above is None:
        return None
    more, less = (above, below) if len(above.crossings) >= len(below.crossings) else (below, above)
    apart = _APART * (plan.t_span[1] - plan.t_span[0])
    k = _first_difference(more, less, apart)
    t = np.append(more.crossings.t[k:], more.t[-1])
    if len(t) < 2 or not _is_touch(plan, more, k):
        return None
    # Two crossings shortly after each other; or one, if the other field leads away, or the state slides.
    dip = slice(k, k + 2) if len(t) > 2 and t[1] - t[0] < apart else slice(k, k + 1)
    time, state = _touch(plan, more, k)
    ends = [float(np.append(run.crossings.t, run.t[-1])[n]) for run, n in ((less, k), (more, dip.stop))]
    following = min(
        (t for t in ends if t > time + apart), default=plan.t_span[1]
    )  # a trajectory that slides ends at the touch
    return Tangency(value, time, state, (time + following) / 2, size)


def _touch(plan: Plan, run: Trajectory, k: int) -> tuple[float, Floats]:
    """Return time and state near crossing k, which is nearly tangential, at which the rate of g is 0.

    By one step of Newton's method along the field: the crossing itself lies apart by the root of the distance between
    the starts.
    """
    met, system = run.crossings, plan.system
    before, surface = int(met.mode[k - 1] if k else run.mode[0]), int(met.surface_met[k])
    t, x = met.t[k : k + 1], met.x[k : k + 1]
    rate, *field = _along(system, before, surface, t, x)[0]
    ahead = _AHEAD * max(1.0, abs(t[0]))
    slope = (_along(system, before, surface, t + ahead, x + ahead * np.array(field))[0, 0] - rate) / ahead
    shift = -rate / slope if slope else 0.0
    if not abs(shift) < _APART * (plan.t_span[1] - plan.t_span[0]):  # the rate does not vanish nearby
        shift = 0.0
    return float(t[0] + shift), x[0] + shift * np.array(field)


def _first_difference(more: Trajectory, less: Trajectory, apart: float) -> int:
    """Number of the first crossing that a run does not share with the other."""
    n = min(len(more.crossings), len(less.crossings))
    differ = np.abs(more.crossings.t[:n] - less.crossings.t[:n]) > apart
    return int(differ.argmax()) if differ.any() else n


def _is_touch(plan: Plan, run: Trajectory, k: int) -> bool:
    """Whether a run that starts off the surface meets it nearly tangentially at crossing k, and does not rest there."""
    system, met, laws = plan.system, run.crossings, plan.system.laws
    before, surface = int(met.mode[k - 1] if k else run.mode[0]), int(met.surface_met[k])
    if not 0 <= before < len(laws.regions):  # it slides up to there
        return False
    span = (plan.t_span[0], float(met.t[k]))
    steps = reference_run(system, tuple(run.x[0]), span, record="steps", sliding=plan.sliding)
    g = laws.surfaces[surface]
    heights = laws.evaluate(("g", surface), (g,), steps.t, steps.x, system.parameter_array)[:, 0]
    rates, speeds = np.zeros((2, len(steps.t)))
    for number in set(steps.mode[~steps.sliding].tolist()):
        rows = steps.mode == number
        rates[rows], *field = _along(system, number, surface, steps.t[rows], steps.x[rows]).T
        speeds[rows] = np.linalg.norm(field, axis=0)
    speed = np.linalg.norm(_along(system, before, surface, met.t[k : k + 1], met.x[k : k + 1])[0, 1:])
    off, flat = abs(heights[0]) > _OFF * np.abs(heights).max(), abs(met.rate_before[k]) < _FLAT * np.abs(rates).max()
    return bool(off and flat and speed > _FLAT * speeds.max())


def _along(system: PiecewiseSystem, mode: int, surface: int, t: Floats, x: Floats) -> Floats:
    """(k, 1 + d) the rate of the switching function of a surface with the field of a region, and that field."""
    law = system.laws.mode(mode).written
    wanted = (law.rate_of(system.laws.surfaces[surface]), *law.field)
    return system.laws.evaluate(("along", mode, surface), wanted, t, x, system.parameter_array)


def _refined(plan: Plan, tangency: Tangency, cancel: Cancel | None) -> Tangency:
    """Return the tangency of the exact solution, where known: that of the integrator has its round-off."""

    def crossings(value: float) -> int:
        return len(exact_times(plan, start_at(plan.x0, plan.coordinate, value), horizon, cancel)[0])

    horizon = tangency.horizon
    if not _is_exact(plan, tangency.value, cancel):
        return tangency
    reach = _NARROW * tangency.size
    while reach < _WIDE * tangency.size:
        low, high = tangency.value - reach, tangency.value + reach
        at_low = crossings(low)
        if at_low != crossings(high):
            break
        reach *= 10
    else:
        return tangency
    while low < (middle := low + (high - low) / 2) < high:
        low, high = (middle, high) if crossings(middle) == at_low else (low, middle)
    return Tangency(middle, tangency.time, tangency.state, horizon, tangency.size)


def _there(plan: Plan, tangency: Tangency, cancel: Cancel | None) -> Tangency:
    """Return a tangency with the state of the solution from its start, in place of one that starts farther from it.

    That solution may end where it touches the surface: one that starts beside it by some roundings does not.
    """
    for aside in (0.0, -_ROUNDINGS * tangency.size, _ROUNDINGS * tangency.size):
        start = start_at(plan.x0, plan.coordinate, tangency.value + aside)
        with suppress(ValueError):
            solution = reference_solution(plan.system, start, plan.t_span[0], sliding=plan.sliding, cancel=cancel)
            return replace(tangency, state=solution.state(tangency.time))
    return tangency


def _is_exact(plan: Plan, value: float, cancel: Cancel | None) -> bool:
    start = start_at(plan.x0, plan.coordinate, value)
    try:
        return reference_solution(plan.system, start, plan.t_span[0], sliding=plan.sliding, cancel=cancel).exact
    except ValueError:  # the start is on the surface
        return False


def exact_times(
    plan: Plan, x0: tuple[float, ...], until: float, cancel: Cancel | None
) -> tuple[NDArray[np.float64], Solution | None]:
    """Times of the crossings of the reference solution up to `until`, or to its end, and the solution."""
    try:
        solution = reference_solution(plan.system, x0, plan.t_span[0], sliding=plan.sliding, cancel=cancel)
    except ValueError:  # no start
        return np.array([]), None
    return np.array(crossing_times(solution, until)), solution
