"""The plane of a portrait: which two variables span it, and in which units they are drawn."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from core.kernels import Floats

__all__ = ["XY", "Axes", "Plane", "units_of"]

Axes = tuple[int, int]
"""Two variables, by number."""

SLENDER = 5.0
"""Ratio of the extents of two variables from which one of them is drawn in a unit of its own."""

ROUNDING = 1e-12
"""Part of the size of a variable, and of the extent of the other, below which it changes by rounding alone."""


class Plane(NamedTuple):
    """A plane in which scales are equal: a drawn coordinate is a variable divided by its unit.

    Attributes
    ----------
    axes : (int, int)
        The variables that span it.
    units : (float, float)
        Powers of ten, one of them 1.
    """

    axes: Axes = (0, 1)
    units: tuple[float, float] = (1.0, 1.0)

    def points(self, x: Floats) -> Floats:
        """Return the places (n, 2) of states (n, d), without a copy where possible."""
        a, b = self.axes
        shown = x[:, a : b + 1 : b - a] if a < b else x[:, (a, b)]
        return shown if self.units == (1.0, 1.0) else shown / self.units

    def place(self, state: Sequence[float]) -> tuple[float, float]:
        """Return the place of one state."""
        (a, b), (across, up) = self.axes, self.units
        return state[a] / across, state[b] / up

    def values(self, points: Floats) -> Floats:
        """Return the values (n, 2) of the two variables at places (n, 2)."""
        return points if self.units == (1.0, 1.0) else points * self.units


XY = Plane()
"""The plane of the first two variables, as they are."""


def units_of(points: Floats) -> tuple[float, float]:
    """Return the units of two variables in which neither makes a curve a line: 1 where neither does by itself.

    The variable whose extent is nearer to 1 keeps the unit 1, so that most numbers are read as they are. One that
    changes by rounding alone has no unit.

    Parameters
    ----------
    points : (n, 2) array
        Values of the variables along the curve.
    """
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    extent, size = high - low, np.maximum(np.abs(low), np.abs(high))
    if not (np.isfinite(extent).all() and (extent > ROUNDING * np.maximum(size, extent.max())).all()):
        return 1.0, 1.0
    x, y = np.log10(extent).tolist()
    if abs(y - x) < math.log10(SLENDER):
        return 1.0, 1.0
    return (1.0, 10.0 ** round(y - x)) if abs(x) <= abs(y) else (10.0 ** round(x - y), 1.0)
