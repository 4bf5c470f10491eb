"""A run in progress: calls the compiled loop in chunks, and collects its rows and crossings between them."""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Callable

import numpy as np

from core.integration.beginning import Blank, beginning_of
from core.integration.corner import surfaces_met
from core.integration.crossings import Crossings
from core.integration.event_log import log_of
from core.integration.failure import Growth
from core.integration.growth_loop import UNKNOWN, compiled_follow
from core.integration.hits import all_crossings, crossings_of, joined, no_crossings
from core.integration.memory import FIELDS, FIRST_HITS
from core.integration.outcome import cause_of_failure
from core.integration.recorded import Chunk, Entry, Point
from core.integration.run_settings import Settings
from core.integration.starting import first_place, leaning, onto_surfaces, regions_entered, way_out
from core.kernels.abi import SINGULAR_LENGTH, SINGULARITY, STEP
from core.kernels.arrays import Floats
from core.methods import Method
from core.symbolic.singularities import Singularity
from core.system import PiecewiseSystem
from core.transition.event_location import BOUND
from core.transition.records import HIT, NO_MODE, ROW
from core.transition.status import Status

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
#: Results of a run that stops at a surface.
_AT_SURFACE = (*_UNDECIDED, Status.CORNER, Status.UNDECLARED)
#: Most corners passed at the same time; more accumulate.
_MOST_CORNERS = 16
#: Status by its code, and two by their names: Python takes longer to find them.
_STATUS = {int(status): status for status in Status}
_RUNNING, _COMPLETED = Status.RUNNING, Status.COMPLETED
#: Places of the fields of the record that are read or written for every run.
_T, _T_CARRY, _T_END, _TAU, _SHIFT, _LONGEST = (
    FIELDS[name] for name in ("t", "t_carry", "t_end", "tau", "shift", "longest")
)
_MODE, _FIRST_MODE, _PENDING, _ASKED, _RECORD, _STEPS, _EVALUATIONS, _CROSSINGS, _MAX_CROSSINGS = (
    FIELDS[name]
    for name in (
        "mode", "first_mode", "pending", "asked", "record", "steps", "evaluations", "crossings", "max_crossings",
    )
)  # fmt: skip
_SAMPLES_KEPT, _ROWS, _HITS, _MAX_EVENTS, _FOUND, _CROWDED = (
    FIELDS[name] for name in ("samples", "rows", "hits", "max_events", "found", "crowded")
)


class Runner:
    """Integrates one initial value problem; may be advanced repeatedly.

    Attributes
    ----------
    t0, start
        Initial time and state.
    t, x, mode, first_mode
        Current time, state and mode, and the mode in which the run began. A mode is `NO_MODE` before the first step,
        and where the run could not leave the surface.
    rows
        States recorded at every step, if requested.
    chunks
        Crossings, call by call of the loop: all of them, or the last two chunks where they are not kept.
    envelope
        (columns, m, 2) least and greatest level residual in each of equal parts of the time.
    log
        The events.
    """

    status = Status.RUNNING
    seconds = 0.0
    """Processor time of the thread in the compiled loop."""
    growth: Growth | None = None
    """How the solution grows where the run has failed, if that could be told."""
    why_cornered = ""
    """Why the laws do not tell how to go on from the last corner; empty if they do."""
    _corner: tuple[int, ...] = ()
    _last_corner, _corners = math.nan, 0
    _room_for_rows, _room_for_hits = _FIRST_ROWS, FIRST_HITS

    def __init__(
        self, system: PiecewiseSystem, method: Method, t0: float, x0: tuple[float, ...], settings: Settings,
        columns: int = 0,
    ) -> None:  # fmt: skip
        self.system, self.settings, self.method, self.t0, self.start = system, settings, method, t0, x0
        laws = system.laws
        self._begun = begun = beginning_of(
            laws, method, settings.transition, settings.slides, settings.tolerance, columns > 0,
            settings.events.functions,
        )  # fmt: skip
        self._ready = begun.ready
        self._memory = memory = begun.lend(self._ready)
        self._run, self._reals, self._wholes = memory.run, memory.reals, memory.wholes
        memory.p[:], memory.x[:], self._reals[_T] = system.parameter_array, x0, t0
        self._wholes[_MAX_CROSSINGS], self._wholes[_MAX_EVENTS] = settings.max_crossings, settings.max_events
        self.log = log_of(settings.events, laws, method, memory.w)
        self.rows: list[Chunk] = []
        self.chunks: list[Chunk] = []
        self.envelope = begun.no_envelope
        if columns:
            self.envelope = np.empty((columns, begun.monitored, 2))
            self.envelope[:] = np.inf, -np.inf
        if not laws.two_sided:
            self._find_first_region()

    def _find_first_region(self) -> None:
        """Find the region in which the run begins: the loop itself tells two sides of one surface apart."""
        place = first_place(self.system, self.t, self.x)
        if place.region is None:
            raise ValueError(f"x0 = {self.start!r} lies in a region for which no law is declared; choose another state")
        self._run["row"], self._run["guard"] = self._begun.table.first_rows[place.region], place.guard
        self._corner = place.corner
        if self._ready.functions[self._run["row"][0], STEP] == 0:
            self._compile(place.region)

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
        return self._memory.x.copy()

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
        return int(self._begun.table.guards["mode"][int(self._run["row"][0])])

    @property
    def slides(self) -> bool:
        """Whether the run slides along a surface."""
        return self.mode >= len(self.system.laws.regions)

    @property
    def samples(self) -> Floats:
        """(k, 3 + d) time, mode, length and state at the start of some steps; the length ends at a crossing."""
        return self._memory.samples[: self._wholes[_SAMPLES_KEPT]].copy()

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
        count = self._wholes[_CROSSINGS]
        return count - (count > 0 and self.status in _AT_SURFACE and not self.system.laws.jumps)

    def advance(
        self, t_end: float, record: bool = False, keep_hits: bool = True, after: Callable[[], object] | None = None
    ) -> Status:
        """Integrate to `t_end`, or to where the run stops before; `after` is called after each call of the loop."""
        sign = self._aim(t_end, record)
        self.status = _COMPLETED if t_end == self._reals[_T] else _RUNNING
        if self._corner and self.first_mode == NO_MODE and self.status is _RUNNING:
            self._pass_corner(sign)
        while self.status is _RUNNING:
            if self._wholes[_STEPS] >= self.settings.max_steps:
                self.status = Status.STEP_LIMIT
            elif self.settings.cancel is not None and self.settings.cancel():
                self.status = Status.CANCELLED
            else:
                if self._wholes[_PENDING] and not self._make_ready(sign):
                    break
                self.status = self._chunk(record, keep_hits)
                if self.status in _AT_SURFACE:
                    self._arrive(sign)
                if after is not None:
                    after()
        if self.status is _COMPLETED:
            return _COMPLETED
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

    def _arrive(self, direction: float) -> None:
        """Stop at a surface, or go on from a corner."""
        if self.status is Status.CORNER:
            self._pass_corner(direction)
        elif self._wholes[_PENDING] and self.crossing_count:
            self.chunks[-1][0]["mode"][-1] = NO_MODE  # the mode that followed could not be begun

    def _aim(self, t_end: float, record: bool) -> float:
        """Take a time to integrate to; returns the sign of the way there."""
        reals, settings = self._reals, self.settings
        sign = 1.0 if t_end >= reals[_T] else -1.0
        reals[_T_END], reals[_TAU], reals[_SHIFT] = t_end, sign * settings.tau, sign * settings.shift
        self._wholes[_RECORD] = record
        for name in ("t_end", "tau", "shift") if settings.events.functions else ():
            self._run[name] = self._run[name][0]  # also for the location of events
        return sign

    def _make_ready(self, direction: float) -> bool:
        """Make the pending mode ready to begin: compile it, or tell where it leads; returns whether that is known."""
        run = self._run
        if not (asked := self._wholes[_ASKED]):
            self._compile(self.mode)
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

    def _compile(self, mode: int) -> None:
        """Compile a mode, besides those entered so far."""
        self._ready = self._begun.compile(mode)
        self._memory.coefficients = np.empty(self._ready.coefficients)

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
        row, run = int(self._begun.table.first_rows[mode]), self._run
        guards = self._begun.table.guards[row : row + int(self._begun.table.guards["count"][row])]
        run["row"], run["guard"] = row, 0
        run["at"] = sum(1 << k for k, surface in enumerate(guards["surface"].tolist()) if surface in surfaces)
        if self.first_mode == NO_MODE:
            run["first_mode"] = mode
            self._compile(mode)
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
            if self.crossing_count and self.chunks:
                self._memory.x[:] = onto_surfaces(self.system, self.t, self.x, surfaces)
                self._memory.carry[:] = 0.0
                hits, places = self.chunks[-1]
                hits["mode"][-1], places[-1, 1:] = mode, self.x  # the place met, and the state that goes on
            self._begin_in(mode, surfaces)

    def _surfaces_at_corner(self) -> tuple[int, ...]:
        """Numbers of the surfaces that meet where the run is."""
        if self.first_mode == NO_MODE:
            return self._corner
        run, laws, first = self._run, self.system.laws, int(self._run["row"][0])
        guards = self._begun.table.guards[first : first + int(self._begun.table.guards["count"][first])]
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
        row, functions = int(self._begun.table.first_rows[self.mode]), self._ready.functions
        if functions[row, STEP] == 0:
            return None
        # Beyond bounds, what kind of growth it is makes the message; else that it grows is enough.
        most = BOUND if self.status is Status.ESCAPED else 0.0
        code = compiled_follow()(
            functions, row, self.method.adaptive, self.method.conservative, self._memory.p,
            self._begun.blank_frame.copy(), self._memory.coefficients, np.array((x, x)), t, t_end, h, size, most,
        )  # fmt: skip
        return None if code == UNKNOWN else Growth(code)

    @property
    def met(self) -> tuple[Singularity, float] | None:
        """The singularity that a step from here would pass, and the length of the step; None if it passes none."""
        number, t, h = self._memory.w[SINGULARITY : SINGULAR_LENGTH + 1].tolist()
        if number == 0.0 or self.mode == NO_MODE or t != self.t + self._reals[_T_CARRY]:
            return None
        return self.system.laws.mode(self.mode).singularities[int(number) - 1], h

    def blank(self, t_end: float) -> Blank:
        """What other runs to `t_end` begin from, of the same method and settings; before this one has begun."""
        self._aim(t_end, record=False)
        return Blank(
            self._ready.functions, self._begun.table.guards, self._memory, self.envelope, self.log.arrays,
            min(_CHUNK, self.settings.max_steps),
        )  # fmt: skip

    def hits(self) -> Chunk:
        """Every crossing kept so far, as the loop has written it: (k,) of `records.HIT`, and its states (k, 3, d)."""
        return joined(self.chunks, self.system.dimension)

    def copy(self) -> Runner:
        """An independent copy."""
        other = copy.copy(self)
        other._memory = memory = self._begun.lend(self._ready)
        other._run, other._reals, other._wholes = memory.run, memory.reals, memory.wholes
        memory.take(self._memory)
        other.log = self.log.copy()
        return other

    def release(self) -> None:
        """Leave the memory to another run; this one must not be used any more."""
        self._begun.take_back(self._memory)

    def state_at(self, t: float) -> Floats | None:
        """State at time t, or None if the run stops before; advances a copy, so that this run keeps its grid."""
        ahead = self.copy()
        return ahead.x if ahead.advance(t) is Status.COMPLETED else None

    @property
    def last(self) -> Point:
        """Where it is."""
        return Point(self._reals[_T], tuple(self._memory.x.tolist()), self._wholes[_MODE])

    @property
    def entry(self) -> Entry:
        """When and where the current segment was entered: at one of the last two crossings, or at the start."""
        segment = self.segment
        if segment == 0:
            return Entry(0, self.t0, self.start)
        back = 1 + self.crossing_count - segment  # a crossing at which the run stops begins no segment
        hits, places = self.chunks[-1]
        if back > len(hits):
            back -= len(hits)
            hits, places = self.chunks[-2]
        return Entry(segment, float(hits["t"][-back]), tuple(places[-back, 2].tolist()))

    def crossings(self) -> Crossings:
        """Every crossing kept so far."""
        return all_crossings(self.chunks, self.system.laws)

    def latest(self, count: int) -> Crossings:
        """The last `count` crossings, at most those of the last call of the loop."""
        if not count:
            return no_crossings(self.system.laws)
        hits, places = self.chunks[-1]
        return crossings_of(hits[-count:], places[-count:], self.system.laws)

    def _chunk(self, record: bool, keep_hits: bool) -> Status:
        """Call the loop once, and collect what it has written."""
        begun, memory, wholes, d = self._begun, self._memory, self._wholes, len(self.start)
        budget = min(_CHUNK, self.settings.max_steps - wholes[_STEPS])
        rows, rows_x = self._room(budget) if record else begun.nowhere
        size, hits, places = FIRST_HITS, memory.hits, memory.places
        if self._room_for_hits > size:
            size = min(self._room_for_hits, _HITS_KEPT if keep_hits else _HITS_NOT_KEPT)
            hits, places = np.empty(size, dtype=HIT), np.empty((size, 3, d))
        saved = self.log.saved(memory.run, memory.w, memory.samples)
        started = time.thread_time()
        status = begun.march(
            self._ready.functions, begun.table.guards, memory.run, memory.p, memory.w, d, memory.coefficients,
            memory.nodes, memory.pieces, budget, rows, rows_x, hits, places, self.envelope, memory.samples,
            *self.log.arrays,
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
            steps = (self._reals[_T_END] - self._reals[_T]) / self._reals[_TAU]
            size = int(min(abs(steps), _CHUNK)) + 2  # a perturbation may have moved it beyond the end
        size = min(size, budget)
        self._room_for_rows = min(_MORE * size, _CHUNK)
        return np.empty(size, dtype=ROW), np.empty((size, len(self.start)))
