"""What is seen of lines: in a window, and beside the curves that are painted over them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.spatial import cKDTree

from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.geometry.window import Window

__all__ = ["any_seen", "unhidden"]

PIXELS = 500
"""Of a window along its longer side; a curve is some pixels wide."""

REACH = 2.5
"""Pixels from the middle of a curve up to which it hides what is below."""

MOST = 50_000
"""Most points of curves that are looked at, a pixel apart: below longer ones lines count as seen."""


def unhidden(line: Floats, curves: Iterable[Floats], within: Window, seen: Window) -> Floats:
    """Return points (n, 2), a pixel apart, of the part of a line in a window that does not lie below curves.

    Parameters
    ----------
    line, curves : (n, 2 or more) array, iterable of such arrays
        Vertices, their places first; NaN for a gap.
    within, seen : Window
        The window, and the part of the plane that is seen, which gives the size of a pixel.
    """
    pixel = seen.longest / PIXELS
    below = _densely(line, pixel)
    below = below[within.holds(below)]
    above = np.concatenate([np.empty((0, 2)), *(_densely(curve, pixel) for curve in curves)])
    if not len(below) or not len(above) or len(above) >= MOST:
        return below
    distance, _ = cKDTree(above).query(below, distance_upper_bound=REACH * pixel)
    return np.asarray(below[~np.isfinite(distance)])


def any_seen(line: Floats, seen: Window) -> bool:
    """Return whether a line, given as by `unhidden`, passes through a window."""
    begin, end = line[:-1, :2], line[1:, :2]
    low, high = np.minimum(begin, end), np.maximum(begin, end)  # NaN at a gap, which no comparison holds for
    near = (low <= [seen.x_high, seen.y_high]).all(axis=1) & (high >= [seen.x_low, seen.y_low]).all(axis=1)
    (dx, dy), (x, y) = (end - begin)[near].T, begin[near].T
    corners = [(across, up) for across in seen[:2] for up in seen[2:]]
    sides = np.array([dx * (up - y) - dy * (across - x) for across, up in corners])
    return bool(((sides.min(axis=0) <= 0) & (sides.max(axis=0) >= 0)).any())


def _densely(points: Floats, pixel: float) -> Floats:
    """Return points on a curve that are no more than a pixel apart, without its gaps; at most `MOST`."""
    points = points[:, :2]
    begin, way = points[:-1], np.diff(points, axis=0)
    there = np.isfinite(way).all(axis=1)
    begin, way = begin[there], way[there]
    counts = np.ceil(np.hypot(*way.T) / pixel).astype(int).clip(1, MOST)
    if counts.sum() > MOST:
        return points[np.isfinite(points).all(axis=1)][:1].repeat(MOST, axis=0)
    rows = np.repeat(np.arange(len(way)), counts)
    part = (np.arange(len(rows)) - np.repeat(np.cumsum(counts) - counts, counts)) / np.repeat(counts, counts)
    return np.asarray(begin[rows] + part[:, None] * way[rows])
