"""A piecewise smooth solution, extended from crossing to crossing as it is asked for; and how crossings are found.

The side is carried, never read from the sign of g near the surface. The solution ends, with a reason in words, where
it cannot cross: on a sliding piece of the surface, and at a tangency.
"""

from bisect import bisect_right
from collections.abc import Callable
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

__all__ = ["MAX_CROSSINGS", "Arc", "ReferenceSolution", "Sample", "State", "Stop", "Time", "first_arc", "first_zero"]

Time: TypeAlias = float | np.longdouble
State: TypeAlias = NDArray[np.floating]
Watch: TypeAlias = Callable[[Time], tuple[Time, Time]]

TANGENT = 1e-8  # |ġ| below this fraction of its largest value on the arc: a tangency, not a crossing
MAX_CROSSINGS = 100_000


class Stop(NamedTuple):
    """Where, when and why a solution ends."""

    t: float
    x: NDArray[np.float64]
    reason: str


class Arc(Protocol):
    """A piece of the solution on one side, from (t, x) until it next reaches the surface."""

    side: int
    t: Time
    x: State
    steepest: float  # largest |ġ| seen on it

    def arrival(self, until: float) -> tuple[Time, State] | None:
        """First time and state on the surface; None if not before `until`.

        ValueError if `until` is inf and there is none, or if none is found within the bounds on work.
        """

    def state(self, t: float) -> State:
        """State (d,) at time t of this arc."""


class ReferenceSolution:
    """Piecewise smooth solution from (t0, x0), extended lazily from crossing to crossing.

    Parameters
    ----------
    name : str
        What it rests on, for display.
    start : callable (t, x, side, on_surface) -> Arc
    gdot : callable (side, t, x) -> float
        Rate of g along the field of a side.
    first : Arc
    max_crossings : int
    """

    def __init__(
        self,
        name: str,
        start: Callable[[Time, State, int, bool], Arc],
        gdot: Callable[[int, Time, State], Time],
        first: Arc,
        max_crossings: int,
    ) -> None:
        self.name = name
        self.stop: Stop | None = None  #: set once the solution is known to end
        self._start, self._gdot, self._max_crossings = start, gdot, max_crossings
        self._arcs = [first]
        self._times = [float(first.t)]

    def crossing(self, k: int) -> tuple[float, NDArray[np.float64]]:
        """Time and state (d,) of crossing k = 1, 2, …; ValueError if the solution has fewer."""
        if not 1 <= k <= self._max_crossings:
            raise ValueError(f"crossing must be from 1 to {self._max_crossings}, not {k}")
        while len(self._arcs) <= k:
            self._advance(np.inf)
        return self._times[k], self._arcs[k].x.astype(float)

    def state(self, t: float) -> NDArray[np.float64]:
        """State (d,) at time t ≥ t0; ValueError past the end of the solution."""
        return self._arc(t).state(t).astype(float)

    def side(self, t: float) -> int:
        """Side, −1 or +1, occupied at time t ≥ t0; at a crossing the side entered."""
        return self._arc(t).side

    def _arc(self, t: float) -> Arc:
        if not self._times[0] <= t < np.inf:
            raise ValueError(f"time must be finite and at least {self._times[0]:.17g}, not {t}")
        while self._times[-1] <= t and self._advance(t):
            if len(self._arcs) > self._max_crossings:
                raise ValueError(f"more than {self._max_crossings} crossings before t = {t}")
        return self._arcs[bisect_right(self._times, t) - 1]

    def _advance(self, until: float) -> bool:
        """Append the next arc; False if there is no crossing up to `until`."""
        arc = self._arcs[-1]
        if self.stop is None or self.stop.t > until:
            arrived = arc.arrival(until)
            if arrived is None or arrived[0] > until:
                return False
            t, x = arrived
            reason = self._obstacle(arc, t, x)
            if reason is None:
                self._arcs.append(self._start(t, x, -arc.side, True))
                self._times.append(float(t))
                return True
            self.stop = Stop(float(t), x.astype(float), reason)
        if self.stop.t >= until:
            return False
        raise ValueError(f"the solution ends at t = {self.stop.t:.16g}, x = {self.stop.x}: {self.stop.reason}")

    def _obstacle(self, arc: Arc, t: Time, x: State) -> str | None:
        """Why the solution cannot cross at (t, x), or None if it crosses transversally."""
        tangent = TANGENT * arc.steepest
        if -arc.side * self._gdot(arc.side, t, x) <= tangent:
            return "it touches the surface tangentially"
        onward = -arc.side * self._gdot(-arc.side, t, x)
        if onward < -tangent:
            return "the field of the other side points back, so it slides along the surface"
        return "the field of the other side is tangent to the surface" if onward <= tangent else None


class Sample(NamedTuple):
    """One look at an arc: the time, side·g (positive inside) and its rate."""

    t: Time
    depth: Time
    rate: Time


def first_arc(
    start: Callable[[Time, State, int, bool], Arc],
    gdot: Callable[[int, Time, State], Time],
    t: Time,
    x: State,
    height: Time,
    reach: Time,
) -> Arc:
    """The arc from (t, x): the side is the sign of g = `height`, or of ġ where |g| ≤ `reach`."""
    if not (np.isfinite(x).all() and np.isfinite(t) and np.isfinite(height)):
        raise ValueError(f"the start t0 = {t}, x0 = {x}, with g = {height}, must be finite")
    if np.abs(height) > reach:
        return start(t, x, 1 if height > 0 else -1, False)
    below, above = gdot(-1, t, x), gdot(1, t, x)
    if below < 0 and above < 0:
        return start(t, x, -1, True)
    if below > 0 and above > 0:
        return start(t, x, 1, True)
    kind = "attracts both fields (sliding)" if below > 0 > above else "repels both, or is tangent to one"
    raise ValueError(f"x0 = {x.astype(float)} is on the surface, which there {kind}: no side to start on")


def first_zero(watch: Watch, a: Sample, b: Sample) -> Time | None:
    """First time in (a, b] at which the depth vanishes, or None; not the zero at a itself.

    Two zeros between a and b show in the sign of the rate: the extremum between them is looked at.
    """
    if a.depth > 0 and b.depth <= 0:
        return _newton(watch, a.t, b.t)
    if a.rate < 0 < b.rate:
        bottom = _extremum(watch, a.t, b.t)
        return _newton(watch, a.t, bottom) if watch(bottom)[0] <= 0 else None
    if b.depth <= 0:  # and a is on the surface: left and met again between two looks
        top = _extremum(watch, a.t, b.t) if a.rate > 0 > b.rate else a.t
        if watch(top)[0] <= 0:
            raise ValueError(f"the solution leaves the surface tangentially; it is back after {b.t - a.t:.3g}")
        return _newton(watch, top, b.t)
    return None


def _extremum(watch: Watch, a: Time, b: Time) -> Time:
    """Time between a and b, where the rate has opposite signs, at which it vanishes."""
    return a + (b - a) * brentq(lambda s: float(watch(a + (b - a) * s)[1]), 0.0, 1.0)


def _newton(watch: Watch, inside: Time, outside: Time) -> Time:
    """Zero of the depth in a bracket, to the last digit: Newton's method, bisecting where it would leave."""
    t = inside + (outside - inside) / 2
    for _ in range(200):
        depth, rate = watch(t)
        if depth > 0:
            inside = t
        else:
            outside = t
        step = -depth / rate if rate != 0 else np.inf
        new = t + step if inside < t + step < outside else inside + (outside - inside) / 2
        if depth == 0 or new in (t, inside, outside):
            break
        t = new
    return t
