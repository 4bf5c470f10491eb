"""Members of an ensemble: many runs of one system and method, that differ in initial states and parameters."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.integration.member_starts import Places
from core.integration.members_loop import (
    ABANDONED,
    COUNTERS,
    DONE,
    END,
    NEXT,
    ROOM,
    USED,
    WANTED,
    compiled_members,
)  # fmt: skip
from core.integration.run_settings import Settings
from core.integration.runner import Runner
from core.integration.time_loop import compiled_march
from core.kernels.arrays import Floats
from core.methods import Method
from core.system import PiecewiseSystem
from core.transition.records import HIT, NO_MODE, ROW
from core.transition.status import CROSSING_KINDS, Status

__all__ = ["Block", "Members", "Told", "Wanted", "integrate_members", "not_begun"]

_CORNER = CROSSING_KINDS.index("corner")
#: Crossings that one call of the time loop can record: few enough to stay in the processor's cache.
_HITS = 64
#: Crossings for which a block has room at first, at least; where they are used up they are put aside.
_ROOM = 4096
#: The same at most: a member that uses up all room begins anew, and room that is not used takes no memory.
_MOST_ROOM = 2**18


class Wanted(NamedTuple):
    """Which crossings, or events, of each member are kept: see `members_loop.WANTED`."""

    events: int = 0
    surface: int = -1
    way: int = 0
    discard: int = 0
    most: int = 2**62

    def of(self, hits: NDArray[Any], first_mode: int, sides: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return which of the crossings of a member these are.

        A corner is a crossing of each surface of which it changes the side; the loop itself leaves those to `Runner`.

        Parameters
        ----------
        first_mode
            Mode in which the member began.
        sides
            `Laws.sides`.
        """
        which: NDArray[np.bool_] = (hits["rate_before"] * self.way >= 0.0) & (
            (self.surface < 0) | (hits["surface"] == self.surface)
        )
        if 0 <= self.surface < sides.shape[1]:
            before = np.concatenate([[first_mode], hits["mode"]])[:-1]
            change = sides[hits["mode"], self.surface] - sides[before, self.surface]
            which = np.where(hits["kind"] == _CORNER, (change != 0) & (change * self.way >= 0), which)
        number = np.cumsum(which)
        return np.asarray(which & (number > self.discard) & (number - self.discard <= self.most))


class Told:
    """Tells the loops in threads of this process to stop; those of another process never hear of it."""

    def __init__(self) -> None:
        self.flag = np.zeros(1, dtype=np.int64)

    def set(self) -> None:
        """Let them stop."""
        self.flag[0] = 1

    def __call__(self) -> bool:
        """Return whether they were told to stop."""
        return bool(self.flag[0])

    def __reduce__(self) -> tuple[type[Told], tuple[()]]:
        """Pickle without the flag, which does not leave its process."""
        return Told, ()


@dataclass(frozen=True)
class Members:
    """Some members of an ensemble, and what they have in common."""

    system: PiecewiseSystem
    method: Method
    settings: Settings
    t_span: tuple[float, float]
    x: Floats
    """(n, d) initial states."""
    p: Floats
    """(n, parameters) parameter values, in the order of `PiecewiseSystem.parameters`."""
    places: Places
    """Where the initial states lie."""
    wanted: Wanted | None
    """Which crossings are kept; None: none."""
    told: Told

    def __len__(self) -> int:
        return len(self.x)

    def part(self, which: slice) -> Members:
        """Some of the members."""
        rows, guards, plain = self.places
        places = Places(rows[which], guards[which], plain[which])
        return replace(self, x=self.x[which], p=self.p[which], places=places)

    def one(self, k: int) -> PiecewiseSystem:
        """The system of a member, given by its number."""
        names = (q.name for q in self.system.parameters)
        return self.system.with_parameters(**dict(zip(names, self.p[k].tolist(), strict=True)))


class Block(NamedTuple):
    """What members have come to."""

    ends: NDArray[Any]
    """(n,) of `members_loop.END`."""
    x: Floats
    """(n, d) last states."""
    hits: NDArray[Any]
    """(k,) of `records.HIT`: the crossings that are kept, member by member."""
    places: Floats
    """(k, 1, d) states there; (k, 2, d) with those after jumps, if the system has any."""


def integrate_members(members: Members) -> Block:
    """Integrate members one after another in the compiled loop; those that it does not settle, by a `Runner`."""
    return _Run(members).block()


def not_begun(members: Members) -> Block:
    """Members that were given up before they had begun."""
    run = _Run(members)
    return Block(run.ends, run.x, run.kept[:0], run.kept_places[:0])


class _Run:
    """Members under way."""

    def __init__(self, members: Members) -> None:
        self.members = members
        n, d = members.x.shape
        self.ends, self.x = np.zeros(n, dtype=END), members.x.copy()
        self.ends["t"], self.ends["status"] = members.t_span[0], Status.CANCELLED
        self.ends["mode"] = NO_MODE
        self.counters = np.zeros(COUNTERS, dtype=np.int64)
        self.aside: list[tuple[NDArray[Any], Floats]] = []
        self._make_room(min(max(_ROOM, members.wanted.most), _MOST_ROOM) if members.wanted else 1)
        wanted = members.wanted or Wanted(discard=2**62, most=2**62)
        self.wanted = np.array([tuple(wanted)], dtype=WANTED)
        self.settings = replace(members.settings, cancel=members.told)
        t0, t1 = members.t_span
        rows = members.places.rows
        self.first_rows = np.full(n, NO_MODE) if t0 == t1 else np.ascontiguousarray(rows)  # where nothing begins
        self.rows, self.rows_x = np.empty(1, dtype=ROW), np.empty((1, d))
        self.hits, self.places = np.empty(_HITS, dtype=HIT), np.empty((_HITS, 3, d))

    def block(self) -> Block:
        """Integrate all."""
        while (code := self._advance()) != DONE and code != ABANDONED:
            if code == ROOM:  # of one member that has used up all room there is twice as much next time
                used = int(self.counters[USED])
                self._put_aside(len(self.kept) if used else 2 * len(self.kept))
            else:
                self._integrate_one(int(self.counters[NEXT]))
        self._put_aside()
        hits, places = (np.concatenate(parts) for parts in zip(*self.aside, strict=True))
        return Block(self.ends, self.x, hits, places)

    def _advance(self) -> int:
        """Call the loop."""
        members = self.members
        runner = Runner(members.one(0), members.method, members.t_span[0], tuple(members.x[0].tolist()), self.settings)
        blank = runner.blank(members.t_span[1])
        memory = blank.memory
        return compiled_members()(
            compiled_march(), blank.functions, blank.guards, memory.record, memory.w, members.system.dimension,
            memory.coefficients, memory.nodes, memory.pieces, memory.record.copy(), memory.w.copy(), self.rows,
            self.rows_x, self.hits, self.places, blank.envelope, memory.samples, *blank.events, blank.budget,
            self.settings.max_steps, self.first_rows, members.places.guards, members.p, members.x, self.ends, self.x,
            self.wanted, self.kept, self.kept_places, self.counters, members.told.flag,
        )  # fmt: skip

    def _integrate_one(self, k: int) -> None:
        """Integrate the next member by a `Runner`."""
        members, wanted, met = self.members, self.members.wanted, 0

        def which(hits: NDArray[Any]) -> NDArray[np.bool_]:
            return (wanted or Wanted()).of(hits, runner.first_mode, members.system.laws.sides)

        def stops() -> bool:
            nonlocal met
            if wanted is None or wanted.events:
                return members.told()
            met = int(which(runner.hits()[0]).sum())
            return members.told() or met == wanted.most

        start, settings = tuple(members.x[k].tolist()), replace(self.settings, cancel=stops)
        runner = Runner(members.one(k), members.method, members.t_span[0], start, settings)
        status = runner.advance(members.t_span[1], keep_hits=wanted is not None and not wanted.events)
        if status is Status.CANCELLED and members.told():
            return
        self._put_aside()
        if wanted is not None:
            hits, places = runner.log.kept() if wanted.events else runner.hits()
            kept = which(hits)
            self.aside.append((hits[kept], places[kept][:, self._columns]))
            met = int(kept.sum())
            status = Status.CROSSING_LIMIT if met == wanted.most and not wanted.events else status
        self.ends[k] = runner.t, status, runner.mode, runner.steps, runner.evaluations, runner.crossing_count, met
        self.x[k] = runner.x
        self.counters[NEXT] = k + 1

    @property
    def _columns(self) -> list[int]:
        """Which of the three states at a crossing, or of the one at an event, are kept."""
        if self.members.wanted is not None and self.members.wanted.events:
            return [0]
        return [1, 2] if self.members.system.laws.jumps else [1]

    def _make_room(self, size: int) -> None:
        self.kept = np.empty(size, dtype=HIT)
        self.kept_places = np.empty((size, len(self._columns), self.members.system.dimension))
        self.counters[USED] = 0

    def _put_aside(self, room: int = 0) -> None:
        """Put the crossings kept so far aside, and make room for others: for as many as before where not given."""
        used = int(self.counters[USED])
        self.aside.append((self.kept[:used].copy(), self.kept_places[:used].copy()))
        self._make_room(room or len(self.kept))
