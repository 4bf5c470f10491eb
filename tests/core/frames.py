"""Compiled functions of a run, called one at a time from Python."""

from __future__ import annotations

import ctypes
from typing import Any

import mpmath as mp
import numpy as np

from core import METHODS, PiecewiseSystem
from core.compilation.compiled import compile_run
from core.kernels.abi import FUNCTIONS, Frame

_double = ctypes.POINTER(ctypes.c_double)
_PROTOTYPE = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_double, ctypes.c_double, _double, _double, _double)


def pointer(array: Any) -> Any:
    """Where an array's numbers are."""
    return array.ctypes.data_as(_double)


class Framed:
    """A frame, and the functions that work on it."""

    def __init__(self, system: PiecewiseSystem, method: str, side: int, x: Any, carry: Any = 0.0) -> None:
        self.compiled = compile_run(system.laws, METHODS[method], levels=True)
        self.system, self.side, self.method = system, side, METHODS[method]
        m = max(len(s.conserved) for s in system.laws.modes.values())
        self.frame = Frame(system.dimension, m)
        self.w, self.p, self.scratch = self.frame.empty(), np.array([*system.parameter_array, 0.0]), np.zeros((1, 1))
        self.part("x")[:], self.part("carry")[:] = x, carry

    def part(self, name: str) -> Any:
        """A vector of the frame."""
        start = getattr(self.frame, name)
        counts = {"level": 2 * self.frame.m, "level_residual": self.frame.m}
        return self.w[start : start + counts.get(name, self.frame.d)]

    def call(self, name: str, t: float, h: float = 0.0) -> int:
        """Call one of `FUNCTIONS`."""
        address = self.compiled.addresses[int(self.side > 0), FUNCTIONS.index(name)]
        pointers = map(pointer, (self.p, self.w, self.scratch))
        return int(_PROTOTYPE(int(address))(t, h, *pointers))


def levels(runner: Any) -> list[Any]:
    """Levels of ψ that a run holds, in mpmath."""
    system = runner.system
    m = max(len(s.conserved) for s in system.laws.modes.values())
    start = Frame(system.dimension, m).level
    return [mp.mpf(runner.memory.w[start + j]) + mp.mpf(runner.memory.w[start + m + j]) for j in range(m)]
