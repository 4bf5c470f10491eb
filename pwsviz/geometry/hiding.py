"""Whether lines are hidden under curves that are painted over them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.spatial import cKDTree

from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.geometry.window import Window

__all__ = ["are_hidden"]

PIXELS = 500
"""Of a window along its longer side; a curve is some pixels wide."""

REACH = 2.5
"""Pixels from the middle of a curve up to which it hides what is below."""

MOST = 50_000
"""Most points of curves that are looked at, a pixel apart: below longer ones lines count as seen."""


def are_hidden(lines: Iterable[Floats], curves: Iterable[Floats], seen: Window) -> bool:
    """Return whether all of some lines that is seen lies below curves.

    Parameters
    ----------
    lines, curves : iterable of (n, 2 or more) arrays
        Vertices, their places first; NaN for a gap.
    seen : Window
        The part of the plane that is seen.
    """
    pixel = seen.longest / PIXELS
    below, above = (
        np.concatenate([np.empty((0, 2)), *(_densely(each, pixel) for each in some)]) for some in (lines, curves)
    )
    below = below[seen.holds(below)]
    if not len(below) or not len(above) or len(above) >= MOST:
        return not len(below)
    distance, _ = cKDTree(above).query(below, distance_upper_bound=REACH * pixel)
    return bool(np.isfinite(distance).all())


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
