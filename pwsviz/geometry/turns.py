"""How densely the turns of an orbit lie on a screen."""

from __future__ import annotations

import numpy as np

from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.geometry.window import Window

__all__ = ["spacing"]

PIXELS = 600
"""Pixels assumed along the longer side of a view: of a portrait on a usual screen."""

CELL = 8
"""Pixels along the side of the squares in which lines are looked at together."""

FEW = 4.0
"""Length of a path, relative to the longer side of the view, up to which its turns are too few to touch."""

MOST = 2_000_000
"""Points at which a path is looked at, at most: more of them fill the view whatever their places are."""


def spacing(path: Floats, view: Window) -> float:
    """Return the mean distance in pixels between neighbouring turns of a path, up to about `CELL`; inf of few turns.

    Turns that share all their pixels count as one: it is the area of the squares which the path meets, divided by the
    pixels that it paints there.

    Parameters
    ----------
    path : (n, 2) array
        The path, with rows of NaN between its pieces.
    view : Window
        The part of the plane that is seen.
    """
    at = (path - (view.x_low, view.y_low)) * (PIXELS / view.longest)
    size = np.array([view.width, view.height]) * (PIXELS / view.longest)
    start, step = at[:-1], np.diff(at, axis=0)
    length = np.hypot(*step.T)
    low, high = np.minimum(start, at[1:]), np.maximum(start, at[1:])
    seen = np.isfinite(length) & (high >= 0).all(axis=1) & (low <= size).all(axis=1)
    start, step, length = start[seen], step[seen], length[seen]
    if length.sum() <= FEW * PIXELS or length.sum() > MOST:
        return np.inf if length.sum() <= FEW * PIXELS else 0.0
    count = 1 + length.astype(np.intp)
    share = (np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)) / np.repeat(count, count)
    points = np.repeat(start, count, axis=0) + share[:, None] * np.repeat(step, count, axis=0)
    points = points[((points >= 0) & (points < size)).all(axis=1)].astype(np.intp)
    painted = np.zeros((CELL * (PIXELS // CELL + 1), CELL * (PIXELS // CELL + 1)), dtype=bool)
    painted[points[:, 0], points[:, 1]] = True
    side = len(painted) // CELL
    cells = painted.reshape(side, CELL, side, CELL).sum(axis=(1, 3))
    there = np.count_nonzero(cells)
    return float(CELL**2 * there / cells.sum()) if there else np.inf
