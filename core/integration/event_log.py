"""The memory in which the compiled loop looks for events, and the events that it has found."""

from __future__ import annotations

import copy
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.codegen.taylor_series import series_rows
from core.integration.events import NOTHING, Events, Watched, events_of
from core.integration.recorded import Chunk
from core.kernels.arrays import Floats
from core.kernels.taylor_coefficients import STRIDE
from core.methods import Method
from core.symbolic.laws import Laws
from core.transition.records import EVENT, HIT

__all__ = ["EventArrays", "EventLog", "log_of"]

#: Events that one call of the loop can write.
_ROOM = 4096


class EventArrays(NamedTuple):
    """What the loop works with: see `event_search.Watch`."""

    events: NDArray[Any]
    found: NDArray[Any]
    found_x: Floats
    frame: Floats
    """The frame of the location of events."""
    series: Floats


_NOWHERE = EventArrays(
    np.empty(0, dtype=EVENT), np.empty(0, dtype=HIT), np.empty((0, 1, 0)), np.empty(0), np.empty((1, 1))
)


class EventLog:
    """The events of a run.

    Attributes
    ----------
    watched
        The event functions.
    arrays
        What the loop works with.
    """

    def __init__(self, watched: Watched = NOTHING, arrays: EventArrays = _NOWHERE) -> None:
        self.watched, self.arrays = watched, arrays
        self._chunks: list[Chunk] = []

    @property
    def records(self) -> int:
        """Number of records of a run: see `event_search.Watch`."""
        return 3 if self.watched.functions else 1

    def saved(self, *arrays: NDArray[Any]) -> list[tuple[NDArray[Any], NDArray[Any]]]:
        """Arrays and the event functions, with copies of them; nothing where there are no events."""
        return [(a, a.copy()) for a in (*arrays, self.arrays.events)] if self.watched.functions else []

    def make_room(self) -> None:
        """Make room for twice as many events in one step."""
        found, x = self.arrays.found, self.arrays.found_x
        self.arrays = self.arrays._replace(
            found=np.empty(2 * len(found), HIT), found_x=np.empty((2 * len(x), *x.shape[1:]))
        )

    def collect(self, count: int) -> None:
        """Keep the events that the loop has written."""
        self._chunks.append((self.arrays.found[:count].copy(), self.arrays.found_x[:count].copy()))

    def kept(self) -> Chunk:
        """(k,) of `records.HIT`, and states (k, 1, d)."""
        d = self.arrays.found_x.shape[2]
        found = [np.empty(0, dtype=HIT), *(found for found, _ in self._chunks)]
        return np.concatenate(found), np.concatenate([np.empty((0, 1, d)), *(x for _, x in self._chunks)])

    def events(self) -> Events:
        """All events so far."""
        return events_of(self.watched, *self.kept()) if self.watched.functions else _NO_EVENTS

    @property
    def last(self) -> str:
        """The event function of the last event."""
        return self.watched.texts[int(self._chunks[-1][0]["surface"][-1])]

    def remarks(self) -> tuple[str, ...]:
        """What is to be said of the event functions, a sentence each."""
        if not self.watched.functions:
            return ()
        found = []
        for text, event in zip(self.watched.texts, self.arrays.events, strict=True):
            if event["vanishes"]:
                found.append(f"The event function {text!r} is zero along a part of the run, where it has no events.")
            if event["undefined"]:
                found.append(
                    f"The event function {text!r} has a pole, a multiple zero or no finite value on the way, and "
                    "events next to there may be missing."
                )
        return tuple(found)

    def copy(self) -> EventLog:
        """An independent copy."""
        other = copy.copy(self)
        other._chunks = list(self._chunks)
        other.arrays = EventArrays(*(a.copy() for a in self.arrays))
        return other


#: The log of a run that looks for none, and what it says.
_NO_LOG, _NO_EVENTS = EventLog(), Events()


def log_of(watched: Watched, laws: Laws, method: Method, frame: Floats, room: int = _ROOM) -> EventLog:
    """Make the log of a run that has not begun."""
    if not watched.functions:
        return _NO_LOG
    rows = series_rows(laws, watched.functions) if method.adaptive else 1
    found, x = np.empty(room, dtype=HIT), np.empty((room, 1, len(laws.x)))
    return EventLog(watched, EventArrays(watched.table(), found, x, frame.copy(), np.empty((rows, STRIDE))))
