"""Advance a run: call the compiled loop in chunks, and collect its rows and crossings between them."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from core.integration.beginning import Blank
from core.integration.corner import BEYOND, surfaces_met
from core.integration.failure import Growth, pole_ahead, pole_of_growth
from core.integration.growth_loop import UNKNOWN, compiled_follow
from core.integration.memory import FIELDS, FIRST_HITS
from core.integration.outcome import cause_of_failure
from core.integration.recorded import Chunk
from core.integration.run import AT_SURFACE, SHORTER, Run
from core.integration.starting import leaning, onto_surfaces, regions_entered, sliding_begun, way_out
from core.kernels.abi import STEP
from core.kernels.arrays import Floats
from core.transition.event_location import BOUND
from core.transition.records import HIT, NO_MODE, ROW
from core.transition.status import CROSSING_KINDS, Status

__all__ = ["Runner"]

#: Steps between two readings of the cancel flag: they take milliseconds, a call of the loop a quarter of one.
_CHUNK = 131072
#: Steps of a method that chooses them which the first call of the loop can record: more room takes longer to make.
_FIRST_ROWS = 512
#: How many times as many steps, or crossings, the next call can record, up to …
_MORE = 16
#: … so many crossings if they are kept …
_HITS_KEPT = 4096
#: … or if they are not: few enough to stay in the processor's cache.
_HITS_NOT_KEPT = 1024
#: Results of a start on the surface by first derivatives of g, for which second derivatives are then examined.
_UNDECIDED = (Status.SLIDING, Status.REPELLING, Status.GRAZING)
#: Steps in a call of the loop whose mean length is that of steps without those that crossings cut.
_MANY = 256
#: Most corners passed at the same time; more accumulate.
_MOST_CORNERS = 16
#: Status by its code, and two by their names: Python takes longer to find them.
_STATUS = {int(status): status for status in Status}
_RUNNING, _COMPLETED = Status.RUNNING, Status.COMPLETED
#: Places of the fields of the record that are read or written for every run.
(
    _T, _T_CARRY, _T_END, _TAU, _SHIFT, _PENDING, _ASKED, _RECORD, _STEPS, _ROWS, _HITS, _FOUND, _CROWDED, _RETRACTED,
    _WANTED,
) = (
    FIELDS[name]
    for name in (
        "t", "t_carry", "t_end", "tau", "shift", "pending", "asked", "record", "steps", "rows", "hits", "found",
        "crowded", "retracted", "wanted",
    )
)  # fmt: skip


class Runner(Run):
    """Integrates one initial value problem; may be advanced repeatedly."""

    _last_corner, _corners = math.nan, 0
    _full_chunks = 0
    _look = (-1, math.nan, math.nan)
    _room_for_rows, _room_for_hits = _FIRST_ROWS, FIRST_HITS

    def advance(
        self, t_end: float, record: bool = False, keep_hits: bool = True, after: Callable[[], object] | None = None
    ) -> Status:
        """Integrate to `t_end`, or to where the run stops before; `after` is called after each call of the loop."""
        sign = self._aim(t_end, record)
        self.status = _COMPLETED if t_end == self.reals[_T] else _RUNNING
        if self.corner and self.first_mode == NO_MODE and self.status is _RUNNING:
            self._pass_corner(sign)
        while self.status is _RUNNING:
            if self.wholes[_STEPS] >= self.settings.max_steps:
                self.status = Status.STEP_LIMIT
            elif self.settings.cancel is not None and self.settings.cancel():
                self.status = Status.CANCELLED
            else:
                if self.wholes[_PENDING] and not self._make_ready(sign):
                    break
                since, carry, made = self.t, self.reals[_T_CARRY], self.wholes[_STEPS]
                self.status = self._chunk(record, keep_hits)
                if self.method.adaptive and (made := self.wholes[_STEPS] - made) >= _MANY:
                    self.recent = abs((self.t - since) + (self.reals[_T_CARRY] - carry)) / made
                    if self.status is _RUNNING and made == _CHUNK:
                        self._look_ahead()
                if self.status in AT_SURFACE:
                    self._arrive(sign)
                if after is not None:
                    after()
        if self.status is _COMPLETED:
            return _COMPLETED
        if self.status in _UNDECIDED and self.first_mode == NO_MODE and not self.corner and self._find_first_mode(sign):
            return self.advance(t_end, record, keep_hits, after)
        if self.status in (Status.NO_CONVERGENCE, Status.ESCAPED) and math.isnan(self.pole):
            self.status, self.growth = cause_of_failure(self)
        return self.status

    def _look_ahead(self) -> None:
        """End where steps get ever shorter towards a pole, without end.

        They do where the field varies the faster the larger the state is. That is asked for again each time that there
        are twice as many steps.
        """
        self._full_chunks += 1
        asked = self._full_chunks & (self._full_chunks - 1) == 0
        if not asked or self.slides or self.mode == NO_MODE or not self.recent < SHORTER * self.longest:
            return
        name, size = self.system.laws.name(self.mode), float(np.abs(self.start).max())
        pole = pole_ahead(self.system, name, self.t, self.x, self.t_end, size, self.settings.cancel)
        pole = self._pole_of_growth(size) if math.isnan(pole) else pole
        if not math.isnan(pole):
            self.status, self.growth, self.pole = Status.ESCAPED, Growth.POLE, pole

    def _pole_of_growth(self, size: float) -> float:
        """Time of a pole that growth since the last look tells, where the end is out of reach; nan if it tells none."""
        before, self._look = self._look, (self.crossing_count, self.t, float(np.abs(self.x).max()))
        far = self.recent * self.settings.max_steps < abs(self.t_end - self.t)
        if not far or before[0] != self.crossing_count:
            return math.nan
        return pole_of_growth([(self.t0, size), before[1:], self._look[1:]])

    def _arrive(self, direction: float) -> None:
        """Stop at a surface, or go on from a corner."""
        if self.status is Status.CORNER:
            self._pass_corner(direction)
        elif self.status is Status.SLIDING and self.jumps_here:
            self._leave_after_jump(direction)
        elif self.wholes[_PENDING] and self.crossing_count:
            self.chunks[-1][0]["mode"][-1] = NO_MODE  # the mode that followed could not be begun

    def _aim(self, t_end: float, record: bool) -> float:
        """Take a time to integrate to; returns the sign of the way there."""
        reals, settings = self.reals, self.settings
        sign = 1.0 if t_end >= reals[_T] else -1.0
        reals[_T_END], reals[_TAU], reals[_SHIFT] = t_end, sign * settings.tau, sign * settings.shift
        self.wholes[_RECORD] = record
        for name in ("t_end", "tau", "shift") if settings.events.functions else ():
            self.record[name] = self.record[name][0]  # also for the location of events
        return sign

    def _make_ready(self, direction: float) -> bool:
        """Make the pending mode ready to begin: compile it, or tell where it leads; returns whether that is known."""
        run = self.record
        if not (asked := self.wholes[_ASKED]):
            self.compile(self.mode)
            return True
        lean = leaning(self.system, self.mode, asked - 1, self.t, self.x, direction)
        bit = 1 << asked - 1
        run["asked"] = 0
        run["inward" if lean.way > 0 else "outward"] |= bit
        run["folded"] |= bit * lean.folded
        if lean.way == 0:
            self.status = Status.GRAZING
            if self.crossing_count:
                self.chunks[-1][0]["mode"][-1] = NO_MODE
        return lean.way != 0

    def _find_first_mode(self, sign: float) -> bool:
        """Find the mode of a start on a surface by the second derivative of g; returns whether there is one only."""
        region, guard = self.first_region, int(self.record["guard"][0])
        entered = regions_entered(self.system, region, guard, self.t, self.x, sign)
        if len(entered) == 1:
            region, guard = entered[0]
            self._begin_in(region, (self.system.laws.ways[region][guard].surface,))
            return True
        begun = None if entered else sliding_begun(self.system, region, guard, self.t, self.x, sign)
        if begun is not None and self.settings.slides:
            self._begin_in(begun[0], ())
            self.record["at"] = 1 << begun[1]
            return True
        self.status = Status.REPELLING if entered else self.status if begun is None else Status.SLIDING
        return False

    def _begin_in(self, mode: int, surfaces: tuple[int, ...]) -> None:
        """Have the loop begin a mode where it is bounded by some surfaces, at whose zeros the state is."""
        row, run = int(self.begun.table.first_rows[mode]), self.record
        guards = self.begun.table.guards[row : row + int(self.begun.table.guards["count"][row])]
        run["row"], run["guard"] = row, 0
        run["at"] = sum(1 << k for k, surface in enumerate(guards["surface"].tolist()) if surface in surfaces)
        if self.first_mode == NO_MODE:
            run["first_mode"] = mode
            self.compile(mode)
            return
        run["mode"], run["entered"], run["pending"], run["guards"] = mode, math.nan, 1, len(guards)
        run["sliding"] = guards["slides"][0]
        for name in ("jumped", "past", "near", "asked", "inward", "outward", "folded"):
            run[name] = 0

    def displace(self, by: Floats) -> None:
        """Go on from another state beside the present one, in the same mode."""
        self.memory.x[:] += by
        if self.first_mode != NO_MODE:  # heights and levels are those of the new state
            self._begin_in(self.mode, ())

    def _pass_corner(self, direction: float) -> None:
        """Go on from a corner, if the laws around leave one way out."""
        surfaces = self._surfaces_at_corner()
        beyond = self.record["past"] > 0
        way = BEYOND if beyond else way_out(self.system, self.t, self.x, surfaces, direction)
        mode, self.why_cornered = way.mode, way.reason
        self._corners = self._corners + 1 if self._last_corner == self.t else 0
        self._last_corner = self.t
        self.status = Status.CORNER
        if mode is None:
            return
        if mode >= len(self.system.laws.regions) and not self.settings.slides:
            self.status = Status.SLIDING
        elif self._corners > _MOST_CORNERS:
            self.status = Status.ZENO
        else:
            if self.crossing_count and self.chunks:
                self.memory.x[:] = onto_surfaces(self.system, self.t, self.x, surfaces)
                self.memory.carry[:] = 0.0
                hits, places = self.chunks[-1]
                hits["mode"][-1], places[-1, 1:] = mode, self.x  # the place met, and the state that goes on
                sides = self.system.laws.sides
                self.wholes[_WANTED] += int(self.settings.max_wanted.among(hits[-1:], self.mode, sides)[0])
            self._begin_in(mode, surfaces)
            self.status = self._limited()

    def _limited(self) -> Status:
        """The status of a run that goes on unless it has had all crossings that it may."""
        if self.crossing_count == 0:
            return _RUNNING
        most = self.crossing_count >= self.settings.max_crossings
        return Status.CROSSING_LIMIT if most or self.wholes[_WANTED] >= self.settings.max_wanted.most else _RUNNING

    def _leave_after_jump(self, direction: float) -> None:
        """Go on from a surface along which the state moves after a jump, if the field curves to where it came from.

        If it leads beyond the surface, the state jumps again.
        """
        guard = int(self.record["guard"][0])
        entered = regions_entered(self.system, self.mode, guard, self.t, self.x, direction)
        if (self.mode, guard) not in entered:
            return
        if len(entered) > 1:
            self.status = Status.REPELLING
        else:
            hit = self.chunks[-1][0][-1:]
            hit["mode"], hit["kind"] = self.mode, CROSSING_KINDS.index("jump")
            self._begin_in(self.mode, (self.system.laws.ways[self.mode][guard].surface,))
            self.status = self._limited()

    def _surfaces_at_corner(self) -> tuple[int, ...]:
        """Numbers of the surfaces that meet where the run is."""
        if self.first_mode == NO_MODE:
            return self.corner
        run, laws, first = self.record, self.system.laws, int(self.record["row"][0])
        guards = self.begun.table.guards[first : first + int(self.begun.table.guards["count"][first])]
        along = laws.pairs[self.mode - len(laws.regions)][2] if self.slides else None
        return surfaces_met(guards, int(run["guard"][0]), int(run["corner"][0]), along)

    def follow(self, t: float, x: Floats, t_end: float, h: float, size: float) -> Growth | None:
        """How the solution grows with the field of the mode; None where steps of the method do not tell.

        Parameters
        ----------
        t, x
            Time and state (d,) from which it is followed, to `t_end`.
        h
            Signed length of the first step.
        size
            As of `failure.growth_of`.
        """
        row, functions = int(self.begun.table.first_rows[self.mode]), self.ready.functions
        if functions[row, STEP] == 0:
            return None
        # Beyond bounds, what kind of growth it is makes the message; else that it grows is enough.
        most = BOUND if self.status is Status.ESCAPED else 0.0
        code = compiled_follow()(
            functions, row, self.method.adaptive, self.method.conservative, self.memory.p,
            self.begun.blank_frame.copy(), self.memory.coefficients, np.array((x, x)), t, t_end, h, size, most,
        )  # fmt: skip
        return None if code == UNKNOWN else Growth(code)

    def fail(self, status: Status, record: NDArray[Any], w: Floats, last_hit: Chunk) -> Status:
        """Take over another run of these settings, whose step has failed; returns why it has."""
        self.record[:1].view(np.uint8)[:], self.memory.w[:] = record.view(np.uint8), w
        self.chunks, self.status = [last_hit], status
        self.status, self.growth = cause_of_failure(self)
        return self.status

    def blank(self, t_end: float) -> Blank:
        """What other runs to `t_end` begin from, of the same method and settings; before this one has begun."""
        self._aim(t_end, record=False)
        return Blank(
            self.ready.functions, self.begun.table.guards, self.memory, self.envelope, self.log.arrays,
            min(_CHUNK, self.settings.max_steps),
        )  # fmt: skip

    def state_at(self, t: float) -> Floats | None:
        """State at time t, or None if the run stops before; advances a copy, so that this run keeps its grid."""
        ahead = self.copy()
        return ahead.x if ahead.advance(t) is Status.COMPLETED else None

    def _chunk(self, record: bool, keep_hits: bool) -> Status:
        """Call the loop once, and collect what it has written."""
        begun, memory, wholes, d = self.begun, self.memory, self.wholes, len(self.start)
        budget = min(_CHUNK, self.settings.max_steps - wholes[_STEPS])
        rows, rows_x = self._room(budget) if record else begun.nowhere
        size, hits, places = FIRST_HITS, memory.hits, memory.places
        if self._room_for_hits > size:
            size = min(self._room_for_hits, _HITS_KEPT if keep_hits else _HITS_NOT_KEPT)
            hits, places = np.empty(size, dtype=HIT), np.empty((size, 3, d))
        saved = self.log.saved(memory.record, memory.w, memory.samples, memory.looks, memory.passes)
        started = time.thread_time()
        status = begun.march(
            self.ready.functions, begun.table.guards, memory.record, memory.p, memory.w, d, memory.coefficients,
            memory.nodes, memory.pieces, budget, rows, rows_x, hits, places, self.envelope, memory.samples,
            memory.looks, memory.passes, *self.log.arrays,
        )  # fmt: skip
        self.seconds += time.thread_time() - started
        if wholes[_CROWDED]:
            for array, before in saved:
                array[:] = before
            self.log.make_room()
            return self._chunk(record, keep_hits)
        if n := wholes[_FOUND]:
            self.log.collect(n)
        if n := wholes[_ROWS]:
            self.rows.append((rows[:n], rows_x[:n]))
        if wholes[_RETRACTED]:
            last, places = self.chunks[-1]
            self.chunks[-1], wholes[_RETRACTED] = (last[:-1], places[:-1]), 0
        if n := wholes[_HITS]:
            self._room_for_hits = min(_MORE * size, _HITS_KEPT)
            self.chunks = [*(self.chunks if keep_hits else self.chunks[-1:]), (hits[:n], places[:n])]
            if hits is memory.hits:
                memory.make_room()
        return _STATUS[status]

    def _room(self, budget: int) -> Chunk:
        """Room for the steps of one call: for all of them, unless the method chooses them."""
        size = self._room_for_rows
        if not self.method.adaptive:
            steps = (self.reals[_T_END] - self.reals[_T]) / self.reals[_TAU]
            size = int(min(abs(steps), _CHUNK)) + 2  # a perturbation may have moved it beyond the end
        size = min(size, budget)
        self._room_for_rows = min(_MORE * size, _CHUNK)
        return np.empty(size, dtype=ROW), np.empty((size, len(self.start)))
