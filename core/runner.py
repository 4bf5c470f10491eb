"""A run in progress: the compiled loop, called in chunks, with what it has written collected between them."""

from __future__ import annotations

import copy
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from core.compiled import compile_steps, compile_surface
from core.laws import Floats
from core.march import compiled_march
from core.methods import Method
from core.state import HIT, ROW, RUN
from core.system import PiecewiseSystem
from core.trajectory import CROSSING_KINDS, Crossings, Status

__all__ = ["Rows", "Runner", "Settings"]

#: Steps between looks at the cancel flag: some milliseconds, beside which the quarter of one for a call is small.
_CHUNK = 131072
_HITS = 4096
_RUNAWAY = 4.0  #: growth of the state from which a failed step may be an escape


@dataclass(frozen=True)
class Settings:
    """How to step, apart from the method."""

    tau: float
    transition: bool = True
    shift: float = 0.0
    """What is added to every crossing time: c·τᵖ."""
    max_crossings: int = 5_000_000
    max_steps: int = 10**9
    cancel: Callable[[], bool] | None = None


@dataclass
class Rows:
    """What the loop has written so far."""

    t: list[Floats]
    x: list[Floats]
    side: list[NDArray[np.int64]]
    segment: list[NDArray[np.int64]]


class Runner:
    """Integrates one initial value; may be told to go on to later and later times.

    Attributes
    ----------
    status, t, x, side, first_side
        Where the run is now, and the side it started on (0 if it could not leave the surface).
    rows
        States recorded at every step, where asked for.
    seconds
        Processor time of the compiled loop: what else the process does at the same time does not count.
    """

    def __init__(
        self, system: PiecewiseSystem, method: Method, t0: float, x0: tuple[float, ...], settings: Settings
    ) -> None:
        self.system, self.settings = system, settings
        surface = compile_surface(system.laws)
        self._march = compiled_march()
        self._functions = (*compile_steps(system.laws, method), *surface)
        self._p = system.parameter_array
        self._x, self._carry = np.array(x0, dtype=float), np.zeros(system.dimension)
        self._work = np.empty((2, system.dimension))
        self._hit_chunks: list[tuple[NDArray[Any], Floats]] = []
        self._size0 = float(np.linalg.norm(self._x))
        self.rows = Rows([], [], [], [])
        self.status, self.seconds = Status.RUNNING, 0.0
        self.first_side = 0
        self._run = np.zeros(1, dtype=RUN)
        self._run["t"] = t0
        self._run["max_crossings"] = settings.max_crossings
        self._run["follow"] = settings.transition
        self._run["has_jump"] = system.jump is not None

    @property
    def t(self) -> float:
        """Time."""
        return float(self._run["t"][0])

    @property
    def x(self) -> Floats:
        """State (d,), a copy."""
        return self._x.copy()

    @property
    def side(self) -> int:
        """Side occupied; 0 before the first step."""
        return int(self._run["side"][0])

    @property
    def steps(self) -> int:
        """Steps taken."""
        return int(self._run["steps"][0])

    @property
    def evaluations(self) -> int:
        """Evaluations of the (discrete) field."""
        return int(self._run["evaluations"][0])

    @property
    def crossing_count(self) -> int:
        """Crossings made, kept or not."""
        return int(self._run["crossings"][0])

    @property
    def segment(self) -> int:
        """Index of the segment between crossings that the run is in: a crossing it stopped at opens no other."""
        stopped = self.status in (Status.SLIDING, Status.REPELLING, Status.GRAZING)
        return max(self.crossing_count - stopped, 0)

    def advance(self, t_end: float, record: bool = False, keep_hits: bool = True) -> Status:
        """Go on to `t_end`, or to where the run stops before it."""
        run = self._run
        sign = 1.0 if t_end >= self.t else -1.0
        run["t_end"], run["tau"], run["record"] = t_end, sign * self.settings.tau, record
        run["shift"] = sign * self.settings.shift
        self.status = Status.COMPLETED if t_end == self.t else Status.RUNNING
        if self.side == 0 and self.status is Status.RUNNING:
            self.status = self._enter(sign)
        while self.status is Status.RUNNING:
            if self.steps >= self.settings.max_steps:
                self.status = Status.STEP_LIMIT
            elif self.settings.cancel is not None and self.settings.cancel():
                self.status = Status.CANCELLED
            else:
                self.status = self._chunk(record, keep_hits)
        if self.status is Status.NO_CONVERGENCE and self._runs_away():
            self.status = Status.ESCAPED
        return self.status

    def glance(self, t: float) -> Floats | None:
        """State at time t, of a copy that goes on to there: this run itself stays on its grid. None if it stops."""
        ahead = copy.copy(self)
        ahead._run, ahead._x, ahead._carry = self._run.copy(), self._x.copy(), self._carry.copy()
        return ahead.x if ahead.advance(t) is Status.COMPLETED else None

    def crossings(self) -> Crossings:
        """Every crossing kept so far."""
        d = self.system.dimension
        empty = (np.empty(0, dtype=HIT), np.empty((0, 3, d)))
        hits, places = (np.concatenate(parts) for parts in zip(empty, *self._hit_chunks, strict=True))
        surface, x, after = (np.ascontiguousarray(places[:, k]) for k in range(3))
        columns = {name: np.ascontiguousarray(hits[name]) for name in ("t", "g", "side", "rate_before", "rate_after")}
        return Crossings(x=x, x_after=after, surface=surface, kind=np.array(CROSSING_KINDS)[hits["kind"]], **columns)

    def _enter(self, sign: float) -> Status:
        """Find the side of the initial value: by the sign of g, on the surface by where the fields lead."""
        run, t, x, p = self._run, self.t, self._x, self._p
        switching, rate = self._functions[2], self._functions[3]
        g = switching(t, x, p)
        if not np.isfinite(g):
            return Status.NO_CONVERGENCE
        into = {side: sign * side * rate(side, t, x, p) for side in (-1, 1)}
        # On the surface as exactly as floating point can say: rounding x alone could move g by as much.
        slack = np.finfo(float).eps * float(np.abs(self.system.switching_gradient(t, x) * x).sum())
        side = 1 if g > 0 else -1
        if abs(g) <= slack:
            inward = [s for s in (-1, 1) if into[s] > 0]
            if len(inward) != 1:
                stopped = Status.REPELLING if inward else Status.SLIDING
                return Status.GRAZING if not inward and 0.0 in into.values() else stopped
            side = inward[0]
            run["leaving"] = 1
        run["side"], run["rate"] = side, into[side]
        self.first_side = side
        return Status.RUNNING

    def _chunk(self, record: bool, keep_hits: bool) -> Status:
        budget = min(_CHUNK, self.settings.max_steps - self.steps)
        size, d = (budget if record else 0), self.system.dimension
        rows, rows_x = np.empty(size, dtype=ROW), np.empty((size, d))
        hits = (np.empty(_HITS, dtype=HIT), np.empty((_HITS, 3, d)))
        if not record:
            rows, rows_x = np.empty(1, dtype=ROW), np.empty((1, d))  # a buffer never full
        started = time.thread_time()
        status = self._march(
            *self._functions, self._p, self._run, self._x, self._carry, self._work, budget, rows, rows_x, *hits
        )
        self.seconds += time.thread_time() - started
        self._collect(int(self._run["rows"][0]), rows, rows_x)
        if n := int(self._run["hits"][0]):
            chunk = (hits[0][:n], hits[1][:n])
            self._hit_chunks = [*self._hit_chunks, chunk] if keep_hits else [chunk]
        return Status(status)

    def _collect(self, n: int, rows: NDArray[Any], rows_x: Floats) -> None:
        if n:
            self.rows.t.append(rows["t"][:n])
            self.rows.x.append(rows_x[:n])
            self.rows.side.append(rows["side"][:n])
            self.rows.segment.append(rows["segment"][:n])

    def _runs_away(self) -> bool:
        """Whether a step failed because the state is on its way to infinity.

        That is: grown well beyond where it started, and about to grow by a good part of itself within one step more.
        """
        size = float(np.linalg.norm(self._x))
        ahead = self._x + float(self._run["tau"][0]) * self.system.field(self.side or 1, self.t, self._x)
        return size > _RUNAWAY * self._size0 and not float(np.linalg.norm(ahead)) < 1.25 * size
