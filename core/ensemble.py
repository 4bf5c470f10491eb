"""ensemble(): integrate many members of one system in the compiled loop, on all processors."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from core.integrate import checked_method, checked_region, checked_settings, checked_span, checked_start, run_warning
from core.integration.crossings import Integers
from core.integration.events import Event, Watched, checked_events
from core.integration.finished import trajectory_of
from core.integration.kept import EnsembleCrossings, EnsembleEvents
from core.integration.members import Block, Members, Wanted, integrate_members, not_begun
from core.integration.members_loop import END
from core.integration.run_settings import Settings
from core.interface.arguments import choice, number, numbers
from core.interface.cancelling import Cancel
from core.interface.tasks import GivenUp, as_completed, check_hooks
from core.kernels.arrays import Floats
from core.methods import Method
from core.symbolic.laws import Laws
from core.system import PiecewiseSystem
from core.systems import System, system_of
from core.transition.records import HIT
from core.transition.status import Status

__all__ = [
    "MOST", "Ensemble", "EnsembleCrossings", "EnsembleEvents", "checked_discard", "checked_members", "ensemble",
    "integrate_all",
]  # fmt: skip

#: Most crossings of a member that may be asked for, and that may be left out.
MOST = 10**12
#: Most parts into which the members are divided, for progress and for the threads to end together.
_PARTS = 128
#: Most steps of a member that are made again to be looked into: they take up to a second.
_MOST_MADE_AGAIN = 2_000_000
#: Least members of a part: a part takes some 0.1 ms of Python.
_LEAST = 16
#: Members whose steps are looked into for a message, of those whose rates change most, and of all.
_LOOKED_INTO = 4
_RECORDS = ("end", "crossings", "events")
#: Default max_crossings and max_events where they are counted and not recorded.
_UNBOUNDED = 10**9


@dataclass(frozen=True, eq=False)
class Ensemble:
    """Where many members have come to; each as `integrate` would have brought it there, to the last bit."""

    system: PiecewiseSystem
    method: str
    t: Floats
    """(n,) times reached."""
    x: Floats
    """(n, d) states there."""
    status: Integers
    """(n,) `core.Status` of each."""
    mode: Integers
    """(n,) index into `PiecewiseSystem.modes` of the mode occupied; −1 where a member has not begun."""
    steps: Integers
    """(n,) steps taken."""
    evaluations: Integers
    """(n,) evaluations of the (discrete) field."""
    crossing_count: Integers
    """(n,) crossings of each, kept or not."""
    crossings: EnsembleCrossings
    """Those that are kept, with ``record="crossings"``."""
    events: EnsembleEvents
    """Those that are kept, with ``record="events"``."""
    unlike: Floats
    """(n,) largest change of a rate seen in the run of each, relative to the largest such rate; see `message`."""
    members: Members = field(repr=False)
    """What the members began from."""

    def __len__(self) -> int:
        return len(self.t)

    def __repr__(self) -> str:
        ends = ", ".join(f"{count} {status.name}" for status, count in self.outcomes.items())
        return f"<Ensemble of {len(self)} members of {self.system.name!r} by {self.method}: {ends}>"

    @cached_property
    def message(self) -> str:
        """How the members ended, and a warning where one of them has steps that are too long, as its own run says it.

        Looked into are those members of which the loop has seen the rates change most from step to step, and some
        others, each for two million steps at most. It is worked out when it is first read.
        """
        ends = ", ".join(f"{count} {status.name}" for status, count in self.outcomes.items())
        told = ((k, self.warning(k)) for k in self._doubtful)
        warned = next((f"Member {k}: {words}" for k, words in told if words), "")
        return f"{len(self)} members: {ends}. {warned}".strip()

    def warning(self, member: int) -> str:
        """What the run of a member warns of; empty where there is nothing to warn of."""
        if self.status[member] == Status.CANCELLED:
            return ""
        runner = self.members.runner(member, max_steps=_MOST_MADE_AGAIN)
        runner.advance(self.members.t_span[1], keep_hits=False)
        told = run_warning(trajectory_of(runner, "end", False, None, run_warning))
        runner.release()
        return told

    @property
    def _doubtful(self) -> list[int]:
        """Numbers of the members that are looked into, those first that are most likely to have steps too long."""
        worst = np.argsort(-np.nan_to_num(self.unlike), kind="stable")[:_LOOKED_INTO]
        others = np.linspace(0, len(self) - 1, min(_LOOKED_INTO, len(self))).astype(int)
        return list(dict.fromkeys([*worst.tolist(), *others.tolist()]))

    @cached_property
    def outcomes(self) -> dict[Status, int]:
        """How many members ended in which status."""
        found, counts = np.unique(self.status, return_counts=True)
        return {Status(status): int(count) for status, count in zip(found, counts, strict=True)}


def ensemble(
    system: System,
    t_span: tuple[float, float],
    x0: ArrayLike | None = None,
    parameters: Mapping[str, ArrayLike] | None = None,
    tau: ArrayLike | None = None,
    method: str | Method = "dmm2",
    *,
    tolerance: float | None = None,
    transition: str = "mannshardt",
    perturbation_order: int | None = None,
    perturbation_scale: float = 1.0,
    record: str = "end",
    max_crossings: int | None = None,
    discard: int = 0,
    max_steps: int | None = None,
    sliding: str = "stop",
    events: str | Event | Sequence[str | Event] = (),
    max_events: int | None = None,
    region: str | None = None,
    executor: Executor | None = None,
    cancel: Cancel | None = None,
    progress: Callable[[float], object] | None = None,
) -> Ensemble:
    """Integrate many members of one system, which differ in initial states, parameters and step sizes.

    The loop over the members is compiled, and runs on all processors. Each member comes out as `integrate` brings it
    there, bit by bit.

    Parameters
    ----------
    system, t_span, method, tolerance, transition, perturbation_order, perturbation_scale, max_steps, sliding,
    events, region
        As of `integrate`.
    x0
        (n, d) initial states, or (d,) for all; the system's own where not given.
    parameters
        Name of a parameter -> (n,) values, or a number for all.
    tau
        (n,) step sizes, or a number for all.
    record
        "end": the last state of each member. "crossings": also its crossings, of which there are at most
        n·(max_crossings − discard), each of 12 + 8·d bytes (12 + 16·d where the system has jumps), and of up to 200
        more while they are computed. "events": also its events, of which there are at most n·(max_events − discard).
    max_crossings
        Number of crossings after which a member stops (CROSSING_LIMIT). Needed with record="crossings", as a bound on
        the memory; else 10⁹ where not given.
    max_events
        Number of events after which a member stops (EVENT_LIMIT). Needed with record="events"; else 10⁹ where not
        given.
    discard
        Number of the first crossings, or events, of each member that are not kept: a transient.
    executor
        Any of `concurrent.futures`, to integrate parts of the members elsewhere: see `core.interface.tasks`. None: on
        a thread a processor.
    cancel
        Called twenty times a second; once it returns True, the members that are not done are given up: CANCELLED, with
        the time and state in which they began.
    progress
        Called with the part of the members done, from 0 to 1, as they are.

    Returns
    -------
    Ensemble

    Raises
    ------
    ValueError
        On arguments that make no sense; of a member that cannot begin, the message tells the number.
    """
    check_hooks(cancel, progress, executor)
    system = system_of(system)
    chosen = checked_method(system, method)
    span, limits = checked_span(t_span), {"crossings": max_crossings, "events": max_events}
    if choice(record, "record", _RECORDS) != "end" and limits[record] is None:
        raise ValueError(f'record="{record}" needs max_{record}, the most {record} of a member: they bound the memory')
    watched = checked_events(system, events)

    def settings_with(step: Any) -> Settings:
        return checked_settings(
            chosen, step, tolerance, transition, perturbation_order, perturbation_scale,
            _UNBOUNDED if max_crossings is None else max_crossings, max_steps, None, sliding, watched,
            _UNBOUNDED if max_events is None else max_events, checked_region(system, region),
        )  # fmt: skip

    each = None if tau is None or np.ndim(tau) == 0 else [settings_with(step) for step in _step_sizes(tau)]
    settings = settings_with(tau if each is None else None)
    first = checked_discard(discard)
    _check_limits(record, limits, watched, first)
    wanted = None if record == "end" else Wanted(events=int(record == "events"), discard=first)
    members = checked_members(system, chosen, settings, span, x0, parameters, wanted, each)
    return integrate_all(members, executor, cancel, progress)


def _check_limits(record: str, limits: Mapping[str, int | None], events: Watched, discard: int) -> None:
    """Refuse limits of events where there are none, and to leave out more than a member may have."""
    if not events.functions and (record == "events" or limits["events"] is not None):
        what = 'record="events"' if record == "events" else f"max_events = {limits['events']}"
        raise ValueError(f"{what}: it needs events, the functions whose zeros are looked for")
    most = limits.get(record)
    if most is not None and discard > most:
        raise ValueError(f"discard = {discard}: a member has {most} {record} at most (max_{record})")


def checked_discard(discard: int) -> int:
    """Return how many of the first crossings are left out; ValueError if that is no such number."""
    first = number(discard, "discard")
    if first < 0 or first != int(first) or first > MOST:
        raise ValueError(f"discard = {discard!r}: a whole number from 0 to {MOST:,} is needed")
    return int(first)


def checked_members(
    system: PiecewiseSystem,
    method: Method,
    settings: Settings,
    t_span: tuple[float, float],
    x0: ArrayLike | None,
    parameters: Mapping[str, ArrayLike] | None,
    wanted: Wanted | None,
    each: Sequence[Settings] | None = None,
) -> Members:
    """Return the members of an ensemble; ValueError if their states or parameters make no sense.

    If they differ in step size, `each` are the settings of each of them.
    """
    x, p = _checked_arrays(system, x0, parameters, None if each is None else len(each))
    members = Members.of(system, method, settings, each or (), t_span, x, p, wanted, GivenUp())
    for k in np.flatnonzero(~members.places.plain).tolist():  # the doubtful ones are checked as `integrate` does
        try:
            checked_start(members.one(k), t_span[0], tuple(x[k].tolist()), system.laws.named_region(settings.region))
        except ValueError as reason:
            raise ValueError(f"member {k}: {reason}") from None
    return members


def integrate_all(
    members: Members, executor: Executor | None, cancel: Cancel | None, progress: Callable[[float], object] | None
) -> Ensemble:
    """Integrate members part by part; see `ensemble`."""
    blocks: dict[int, Block] = {}
    parts, done = list(_parts(len(members))), 0
    try:
        for k, block in as_completed(integrate_members, (members.part(part) for part in parts), executor, cancel):
            blocks[k] = block
            done += len(block.ends)
            if progress is not None:
                progress(done / len(members))
    finally:
        members.told.set()  # threads that still run do so for nobody
    all_parts = (blocks[k] if k in blocks else not_begun(members.part(part)) for k, part in enumerate(parts))
    return _joined(members, list(all_parts))


def _checked_arrays(
    system: PiecewiseSystem, x0: ArrayLike | None, parameters: Mapping[str, ArrayLike] | None, steps: int | None
) -> tuple[Floats, Floats]:
    """Initial states (n, d) and parameter values (n, parameters); ValueError if they make no sense.

    `steps` is the number of step sizes, where they are given one by one.
    """
    d, names = system.dimension, [q.name for q in system.parameters]
    states = numbers(system.x0 if x0 is None else x0, "x0")
    if states.ndim not in (1, 2) or states.shape[-1] != d:
        raise ValueError(f"x0 has shape {states.shape}: (n, {d}), or ({d},) for all members, is needed")
    columns = {}
    if not isinstance(given := {} if parameters is None else parameters, Mapping):
        raise ValueError(f"parameters = {parameters!r}: a mapping from names to values is needed")
    for name, values in given.items():
        if name not in names:
            raise ValueError(f"unknown parameter {name!r}; known are {', '.join(names) or 'none'}")
        columns[name] = numbers(values, f"parameter {name}")
        if columns[name].ndim > 1:
            raise ValueError(f"parameter {name} has shape {columns[name].shape}: (n,), or a number for all, is needed")
        for extreme in (columns[name].min(initial=np.inf), columns[name].max(initial=-np.inf)):
            if columns[name].size:
                system.parameters[names.index(name)].check(float(extreme))
    lengths = {len(states)} if states.ndim == 2 else set()
    lengths |= {len(column) for column in columns.values() if column.ndim} | (set() if steps is None else {steps})
    if len(lengths) > 1:
        numbers_of = " and ".join(map(str, sorted(lengths)))
        raise ValueError(f"x0, parameters and tau are of {numbers_of} members: give as many of each")
    n = lengths.pop() if lengths else 1
    p = np.empty((n, len(names)))
    p[:] = system.parameter_array
    for name, column in columns.items():
        p[:, names.index(name)] = column
    return np.array(np.broadcast_to(states, (n, d)), order="C"), p


def _step_sizes(tau: ArrayLike | None) -> list[float]:
    """(n,) step sizes as numbers; ValueError if they are none."""
    sizes = numbers(tau, "tau")
    if sizes.ndim != 1:
        raise ValueError(f"tau has shape {sizes.shape}: (n,), or a number for all, is needed")
    return list(sizes.tolist())


def _parts(count: int) -> Iterator[slice]:
    """Divide the members."""
    size = max(_LEAST, -(-count // _PARTS))
    yield from (slice(begin, min(begin + size, count)) for begin in range(0, count, size))


def _joined(members: Members, blocks: list[Block]) -> Ensemble:
    """Put the parts together."""
    d, laws = members.system.dimension, members.system.laws
    ends = np.concatenate([np.empty(0, dtype=END), *(block.ends for block in blocks)])
    hits = np.concatenate([np.empty(0, dtype=HIT), *(block.hits for block in blocks)])
    of_events = members.wanted is not None and bool(members.wanted.events)
    columns = 2 if laws.jumps and not of_events else 1
    places = np.concatenate([np.empty((0, columns, d)), *(block.places for block in blocks)])
    offsets = np.concatenate([[0], np.cumsum(ends["kept"])])
    none = hits[:0], places[:0], np.zeros_like(offsets)
    found = hits, places, offsets
    crossings = _crossings(*(none if of_events else found), laws)
    events = _events(*(found if of_events else none))
    own = {name: np.ascontiguousarray(ends[name]) for name in ("t", "status", "mode", "steps", "evaluations")}
    last = np.concatenate([np.empty((0, d)), *(block.x for block in blocks)])
    counts = np.ascontiguousarray(ends["crossings"])
    return Ensemble(
        members.system, members.method.name, x=last, crossing_count=counts, crossings=crossings, events=events,
        unlike=np.ascontiguousarray(ends["unlike"]), members=members, **own,
    )  # fmt: skip


def _crossings(hits: NDArray[Any], places: Floats, offsets: Integers, laws: Laws) -> EnsembleCrossings:
    x = np.ascontiguousarray(places[:, 0])
    return EnsembleCrossings(
        np.ascontiguousarray(hits["t"]), x, np.ascontiguousarray(places[:, 1]) if places.shape[1] > 1 else x,
        hits["mode"].astype(np.int16), hits["kind"].astype(np.int8), hits["surface"].astype(np.int8), offsets,
        laws.sides,
    )  # fmt: skip


def _events(hits: NDArray[Any], places: Floats, offsets: Integers) -> EnsembleEvents:
    return EnsembleEvents(
        np.ascontiguousarray(hits["t"]), np.ascontiguousarray(places[:, 0]), hits["surface"].astype(np.int16),
        hits["kind"].astype(np.int8), hits["mode"].astype(np.int16), offsets,
    )  # fmt: skip
