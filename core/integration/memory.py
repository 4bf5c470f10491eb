"""The memory in which the compiled loop works during a run."""

from __future__ import annotations

import numpy as np

from core.integration.unlike import rows_of_looks
from core.kernels.arrays import Floats
from core.transition.event_location import MAX_NODES
from core.transition.passes import PASSES
from core.transition.records import HIT, RUN

__all__ = ["FIELDS", "FIRST_HITS", "Memory"]

#: Name of a field of the record -> its place: each takes eight bytes.
FIELDS = {name: place for place, name in enumerate(RUN.names or ())}
#: Crossings for which there is room.
FIRST_HITS = 16
#: Largest number of steps sampled over the run, for `diagnostics.resolution`.
_SAMPLES = 128


class Memory:
    """The record and the frame of a run, and what else the loop writes to.

    To make it takes longer than a short run, so that one run takes it over from another: see `Beginning.lend`.

    Attributes
    ----------
    record
        (records,) of `records.RUN`.
    reals, wholes
        Its fields as floats and as integers, each at its place of `FIELDS`; numpy takes ten times as long to read one.
    w, x, carry
        The frame, and its parts with the state and its compensation.
    p
        Parameters.
    coefficients
        What a variable-step method keeps between calls.
    nodes, pieces
        Scratch: the nodes of an event location, and the pieces of a polynomial.
    samples
        (k, 3 + d): see `Trajectory.samples`.
    looks
        See `unlike`.
    passes
        See `transition.passes`.
    hits, places
        Crossings and their states.

    Parameters
    ----------
    record
        Contents of the record of a run that has not begun.
    frame
        The same of its frame, read-only.
    state
        Where in the frame the state begins.
    d, parameters
        Numbers of variables and of parameters.
    pieces
        Shape of the pieces.
    """

    def __init__(
        self, record: bytes, frame: Floats, state: int, d: int, parameters: int, pieces: tuple[int, int]
    ) -> None:
        self._blank = record, frame
        self._own = own = memoryview(bytearray(record))
        self.record, self.reals, self.wholes = np.frombuffer(own, dtype=RUN), own.cast("d"), own.cast("q")
        self.w, self.p = frame.copy(), np.empty(parameters)
        self.x, self.carry = self.w[state : state + d], self.w[state + d : state + 2 * d]
        self.nodes, self.pieces, self.coefficients = np.empty((MAX_NODES, 3)), np.empty(pieces), np.empty((1, 1))
        self.samples, self.looks = np.empty((_SAMPLES, 3 + d)), np.empty((rows_of_looks(d), 3 + d))
        self.passes = np.empty((PASSES, 4 + d))
        self.make_room()

    def make_room(self) -> None:
        """Make room for crossings in place of that which has been used."""
        self.hits, self.places = np.empty(FIRST_HITS, dtype=HIT), np.empty((FIRST_HITS, 3, len(self.x)))

    def clear(self) -> None:
        """Make record and frame those of a run that has not begun."""
        self._own[:], self.w[:] = self._blank

    def take(self, other: Memory) -> None:
        """Take over what the run in another memory has come to."""
        self._own[:], self.w[:], self.p[:], self.samples[:] = other._own, other.w, other.p, other.samples
        self.looks[:], self.passes[:] = other.looks, other.passes
        self.coefficients = other.coefficients.copy()
