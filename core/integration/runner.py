"""A run in progress: calls the compiled loop in chunks, and collects its rows and crossings between them."""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from core.compilation.compiled import compile_run, modes_entered
from core.integration.corner import surfaces_met
from core.integration.crossings import Crossings
from core.integration.event_log import EventLog
from core.integration.failure import Growth
from core.integration.growth_loop import UNKNOWN, compiled_follow
from core.integration.hits import crossings_of, no_crossings
from core.integration.outcome import cause_of_failure
from core.integration.run_record import FIELDS, Blank, Record, Rows, beginning_of
from core.integration.run_settings import Settings
from core.integration.starting import first_place, leaning, onto_surfaces, regions_entered, way_out
from core.kernels.abi import LAST, MAX_VISITS, SINGULAR_LENGTH, SINGULARITY, STEP, VISIT, VISITS
from core.kernels.arrays import Floats
from core.kernels.taylor_coefficients import STRIDE
from core.methods import Method
from core.methods.taylor_step import coefficient_rows
from core.symbolic.singularities import Singularity
from core.system import PiecewiseSystem
from core.transition.event_location import BOUND
from core.transition.records import HIT, NO_MODE, ROW
from core.transition.status import Status

__all__ = ["Runner"]

#: Steps between two readings of the cancel flag: they take milliseconds, a call of the loop a quarter of one.
_CHUNK = 131072
#: Steps and crossings that the first call of the loop can record at least: more room takes longer to make.
_FIRST_ROWS, _FIRST_HITS = 512, 64
#: How many times as many the next call can, up to …
_MORE = 16
#: … so many crossings if they are kept …
_HITS_KEPT = 4096
#: … or if they are not: few enough to stay in the processor's cache.
_HITS_NOT_KEPT = 1024
#: Largest number of steps sampled over the run, for `diagnostics.resolution`.
_SAMPLES = 128
#: Results of a start on the surface by first derivatives of g, for which second derivatives are then examined.
_UNDECIDED = (Status.SLIDING, Status.REPELLING, Status.GRAZING)
#: Results of a run that stops at a surface.
_AT_SURFACE = (*_UNDECIDED, Status.CORNER, Status.UNDECLARED)
#: Most corners passed at the same time; more accumulate.
_MOST_CORNERS = 16
#: Status by its code; Python takes longer to find it.
_STATUS = {int(status): status for status in Status}
#: Places of the fields of the record that are read or written for every run.
_T, _T_CARRY, _T_START, _T_END, _TAU, _SHIFT, _LONGEST, _LAST_HIT = (
    FIELDS[name] for name in ("t", "t_carry", "t_start", "t_end", "tau", "shift", "longest", "last_hit")
)
_MODE, _FIRST_MODE, _PENDING, _ASKED, _RECORD, _STEPS, _EVALUATIONS, _CROSSINGS, _MAX_CROSSINGS = (
    FIELDS[name]
    for name in (
        "mode", "first_mode", "pending", "asked", "record", "steps", "evaluations", "crossings", "max_crossings",
    )
)  # fmt: skip
_SAMPLES_KEPT, _ROWS, _HITS = (FIELDS[name] for name in ("samples", "rows", "hits"))
_EVENTS, _MAX_EVENTS, _FOUND, _CROWDED = (FIELDS[name] for name in ("events", "max_events", "found", "crowded"))


class Runner:
    """Integrates one initial value problem; may be advanced repeatedly.

    Attributes
    ----------
    start
        Initial state (d,).
    status, t, x, mode, first_mode
        Current status, time, state and mode, and the mode in which the run began. A mode is `NO_MODE` before the first
        step, and where the run could not leave the surface.
    rows
        States recorded at every step, if requested.
    envelope
        (columns, m, 2) least and greatest level residual in each of equal parts of the time.
    seconds
        Processor time of the thread in the compiled loop.
    why_cornered
        Why the laws do not tell how to go on from the last corner; empty if they do.
    """

    def __init__(
        self, system: PiecewiseSystem, method: Method, t0: float, x0: tuple[float, ...], settings: Settings,
        columns: int = 0,
    ) -> None:  # fmt: skip
        laws = system.laws
        self.system, self.settings, self.method, self._levels = system, settings, method, columns > 0
        self._modes = modes_entered(laws, method, columns > 0)
        self._begun = begun = beginning_of(
            laws, method, settings.transition, settings.slides, settings.tolerance, columns > 0
        )
        self._table, self._workspace = begun.table, begun.workspace()
        self._corner: tuple[int, ...] = ()
        self._last_corner, self._corners = math.nan, 0
        self.why_cornered = ""
        self._p = system.parameter_array.copy()
        self._w = begun.blank_frame.copy()
        self._take_views()
        self._x[:] = x0
        self._w[VISITS + LAST : VISITS + VISIT * MAX_VISITS : VISIT] = t0
        self._hit_chunks: list[tuple[NDArray[Any], Floats]] = []
        self._room_for_rows, self._room_for_hits = _FIRST_ROWS, _FIRST_HITS
        self._t0, self.start = t0, x0
        self.rows = Rows([], [], [], [])
        self.envelope = np.empty((columns, begun.monitored, 2))
        if columns:
            self.envelope[:] = np.inf, -np.inf
        self.status, self.seconds = Status.RUNNING, 0.0
        self.growth: Growth | None = None
        """How the solution grows where the run has failed, if that could be told."""
        self.log = EventLog(settings.events, laws, method, self._w)
        self._record = Record(begun.blank_record * self.log.records)
        self._run, self._reals, self._wholes = self._record.array, self._record.reals, self._record.wholes
        self._reals[_T] = self._reals[_LAST_HIT] = self._reals[_T_START] = t0
        self._wholes[_MAX_CROSSINGS], self._wholes[_MAX_EVENTS] = settings.max_crossings, settings.max_events
        self._wholes[_EVENTS] = len(settings.events.functions)
        self._samples = np.empty((_SAMPLES, 3 + len(x0)))
        self._coefficients = np.empty((1, 1))
        if not laws.two_sided:
            self._find_first_region()
        self._compile()

    def _take_views(self) -> None:
        """Take views of state and carry in the frame."""
        frame = self._begun.frame
        self._x, self._carry = self._w[frame.x : frame.carry], self._w[frame.carry : frame.increment]

    def _find_first_region(self) -> None:
        """Find the region in which the run begins: the loop itself tells two sides of one surface apart."""
        place = first_place(self.system, self.t, self.x)
        if place.region is None:
            raise ValueError(f"x0 = {self.start!r} lies in a region for which no law is declared; choose another state")
        self._run["row"], self._run["guard"] = self._table.first_rows[place.region], place.guard
        self._modes.add(place.region)
        self._corner = place.corner

    @property
    def direction(self) -> float:
        """Positive where time runs on, negative where it runs back, 0 before the run is advanced."""
        return float(self._reals[_TAU])

    @property
    def t(self) -> float:
        """Time."""
        return float(self._reals[_T])

    @property
    def x(self) -> Floats:
        """State (d,), a copy."""
        return self._x.copy()

    @property
    def mode(self) -> int:
        """Number of the mode occupied; `NO_MODE` before the first step."""
        return int(self._wholes[_MODE])

    @property
    def first_mode(self) -> int:
        """Number of the mode in which the run began; `NO_MODE` before the first step."""
        return int(self._wholes[_FIRST_MODE])

    @property
    def first_region(self) -> int:
        """Number of a region in which, or at the boundary of which, the run begins."""
        return int(self._table.guards["mode"][int(self._run["row"][0])])

    @property
    def slides(self) -> bool:
        """Whether the run slides along a surface."""
        return self.mode >= len(self.system.laws.regions)

    @property
    def samples(self) -> Floats:
        """(k, 3 + d) time, mode, length and state at the start of some steps; the length ends at a crossing."""
        return self._samples[: self._wholes[_SAMPLES_KEPT]]

    @property
    def longest(self) -> float:
        """The longest step that a method has chosen."""
        return float(self._reals[_LONGEST])

    @property
    def steps(self) -> int:
        """Steps taken."""
        return int(self._wholes[_STEPS])

    @property
    def evaluations(self) -> int:
        """Evaluations of the (discrete) field."""
        return int(self._wholes[_EVALUATIONS])

    @property
    def crossing_count(self) -> int:
        """Number of crossings, kept or not."""
        return int(self._wholes[_CROSSINGS])

    @property
    def segment(self) -> int:
        """Index of the segment between crossings in which the run is.

        A crossing at which the run stops begins no new segment, unless the state has jumped, and ψ with it.
        """
        return max(self.crossing_count - (self.status in _AT_SURFACE and not self.system.laws.jumps), 0)

    def advance(
        self, t_end: float, record: bool = False, keep_hits: bool = True, after: Callable[[], object] | None = None
    ) -> Status:
        """Integrate to `t_end`, or to where the run stops before; `after` is called after each call of the loop."""
        sign = self._aim(t_end, record)
        self.status = Status.COMPLETED if t_end == self.t else Status.RUNNING
        if self._corner and self.first_mode == NO_MODE and self.status is Status.RUNNING:
            self._pass_corner(sign)
        while self.status is Status.RUNNING:
            if self.steps >= self.settings.max_steps:
                self.status = Status.STEP_LIMIT
            elif self.settings.cancel is not None and self.settings.cancel():
                self.status = Status.CANCELLED
            else:
                if self._wholes[_PENDING] and not self._make_ready(sign):
                    break
                self.status = self._chunk(record, keep_hits)
                if self.status is Status.CORNER:
                    self._pass_corner(sign)
                elif self.status in _AT_SURFACE and self._wholes[_PENDING] and self.crossing_count:
                    self._hit_chunks[-1][0]["mode"][-1] = NO_MODE  # the mode that followed could not be begun
                if after is not None:
                    after()
        if (
            self.status in _UNDECIDED
            and self.first_mode == NO_MODE
            and not self._corner
            and self._find_first_mode(sign)
        ):
            return self.advance(t_end, record, keep_hits, after)
        if self.status in (Status.NO_CONVERGENCE, Status.ESCAPED):
            self.status, self.growth = cause_of_failure(self)
        return self.status

    def _aim(self, t_end: float, record: bool) -> float:
        """Take a time to integrate to; returns the sign of the way there."""
        reals, sign = self._reals, 1.0 if t_end >= self.t else -1.0
        reals[_T_END], reals[_TAU], reals[_SHIFT] = t_end, sign * self.settings.tau, sign * self.settings.shift
        self._wholes[_RECORD] = record
        for name in ("t_end", "tau", "shift") if self.log.records > 1 else ():
            self._run[name] = self._run[name][0]  # also for the location of events
        return sign

    def _make_ready(self, direction: float) -> bool:
        """Make the pending mode ready to begin: compile it, or tell where it leads; returns whether that is known."""
        run = self._run
        if not (asked := self._wholes[_ASKED]):
            self._modes.add(self.mode)
            self._compile()
            return True
        lean = leaning(self.system, self.mode, asked - 1, self.t, self.x, direction)
        bit = 1 << asked - 1
        run["asked"] = 0
        run["inward" if lean.way > 0 else "outward"] |= bit
        run["folded"] |= bit * lean.folded
        if lean.way == 0:
            self.status = Status.GRAZING
            if self.crossing_count:
                self._hit_chunks[-1][0]["mode"][-1] = NO_MODE
        return lean.way != 0

    def _compile(self) -> None:
        """Compile the modes entered so far."""
        laws, modes = self.system.laws, tuple(sorted(self._modes))
        self._compiled = compile_run(laws, self.method, self._levels, modes, self.settings.events.functions)
        if self.method.adaptive:
            self._coefficients = np.empty((coefficient_rows(laws, modes), STRIDE))

    def _find_first_mode(self, sign: float) -> bool:
        """Find the mode of a start on a surface by the second derivative of g; returns whether there is one only."""
        region, guard = self.first_region, int(self._run["guard"][0])
        entered = regions_entered(self.system, region, guard, self.t, self.x, sign)
        if len(entered) == 1:
            region, guard = entered[0]
            self._begin_in(region, (self.system.laws.ways[region][guard].surface,))
            return True
        self.status = Status.REPELLING if entered else self.status
        return False

    def _begin_in(self, mode: int, surfaces: tuple[int, ...]) -> None:
        """Have the loop begin a mode where it is bounded by some surfaces, at whose zeros the state is."""
        row, run = int(self._table.first_rows[mode]), self._run
        guards = self._table.guards[row : row + int(self._table.guards["count"][row])]
        run["row"], run["guard"] = row, 0
        run["at"] = sum(1 << k for k, surface in enumerate(guards["surface"].tolist()) if surface in surfaces)
        if self.first_mode == NO_MODE:
            run["first_mode"] = mode
            self._modes.add(mode)
            self._compile()
            return
        run["mode"], run["entered"], run["pending"], run["guards"] = mode, math.nan, 1, len(guards)
        run["sliding"] = guards["slides"][0]
        for name in ("jumped", "past", "near", "asked", "inward", "outward", "folded"):
            run[name] = 0

    def _pass_corner(self, direction: float) -> None:
        """Go on from a corner, if the laws around leave one way out."""
        surfaces = self._surfaces_at_corner()
        mode, self.why_cornered = way_out(self.system, self.t, self.x, surfaces, direction)
        self._corners = self._corners + 1 if self._last_corner == self.t else 0
        self._last_corner = self.t
        self.status = Status.CORNER
        if mode is None:
            return
        if mode >= len(self.system.laws.regions) and not self.settings.slides:
            self.status = Status.SLIDING
        elif self._corners > _MOST_CORNERS:
            self.status = Status.ZENO
        elif self.crossing_count >= self.settings.max_crossings:
            self.status = Status.CROSSING_LIMIT
        else:
            self.status = Status.RUNNING
            if self.crossing_count and self._hit_chunks:
                self._x[:] = onto_surfaces(self.system, self.t, self.x, surfaces)
                self._carry[:] = 0.0
                hits, places = self._hit_chunks[-1]
                hits["mode"][-1], places[-1, 1:] = mode, self._x  # the place met, and the state that goes on
            self._begin_in(mode, surfaces)

    def _surfaces_at_corner(self) -> tuple[int, ...]:
        """Numbers of the surfaces that meet where the run is."""
        if self.first_mode == NO_MODE:
            return self._corner
        run, laws, first = self._run, self.system.laws, int(self._run["row"][0])
        guards = self._table.guards[first : first + int(self._table.guards["count"][first])]
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
        row, functions = int(self._table.first_rows[self.mode]), self._compiled.addresses
        if functions[row, STEP] == 0:
            return None
        # Beyond bounds, what kind of growth it is makes the message; else that it grows is enough.
        most = BOUND if self.status is Status.ESCAPED else 0.0
        code = compiled_follow()(
            functions, row, self.method.adaptive, self.method.conservative, self._p, self._begun.blank_frame.copy(),
            self._coefficients, np.array((x, x)), t, t_end, h, size, most,
        )  # fmt: skip
        return None if code == UNKNOWN else Growth(code)

    @property
    def met(self) -> tuple[Singularity, float] | None:
        """The singularity that a step from here would pass, and the length of the step; None if it passes none."""
        number, t, h = self._w[SINGULARITY : SINGULAR_LENGTH + 1].tolist()
        if number == 0.0 or self.mode == NO_MODE or t != self.t + self._reals[_T_CARRY]:
            return None
        return self.system.laws.mode(self.mode).singularities[int(number) - 1], h

    def blank(self, t_end: float) -> Blank:
        """What other runs to `t_end` begin from, of the same method and settings; before this one has begun."""
        self._aim(t_end, record=False)
        budget = min(_CHUNK, self.settings.max_steps)
        nodes, pieces = self._workspace
        return Blank(
            self._compiled.addresses, self._table.guards, self._run, self._w, self._coefficients, nodes, pieces,
            self.envelope, self._samples, self.log.arrays, budget,
        )  # fmt: skip

    def hits(self) -> tuple[NDArray[Any], Floats]:
        """Every crossing kept so far, as the loop has written it: (k,) of `records.HIT`, and its states (k, 3, d)."""
        if not self._hit_chunks:
            return np.empty(0, dtype=HIT), np.empty((0, 3, self.system.dimension))
        hits, places = (np.concatenate(parts) for parts in zip(*self._hit_chunks, strict=True))
        return hits, places

    def copy(self) -> Runner:
        """An independent copy."""
        other = copy.copy(self)
        other._record = self._record.copy()
        other._run, other._reals, other._wholes = other._record.array, other._record.reals, other._record.wholes
        other._w, other.log = self._w.copy(), self.log.copy()
        other._take_views()
        other._samples = self._samples.copy()
        other._coefficients, other._workspace = self._coefficients.copy(), tuple(a.copy() for a in self._workspace)
        return other

    def state_at(self, t: float) -> Floats | None:
        """State at time t, or None if the run stops before; advances a copy, so that this run keeps its grid."""
        ahead = self.copy()
        return ahead.x if ahead.advance(t) is Status.COMPLETED else None

    def entry(self) -> tuple[float, Floats]:
        """Time and state at which the current segment was entered; needs the last two crossings only."""
        if self.segment == 0:
            return self._t0, np.array(self.start)
        back = 1 + self.crossing_count - self.segment  # a crossing at which the run stops begins no segment
        hits, places = self._hit_chunks[-1]
        if back > len(hits):
            back -= len(hits)
            hits, places = self._hit_chunks[-2]
        return float(hits["t"][-back]), places[-back, 2].copy()

    def crossings(self) -> Crossings:
        """Every crossing kept so far."""
        return crossings_of(*self.hits(), self.system.laws) if self._hit_chunks else no_crossings(self.system.laws)

    def latest(self, count: int) -> Crossings:
        """The last `count` crossings, at most those of the last call of the loop."""
        if not count:
            return no_crossings(self.system.laws)
        hits, places = self._hit_chunks[-1]
        return crossings_of(hits[-count:], places[-count:], self.system.laws)

    def _chunk(self, record: bool, keep_hits: bool) -> Status:
        budget, d = min(_CHUNK, self.settings.max_steps - self.steps), len(self.start)
        rows, rows_x = self._begun.nowhere
        if record:
            steps = (self._reals[_T_END] - self.t) / self._reals[_TAU]  # 0 where the method chooses them
            size = min(max(self._room_for_rows, int(min(steps, _CHUNK)) + 2), budget)
            rows, rows_x = np.empty(size, dtype=ROW), np.empty((size, d))
            self._room_for_rows = min(_MORE * size, _CHUNK)
        size = min(self._room_for_hits, _HITS_KEPT if keep_hits else _HITS_NOT_KEPT)
        hits, places = np.empty(size, dtype=HIT), np.empty((size, 3, d))
        saved = self.log.saved(self._run, self._w, self._samples)
        started = time.thread_time()
        status = self._begun.march(
            self._compiled.addresses, self._table.guards, self._run, self._p, self._w, d, self._coefficients,
            *self._workspace, budget, rows, rows_x, hits, places, self.envelope, self._samples, *self.log.arrays,
        )  # fmt: skip
        self.seconds += time.thread_time() - started
        if self._wholes[_CROWDED]:
            for array, before in saved:
                array[:] = before
            self.log.make_room()
            return self._chunk(record, keep_hits)
        self.log.collect(self._wholes[_FOUND])
        self.rows.collect(self._wholes[_ROWS], rows, rows_x)
        if n := self._wholes[_HITS]:
            self._room_for_hits = min(_MORE * size, _HITS_KEPT)
            chunk = (hits[:n], places[:n])
            self._hit_chunks = [*self._hit_chunks, chunk] if keep_hits else [*self._hit_chunks[-1:], chunk]
        return _STATUS[status]
