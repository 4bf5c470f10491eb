"""What a run has recorded, from which arrays are made when they are first asked for."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, NamedTuple, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from core.kernels.arrays import Floats

__all__ = ["Chunk", "Entry", "Once", "Point", "States", "distinct", "states_of"]

Value = TypeVar("Value")

#: What one call of the loop has written: (n,) rows, crossings or events, and their states (n, …, d).
Chunk: TypeAlias = tuple[NDArray[Any], Floats]


class Once(Generic[Value]):
    """A value that is worked out when it is first asked for; what it is worked out from is dropped then."""

    __slots__ = ("_value", "_work")

    def __init__(self, work: Callable[..., Value], *arguments: Any) -> None:
        self._work: tuple[Callable[..., Value], tuple[Any, ...]] | None = work, arguments

    def __call__(self) -> Value:
        """Return the value; two threads that ask at once may both work it out."""
        if (work := self._work) is not None:
            self._value = work[0](*work[1])
            self._work = None
        return self._value

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the value alone."""
        return Once, (_same, self())


def _same(value: Value) -> Value:
    return value


class Point(NamedTuple):
    """Where a run begins or ends."""

    t: float
    x: tuple[float, ...]
    mode: int


class Entry(NamedTuple):
    """When and where a segment, given by its number, was entered."""

    segment: int
    t: float
    x: tuple[float, ...]


class States(NamedTuple):
    """The recorded states as arrays: see the fields of the same names of `Trajectory`."""

    t: Floats
    x: Floats
    mode: NDArray[np.int64]
    segment: NDArray[np.int64]


def states_of(first: Point, rows: list[Chunk], last: Point, segment: int, entries: tuple[Entry, ...] | None) -> States:
    """Put the recorded steps between the first and the last state.

    The last state is left out where it was recorded already, or where the run has neither moved nor changed its mode.
    Steps beyond a crossing that a touch has taken the place of, see `retract_crossing`, are in the last segment.

    Parameters
    ----------
    segment
        Number of the last segment.
    entries
        The segments to which all are renumbered, see `distinct`; None where all are kept.
    """
    t = np.concatenate([(first.t,), *(steps["t"] for steps, _ in rows), (last.t,)])
    x = np.concatenate([(first.x,), *(x for _, x in rows), (last.x,)])
    mode = np.concatenate([(first.mode,), *(steps["mode"] for steps, _ in rows), (last.mode,)])
    segments = np.concatenate([(0,), *(steps["segment"] for steps, _ in rows), (segment,)])
    retracted = segments > segment
    mode[retracted], segments[retracted] = last.mode, segment
    if entries is not None:
        segments = np.searchsorted([entry.segment for entry in distinct(entries)], segments)
    repeated = t[-1] == t[-2] and (x[-1] == x[-2]).all() and mode[-1] == mode[-2]
    return States(*(column[:-1] if repeated else column for column in (t, x, mode, segments)))


def distinct(entries: tuple[Entry, ...]) -> list[Entry]:
    """Leave out entries of the same segment."""
    return list({entry.segment: entry for entry in entries}.values())
