"""What a run begins from, made once for all runs of a system, method and settings; and what the loop keeps of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.compilation.guards import GuardTable, guard_table
from core.integration.event_log import EventArrays
from core.integration.time_loop import compiled_march
from core.kernels.abi import ORDER, TOLERANCE, Frame
from core.kernels.arrays import Floats
from core.kernels.root_isolation import scratch_shape
from core.kernels.taylor_coefficients import order_of
from core.methods import Method
from core.symbolic.laws import Laws
from core.transition.event_location import MAX_NODES
from core.transition.records import NO_MODE, ROW, RUN

__all__ = ["FIELDS", "Beginning", "Blank", "Record", "Rows", "beginning_of"]

#: Name of a field of the record -> its place: each takes eight bytes.
FIELDS = {name: place for place, name in enumerate(RUN.names or ())}


class Blank(NamedTuple):
    """Arguments of the loop for a run that has not begun."""

    functions: NDArray[np.int64]
    guards: NDArray[Any]
    record: NDArray[Any]
    frame: Floats
    coefficients: Floats
    nodes: Floats
    pieces: Floats
    envelope: Floats
    samples: Floats
    events: EventArrays
    budget: int
    """Most steps of one call."""


@dataclass
class Rows:
    """Recorded steps: chunks of times, states, modes, and indices of segments."""

    t: list[Floats]
    x: list[Floats]
    mode: list[NDArray[np.int64]]
    segment: list[NDArray[np.int64]]

    def collect(self, count: int, rows: NDArray[Any], x: Floats) -> None:
        """Keep the first `count` of the rows, `records.ROW`, that the loop has written, and their states."""
        if count:
            self.t.append(rows["t"][:count])
            self.x.append(x[:count])
            self.mode.append(rows["mode"][:count])
            self.segment.append(rows["segment"][:count])


class Record:
    """The record of a run: an array for the loop, and the same memory as plain numbers.

    numpy takes 4 µs to make a record of so many fields, 20 µs to copy it, and 0.3 µs to read or write one of them.
    """

    __slots__ = ("array", "reals", "wholes")

    array: NDArray[Any]
    """(1,) of `records.RUN`."""
    reals: memoryview[float]
    """Its fields as floats, each at its place of `FIELDS`; those that are integers make no sense here."""
    wholes: memoryview[int]
    """Its fields as integers, likewise."""

    def __init__(self, contents: bytes) -> None:
        own = memoryview(bytearray(contents))
        self.array = np.frombuffer(own, dtype=RUN)
        self.reals, self.wholes = own.cast("d"), own.cast("q")

    def copy(self) -> Record:
        """An independent copy."""
        return Record(self.array.tobytes())


class Beginning(NamedTuple):
    """What all runs of a method begin from, for the same laws and settings."""

    march: Callable[..., int]
    """The time loop."""
    table: GuardTable
    frame: Frame
    blank_frame: Floats
    """A frame without state and time, read-only."""
    blank_record: bytes
    """Contents of a record, likewise."""
    monitored: int
    """Number of conserved quantities whose level residuals an envelope keeps."""
    pieces: tuple[int, int]
    """Shape of the scratch of `root_isolation.first_root`."""
    nowhere: tuple[NDArray[Any], Floats]
    """Buffers for rows of a run that records none: the loop never writes to them."""

    def workspace(self) -> tuple[Floats, ...]:
        """Scratch of the loop: the nodes of an event location, and the pieces of a polynomial."""
        return np.empty((MAX_NODES, 3)), np.empty(self.pieces)


@lru_cache(maxsize=256)
def beginning_of(
    laws: Laws, method: Method, follow: bool, slides: bool, tolerance: float, monitored: bool
) -> Beginning:
    """Make what runs begin from.

    Parameters
    ----------
    follow, slides
        As in `records.RUN`.
    tolerance
        Of a variable-step method.
    monitored
        Whether an envelope is kept.
    """
    frame = Frame(len(laws.x), laws.most_conserved_sliding)
    m = frame.m if slides else laws.most_conserved
    run, w = np.zeros(1, dtype=RUN), frame.empty()
    run["follow"], run["slides"], run["partly_defined"] = follow, slides, laws.edged
    run["mode"] = run["first_mode"] = NO_MODE
    run["conservative"], run["adaptive"], run["monitored"] = method.conservative, method.adaptive, m * monitored
    run["stride"] = 1
    pieces = (1, 1)
    if method.adaptive:
        w[ORDER], w[TOLERANCE] = order_of(tolerance), tolerance
        pieces = scratch_shape(order_of(tolerance))
    w.flags.writeable = False
    nowhere = np.empty(1, dtype=ROW), np.empty((1, frame.d))
    return Beginning(compiled_march(), guard_table(laws), frame, w, run.tobytes(), m, pieces, nowhere)
