"""A piecewise smooth solution, extended from crossing to crossing as it is asked for.

The side is carried, never read from the sign of g near the surface. The solution ends, with a reason in words, where
it cannot go on: on a sliding piece of the surface, at a tangency, and where its crossings accumulate.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from core.reference.search import Time

__all__ = ["MAX_CROSSINGS", "Arc", "Motion", "ReferenceSolution", "Solution", "State", "Stop", "first_arc"]

State: TypeAlias = NDArray[Any]  # (d,) of such numbers as time is

TANGENT = 1e-8  # |ġ| below this fraction of its largest value on the arc: a tangency, not a crossing
OFF_SURFACE = 1e-9  # |g| after a jump above this fraction of the largest seen: the jump leads off the surface
MAX_CROSSINGS = 100_000
# Crossings accumulate if so many, one after another, take less than this fraction of the time since the start, or two
# gaps in a row less than so many ulps of time. If half the speed is left by each impact, the last gap is 1e-12 of it.
ACCUMULATED, ACCUMULATION, GAP_ULPS = 10, 1e-9, 1000


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

    @property
    def steepest(self) -> float:
        """Largest |ġ| seen on it."""

    @property
    def deepest(self) -> float:
        """Largest |g| seen on it."""

    def arrival(self, until: float) -> tuple[Time, State] | None:
        """First time and state on the surface; None if not before `until`.

        ValueError if `until` is inf and there is none, or if none is found within the bounds on work.
        """

    def state(self, t: float) -> State:
        """State (d,) at time t of this arc."""


class Motion(NamedTuple):
    """What a solution is made from."""

    start: Callable[[Time, State, int, bool], Arc]
    """(t, x, side, on_surface) -> the arc from there."""
    height: Callable[[Time, State], Time]
    """(t, x) -> g."""
    rate: Callable[[int, Time, State], Time]
    """(side, t, x) -> ġ = g_t + ∇g·f with the field of that side."""
    jump: Callable[[Time, State], State] | None = None
    """(t, x) -> the state (d,) after reaching the surface; None: it goes on as it is."""


class Solution(Protocol):
    """A solution to measure others against."""

    @property
    def name(self) -> str:
        """What it rests on, for display."""

    @property
    def exact(self) -> bool:
        """Whether all that was asked for so far is right to round-off of a double."""

    @property
    def error(self) -> float:
        """Bound on the error of what was asked for so far where it is exact, else its own estimate of it."""

    def crossing(self, k: int) -> tuple[float, NDArray[np.float64]]:
        """Time and state (d,) on the surface of crossing k, from 1 on."""

    def after(self, k: int) -> NDArray[np.float64]:
        """State (d,) from which the solution goes on after crossing k."""

    def state(self, t: float) -> NDArray[np.float64]:
        """State (d,) at time t."""

    def side(self, t: float) -> int:
        """Side occupied at time t."""


class ReferenceSolution:
    """Piecewise smooth solution from (t0, x0), extended lazily from crossing to crossing.

    Parameters
    ----------
    name : str
        What it rests on, for display.
    motion : Motion
    first : Arc
    max_crossings : int
    error : float
        Its own estimate of its error in the state.
    """

    exact = False

    def __init__(
        self, name: str, motion: Motion, first: Arc, max_crossings: int = MAX_CROSSINGS, error: float = np.inf
    ) -> None:
        self.name = name
        self.error = error
        self.stop: Stop | None = None  #: set once the solution is known to end
        self._motion, self._max_crossings = motion, max_crossings
        self._arcs = [first]
        self._times = [float(first.t)]
        self._places = [first.x]  # where each arc was begun, before the jump
        self._deepest = 0.0

    def crossing(self, k: int) -> tuple[float, NDArray[np.float64]]:
        """Time and state (d,) on the surface of crossing k = 1, 2, …; ValueError if the solution has fewer."""
        t, x, _ = self.passage(k)
        return float(t), x.astype(float)

    def after(self, k: int) -> NDArray[np.float64]:
        """State (d,) from which the solution goes on after crossing k: the one on the surface, or after its jump."""
        return self.passage(k)[2].astype(float)

    def state(self, t: float) -> NDArray[np.float64]:
        """State (d,) at time t ≥ t0, at a crossing the one after its jump; ValueError past the end of the solution."""
        return self.point(t).astype(float)

    def side(self, t: float) -> int:
        """Side, −1 or +1, occupied at time t ≥ t0; at a crossing the side entered."""
        return self._arc(t).side

    def passage(self, k: int) -> tuple[Time, State, State]:
        """Time of crossing k and the states (d,) before and after its jump, to all digits that they have."""
        self._reach(k)
        return self._arcs[k].t, self._places[k], self._arcs[k].x

    def arc(self, k: int) -> Arc | None:
        """The arc after crossing k, the first one for k = 0; None if it has not been worked out."""
        return self._arcs[k] if k < len(self._arcs) else None

    def point(self, t: float) -> State:
        """State (d,) at time t, to all digits that it has."""
        return self._arc(t).state(t)

    def _reach(self, k: int) -> None:
        if not 1 <= k <= self._max_crossings:
            raise ValueError(f"crossing must be from 1 to {self._max_crossings}, not {k}")
        while len(self._arcs) <= k:
            self._advance(np.inf)

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
            self._deepest = max(self._deepest, arc.deepest)
            onward = self._onward(arc, t, x)
            if not isinstance(onward, str):
                self._arcs.append(onward)
                self._times.append(float(t))
                self._places.append(x)
                return True
            self.stop = Stop(float(t), x.astype(float), onward)
        if self.stop.t >= until:
            return False
        raise ValueError(f"the solution ends at t = {self.stop.t:.16g}, x = {self.stop.x}: {self.stop.reason}")

    def _onward(self, arc: Arc, t: Time, x: State) -> Arc | str:
        """The arc after the crossing at (t, x), or why there is none."""
        tangent = TANGENT * arc.steepest
        if -arc.side * self._motion.rate(arc.side, t, x) <= tangent:
            return "it touches the surface tangentially"
        if self._accumulates(float(t)):
            return "its crossings accumulate: infinitely many follow in a finite time (Zeno)"
        if self._motion.jump is not None:
            return self._landing(t, self._motion.jump(t, x), tangent)
        onward = -arc.side * self._motion.rate(-arc.side, t, x)
        if onward < -tangent:
            return "the field of the other side points back, so it slides along the surface"
        if onward <= tangent:
            return "the field of the other side is tangent to the surface"
        return self._motion.start(t, x, -arc.side, True)

    def _landing(self, t: Time, x: State, tangent: float) -> Arc | str:
        """The arc after a jump to (t, x), or why there is none: on the surface it goes where the fields lead."""
        height = self._motion.height(t, x)
        if not _finite(*x, height):
            return f"the jump leads to {x.astype(float)}, where nothing is defined"
        if np.abs(height) > OFF_SURFACE * self._deepest:
            return self._motion.start(t, x, 1 if height > 0 else -1, False)
        below, above = -self._motion.rate(-1, t, x) > tangent, self._motion.rate(1, t, x) > tangent
        if below and above:
            return "after the jump both fields lead away from the surface"
        if not (below or above):
            return "after the jump neither field leads away from the surface, so it stays there"
        return self._motion.start(t, x, 1 if above else -1, True)

    def _accumulates(self, t: float) -> bool:
        """Whether a crossing at t comes too soon after the ones before it."""
        crossings = self._times[max(1, len(self._times) - ACCUMULATED) :]
        if len(crossings) == ACCUMULATED and t - crossings[0] < ACCUMULATION * (t - self._times[0]):
            return True
        return len(crossings) >= 2 and t - crossings[-2] <= GAP_ULPS * np.spacing(abs(t))


def first_arc(motion: Motion, t: Time, x: State, reach: Time) -> Arc:
    """The arc from (t, x): the side is the sign of g, or where |g| ≤ `reach`, the one the fields lead to."""
    height = motion.height(t, x)
    if not _finite(t, *x, height):
        raise ValueError(f"the start t0 = {float(t)}, x0 = {x.astype(float)}, with g = {float(height)}, must be finite")
    if np.abs(height) > reach:
        return motion.start(t, x, 1 if height > 0 else -1, False)
    below, above = motion.rate(-1, t, x), motion.rate(1, t, x)
    if below < 0 and above < 0:
        return motion.start(t, x, -1, True)
    if below > 0 and above > 0:
        return motion.start(t, x, 1, True)
    kind = "attracts both fields (sliding)" if below > 0 > above else "repels both, or is tangent to one"
    raise ValueError(f"x0 = {x.astype(float)} is on the surface, which there {kind}: no side to start on")


def _finite(*numbers: Time) -> bool:
    return bool(np.isfinite([float(u) for u in numbers]).all())
