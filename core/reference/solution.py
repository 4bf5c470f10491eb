"""A piecewise smooth solution, extended from crossing to crossing as it is asked for.

The side is carried, never read from the sign of g near the surface. The solution ends, with a reason in words, where
it cannot be continued: at a sliding or repelling point of the surface, at a tangency, where its crossings accumulate.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from core.reference.search import Time

__all__ = ["MAX_CROSSINGS", "Arc", "Dynamics", "ReferenceSolution", "Solution", "State", "Stop", "first_arc"]

State: TypeAlias = NDArray[Any]  # (d,) of numbers of the same kind as time

#: |ġ| at the surface, as part of its largest value on the arc, below which the surface is touched, not crossed.
TANGENT = 1e-8
#: |g| after a jump, as part of its largest value so far, above which the jump leads off the surface.
OFF_SURFACE = 1e-9
#: Most crossings of a solution, where not given.
MAX_CROSSINGS = 100_000
#: Number of successive crossings that are tested for accumulation.
ACCUMULATED = 10
#: They accumulate if they take less than this part of the time since the start.
ACCUMULATION = 1e-9
#: Crossings accumulate, too, if two successive gaps together are at most this many ulps of the time. If each impact
#: leaves half the speed, the last gap is then 1e-12 of the time.
GAP_ULPS = 1000


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
    def largest_rate(self) -> float:
        """Largest |ġ| found on it."""

    @property
    def largest_height(self) -> float:
        """Largest |g| found on it."""

    def arrival(self, until: float) -> tuple[Time, State] | None:
        """First time and state on the surface; None if not before `until`.

        Raises
        ------
        ValueError
            If `until` is inf and the surface is never reached, or is not reached within the limit on steps.
        """

    def state(self, t: float) -> State:
        """State (d,) at time t of this arc."""


class Dynamics(NamedTuple):
    """The functions from which a piecewise solution is put together."""

    start: Callable[[Time, State, int, bool], Arc]
    """(t, x, side, on_surface) -> the arc from there."""
    height: Callable[[Time, State], Time]
    """(t, x) -> g."""
    rate: Callable[[int, Time, State], Time]
    """(side, t, x) -> ġ = g_t + ∇g·f with the field of that side."""
    jump: Callable[[Time, State], State] | None = None
    """(t, x) -> the state (d,) after reaching the surface; None where it is continuous."""


class Solution(Protocol):
    """A reference solution, against which errors are measured."""

    @property
    def name(self) -> str:
        """What it rests on, for display."""

    @property
    def exact(self) -> bool:
        """Whether all that was asked for so far is right to round-off of a double."""

    @property
    def error(self) -> float:
        """Error of what was asked for so far: a bound where the solution is exact, else its own estimate."""

    def crossing(self, k: int) -> tuple[float, NDArray[np.float64]]:
        """Time and state (d,) on the surface of crossing k, from 1 on."""

    def after(self, k: int) -> NDArray[np.float64]:
        """State (d,) from which the solution continues after crossing k."""

    def entered(self, k: int) -> int:
        """Side entered at crossing k, −1 or +1; 0 where sliding begins."""

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
    dynamics : Dynamics
    first : Arc
    max_crossings : int
    error : float
        Its own estimate of its error in the state.
    """

    exact = False

    def __init__(
        self, name: str, dynamics: Dynamics, first: Arc, max_crossings: int = MAX_CROSSINGS, error: float = np.inf
    ) -> None:
        self.name = name
        self.error = error
        self.stop: Stop | None = None  #: set once the solution is known to end
        self._dynamics, self._max_crossings = dynamics, max_crossings
        self._arcs = [first]
        self._times = [float(first.t)]
        self._arrivals = [first.x]  # where each arc was begun, before the jump
        self._largest_height = 0.0

    def crossing(self, k: int) -> tuple[float, NDArray[np.float64]]:
        """Time and state (d,) on the surface of crossing k = 1, 2, …; ValueError if the solution has fewer."""
        t, x, _ = self.crossing_in_digits(k)
        return float(t), x.astype(float)

    def after(self, k: int) -> NDArray[np.float64]:
        """State (d,) from which the solution continues after crossing k: on the surface, or after the jump."""
        return self.crossing_in_digits(k)[2].astype(float)

    def entered(self, k: int) -> int:
        """Side entered at crossing k, −1 or +1."""
        self._extend_to(k)
        return self._arcs[k].side

    def state(self, t: float) -> NDArray[np.float64]:
        """State (d,) at time t ≥ t0, at a crossing the one after its jump; ValueError past the end of the solution."""
        return self.state_in_digits(t).astype(float)

    def side(self, t: float) -> int:
        """Side, −1 or +1, occupied at time t ≥ t0; at a crossing the side entered."""
        return self._arc(t).side

    def crossing_in_digits(self, k: int) -> tuple[Time, State, State]:
        """Time of crossing k, and the states (d,) before and after its jump, unrounded."""
        self._extend_to(k)
        return self._arcs[k].t, self._arrivals[k], self._arcs[k].x

    def arc(self, k: int) -> Arc | None:
        """The arc after crossing k, the first arc for k = 0; None if not computed yet."""
        return self._arcs[k] if k < len(self._arcs) else None

    def state_in_digits(self, t: float) -> State:
        """State (d,) at time t, unrounded."""
        return self._arc(t).state(t)

    def _extend_to(self, k: int) -> None:
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
            self._largest_height = max(self._largest_height, arc.largest_height)
            onward = self._next_arc(arc, t, x)
            if not isinstance(onward, str):
                self._arcs.append(onward)
                self._times.append(float(t))
                self._arrivals.append(x)
                return True
            self.stop = Stop(float(t), x.astype(float), onward)
        if self.stop.t >= until:
            return False
        raise ValueError(f"the solution ends at t = {self.stop.t:.16g}, x = {self.stop.x}: {self.stop.reason}")

    def _next_arc(self, arc: Arc, t: Time, x: State) -> Arc | str:
        """The arc after the crossing at (t, x), or the reason why there is none."""
        tangent = TANGENT * arc.largest_rate
        if -arc.side * self._dynamics.rate(arc.side, t, x) <= tangent:
            return "it touches the surface tangentially"
        if self._accumulates(float(t)):
            return "its crossings accumulate: infinitely many follow in a finite time (Zeno)"
        if self._dynamics.jump is not None:
            return self._arc_after_jump(t, self._dynamics.jump(t, x), tangent)
        onward = -arc.side * self._dynamics.rate(-arc.side, t, x)
        if onward < -tangent:
            return "the field of the other side points back, so it slides along the surface"
        if onward <= tangent:
            return "the field of the other side is tangent to the surface"
        return self._dynamics.start(t, x, -arc.side, True)

    def _arc_after_jump(self, t: Time, x: State, tangent: float) -> Arc | str:
        """The arc after a jump to (t, x), or why there is none; on the surface the fields decide its side."""
        height = self._dynamics.height(t, x)
        if not _finite(*x, height):
            return f"the reset map leads to {x.astype(float)}, where nothing is defined"
        if np.abs(height) > OFF_SURFACE * self._largest_height:
            return self._dynamics.start(t, x, 1 if height > 0 else -1, False)
        below, above = -self._dynamics.rate(-1, t, x) > tangent, self._dynamics.rate(1, t, x) > tangent
        if below and above:
            return "after the reset both fields lead away from the surface"
        if not (below or above):
            return "after the reset neither field leads away from the surface, so it stays there"
        return self._dynamics.start(t, x, 1 if above else -1, True)

    def _accumulates(self, t: float) -> bool:
        """Whether crossings accumulate at t (Zeno): it follows too soon on those before it."""
        crossings = self._times[max(1, len(self._times) - ACCUMULATED) :]
        if len(crossings) == ACCUMULATED and t - crossings[0] < ACCUMULATION * (t - self._times[0]):
            return True
        return len(crossings) >= 2 and t - crossings[-2] <= GAP_ULPS * np.spacing(abs(t))


def first_arc(dynamics: Dynamics, t: Time, x: State, round_off: Time) -> Arc:
    """The arc from (t, x): its side is the sign of g or, where |g| ≤ `round_off`, that to which both fields point."""
    height = dynamics.height(t, x)
    if not _finite(t, *x, height):
        raise ValueError(f"the start t0 = {float(t)}, x0 = {x.astype(float)}, with g = {float(height)}, must be finite")
    if np.abs(height) > round_off:
        return dynamics.start(t, x, 1 if height > 0 else -1, False)
    below, above = dynamics.rate(-1, t, x), dynamics.rate(1, t, x)
    if below < 0 and above < 0:
        return dynamics.start(t, x, -1, True)
    if below > 0 and above > 0:
        return dynamics.start(t, x, 1, True)
    kind = "attracts both fields (sliding)" if below > 0 > above else "repels both, or is tangent to one"
    raise ValueError(f"x0 = {x.astype(float)} is on the surface, which there {kind}: no side to start on")


def _finite(*numbers: Time) -> bool:
    return bool(np.isfinite([float(u) for u in numbers]).all())
