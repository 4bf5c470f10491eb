"""Members of an ensemble: many runs of one system and method, that differ in initial states and parameters."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.compilation.compiled import Compiled
from core.integration.member_starts import Places, first_places
from core.integration.members_loop import (
    ABANDONED,
    COUNTERS,
    DONE,
    END,
    FAILED,
    FAILURES,
    NEXT,
    ROOM,
    USED,
    WANTED,
    compiled_members,
)  # fmt: skip
from core.integration.psi_change import compile_psi, largest_change, psi_arrays, size_of_psi
from core.integration.run_settings import ALL, CrossingsOf, Settings
from core.integration.runner import Runner
from core.interface.tasks import GivenUp
from core.kernels.abi import Frame
from core.kernels.arrays import Floats
from core.methods import Method
from core.system import PiecewiseSystem
from core.transition.records import HIT, NO_MODE, ROW, RUN
from core.transition.status import Status

__all__ = ["Block", "Members", "Wanted", "integrate_members", "not_begun"]

#: Crossings that one call of the time loop can record: few enough to stay in the processor's cache.
_HITS = 64
#: Steps likewise, where ψ is followed.
_ROWS = 512
#: Members that may fail before the loop returns.
_FAILURES = 64
#: Crossings for which a block has room at first, at least; where they are used up they are put aside.
_ROOM = 4096
#: The same at most: a member that uses up all room begins anew, and room that is not used takes no memory.
_MOST_ROOM = 2**18


class Wanted(NamedTuple):
    """What of each member is kept besides its end: see `members_loop.WANTED`."""

    events: int = 0
    surface: int = -1
    way: int = 0
    discard: int = 0
    most: int = 2**62
    psi: int = 0

    def of(self, hits: NDArray[Any], first_mode: int, sides: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return which of the crossings of a member these are.

        Parameters
        ----------
        first_mode
            Mode in which the member began.
        sides
            `Laws.sides`.
        """
        before = np.concatenate([[first_mode], hits["mode"]])[:-1]
        which = CrossingsOf(self.surface, self.way).among(hits, before, sides)
        number = np.cumsum(which)
        return np.asarray(which & (number > self.discard) & (number - self.discard <= self.most))

    @property
    def limit(self) -> CrossingsOf:
        """The crossings with the last of which a member ends."""
        if self.events or self.most == Wanted().most:
            return ALL
        return CrossingsOf(self.surface, self.way, self.discard + self.most)


@dataclass(frozen=True)
class Members:
    """Some members of an ensemble, and what they have in common."""

    system: PiecewiseSystem
    method: Method
    settings: Settings
    """What they have in common; its step size and perturbation are those below, if all are the same."""
    t_span: tuple[float, float]
    tau: Floats
    """(n,) step sizes."""
    shift: Floats
    """(n,) perturbations c·τᵖ."""
    x: Floats
    """(n, d) initial states."""
    p: Floats
    """(n, parameters) parameter values, in the order of `PiecewiseSystem.parameters`."""
    places: Places
    """Where the initial states lie."""
    wanted: Wanted | None
    """Which crossings are kept; None: none."""
    told: GivenUp

    @classmethod
    def of(
        cls, system: PiecewiseSystem, method: Method, settings: Settings, each: Sequence[Settings],
        t_span: tuple[float, float], x: Floats, p: Floats, wanted: Wanted | None, told: GivenUp,
    ) -> Members:  # fmt: skip
        """Make members of (n, d) states and (n, parameters) parameter values.

        If they differ in step size, `each` are the (n,) settings of each of them, else it is empty.
        """
        tau, shift = steps = np.empty((2, len(x)))
        steps.T[:] = [(one.tau, one.shift) for one in each or (settings,)]
        places = first_places(system.laws, t_span[0], x, p, settings.region)
        return cls(system, method, settings, t_span, tau, shift, x, p, places, wanted, told)

    def __len__(self) -> int:
        return len(self.x)

    def part(self, which: slice) -> Members:
        """Some of the members."""
        rows, guards, plain = self.places
        places = Places(rows[which], guards[which], plain[which])
        own = {name: getattr(self, name)[which] for name in ("tau", "shift", "x", "p")}
        return replace(self, places=places, **own)

    def runner(self, k: int, cancel: Callable[[], bool] | None = None, max_steps: int = sys.maxsize) -> Runner:
        """Make a run of a member, by its number, which takes no more steps than all may, and than these."""
        settings = replace(
            self.settings, tau=float(self.tau[k]), shift=float(self.shift[k]), cancel=cancel,
            max_steps=min(self.settings.max_steps, max_steps), max_wanted=(self.wanted or Wanted()).limit,
        )  # fmt: skip
        return Runner(self.one(k), self.method, self.t_span[0], tuple(self.x[k].tolist()), settings)

    def one(self, k: int) -> PiecewiseSystem:
        """The system of a member, given by its number."""
        if np.array_equal(self.p[k], self.system.parameter_array):
            return self.system
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
    """(k, 1, d) states there; (k, 2, d) with those after jumps, if the system has any; all three of `surface.Log`, if
    |Δψ| is wanted."""


def integrate_members(members: Members) -> Block:
    """Integrate members one after another in the compiled loop; those that it does not settle, by a `Runner`."""
    return _Run(members).block()


def not_begun(members: Members) -> Block:
    """Members that were given up before they had begun."""
    run = _Run(members)
    return Block(run.ends, run.x, run.kept[:0], run.kept_places[:0])


class _Failed(NamedTuple):
    """Members of which a step has failed, as arguments of the loop: see `members_loop`."""

    numbers: NDArray[np.int64]
    records: NDArray[Any]
    w: Floats
    hits: NDArray[Any]
    places: Floats

    @classmethod
    def none(cls, frame: int, d: int) -> _Failed:
        """Room for some of them, in a system of d variables, with frames of so many numbers."""
        n = _FAILURES
        places = np.empty((n, 3, d))
        return cls(np.empty(n, np.int64), np.zeros(n, RUN), np.empty((n, frame)), np.empty(n, HIT), places)


class _Run:
    """Members under way."""

    def __init__(self, members: Members) -> None:
        self.members = members
        n, d = members.x.shape
        wanted = members.wanted or Wanted(discard=2**62, most=2**62)
        self._follows = bool(wanted.psi) and size_of_psi(members.system.laws, members.settings.slides) > 0
        self.wanted = np.array([tuple(wanted._replace(psi=int(self._follows)))], dtype=WANTED)
        self.ends, self.x = np.zeros(n, dtype=END), members.x.copy()
        self.ends["t"], self.ends["status"] = members.t_span[0], Status.CANCELLED
        self.ends["mode"] = self.ends["first_mode"] = NO_MODE
        self.ends["change_of_psi"] = np.nan
        self.counters = np.zeros(COUNTERS, dtype=np.int64)
        self.aside: list[tuple[NDArray[Any], Floats]] = []
        self._make_room(min(max(_ROOM, members.wanted.most), _MOST_ROOM) if members.wanted else 1)
        t0, t1 = members.t_span
        rows = members.places.rows
        self.first_rows = np.full(n, NO_MODE) if t0 == t1 else np.ascontiguousarray(rows)  # where nothing begins
        room = _ROWS if self._follows else 1
        self.rows, self.rows_x = np.empty(room, dtype=ROW), np.empty((room, d))
        self.hits, self.places = np.empty(_HITS, dtype=HIT), np.empty((_HITS, 3, d))
        self.failed = _Failed.none(Frame(d, members.system.laws.most_conserved_sliding).empty().size, d)

    def block(self) -> Block:
        """Integrate all."""
        self._prepare()
        while (code := self._advance()) != DONE and code != ABANDONED:
            if code == FAILURES:
                self._look_into_failures()
            elif code == ROOM:  # of one member that has used up all room there is twice as much next time
                used = int(self.counters[USED])
                self._put_aside(len(self.kept) if used else 2 * len(self.kept))
            else:
                self._integrate_one(int(self.counters[NEXT]))
                self._prepare()  # it may have compiled a mode
        self._look_into_failures()
        self._put_aside()
        hits, places = (np.concatenate(parts) for parts in zip(*self.aside, strict=True))
        return Block(self.ends, self.x, hits, places)

    def _prepare(self) -> None:
        """Make what all members begin from."""
        members, laws = self.members, self.members.system.laws
        self.first = self.members.runner(0, members.told)  # with its functions, kept for as long as the loop calls them
        self.blank = self.first.blank(members.t_span[1])
        none = Compiled(self.blank.functions[:0], ())
        self.psi_functions = compile_psi(laws, members.method) if self._follows else none
        self.psi = psi_arrays(laws, self.psi_functions, members.settings.slides)

    def _look_into_failures(self) -> None:
        """Find out why steps of members have failed."""
        failed, statuses = self.failed, self.ends["status"]
        for n, k in enumerate(failed.numbers[: int(self.counters[FAILED])].tolist()):
            if self.members.told():  # nobody takes what has been found
                break
            last_hit = failed.hits[n : n + 1], failed.places[n : n + 1]
            runner, status = self.members.runner(k, self.members.told), Status(int(statuses[k]))
            statuses[k] = runner.fail(status, failed.records[n : n + 1], failed.w[n], last_hit)
            runner.release()
        self.counters[FAILED] = 0

    def _advance(self) -> int:
        """Call the loop."""
        members, laws, blank, memory = self.members, self.members.system.laws, self.blank, self.blank.memory
        return compiled_members()(
            self.first.begun.march, blank.functions, blank.guards, memory.record, memory.w, members.system.dimension,
            memory.coefficients, memory.nodes, memory.pieces, memory.record.copy(), memory.w.copy(), self.rows,
            self.rows_x, self.hits, self.places, blank.envelope, memory.samples, memory.looks, memory.passes,
            *blank.events, blank.budget, members.settings.max_steps, self.first_rows, members.places.guards,
            members.tau, members.shift, members.p, members.x, self.ends, self.x, self.wanted, self.kept,
            self.kept_places, self.counters, members.told.flag, *self.psi, len(laws.regions), int(laws.jumps),
            *self.failed,
        )  # fmt: skip

    def _integrate_one(self, k: int) -> None:
        """Integrate the next member by a `Runner`."""
        members, wanted, met = self.members, self.members.wanted, 0
        runner = members.runner(k, members.told)
        keeps_hits = wanted is not None and not wanted.events
        status = runner.advance(members.t_span[1], record=self._follows, keep_hits=keeps_hits)
        if status is Status.CANCELLED and members.told():
            return
        self._put_aside()
        if wanted is not None:
            hits, places = runner.log.kept() if wanted.events else runner.hits()
            kept = wanted.of(hits, runner.first_mode, members.system.laws.sides)
            self.aside.append((hits[kept], places[kept][:, self._columns]))
            met = int(kept.sum())
        counts = runner.steps, runner.evaluations, runner.crossing_count, met
        change = largest_change(runner) if self._follows else np.nan
        self.ends[k] = runner.t, status, runner.mode, *counts, runner.first_mode, change, runner.record["unlike"][0]
        self.x[k] = runner.x
        self.counters[NEXT] = k + 1

    @property
    def _columns(self) -> list[int]:
        """Which of the three states at a crossing, or of the one at an event, are kept."""
        if self.members.wanted is not None and self.members.wanted.events:
            return [0]
        if self._follows:
            return [0, 1, 2]
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
