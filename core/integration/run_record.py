"""The record that the loop keeps of a run: numpy takes 4 µs to make one of so many fields, and 20 µs to copy it."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from core.methods import Method
from core.symbolic.laws import Laws
from core.transition.records import NO_MODE, RUN

__all__ = ["copied_record", "new_record"]


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
