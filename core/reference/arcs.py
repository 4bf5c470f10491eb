"""Arcs of exact solutions: power series in many digits, from the surface until they next reach it."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.interface.cancelling import Cancel, raise_if
from core.reference.first_root import FirstRoot, newton, zero_between
from core.reference.powers import GUARD, Field, Step
from core.reference.program import Digits
from core.reference.solution import State
from core.reference.surface import Enclosure, Polynomial, Surface

__all__ = ["ExactArc", "Level"]

#: Most steps of one arc, some 300 turns, before the search for a crossing is given up.
_MAX_STEPS = 2000
#: Step, relative to the time since the start of the arc, below which the solution may be at a pole.
_POLE = 2.0**-40
#: Least growth of the state, relative to the start of the arc, that is taken for a pole.
_GROWN = 2.0**20
#: Size of a state above which no crossing is sought, so that products of some states stay within doubles.
_LARGEST = 1e100
#: Successive steps without a change after which the solution is at rest: some hundred time constants.
_RESTING = 64
#: Part of the bits to which a root is found; |g| at a minimum that is smaller still counts as touching.
_TOUCH = 0.75
#: Part of the bits to which a state has to return for its orbit to be closed.
_CLOSED = 0.5
#: Relative half-width of the bracket around a crossing that fewer digits have found.
_EXPECTED = 2.0**-30


class Level(NamedTuple):
    """A precision, with the fields and the surface to evaluate in it, and what tells whether to stop."""

    digits: Digits
    fields: Mapping[int, Field]
    surface: Surface
    cancel: Cancel | None = None


class ExactArc:
    """An arc along an exact flow, expanded step by step as far as is asked for.

    If the same arc is known in fewer digits, its crossing is sought near the one found there.

    Parameters
    ----------
    level
    t, x
        Time, and state (d,), in many digits.
    side
        −1 or +1.
    on_surface
        Whether the arc starts on the surface.
    guide
        The same arc in fewer digits.
    """

    def __init__(
        self, level: Level, t: Any, x: State, side: int, on_surface: bool, guide: ExactArc | None = None
    ) -> None:
        self.t, self.x, self.side = t, x, side
        self._largest_height = self._largest_rate = 0.0
        self.found: tuple[Any, State] | None = None  #: time and state of its arrival on the surface, once known
        self.decided_by_bounds = True  #: whether bounds decided where it ends; else more digits could change that
        self._level, self._leaving, self._guide = level, on_surface, guide
        self._context = level.digits.context
        self._eps = self._context.ldexp(1, -int(_TOUCH * (self._context.prec - GUARD)))
        self._round_off = self._context.ldexp(1, GUARD - self._context.prec)
        self._steps: list[Step] = []
        self._unchanged_steps = 0  # steps in a row that changed nothing
        self._end, self._last, self._unit = self._context.mpf(0), x, level.fields[side].unit(level.digits, x)
        self._no_arrival = ""  # why the arc never reaches the surface, once known
        self._period: Any = None  # of a closed orbit, once known to be one
        self._origin: NDArray[np.float64] | None = None  # (2, d): the first step's coefficients of orders 0 and 1

    @property
    def largest_height(self) -> float:
        """Largest |g| seen on it."""
        return max(self._largest_height, self._guide.largest_height) if self._guide else self._largest_height

    @property
    def largest_rate(self) -> float:
        """Largest |ġ| seen on it."""
        return max(self._largest_rate, self._guide.largest_rate) if self._guide else self._largest_rate

    def arrival(self, until: float) -> tuple[Any, State] | None:
        """First time and state on the surface; None if not before `until`."""
        while self.found is None and not self._no_arrival and self.t + self._end < until:
            self._extend()
        if self._no_arrival and until == np.inf:
            raise ValueError(
                f"the solution never reaches the surface after t = {float(self.t):.17g}: {self._no_arrival}"
            )
        return self.found

    def state(self, t: float) -> State:
        """State (d,) at time t of this arc."""
        elapsed = self._context.mpf(t) - self.t
        if self._period:
            elapsed -= self._period * self._context.floor(elapsed / self._period)
        if not self._steps:
            self._extend()
        if self._no_arrival and not self._period and elapsed > self._end:
            raise ValueError(f"no state at t = {t}: {self._no_arrival}")
        number = bisect_right(self._steps, elapsed, key=lambda step: step.start)
        return self._steps[max(number - 1, 0)].at(elapsed)

    def _extend(self) -> None:
        """Take a step, and find the first crossing on it."""
        raise_if(self._level.cancel)
        if len(self._steps) == _MAX_STEPS:
            last = float(self._end)
            raise ValueError(f"no crossing found in {_MAX_STEPS} steps, up to {last:.6g} after the last one")
        step = self._level.fields[self.side].step(self._level.digits, self._end, self._last, self._unit)
        self._steps.append(step)
        self._end += step.span
        before, self._last, self._unit = self._last, step.at(self._end), step.next_unit
        unchanged = np.abs(self._last - before).max() <= np.abs(self._last).max() * self._round_off
        self._unchanged_steps = self._unchanged_steps + 1 if unchanged else 0
        if not self._search_near_guide(step):
            self._search(step)
        self._leaving = False

    def _search_near_guide(self, step: Step) -> bool:
        """Seek the crossing near that in fewer digits; True if found there, or known to lie on a later step."""
        if self._guide is None or self._guide.found is None or not self._guide.decided_by_bounds:
            return False
        expected = self._context.mpf(self._guide.found[0]) - self.t
        if expected > self._end:
            return True
        view = _View(self._level, self.t, self.side, step)
        part, away = view.part(expected), view.part(expected * (1 + _EXPECTED)) - view.part(expected)
        low, high = part - away, part + away
        if not view.evaluate(low)[0] > 0 >= view.evaluate(high)[0]:
            return False
        self.found = view.place(newton(view.evaluate, low, high, part, self._eps))
        return True

    def _search(self, step: Step) -> None:
        """Find the first crossing on a step by bounds over all of it."""
        view = _View(self._level, self.t, self.side, step)
        search = FirstRoot(view, self._context.mpf, self._eps, self._leaving)
        part = search.find()
        self._largest_height = max(self._largest_height, view.largest_height)
        self._largest_rate = max(self._largest_rate, view.largest_rate)
        self.decided_by_bounds = self.decided_by_bounds and not search.decided_by_digits
        if part is None:
            self._unit = min(self._unit, step.unit) if search.divided else self._unit
            self._find_no_arrival(step, view.states)
        elif self._context.isfinite(view.evaluate(part)[0]):
            self.found = view.place(part)
        else:
            self._no_arrival = f"g is not defined after t = {float(view.place(part)[0]):.17g}"

    def _find_no_arrival(self, step: Step, states: Polynomial) -> None:
        """Note if no crossing can follow: at a pole, or, where the surface is at rest, at rest or on a closed orbit."""
        if self._origin is None:
            self._origin = self._steps[0].polynomial()[:2]
        if np.abs(self._last).max() > _LARGEST:
            self._no_arrival = f"it grows beyond {_LARGEST:g} by t = {float(self.t + self._end):.17g}"
        elif step.span < _POLE * self._end and np.abs(self._last).max() > _GROWN * np.abs(self.x).max():
            self._no_arrival = f"it escapes to infinity at t = {float(self.t + self._end):.17g}"
        elif self._level.surface.moves:
            return
        elif not self._origin[1].any() or self._unchanged_steps == _RESTING:
            self._no_arrival = f"it comes to rest at {self._last.astype(float)}"
        elif (period := self._closing_time(self._origin, step, states)) is not None:
            self._period, self._no_arrival = period, f"its orbit closes after a period {float(period):.17g}"

    def _closing_time(self, origin: NDArray[np.float64], step: Step, states: Polynomial) -> Any | None:
        """Elapsed time on a step at which the orbit returns to its start through the plane normal to it, or None."""
        n = len(states.coefficients)
        away = states.grid(n) - origin[0]
        ahead, distance = away @ origin[1], np.abs(away).max(axis=1)
        near = np.minimum(distance[1:], distance[:-1]) < np.abs(np.diff(away, axis=0)).max(axis=1)
        least = self._context.ldexp(np.abs(self.x).max(), -int(_CLOSED * (self._context.prec - GUARD)))
        for k in np.flatnonzero((ahead[:-1] < 0) & (ahead[1:] >= 0) & near):
            low, high = (step.start + self._context.mpf(int(m)) / (n - 1) * step.span for m in (k, k + 1))
            time = zero_between(lambda s: origin[1] @ (step.at(s) - self.x), low, high, self._eps)
            if np.abs(step.at(time) - self.x).max() <= least:
                return time
        return None


class _View:
    """side·g (positive inside) and its rate over one step, as functions of the part of it, from 0 to 1."""

    def __init__(self, level: Level, t: Any, side: int, step: Step) -> None:
        self.states = Polynomial(step)
        self.largest_height = self.largest_rate = 0.0
        self._level, self._t, self._side, self._step = level, t, side, step
        self._begin, self._span = float(t + step.start), float(step.span)

    def part(self, elapsed: Any) -> Any:
        """Part of the step at an elapsed time of the arc."""
        return (elapsed - self._step.start) / self._step.span

    def place(self, part: Any) -> tuple[Any, State]:
        """Time and state (d,)."""
        elapsed = self._step.start + part * self._step.span
        return self._t + elapsed, self._step.at(elapsed)

    def evaluate(self, part: Any) -> tuple[Any, Any]:
        """In many digits."""
        t, x = self.place(part)
        height, rate = self._level.surface.evaluate(self._level.digits, self._side, t, x)
        return self._side * height, self._side * rate * self._step.span

    def evaluate_in_doubles(self, part: float) -> tuple[float, float]:
        """In doubles."""
        t, x = self._begin + part * self._span, self.states.at(part)
        height, rate = self._level.surface.evaluate_in_doubles(self._side, t, x)
        return self._side * height, self._side * rate * self._span

    def enclose(self, edges: NDArray[np.float64]) -> Enclosure:
        """Bounds over the equal pieces between the edges (m + 1,)."""
        found = self._level.surface.enclose(self._side, self._begin, self._span, self.states, edges)
        self.largest_height = max(self.largest_height, found.largest_height)
        self.largest_rate = max(self.largest_rate, found.largest_rate)
        return found
