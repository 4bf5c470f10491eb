"""The record that the loop keeps of a run, and what it begins from and writes beside it.

numpy takes 4 µs to make a record of so many fields, and 20 µs to copy it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.kernels.arrays import Floats
from core.methods import Method
from core.symbolic.laws import Laws
from core.transition.records import NO_MODE, RUN

__all__ = ["Blank", "Rows", "copied_record", "new_record"]


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
    budget: int
    """Most steps of one call."""


@dataclass
class Rows:
    """Recorded steps: chunks of times, states, modes, and indices of segments."""

    t: list[Floats]
    x: list[Floats]
    mode: list[NDArray[np.int64]]
    segment: list[NDArray[np.int64]]


def new_record(laws: Laws, method: Method, follow: bool, slides: bool, monitored: int) -> NDArray[Any]:
    """The record (1,) of a run that has not begun; `follow`, `slides` and `monitored` as in `records.RUN`."""
    return np.frombuffer(bytearray(_contents(laws, method, follow, slides, monitored)), dtype=RUN)


def copied_record(run: NDArray[Any]) -> NDArray[Any]:
    """An independent copy of a record (1,)."""
    return np.frombuffer(bytearray(run.tobytes()), dtype=RUN)


@lru_cache(maxsize=256)
def _contents(laws: Laws, method: Method, follow: bool, slides: bool, monitored: int) -> bytes:
    run = np.zeros(1, dtype=RUN)
    run["follow"], run["slides"], run["partly_defined"] = follow, slides, laws.edged
    run["mode"] = run["first_mode"] = NO_MODE
    run["conservative"], run["adaptive"], run["monitored"] = method.conservative, method.adaptive, monitored
    run["stride"] = 1
    return run.tobytes()
