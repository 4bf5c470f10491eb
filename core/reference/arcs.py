"""Arcs of exact solutions: power series to many digits, from the surface until they next reach it."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.reference.first_root import FirstRoot, newton, zero_between
from core.reference.powers import GUARD, Field, Step
from core.reference.program import Digits
from core.reference.solution import State
from core.reference.surface import Enclosure, Polynomial, Surface

__all__ = ["ExactArc", "Level"]

_MAX_STEPS = 2000  # of one arc: some 300 turns
_POLE = 2.0**-40  # relative distance to a pole at which the search for a crossing ends
_GROWN = 2.0**20  # times the start's size that a state there is at least
_LARGEST = 1e100  # size of a state above which no crossing is looked for: its square is no double any more soon
_RESTING = 64  # steps in a row that change nothing, after which the solution is at rest: some hundred time constants
_TOUCH = 0.75  # part of the bits of which a root is one: what is lower than all of them, touches
_CLOSED = 0.5  # part of the bits to which a closed orbit comes back
_EXPECTED = 2.0**-30  # relative error that a crossing expected from fewer digits may have


class Level(NamedTuple):
    """A precision, and what to work out at it."""

    digits: Digits
    fields: Mapping[int, Field]
    surface: Surface


class ExactArc:
    """An arc along an exact flow, expanded from its start on as far as anyone asked.

    Where the same arc has been worked out to fewer digits, its crossing is looked for around that one.
    """

    def __init__(
        self, level: Level, t: Any, x: State, side: int, on_surface: bool, guide: ExactArc | None = None
    ) -> None:
        self.t, self.x, self.side = t, x, side
        self._deepest = self._steepest = 0.0
        self.found: tuple[Any, State] | None = None  #: time and state of its end on the surface, once known
        self.clear = True  #: whether bounds alone told where it ends, without a near thing that digits decided
        self._level, self._leaving, self._guide = level, on_surface, guide
        self._context = level.digits.context
        self._eps = self._context.ldexp(1, -int(_TOUCH * (self._context.prec - GUARD)))
        self._round_off = self._context.ldexp(1, GUARD - self._context.prec)
        self._steps: list[Step] = []
        self._still = 0  # steps in a row that changed nothing
        self._end, self._last, self._unit = self._context.mpf(0), x, level.fields[side].unit(level.digits, x)
        self._fate = ""  # why it never reaches the surface, once known
        self._period: Any = None  # once it is known to be closed
        self._course: NDArray[np.float64] | None = None  # its start, and direction there

    @property
    def deepest(self) -> float:
        """Largest |g| seen on it."""
        return max(self._deepest, self._guide.deepest) if self._guide else self._deepest

    @property
    def steepest(self) -> float:
        """Largest |ġ| seen on it."""
        return max(self._steepest, self._guide.steepest) if self._guide else self._steepest

    def arrival(self, until: float) -> tuple[Any, State] | None:
        """First time and state on the surface; None if not before `until`."""
        while self.found is None and not self._fate and self.t + self._end < until:
            self._extend()
        if self._fate and until == np.inf:
            raise ValueError(f"the solution never reaches the surface after t = {float(self.t):.17g}: {self._fate}")
        return self.found

    def state(self, t: float) -> State:
        """State (d,) at time t of this arc."""
        elapsed = self._context.mpf(t) - self.t
        if self._period:
            elapsed -= self._period * self._context.floor(elapsed / self._period)
        if not self._steps:
            self._extend()
        if self._fate and not self._period and elapsed > self._end:
            raise ValueError(f"no state at t = {t}: {self._fate}")
        number = bisect_right(self._steps, elapsed, key=lambda step: step.start)
        return self._steps[max(number - 1, 0)].at(elapsed)

    def _extend(self) -> None:
        """Take a step, and keep the first crossing on it."""
        if len(self._steps) == _MAX_STEPS:
            last = float(self._end)
            raise ValueError(f"no crossing found in {_MAX_STEPS} steps, up to {last:.6g} after the last one")
        step = self._level.fields[self.side].step(self._level.digits, self._end, self._last, self._unit)
        self._steps.append(step)
        self._end += step.span
        before, self._last, self._unit = self._last, step.at(self._end), step.next_unit
        unchanged = np.abs(self._last - before).max() <= np.abs(self._last).max() * self._round_off
        self._still = self._still + 1 if unchanged else 0
        if not self._meets(step):
            self._search(step)
        self._leaving = False

    def _meets(self, step: Step) -> bool:
        """Find the crossing where fewer digits say it is; whether they do, and it is there or on a later step."""
        if self._guide is None or self._guide.found is None or not self._guide.clear:
            return False
        expected = self._context.mpf(self._guide.found[0]) - self.t
        if expected > self._end:
            return True
        view = _View(self._level, self.t, self.side, step)
        part, away = view.part(expected), view.part(expected * (1 + _EXPECTED)) - view.part(expected)
        low, high = part - away, part + away
        if not view.look(low)[0] > 0 >= view.look(high)[0]:
            return False
        self.found = view.place(newton(view.look, low, high, part, self._eps))
        return True

    def _search(self, step: Step) -> None:
        """Look for the first crossing on a step, by bounds on all of it."""
        view = _View(self._level, self.t, self.side, step)
        search = FirstRoot(view, self._context.mpf, self._eps, self._leaving)
        part = search.find()
        self._deepest, self._steepest = max(self._deepest, view.deepest), max(self._steepest, view.steepest)
        self.clear = self.clear and not search.close
        if part is None:
            self._unit = min(self._unit, step.unit) if search.divided else self._unit
            self._foresee(step, view.states)
        elif self._context.isfinite(view.look(part)[0]):
            self.found = view.place(part)
        else:
            self._fate = f"g is not defined after t = {float(view.place(part)[0]):.17g}"

    def _foresee(self, step: Step, states: Polynomial) -> None:
        """Whether no crossing can follow: at a pole, and on a closed orbit beside a surface that stands still."""
        if self._course is None:
            self._course = self._steps[0].polynomial()[:2]
        if np.abs(self._last).max() > _LARGEST:
            self._fate = f"it grows beyond {_LARGEST:g} by t = {float(self.t + self._end):.17g}"
        elif step.span < _POLE * self._end and np.abs(self._last).max() > _GROWN * np.abs(self.x).max():
            self._fate = f"it escapes to infinity at t = {float(self.t + self._end):.17g}"
        elif self._level.surface.moves:
            return
        elif not self._course[1].any() or self._still == _RESTING:
            self._fate = f"it comes to rest at {self._last.astype(float)}"
        elif (period := self._return(self._course, step, states)) is not None:
            self._period, self._fate = period, f"its orbit closes after a period {float(period):.17g}"

    def _return(self, course: NDArray[np.float64], step: Step, states: Polynomial) -> Any | None:
        """Elapsed time on a step at which the orbit comes back to its start, through the plane across the flow."""
        n = len(states.coefficients)
        away = states.grid(n) - course[0]
        ahead, distance = away @ course[1], np.abs(away).max(axis=1)
        near = np.minimum(distance[1:], distance[:-1]) < np.abs(np.diff(away, axis=0)).max(axis=1)
        least = self._context.ldexp(np.abs(self.x).max(), -int(_CLOSED * (self._context.prec - GUARD)))
        for k in np.flatnonzero((ahead[:-1] < 0) & (ahead[1:] >= 0) & near):
            low, high = (step.start + self._context.mpf(int(m)) / (n - 1) * step.span for m in (k, k + 1))
            time = zero_between(lambda s: course[1] @ (step.at(s) - self.x), low, high, self._eps)
            if np.abs(step.at(time) - self.x).max() <= least:
                return time
        return None


class _View:
    """side·g (positive inside) and its rate over one step, in parts of it from 0 to 1."""

    def __init__(self, level: Level, t: Any, side: int, step: Step) -> None:
        self.states = Polynomial(step)
        self.deepest = self.steepest = 0.0
        self._level, self._t, self._side, self._step = level, t, side, step
        self._begin, self._span = float(t + step.start), float(step.span)

    def part(self, elapsed: Any) -> Any:
        """Part of the step of an elapsed time of the arc."""
        return (elapsed - self._step.start) / self._step.span

    def place(self, part: Any) -> tuple[Any, State]:
        """Time and state (d,)."""
        elapsed = self._step.start + part * self._step.span
        return self._t + elapsed, self._step.at(elapsed)

    def look(self, part: Any) -> tuple[Any, Any]:
        """To many digits."""
        t, x = self.place(part)
        height, rate = self._level.surface.look(self._level.digits, self._side, t, x)
        return self._side * height, self._side * rate * self._step.span

    def glance(self, part: float) -> tuple[float, float]:
        """In doubles."""
        t, x = self._begin + part * self._span, self.states.at(part)
        height, rate = self._level.surface.glance(self._side, t, x)
        return self._side * height, self._side * rate * self._span

    def enclose(self, edges: NDArray[np.float64]) -> Enclosure:
        """Bounds over equal pieces."""
        found = self._level.surface.enclose(self._side, self._begin, self._span, self.states, edges)
        self.deepest, self.steepest = max(self.deepest, found.deepest), max(self.steepest, found.steepest)
        return found
