"""Constants that several folders need."""

from __future__ import annotations

import numpy as np

__all__ = ["MACHINE_EPSILON"]

MACHINE_EPSILON = float(np.finfo(float).eps)
"""2⁻⁵², the distance from 1 to the next float."""
