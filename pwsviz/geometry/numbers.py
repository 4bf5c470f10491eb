"""Numbers that more than one room needs."""

from __future__ import annotations

import numpy as np

__all__ = ["MACHINE_EPSILON"]

MACHINE_EPSILON = float(np.finfo(float).eps)
