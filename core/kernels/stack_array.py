"""Local arrays of generated functions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["stack_array"]


def stack_array(size: int) -> NDArray[np.float64]:
    """Return an uninitialised array; machine code of `native` allocates it on the stack of the function."""
    return np.empty(size)
