"""A piecewise smooth solution, extended from crossing to crossing as it is asked for.

The mode is carried, never read from the sign of g near a surface. The solution ends, with a reason in words, where it
cannot be continued: see `transitions`.
"""

from __future__ import annotations

from bisect import bisect_right
from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from core.reference.search import Time

__all__ = [
    "MAX_CROSSINGS", "Arc", "Arrival", "Ending", "ReferenceSolution", "Rules", "Solution", "State", "Stop",
]  # fmt: skip

State: TypeAlias = NDArray[Any]  # (d,) of numbers of the same kind as time

#: Most crossings of a solution, where not given.
MAX_CROSSINGS = 100_000


class Ending(NamedTuple):
    """Why no arc follows a crossing."""

    reason: str
    unknown: bool = False
    """Whether the solution does continue, in a mode whose field has no known closed form."""
    doubtful: bool = False
    """Whether a rate that is too small to be told from zero decides, so that more digits may show how it goes on."""


class Stop(NamedTuple):
    """Where, when and why a solution ends."""

    t: float
    x: NDArray[np.float64]
    reason: str
    unknown: bool = False
    """As in `Ending`."""
    doubtful: bool = False
    """As in `Ending`."""

    @property
    def where(self) -> str:
        """Time and state in words: “t = 1.25, x = (0, -1)”."""
        return f"t = {self.t:.16g}, x = ({', '.join(f'{value:.6g}' for value in self.x)})"


class Arrival(NamedTuple):
    """Where an arc ends."""

    t: Time
    x: State
    guard: int = 0
    """Number of the guard of its mode that vanishes."""
    at_once: bool = False
    """Whether the arc began beyond that guard, or at its zero with a field that leads out of the mode."""


class Arc(Protocol):
    """A piece of the solution in one mode, from (t, x) until the first of its guards vanishes."""

    mode: int
    t: Time
    x: State

    def largest_height(self, guard: int) -> float:
        """Largest height of a guard found on it."""

    def largest_rate(self, guard: int) -> float:
        """Largest rate of a guard found on it, in size."""

    def arrival(self, until: float) -> Arrival | None:
        """Where a guard vanishes first; None if not before `until`.

        Raises
        ------
        ValueError
            If `until` is inf and no guard ever vanishes, or none does within the limit on steps.
        """

    def state(self, t: float) -> State:
        """State (d,) at time t of this arc."""


class Rules(Protocol):
    """What begins a solution, and what follows where an arc ends."""

    def first(self, t: Time, x: State) -> Arc:
        """The arc from an initial value; ValueError if there is none."""

    def onward(self, arc: Arc, met: Arrival) -> Arc | Ending:
        """The arc that follows another one, or why there is none."""

    def label(self, mode: int) -> int:
        """What tells a mode apart for the user: see `Laws.label`."""


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

    @property
    def stop(self) -> Stop | None:
        """Where, when and why it ends, once that is known."""

    def crossing(self, k: int) -> tuple[float, NDArray[np.float64]]:
        """Time and state (d,) on the surface of crossing k, from 1 on."""

    def after(self, k: int) -> NDArray[np.float64]:
        """State (d,) from which the solution continues after crossing k."""

    def entered(self, k: int) -> int:
        """Side entered at crossing k, −1 or +1; 0 where sliding begins. Of several surfaces the number of the mode."""

    def count(self, t: float) -> int:
        """Number of crossings up to time t; ValueError past the end of the solution."""

    def state(self, t: float) -> NDArray[np.float64]:
        """State (d,) at time t."""

    def side(self, t: float) -> int:
        """Side occupied at time t; 0 while sliding. Of several surfaces the number of the mode."""


class ReferenceSolution:
    """Piecewise smooth solution from (t, x), extended lazily from crossing to crossing.

    Parameters
    ----------
    name : str
        What it rests on, for display.
    rules : Rules
    t, x
        Initial time and state (d,).
    max_crossings : int
    error : float
        Its own estimate of its error in the state.
    """

    exact = False

    def __init__(
        self, name: str, rules: Rules, t: Time, x: State, max_crossings: int = MAX_CROSSINGS, error: float = np.inf
    ) -> None:
        self.name = name
        self.error = error
        self.stop: Stop | None = None  #: set once the solution is known to end
        self._rules, self._max_crossings = rules, max_crossings
        self._arcs = [rules.first(t, x)]
        self._times = [float(t)]
        self._arrivals = [x]  # where each arc was begun, before the jump

    def crossing(self, k: int) -> tuple[float, NDArray[np.float64]]:
        """Time and state (d,) on the surface of crossing k = 1, 2, …; ValueError if the solution has fewer."""
        t, x, _ = self.crossing_in_digits(k)
        return float(t), x.astype(float)

    def after(self, k: int) -> NDArray[np.float64]:
        """State (d,) from which the solution continues after crossing k: on the surface, or after the jump."""
        return self.crossing_in_digits(k)[2].astype(float)

    def entered(self, k: int) -> int:
        """Side entered at crossing k, −1 or +1; 0 where sliding begins. Of several surfaces the number of the mode."""
        self._extend_to(k)
        return self._rules.label(self._arcs[k].mode)

    def state(self, t: float) -> NDArray[np.float64]:
        """State (d,) at time t ≥ t0, at a crossing the one after its jump; ValueError past the end of the solution."""
        return self.state_in_digits(t).astype(float)

    def side(self, t: float) -> int:
        """Side, −1 or +1, occupied at time t ≥ t0, at a crossing the side entered; 0 while sliding.

        Of several surfaces the number of the mode.
        """
        return self._rules.label(self._arc(t).mode)

    def count(self, t: float) -> int:
        """Number of crossings up to time t ≥ t0, later ones not searched; ValueError past the end of the solution."""
        self._arc(t)
        return bisect_right(self._times, t) - 1

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
            met = arc.arrival(until)
            if met is None or met.t > until:
                return False
            onward = self._rules.onward(arc, met)
            if not isinstance(onward, Ending):
                self._arcs.append(onward)
                self._times.append(float(met.t))
                self._arrivals.append(met.x)
                return True
            self.stop = Stop(float(met.t), met.x.astype(float), *onward)
        if self.stop.t >= until:
            return False
        raise ValueError(f"the solution ends at {self.stop.where}: {self.stop.reason}")
