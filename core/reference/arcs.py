"""Arcs of exact solutions: power series in many digits, from where a mode is entered to where a guard vanishes."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, NamedTuple, NoReturn

import numpy as np
import sympy
from numpy.typing import NDArray

from core.interface.cancelling import Cancel, raise_if
from core.reference.first_root import FirstRoot, TooLongError, newton, zero_between
from core.reference.guard import Enclosure, Guard, Polynomial
from core.reference.powers import GUARD, Field, Step
from core.reference.slow_flow import FastPart, SlowFlow
from core.reference.solution import Arrival, State
from core.reference.transitions import Entry
from core.symbolic.program import Digits

__all__ = ["ExactArc", "Level", "Motion", "zero_of"]

#: Most steps of one arc, some 300 turns, before the search for a crossing is given up.
_MAX_STEPS = 2000
#: Steps of an arc after which parts that decay are looked for: fewer take less time.
_FEW = 12
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
#: Pieces in whose middles the size of a height and of its rate is taken.
_LOOKS = 12
#: Most times that a step of one arc is begun anew because bounds over it tell nothing.
_MAX_SHORTENED = 64
#: Relative half-width of the bracket around a crossing that fewer digits have found.
_EXPECTED = 2.0**-30


class Motion:
    """A mode in exact expressions: its field, and the heights that end it where they vanish.

    Parameters
    ----------
    field : d expressions
        In the variables.
    heights : expressions
        In the variables and time, positive inside the mode.
    variables : d symbols
    """

    def __init__(
        self, field: Sequence[sympy.Expr], heights: Sequence[sympy.Expr], variables: Sequence[sympy.Symbol]
    ) -> None:
        self.field = Field(field, variables)
        self.guards = [Guard(height, field, variables) for height in heights]
        self.moves = any(guard.moves for guard in self.guards)
        self._laws = field, heights, variables
        self._slow: dict[Digits, tuple[SlowFlow, Motion] | None] = {}

    @cached_property
    def _fast_part(self) -> FastPart | None:
        field, _, variables = self._laws
        return FastPart.of(field, variables)

    def on_slow_flow(self, digits: Digits, x: State, least: Any) -> tuple[Motion, State] | None:
        """The mode and the state (d,) without a fast part, if there is one that is at most `least` times the state."""
        if self._fast_part is None:
            return None
        if digits not in self._slow:
            flow, (_, heights, variables) = self._fast_part.left_out(digits), self._laws
            self._slow[digits] = None if flow is None else (flow, Motion(flow.field, heights, variables))
        if (slow := self._slow[digits]) is None or (on := slow[0].entered(digits, x, least)) is None:
            return None
        return slow[1], on


class Level(NamedTuple):
    """A precision, with the modes to evaluate in it, and what tells whether to stop."""

    digits: Digits
    motion: Callable[[int], Motion]
    cancel: Cancel | None = None


class ExactArc:
    """An arc along an exact flow, expanded step by step as far as is asked for.

    If the same arc is known in fewer digits, its end is sought near the one found there.

    Parameters
    ----------
    level
    t, x
        Time, and state (d,), in many digits.
    entry
        The mode, and how it begins.
    guide
        The same arc in fewer digits.
    """

    def __init__(self, level: Level, t: Any, x: State, entry: Entry, guide: ExactArc | None = None) -> None:
        self.t, self.x, self.mode = t, x, entry.mode
        self.found: Arrival | None = None if entry.past is None else Arrival(t, x, entry.past, at_once=True)
        """Where it ends, once known."""
        self.decided_by_bounds = True  #: whether bounds decided where it ends; else more digits could change that
        self._level, self._motion, self._entry = level, level.motion(entry.mode), entry
        self._guide = guide if guide is not None and guide.mode == entry.mode else None
        self._largest_heights, self._largest_rates = np.zeros((2, len(self._motion.guards)))
        self._context = level.digits.context
        self._eps = zero_of(level.digits)
        self._round_off = self._context.ldexp(1, GUARD - self._context.prec)
        self._steps: list[Step] = []
        self._unchanged_steps = 0  # steps in a row that changed nothing
        self._shortened = 0  # times that a step was too long
        self._end, self._last = self._context.mpf(0), x
        self._unit = self._motion.field.unit(level.digits, x)
        self._no_arrival = ""  # why it never ends, once known
        self._undefined_after: Any = None  # elapsed time after which a guard is not defined, once known
        self._rests = False  # whether it never moves
        self._period: Any = None  # of a closed orbit, once known to be one
        self._origin: NDArray[np.float64] | None = None  # (2, d): the first step's coefficients of orders 0 and 1

    def largest_height(self, guard: int) -> float:
        """Largest height of a guard seen on it."""
        here = float(self._largest_heights[guard])
        return max(here, self._guide.largest_height(guard)) if self._guide else here

    def largest_rate(self, guard: int) -> float:
        """Largest rate of a guard seen on it, in size."""
        here = float(self._largest_rates[guard])
        return max(here, self._guide.largest_rate(guard)) if self._guide else here

    def arrival(self, until: float) -> Arrival | None:
        """Where a guard vanishes first; None if not before `until`."""
        while self.found is None and not self._no_arrival and self.t + self._end < until:
            if until == np.inf and self._unchanged_steps >= _RESTING and not self._motion.moves:
                self._never(f"it comes to rest at {self._last.astype(float)}")
            self._extend()
        if self._no_arrival and until == np.inf:
            self._never(self._no_arrival)
        return self.found

    def _never(self, reason: str) -> NoReturn:
        raise ValueError(f"no crossing follows after t = {float(self.t):.17g}: {reason}")

    def state(self, t: float) -> State:
        """State (d,) at time t of this arc."""
        elapsed = self._context.mpf(t) - self.t
        if self._period:
            elapsed -= self._period * self._context.floor(elapsed / self._period)
        while not self._steps:
            self._extend()
        if self._no_arrival and not self._period and not self._rests and elapsed > self._end:
            raise ValueError(f"no state at t = {t}: {self._no_arrival}")
        number = bisect_right(self._steps, elapsed, key=lambda step: step.start)
        return self._steps[max(number - 1, 0)].at(elapsed)

    def _extend(self) -> None:
        """Take a step, and find the first zero of a guard on it; a step over which bounds tell nothing is not taken."""
        raise_if(self._level.cancel)
        if len(self._steps) == _MAX_STEPS:
            last = float(self._end)
            up_to = f", up to {last:.6g} after the last one" if math.isfinite(last) else ""
            raise ValueError(f"no crossing found in {_MAX_STEPS} steps{up_to}")
        self._leave_out_decayed_parts()
        step = self._motion.field.step(self._level.digits, self._end, self._last, self._unit)
        states = Polynomial(step)
        try:
            divided = None if self._search_near_guide(step, states) else self._search(step, states)
        except TooLongError as error:
            self._shorten(step, error)
            return
        self._steps.append(step)
        self._end = step.start + step.span if self._undefined_after is None else self._undefined_after
        before, self._last = self._last, step.at(self._end)
        self._unit = min(step.next_unit, step.unit) if divided else step.next_unit
        unchanged = np.abs(self._last - before).max() <= np.abs(self._last).max() * self._round_off
        self._unchanged_steps = self._unchanged_steps + 1 if unchanged else 0
        if divided is not None and self.found is None and not self._no_arrival:
            self._find_no_arrival(step, states)

    def _shorten(self, step: Step, error: TooLongError) -> None:
        """Begin the next step anew, shorter: the surface moves, or g varies, much faster than the state."""
        if self._shortened == _MAX_SHORTENED:
            last = float(self.t + self._end)
            raise ValueError(f"no crossing found: g varies too fast after t = {last:.17g}") from None
        self._shortened += 1
        self._unit = step.unit + math.floor(math.log2(error.part))

    def _leave_out_decayed_parts(self) -> None:
        """Go on without the parts of the state that have decayed below the precision, so that steps may be longer."""
        digits = self._level.digits
        while len(self._steps) >= _FEW and (slow := self._motion.on_slow_flow(digits, self._last, self._round_off)):
            self._motion, self._last = slow
            self._unit = self._motion.field.unit(digits, self._last)

    def _search_near_guide(self, step: Step, states: Polynomial) -> bool:
        """Seek the end near that in fewer digits; True if found there, or known to lie on a later step."""
        if self._guide is None or self._guide.found is None or not self._guide.decided_by_bounds:
            return False
        near = self._guide.found
        expected = self._context.mpf(near.t) - self.t
        if expected > step.start + step.span:
            return True
        view = _View(self._level.digits, self._motion.guards[near.guard], self.t, step, states)
        part, away = view.part(expected), view.part(expected * (1 + _EXPECTED)) - view.part(expected)
        low, high = part - away, part + away
        if not view.evaluate(low)[0] > 0 >= view.evaluate(high)[0]:
            return False
        found = Arrival(*view.place(newton(view.evaluate, low, high, part, self._eps)), near.guard)
        others = (guard for k, guard in enumerate(self._motion.guards) if k != near.guard)
        if any(guard.evaluate(self._level.digits, found.t, found.x)[0] <= 0 for guard in others):
            return False  # more digits may show that another guard vanishes first
        self.found = found
        return True

    def _search(self, step: Step, states: Polynomial) -> bool:
        """Find the first zero of a guard on a step by bounds over all of it; whether pieces of it had to be cut."""
        first, divided, undefined = None, False, False
        views = [_View(self._level.digits, guard, self.t, step, states) for guard in self._motion.guards]
        for k, view in enumerate(views):
            leaving = not self._steps and k in self._entry.at
            search = FirstRoot(view, self._context.mpf, self._eps, leaving, leaving and self._entry.folded)
            part = search.find(1.0 if first is None else float(first[0]))
            self.decided_by_bounds = self.decided_by_bounds and not search.decided_by_digits
            divided = divided or search.divided
            if part is not None and (first is None or part < first[0]):
                first, undefined = (part, k), search.undefined
        heights, rates = zip(*(view.sizes(1.0 if first is None else float(first[0])) for view in views), strict=True)
        self._largest_heights = np.maximum(self._largest_heights, heights)
        self._largest_rates = np.maximum(self._largest_rates, rates)
        if first is not None:
            t, x = views[first[1]].place(first[0])
            if undefined:
                self._no_arrival, self._undefined_after = f"g is not defined after t = {float(t):.17g}", t - self.t
            else:
                self.found = Arrival(t, x, first[1])
        return divided

    def _find_no_arrival(self, step: Step, states: Polynomial) -> None:
        """Note if no guard can vanish: at a pole, or, where the surfaces do not move, at rest or on a closed orbit."""
        if self._origin is None:
            self._origin = self._steps[0].polynomial()[:2]
        if np.abs(self._last).max() > _LARGEST:
            self._no_arrival = f"it grows beyond {_LARGEST:g} by t = {float(self.t + self._end):.17g}"
        elif step.span < _POLE * self._end and np.abs(self._last).max() > _GROWN * np.abs(self.x).max():
            self._no_arrival = f"it escapes to infinity at t = {float(self.t + self._end):.17g}"
        elif self._motion.moves:
            return
        elif not self._origin[1].any():
            self._rests, self._no_arrival = True, f"it is at rest at {self._last.astype(float)}"
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
    """The height of a guard and its rate over one step, as functions of the part of it, from 0 to 1."""

    def __init__(self, digits: Digits, guard: Guard, t: Any, step: Step, states: Polynomial) -> None:
        self._digits, self._guard, self._t, self._step, self._states = digits, guard, t, step, states
        self._begin, self.span = float(t + step.start), float(step.span)
        self.shortest = 4 * float(np.spacing(self._begin + self.span))

    def part(self, elapsed: Any) -> Any:
        """Part of the step at an elapsed time of the arc."""
        return (elapsed - self._step.start) / self._step.span

    def place(self, part: Any) -> tuple[Any, State]:
        """Time and state (d,)."""
        elapsed = self._step.start + part * self._step.span
        return self._t + elapsed, self._step.at(elapsed)

    def evaluate(self, part: Any) -> tuple[Any, Any]:
        """In many digits."""
        height, rate = self._guard.evaluate(self._digits, *self.place(part))
        return height, rate * self._step.span

    def sizes(self, part: float) -> tuple[float, float]:
        """Largest height, and largest rate in time, up to a part of the step."""
        with np.errstate(all="ignore"):
            found = self.enclose(np.linspace(0.0, part, _LOOKS + 1))
        return found.largest_height, found.largest_rate

    def evaluate_in_doubles(self, part: float) -> tuple[float, float]:
        """In doubles."""
        height, rate = self._guard.evaluate_in_doubles(self._begin + part * self.span, self._states.at(part))
        return height, rate * self.span

    def enclose(self, edges: NDArray[np.float64]) -> Enclosure:
        """Bounds over the equal pieces between the edges (m + 1,)."""
        return self._guard.enclose(self._begin, self.span, self._states, edges)


def zero_of(digits: Digits) -> Any:
    """Part of the size of a number that is zero but for the rounding of its computation."""
    return digits.context.ldexp(1, -int(_TOUCH * (digits.context.prec - GUARD)))
