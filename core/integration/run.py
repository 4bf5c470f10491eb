"""A run in progress: its memory, and what it has come to."""

from __future__ import annotations

import copy
import math
from operator import itemgetter
from typing import Self

import numpy as np

from core.integration.beginning import beginning_of
from core.integration.crossings import Crossings
from core.integration.event_log import log_of
from core.integration.failure import Growth
from core.integration.hits import all_crossings, crossings_of, joined, no_crossings
from core.integration.memory import FIELDS
from core.integration.recorded import Chunk, Entry, Point
from core.integration.run_settings import Settings
from core.integration.starting import Place, first_place
from core.integration.unlike import begun_rows, kept_rows
from core.kernels.abi import SINGULAR_LENGTH, SINGULARITY, STEP
from core.kernels.arrays import Floats
from core.methods import Method
from core.symbolic.singularities import Singularity
from core.system import PiecewiseSystem
from core.transition.passes import PASSES
from core.transition.records import NO_JUMP, NO_MODE
from core.transition.status import Status

__all__ = ["AT_SURFACE", "SHORTER", "Run"]

#: Results of a run that stops at a surface.
AT_SURFACE = (Status.SLIDING, Status.REPELLING, Status.GRAZING, Status.CORNER, Status.UNDECLARED)
SHORTER = 2.0**-10
"""Mean length of steps, as part of the longest one, from which on they may have become shorter without end."""
#: Places of the fields of the record that are read or written for every run.
_T, _T_CARRY, _T_END, _TAU, _LONGEST, _MODE, _FIRST_MODE, _ROW, _GUARD = (
    FIELDS[name] for name in ("t", "t_carry", "t_end", "tau", "longest", "mode", "first_mode", "row", "guard")
)
_STEPS, _EVALUATIONS, _CROSSINGS, _SAMPLES, _PASSES, _MAX_CROSSINGS, _MAX_EVENTS = (
    FIELDS[name] for name in ("steps", "evaluations", "crossings", "samples", "passes", "max_crossings", "max_events")
)
_WANTED_SURFACE, _WANTED_WAY, _MAX_WANTED = (FIELDS[name] for name in ("wanted_surface", "wanted_way", "max_wanted"))
_LOOKS = itemgetter(*(FIELDS[name] for name in ("looks", "look_segment", "crossings", "changes", "doublings")))


class Run:
    """One initial value problem, and how far its integration has come.

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
    begun, ready, memory, record, reals, wholes
        For `Runner`: what it has begun from, the modes compiled for it, its memory, and parts of that.
    """

    status = Status.RUNNING
    seconds = 0.0
    """Processor time of the thread in the compiled loop."""
    growth: Growth | None = None
    """How the solution grows where the run has failed, if that could be told."""
    recent = math.inf
    """Mean length of a step in the last call of the loop that made many."""
    pole = math.nan
    """Time of a pole to which the run would need ever shorter steps, about; nan if none is known."""
    why_cornered = ""
    """Why the laws do not tell how to go on from the last corner; empty if they do."""
    corner: tuple[int, ...] = ()
    """Numbers of the surfaces on which it begins, if more than one."""

    def __init__(
        self, system: PiecewiseSystem, method: Method, t0: float, x0: tuple[float, ...], settings: Settings,
        columns: int = 0,
    ) -> None:  # fmt: skip
        self.system, self.settings, self.method, self.t0, self.start = system, settings, method, t0, x0
        laws = system.laws
        self.begun = begun = beginning_of(
            laws, method, settings.transition, settings.slides, settings.tolerance, columns > 0,
            settings.events.functions,
        )  # fmt: skip
        self.ready = begun.ready
        self.memory = memory = begun.lend(self.ready)
        self.record, self.reals, self.wholes = memory.record, memory.reals, memory.wholes
        memory.p[:], memory.x[:], self.reals[_T] = system.parameter_array, x0, t0
        self.wholes[_MAX_CROSSINGS], self.wholes[_MAX_EVENTS] = settings.max_crossings, settings.max_events
        wanted = settings.max_wanted
        self.wholes[_WANTED_SURFACE], self.wholes[_WANTED_WAY], self.wholes[_MAX_WANTED] = wanted
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
        given = self.settings.region
        place = first_place(self.system, self.t0, self.memory.x) if given == NO_MODE else Place(given)
        if place.region is None:
            raise ValueError(f"x0 = {self.start!r} lies in a region for which no law is declared; choose another state")
        row, self.corner = int(self.begun.table.first_rows[place.region]), place.corner
        self.wholes[_ROW], self.wholes[_GUARD] = row, place.guard
        if self.ready.functions[row, STEP] == 0:
            self.compile(place.region)

    @property
    def direction(self) -> float:
        """Positive where time runs on, negative where it runs back, 0 before the run is advanced."""
        return self.reals[_TAU]

    @property
    def t_end(self) -> float:
        """Time to which the run has been asked to go."""
        return self.reals[_T_END]

    @property
    def t(self) -> float:
        """Time."""
        return self.reals[_T]

    @property
    def x(self) -> Floats:
        """State (d,), a copy."""
        return self.memory.x.copy()

    @property
    def mode(self) -> int:
        """Number of the mode occupied; `NO_MODE` before the first step."""
        return self.wholes[_MODE]

    @property
    def first_mode(self) -> int:
        """Number of the mode in which the run began; `NO_MODE` before the first step."""
        return self.wholes[_FIRST_MODE]

    @property
    def jumps_here(self) -> bool:
        """Whether the state jumps at the surface that is met, of the mode occupied."""
        guard = self.wholes[_ROW] + int(self.record["guard"][0])
        return self.first_mode != NO_MODE and bool(self.begun.table.guards["jump"][guard] != NO_JUMP)

    @property
    def first_region(self) -> int:
        """Number of a region in which, or at the boundary of which, the run begins."""
        return int(self.begun.table.guards["mode"][self.wholes[_ROW]])

    @property
    def slides(self) -> bool:
        """Whether the run slides along a surface."""
        return self.mode >= len(self.system.laws.regions)

    @property
    def unlike(self) -> Floats:
        """(k, 3 + d) see `Trajectory.unlike`."""
        looks, segment, crossings, changes, doublings = _LOOKS(self.wholes)
        last = begun_rows(looks) if segment == crossings else []
        rows = np.array([*last, *kept_rows(changes, doublings, len(self.start))], dtype=np.intp)
        return self.memory.looks.take(rows, axis=0)

    @property
    def passes(self) -> Floats:
        """(k, 4 + d) see `Trajectory.passes`."""
        kept = [row for row in range(PASSES) if self.wholes[_PASSES] >> row & 1]
        return self.memory.passes.take(kept, axis=0)

    @property
    def samples(self) -> Floats:
        """(k, 3 + d) time, mode, length and state at the start of some steps; the length ends at a crossing."""
        return self.memory.samples[: self.wholes[_SAMPLES]].copy()

    @property
    def longest(self) -> float:
        """The longest step that a method has chosen."""
        return self.reals[_LONGEST]

    @property
    def steps(self) -> int:
        """Steps taken."""
        return self.wholes[_STEPS]

    @property
    def evaluations(self) -> int:
        """Evaluations of the (discrete) field."""
        return self.wholes[_EVALUATIONS]

    @property
    def crossing_count(self) -> int:
        """Number of crossings, kept or not."""
        return self.wholes[_CROSSINGS]

    @property
    def segment(self) -> int:
        """Index of the segment between crossings in which the run is.

        A crossing at which the run stops begins no new segment, unless the state has jumped, and ψ with it.
        """
        count = self.wholes[_CROSSINGS]
        return count - (count > 0 and self.status in AT_SURFACE and not self.system.laws.jumps)

    def compile(self, mode: int) -> None:
        """Compile a mode, besides those entered so far."""
        self.ready = self.begun.compile(mode)
        self.memory.coefficients = np.empty(self.ready.coefficients)

    @property
    def met(self) -> tuple[Singularity, float] | None:
        """The singularity that a step from here would pass, and the length of the step; None if it passes none."""
        number, t, h = self.memory.w[SINGULARITY : SINGULAR_LENGTH + 1].tolist()
        if number == 0.0 or self.mode == NO_MODE or t != self.t + self.reals[_T_CARRY]:
            return None
        return self.system.laws.mode(self.mode).singularities[int(number) - 1], h

    def hits(self) -> Chunk:
        """Every crossing kept so far, as the loop has written it: (k,) of `records.HIT`, and its states (k, 3, d)."""
        return joined(self.chunks, self.system.dimension)

    @property
    def last(self) -> Point:
        """Where it is."""
        return Point(self.reals[_T], tuple(self.memory.x.tolist()), self.wholes[_MODE])

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

    def copy(self) -> Self:
        """An independent copy."""
        other = copy.copy(self)
        other.memory = memory = self.begun.lend(self.ready)
        other.record, other.reals, other.wholes = memory.record, memory.reals, memory.wholes
        memory.take(self.memory)
        other.log = self.log.copy()
        return other

    def release(self) -> None:
        """Leave the memory to another run; this one must not be used any more."""
        self.begun.take_back(self.memory)
