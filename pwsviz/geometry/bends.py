"""Where a curve bends between its vertices so far that it is seen: in one compiled pass over a million of them."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types of compiled functions from their first call.

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from pwsviz.geometry.polyline_reduction import EVERYWHERE, Floats, Mask

__all__ = ["bent_pieces"]

_compiled: Any = njit(cache=True, nogil=True, error_model="numpy")


def bent_pieces(
    t: Floats,
    points: Floats,
    kinks: Mask,
    tolerance: float,
    window: tuple[float, float, float, float] = EVERYWHERE,
) -> Mask:
    """Return which pieces of a curve may bend visibly between their ends.

    A piece may bend if one of its ends is farther than the tolerance from the line through its neighbours. At a corner
    the curve turns, however short its pieces are; a piece between two corners is taken to bend.

    Parameters
    ----------
    t : (n,) array
        Times of the vertices; a piece that takes no time is a jump, not a part of the curve.
    points : (n, 2) array
        The vertices; those that are not finite leave a gap.
    kinks : (n,) bool array
        Corners of the curve. Its ends, and those of gaps and jumps, are corners, too.
    tolerance : float
        Least distance that is seen.
    window : (x_low, x_high, y_low, y_high)
        Pieces with both ends outside are not seen.

    Returns
    -------
    (n - 1,) bool array
    """
    bent: Mask = np.zeros(max(len(points) - 1, 0), dtype=bool)
    box = np.array(window, dtype=float)
    _mark_bent(np.ascontiguousarray(t), np.ascontiguousarray(points), kinks, float(tolerance), box, bent)
    return bent


@_compiled
def _mark_bent(t, points, kinks, tolerance, window, bent):
    count = points.shape[0]
    came = seen_before = corner_before = turned_before = False  # of the piece and the vertex before
    for i in range(count):
        x, y = points[i, 0], points[i, 1]
        there = abs(x) < np.inf and abs(y) < np.inf
        seen = there and window[0] <= x <= window[1] and window[2] <= y <= window[3]
        goes = there and i + 1 < count and t[i + 1] > t[i]
        goes = goes and abs(points[i + 1, 0]) < np.inf and abs(points[i + 1, 1]) < np.inf
        corner = kinks[i] or not came or not goes
        turned = False
        if not corner:
            across, up = points[i + 1, 0] - points[i - 1, 0], points[i + 1, 1] - points[i - 1, 1]
            away = abs(across * (y - points[i - 1, 1]) - up * (x - points[i - 1, 0])) / np.sqrt(across**2 + up**2)
            turned = not away <= tolerance  # also where it is NaN: where the curve returns to a point
        if i > 0:
            bent[i - 1] = came and (seen or seen_before) and (turned or turned_before or (corner and corner_before))
        came, seen_before, corner_before, turned_before = goes, seen, corner, turned
