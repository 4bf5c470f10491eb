"""Curves cut at the border of a rectangle of the plane."""

from __future__ import annotations

import numpy as np

from pwsviz.geometry.polyline_reduction import Floats, Mask
from pwsviz.geometry.window import Window

__all__ = ["clipped"]


def clipped(points: Floats, kinks: Mask, window: Window) -> tuple[Floats, Mask, Mask]:
    """Insert vertices where a curve crosses the border of a window.

    Parameters
    ----------
    points : (n, 2) array
        The curve; points that are not finite leave a gap.
    kinks : (n,) bool array
        A mark of each vertex.
    window : Window
        The rectangle.

    Returns
    -------
    points : (m, 2) array
        The curve with the vertices on the border.
    kinks : (m,) bool array
        The marks; False on the border.
    within : (m,) bool array
        Which vertices lie within the window or on its border: those to draw.

    Notes
    -----
    Each edge a + s (b - a) lies within from the last s at which it enters a strip to the first at which it leaves one
    (Liang, Barsky, ACM Trans. Graph. 3, 1984).
    """
    within = window.holds(points)
    if within.all():
        return points, kinks, within
    edges = np.flatnonzero(~(within[1:] & within[:-1]) & np.isfinite(points[1:] - points[:-1]).all(axis=1))
    back = np.abs(points[edges]).max(axis=1) > np.abs(points[edges + 1]).max(axis=1)  # s is small at the smaller end
    a, b = points[edges + back], points[edges + ~back]
    low, high = np.array(window).reshape(2, 2).T
    with np.errstate(divide="ignore", invalid="ignore"):
        bounds = np.sort(np.stack([(low - a) / (b - a), (high - a) / (b - a)]), axis=0)
    outside = (a == b) & ((a < low) | (a > high))  # parallel to a strip, and beside it
    bounds = np.where(a == b, np.array([-np.inf, np.inf])[:, None, None], bounds)
    enters, leaves = bounds[0].max(axis=1).clip(min=0.0), bounds[1].min(axis=1).clip(max=1.0)
    crosses = (enters < leaves) & ~outside.any(axis=1)
    share = np.where(back[:, None], np.column_stack([leaves, enters]), np.column_stack([enters, leaves]))
    new = crosses[:, None] & np.column_stack([~within[edges], ~within[edges + 1]])
    there = np.clip(a[:, None] + share[..., None] * (b - a)[:, None], low, high)[new]
    places = np.broadcast_to(edges[:, None] + 1, new.shape)[new]
    return (
        np.insert(points, places, there, axis=0),
        np.insert(kinks, places, False),
        np.insert(within, places, True),
    )
