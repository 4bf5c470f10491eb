"""Reduction of a long series of values against time to the columns of pixels of a screen."""

from __future__ import annotations

import numpy as np

from pwsviz.geometry.polyline_reduction import Floats

__all__ = ["envelope"]


def envelope(t: Floats, y: Floats, columns: int = 1200) -> tuple[Floats, Floats]:
    """Return the least and greatest value in each pixel column, as one zigzag line.

    Parameters
    ----------
    t : (n,) array
        Times, ascending.
    y : (n,) array
        Values; NaN if there is none.
    columns : int
        Pixel columns across the plot.

    Returns
    -------
    t, y : (k,) arrays with k ≤ 2 columns
        The series itself if it has at most 2 × columns points; else two points a column, at its first time.
    """
    if len(t) <= 2 * columns:
        return t, y
    starts = np.unique(np.searchsorted(t, t[0] + (t[-1] - t[0]) * (np.arange(columns) / columns)))
    starts = starts[starts < len(t)]
    low, high = np.fmin.reduceat(y, starts), np.fmax.reduceat(y, starts)
    return np.repeat(t[starts], 2), np.column_stack([low, high]).ravel()
