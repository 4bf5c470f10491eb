"""Events of a run: what it is asked to look for, and what it has found."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray
from sympy import Expr

from core.integration.crossings import Integers, with_columns
from core.interface.arguments import listed
from core.kernels.arrays import Floats
from core.symbolic.expressions import TIME, parse
from core.symbolic.source_text import quoted
from core.system import PiecewiseSystem
from core.transition.records import EVENT

__all__ = ["NOTHING", "Event", "Events", "Watched", "checked_direction", "checked_events", "events_of"]


@dataclass(frozen=True)
class Event:
    """A function h(t, x) whose zeros are looked for along a run, which they do not change."""

    function: str
    """h, an expression in the variables, the parameters and t."""
    direction: int = 0
    """1: where dh/dt > 0, −1: where dh/dt < 0, 0: both. Of a run that goes back in time that is the sign of dh/dt too,
    and not of the change along the run."""
    terminal: bool = False
    """Whether the run ends at the first such zero."""


@dataclass(frozen=True)
class Watched:
    """The event functions of a run, checked."""

    texts: tuple[str, ...] = ()
    functions: tuple[Expr, ...] = ()
    ways: tuple[int, ...] = ()
    ends: tuple[bool, ...] = ()

    def table(self) -> NDArray[Any]:
        """(n,) of `records.EVENT`, of a run that has not begun."""
        table = np.zeros(len(self.functions), dtype=EVENT)
        table["way"], table["ends"] = self.ways, self.ends
        return table


#: No event functions.
NOTHING = Watched()


@dataclass(frozen=True, eq=False)
class Events:
    """The events of a run, in the order in which they took place: a sequence, stored as one array for each field.

    ``events[k]`` are the arrays of one event, or of a selection, as ``events[events.direction == 1]``.
    """

    functions: tuple[str, ...] = ()
    """The event functions, as given."""
    directions: tuple[int, ...] = ()
    """The direction in which each is looked for: see `Event.direction`."""
    t: Floats = field(default_factory=lambda: np.empty(0))
    """(k,) times."""
    x: Floats = field(default_factory=lambda: np.empty((0, 0)))
    """(k, d) states; where a crossing is met at the same time, before its jump."""
    number: Integers = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    """(k,) index into `functions`."""
    direction: Integers = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    """(k,) 1 where the function increases with time, −1 where it decreases."""
    mode: Integers = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    """(k,) index into `PiecewiseSystem.modes` of the mode occupied before."""
    rate: Floats = field(default_factory=lambda: np.empty(0))
    """(k,) time derivative of the function along the field of that mode."""
    residual: Floats = field(default_factory=lambda: np.empty(0))
    """(k,) value of the function: zero up to rounding."""

    def __repr__(self) -> str:
        counts = [f"{n} of {self.functions[k]!r}" for k, n in enumerate(self.counts.tolist())]
        return f"<Events: {', '.join(counts) or 'none'}>"

    def __len__(self) -> int:
        return len(self.t)

    def __iter__(self) -> Iterator[Events]:
        return (self[k : k + 1] for k in range(len(self)))

    @overload
    def __getitem__(self, which: int) -> Events: ...

    @overload
    def __getitem__(self, which: slice | Integers | NDArray[np.bool_]) -> Events: ...

    def __getitem__(self, which: Any) -> Events:
        rows = [which] if isinstance(which, (int, np.integer)) else which
        return Events(self.functions, self.directions, *(getattr(self, f.name)[rows] for f in fields(self)[2:]))

    @cached_property
    def counts(self) -> Integers:
        """(functions,) number of events of each."""
        return np.bincount(self.number, minlength=len(self.functions)).astype(np.int64)

    def of(self, number: int) -> Events:
        """The events of one function, by its index."""
        return self[self.number == number]

    def columns(self, variables: tuple[str, ...]) -> dict[str, NDArray[Any]]:
        """One (k,) array a column, as data frames take them; `variables` are the names of the d coordinates."""
        columns: dict[str, NDArray[Any]] = {"t": self.t}
        columns |= {name: self.x[:, i] for i, name in enumerate(variables)}
        return with_columns(columns, {n: getattr(self, n) for n in ("number", "direction", "mode", "rate", "residual")})


def events_of(watched: Watched, found: NDArray[Any], places: Floats) -> Events:
    """Events from records `HIT` and their states (k, 1, d)."""
    names = ("surface", "kind", "mode", "rate_before", "g")
    columns = [np.ascontiguousarray(found[name]) for name in names]
    return Events(
        watched.texts, watched.ways, np.ascontiguousarray(found["t"]), np.ascontiguousarray(places[:, 0]), *columns
    )


def checked_events(system: PiecewiseSystem, events: Any) -> Watched:
    """Return the event functions of a run: an `Event`, or text for one in both directions, or a sequence of these.

    Raises
    ------
    ValueError
        If one is no expression in the system's variables, its parameters and t, or depends neither on t nor on the
        state, or if its direction is none.
    """
    if isinstance(events, tuple) and not events:
        return NOTHING
    given = listed(events, "events", "expressions, or core.Event, are needed", (str, Event))
    names = (*system.variables, *(q.name for q in system.parameters))
    texts, functions, ways, ends = [], [], [], []
    for k, item in enumerate(given):
        event = item if isinstance(item, Event) else Event(item)
        if not isinstance(event.terminal, (bool, np.bool_)):
            raise ValueError(f"events[{k}]: terminal = {event.terminal!r}: True or False is needed")
        function = parse(event.function, names, f"events[{k}]")
        if not function.free_symbols & {TIME, *system.laws.x}:
            raise ValueError(f"events[{k}] = {quoted(str(event.function))} depends neither on t nor on the state")
        texts.append(str(event.function))
        functions.append(function)
        ways.append(checked_direction(event.direction))
        ends.append(bool(event.terminal))
    return Watched(tuple(texts), tuple(functions), tuple(ways), tuple(ends))


def checked_direction(direction: Any) -> int:
    """Return the direction in which a function is to vanish; ValueError if it is none."""
    if isinstance(direction, (bool, np.bool_)) or np.ndim(direction) or direction not in (-1, 0, 1):
        raise ValueError(f"direction = {direction!r}: 1 where h increases, -1 where it decreases, 0 for both")
    return int(direction)
