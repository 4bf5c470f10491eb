"""A window of the plane: what a portrait shows, and the larger one on which its backdrop is drawn."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pwsviz.geometry.polyline_reduction import Floats

__all__ = ["ARROWS", "Window"]

ARROWS = 24
"""Arrows of the field along the longer side."""

BEYOND = 1.3
"""Least size of a backdrop relative to the view that it is for, so that a short pan stays within it."""


class Window(NamedTuple):
    """A rectangle of the plane."""

    x_low: float
    x_high: float
    y_low: float
    y_high: float

    @property
    def width(self) -> float:
        """Extent in x."""
        return self.x_high - self.x_low

    @property
    def height(self) -> float:
        """Extent in y."""
        return self.y_high - self.y_low

    @classmethod
    def around(cls, points: Floats, margin: float = 0.2) -> Window:
        """Return the bounding box of points (n, 2) with a margin, relative to its longer side, ignoring NaN."""
        low, high = np.nanmin(points, axis=0), np.nanmax(points, axis=0)
        size, away = float((high - low).max()), float(np.abs(high + low).max()) / 2
        if size <= 1e-6 * max(away, 1e-3):  # one point: its largest |coordinate| becomes the margin, or 1
            size = 5 * max(away, 1.0)
        beside = margin * size
        return cls(*(float(end) for end in (low[0] - beside, high[0] + beside, low[1] - beside, high[1] + beside)))

    def holds(self, points: Floats) -> NDArray[np.bool_]:
        """Return (n,) which of the points (n, 2) lie within."""
        x, y = points[:, 0], points[:, 1]
        return (self.x_low <= x) & (x <= self.x_high) & (self.y_low <= y) & (y <= self.y_high)

    def scaled(self, factor: float) -> Window:
        """Return the window scaled about its centre."""
        x, y = (self.x_low + self.x_high) / 2, (self.y_low + self.y_high) / 2
        w, h = factor * self.width / 2, factor * self.height / 2
        return Window(x - w, x + w, y - h, y + h)

    @property
    def longest(self) -> float:
        """The longer side."""
        return max(self.width, self.height)

    def covers(self, other: Window) -> bool:
        """Whether `other` lies within."""
        across = self.x_low <= other.x_low and other.x_high <= self.x_high
        return across and self.y_low <= other.y_low and other.y_high <= self.y_high

    def surroundings(self) -> Window:
        """Return the window of a backdrop for this view.

        Its longer side is a power of two, and its arrows stand on a lattice: how dense they are follows from the size
        of the view alone, not from the way on which the view was reached, and a pan does not move them.
        """
        longer = 2.0 ** math.ceil(math.log2(BEYOND * self.longest))
        cell = longer / ARROWS
        sides = [(side / self.longest, side / cell) for side in (self.width, self.height)]
        half = [cell * math.ceil(max(ARROWS / 2 * share, 0.5 * cells + 0.5)) for share, cells in sides]
        x, y = (cell * round(0.5 * (low + high) / cell) for low, high in (self[:2], self[2:]))
        return Window(x - half[0], x + half[0], y - half[1], y + half[1])

    def shows_well(self, other: Window) -> bool:
        """Whether this backdrop suits the view `other`: it covers it, and is of the size of its own backdrop."""
        return self.covers(other) and math.isclose(self.longest, other.surroundings().longest, rel_tol=1e-6)
