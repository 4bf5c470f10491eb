"""What a run begins from, made once for all runs of a system, method and settings."""

from __future__ import annotations

from functools import lru_cache
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from sympy import Expr

from core.compilation.compiled import compile_run, modes_entered
from core.compilation.guards import guard_table
from core.integration.event_log import EventArrays
from core.integration.memory import Memory
from core.integration.time_loop import compiled_march
from core.kernels.abi import ORDER, TOLERANCE, Frame
from core.kernels.arrays import Floats
from core.kernels.root_isolation import scratch_shape
from core.kernels.taylor_coefficients import STRIDE, order_of
from core.methods import Method
from core.methods.taylor_step import coefficient_rows
from core.symbolic.laws import Laws
from core.transition.records import NO_MODE, ROW, RUN

__all__ = ["Beginning", "Blank", "Ready", "beginning_of"]


class Blank(NamedTuple):
    """Arguments of the loop for a run that has not begun."""

    functions: NDArray[np.int64]
    guards: NDArray[Any]
    memory: Memory
    envelope: Floats
    events: EventArrays
    budget: int
    """Most steps of one call."""


class Ready(NamedTuple):
    """What is compiled for runs."""

    functions: NDArray[np.int64]
    """Addresses: see `compiled.Compiled`."""
    modules: tuple[ModuleType, ...]
    """The modules, which keep the machine code alive."""
    coefficients: tuple[int, int]
    """Shape of what a variable-step method keeps between calls."""


class Beginning:
    """What all runs of a method begin from, for the same laws and settings.

    Attributes
    ----------
    march
        The time loop.
    table
        The guards.
    ready
        The modes entered so far, compiled.
    blank_frame
        A frame without state, read-only.
    monitored
        Number of conserved quantities whose level residuals an envelope keeps.
    nowhere
        Buffers for rows of a run that records none: the loop never writes to them.
    no_envelope
        Likewise, where no envelope is kept.

    Parameters
    ----------
    follow, slides
        As in `records.RUN`.
    tolerance
        Of a variable-step method.
    levels
        Whether an envelope is kept.
    events
        Event functions.
    """

    def __init__(
        self, laws: Laws, method: Method, follow: bool, slides: bool, tolerance: float, levels: bool,
        events: tuple[Expr, ...],
    ) -> None:  # fmt: skip
        frame, pieces = Frame(len(laws.x), laws.most_conserved_sliding), (1, 1)
        run, w = np.zeros(3 if events else 1, dtype=RUN), frame.empty()
        self.monitored = (frame.m if slides else laws.most_conserved) * levels
        run["follow"], run["slides"], run["partly_defined"] = follow, slides, laws.edged
        run["mode"] = run["first_mode"] = NO_MODE
        run["conservative"], run["adaptive"], run["monitored"] = method.conservative, method.adaptive, self.monitored
        run["stride"], run["events"] = 1, len(events)
        if method.adaptive:
            w[ORDER], w[TOLERANCE] = order_of(tolerance), tolerance
            pieces = scratch_shape(order_of(tolerance))
        w.flags.writeable = False
        self.march, self.table, self.blank_frame = compiled_march(bool(events)), guard_table(laws), w
        self.nowhere = np.empty(1, dtype=ROW), np.empty((1, frame.d))
        self.no_envelope = np.empty((0, self.monitored, 2))
        self._shape = run.tobytes(), w, frame.x, frame.d, len(laws.p), pieces
        self._free: list[Memory] = []
        self._declared = laws, method, levels, events
        self._modes = modes_entered(laws, method, levels)
        self.compile()

    def compile(self, *modes: int) -> Ready:
        """Compile modes, for a run that enters them and for all later ones, besides those entered so far."""
        laws, method, levels, events = self._declared
        self._modes.update(modes)
        known = tuple(sorted(self._modes))
        rows = coefficient_rows(laws, known) if method.adaptive and known else 1
        self.ready = Ready(*compile_run(laws, method, levels, known, events), (rows, STRIDE))
        return self.ready

    def lend(self, ready: Ready) -> Memory:
        """Memory for a run in modes that are ready: that of one which has given it back, or else new."""
        try:
            memory = self._free.pop()
            memory.clear()
        except IndexError:
            memory = Memory(*self._shape)
        if memory.coefficients.shape != ready.coefficients:
            memory.coefficients = np.empty(ready.coefficients)
        return memory

    def take_back(self, memory: Memory) -> None:
        """Keep memory that is not used any more for another run."""
        self._free.append(memory)


#: What runs begin from, made once for the same laws, method and settings.
beginning_of = lru_cache(maxsize=256)(Beginning)
