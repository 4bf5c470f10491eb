"""Reduction of long curves to the resolution of a screen.

A million states pass through here between two frames of a dragged slider, so the loops are compiled. Each reduction
states a bound that the tests check.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# numba infers the types of compiled functions from their first call.

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]

RESOLUTION = 1500
"""Pixels assumed along the longer side of a plot, more than most screens give it."""

TOLERANCES = (0.25, 0.5, 1.0)
"""Distances to which a curve is simplified, in pixels: the next one if too many vertices remain."""

MOST_VERTICES = 12_000
"""Most vertices of a curve: below, gaps would be seen in what fills an area but sparsely."""

EVERYWHERE = (-np.inf, np.inf, -np.inf, np.inf)
"""Ends (left, right, bottom, top) of a window that leaves out nothing."""

RECENT = 8
"""Pixels of a path that are near what follows since they lead to it."""

MOST_CELLS = 10_000_000
"""Pixels of a picture that it is looked up in whether they have been painted: four times those of a square one."""

BITS = 4
"""Of the number of a pixel, those that tell its place within a tile; the others tell the tile."""

TILE = 1 << BITS
"""Pixels along the side of a tile of such a picture."""

_OPTIONS: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy"}
_compiled: Any = njit(**_OPTIONS)


def simplify(points: Floats, tolerance: float, pinned: Mask | None = None) -> Indices:
    """Choose the vertices of a simplified curve: many where it bends, few where it is straight.

    Parameters
    ----------
    points : (n, 2) array
        The curve.
    tolerance : float
        Largest Hausdorff distance allowed between the curve and the simplified one.
    pinned : (n,) bool array, optional
        Vertices to keep in any case. Both ends are always kept.

    Returns
    -------
    (k,) int array
        Indices of the vertices to keep, ascending.

    Notes
    -----
    One pass: an edge from the last vertex kept is extended as long as all points passed lie within the tolerance of it
    (the cone of admissible directions: Williams, Comput. J. 21, 1978; Sklansky, Gonzalez, Pattern Recogn. 12, 1980).
    It also ends where the curve turns back, so that no point lies beyond its end.

    It is compiled by the import, in a second once on a machine: the field of a system needs it, and is to be seen while
    its integrators are compiled, which takes longer and excludes other compilation.
    """
    kept = np.empty(len(points), dtype=np.intp)
    fixed = np.zeros(len(points), dtype=bool) if pinned is None else np.ascontiguousarray(pinned)
    count = _simplify(np.ascontiguousarray(points), float(tolerance), fixed, kept)
    return kept[:count].copy()


@njit("intp(float64[:, ::1], float64, boolean[::1], intp[::1])", **_OPTIONS)
def _simplify(points, tolerance, fixed, kept):
    last = points.shape[0] - 1
    kept[0] = anchor = 0
    count, far, open_ = 1, 0.0, True  # open: no direction is excluded yet
    low_x = low_y = high_x = high_y = 0.0  # the ends of the cone, clockwise and counterclockwise
    for i in range(1, last + 1):
        x, y = points[i, 0] - points[anchor, 0], points[i, 1] - points[anchor, 1]
        r = np.sqrt(x * x + y * y)
        within = r >= far and (open_ or (low_x * y - low_y * x >= 0.0 and high_x * y - high_y * x <= 0.0))
        if not open_ and tolerance == 0.0 and low_x * x + low_y * y <= 0.0:
            within = False  # the cone is a line, and this point lies in the opposite direction
        if i - 1 > anchor and (fixed[i - 1] or not within):
            anchor = kept[count] = i - 1
            count, far, open_ = count + 1, 0.0, True
            x, y = points[i, 0] - points[anchor, 0], points[i, 1] - points[anchor, 1]
            r = np.sqrt(x * x + y * y)
        far = max(far, r)
        if r > tolerance:  # narrow the cone to the directions that pass this point closely enough
            along = np.sqrt(r * r - tolerance * tolerance)
            right_x, right_y = x * along + y * tolerance, y * along - x * tolerance
            left_x, left_y = x * along - y * tolerance, y * along + x * tolerance
            if open_ or low_x * right_y - low_y * right_x > 0.0:
                low_x, low_y = right_x, right_y
            if open_ or high_x * left_y - high_y * left_x < 0.0:
                high_x, high_y = left_x, left_y
            open_ = False
    if last > 0:
        kept[count] = last
        count += 1
    return count


def screen_path(
    points: Floats,
    pinned: Mask | None = None,
    shown: Mask | None = None,
    limit: int = MOST_VERTICES,
    pixel: float | None = None,
) -> Floats:
    """Reduce a trajectory to at most `limit` vertices that draw the same picture.

    It is simplified to within a quarter of a pixel; if too many vertices remain, of half a pixel, or of a whole one. If
    these are still too many, the trajectory fills an area; then only the pieces that reach pixels not painted before
    are kept, and the pixels are enlarged until the bound is met. No edge is painted twice: see `painted_once`.

    Parameters
    ----------
    points : (n, 2) array
        The trajectory; states that are not finite leave a gap.
    pinned : (n,) bool array, optional
        Vertices with a kink, such as crossings, kept unless their pixel is already painted.
    shown : (n,) bool array, optional
        Vertices to draw; the others leave a gap.
    limit : int
        Bound on the rows returned.
    pixel : float, optional
        Size of a pixel; by default such that the vertices drawn fill `RESOLUTION` pixels.

    Returns
    -------
    (k, 2) array
        Vertices, with a row of NaN between pieces.
    """
    valid = np.ones(len(points), dtype=bool) if shown is None else shown.copy()
    fixed = np.zeros(len(points), dtype=bool) if pinned is None else np.ascontiguousarray(pinned)
    points = np.ascontiguousarray(points)
    box = _bounds(points, valid)
    if valid.all():
        curve = _Curve(points, fixed, np.zeros(max(len(points) - 1, 0), dtype=bool))
    else:
        curve = _Curve(points[valid], fixed[valid], np.diff(np.flatnonzero(valid)) > 1)
    coarsest = max(box[1] - box[0], box[3] - box[2]) / RESOLUTION if len(curve.points) else 0.0
    if coarsest == 0.0:
        return curve.points[:1]
    finest = size = coarsest if pixel is None else pixel
    for part in TOLERANCES:
        path = painted_once(curve.path(part * size), finest)
        if len(path) <= limit:
            return path
    while len(path) > limit:
        size = max(size, coarsest)
        curve = curve.unpainted(size)
        size *= 1.5
        path = painted_once(curve.path(size / 4), finest)
    return path


def painted_once(path: Floats, pixel: float) -> Floats:
    """Leave out the edges of a path that lie within about a pixel of earlier ones, as later turns of an orbit do.

    Painted again, dashes fill the gaps between dashes, and the edges of thin lines become opaque, in each renderer and
    at each size differently.

    Parameters
    ----------
    path : (n, 2) array
        Vertices, with rows of NaN between pieces.
    pixel : float
        Size of a pixel.

    Returns
    -------
    (k, 2) array
        The rest of the path, with a row of NaN between pieces.
    """
    new = painted_first(path, pixel)
    if new.all():
        return path
    there = np.zeros(len(path), dtype=bool)
    there[:-1] |= new
    there[1:] |= new
    kept = np.flatnonzero(there)
    return np.insert(path[kept], 1 + np.flatnonzero(~new[kept[:-1]]), np.nan, axis=0)


def painted_first(path: Floats, pixel: float) -> Mask:
    """Return (n - 1,) which edges of a path (n, 2) are not painted before; all if it is too large to be told."""
    x_low, x_high, y_low, y_high = _bounds(path, np.ones(len(path), dtype=bool))
    columns, rows = (3 + min(size / pixel, MOST_CELLS) for size in (x_high - x_low, y_high - y_low))
    new: Mask = np.ones(max(len(path) - 1, 0), dtype=bool)
    if len(path) < 3 or not columns * rows <= MOST_CELLS:
        return new
    new[:] = False
    tiles = np.zeros((int(columns) // TILE + 1, int(rows) // TILE + 1), np.uint32)
    _first_painted(path, x_low - pixel, y_low - pixel, pixel, tiles, new)
    return new


@_compiled
def _is_painted(tiles, painted, column, row, until):
    """Whether the pixel, which most often is that of an earlier turn, or one beside it was painted before."""
    if 0.0 <= painted[tiles[column >> BITS, row >> BITS], column & TILE - 1, row & TILE - 1] < until:
        return True
    for a in range(max(column - 1, 0), column + 2):
        for b in range(max(row - 1, 0), row + 2):
            if 0.0 <= painted[tiles[a >> BITS, b >> BITS], a & TILE - 1, b & TILE - 1] < until:
                return True
    return False


@_compiled
def _first_painted(path, x_low, y_low, pixel, tiles, new):
    """Paint a path, and mark the edges that reach pixels not painted before.

    Most of a picture stays empty, so only the tiles that the path reaches are made; `tiles` has their numbers, and 0
    for all others.
    """
    painted, made = np.full((64, TILE, TILE), np.float32(-1.0)), 1
    passed = 0.0  # length of the path so far in pixels; each pixel has the length at which it was painted, or -1
    for k in range(new.size):
        x, y = path[k, 0], path[k, 1]
        across, up = path[k + 1, 0] - x, path[k + 1, 1] - y
        length = np.sqrt(across * across + up * up) / pixel
        if not length < np.inf:
            continue
        count = 1 + int(length)
        for i in range(count + 1):
            column, row = int((x + across * i / count - x_low) / pixel), int((y + up * i / count - y_low) / pixel)
            if not _is_painted(tiles, painted, column, row, passed + length * i / count - RECENT):
                new[k] = True
                break
        if new[k]:
            for i in range(count + 1):
                column, row = int((x + across * i / count - x_low) / pixel), int((y + up * i / count - y_low) / pixel)
                tile = tiles[column >> BITS, row >> BITS]
                if tile == 0:
                    if made == len(painted):
                        painted = np.concatenate((painted, np.full_like(painted, np.float32(-1.0))))
                    tile = tiles[column >> BITS, row >> BITS] = made
                    made += 1
                if painted[tile, column & TILE - 1, row & TILE - 1] < 0:
                    painted[tile, column & TILE - 1, row & TILE - 1] = passed + length * i / count
        passed += length


@dataclass(frozen=True)
class _Curve:
    """A polyline with gaps, and with kinks to keep.

    Attributes
    ----------
    points : (n, 2) array
    fixed : (n,) bool array
        Vertices to keep.
    broken : (n - 1,) bool array
        Edges not to draw.
    """

    points: Floats
    fixed: Mask
    broken: Mask

    def path(self, tolerance: float) -> Floats:
        """Return the simplified curve, with a row of NaN in each gap."""
        pinned = self.fixed.copy()
        pinned[:-1] |= self.broken
        pinned[1:] |= self.broken
        kept = simplify(self.points, tolerance, pinned)
        return np.insert(self.points[kept], 1 + np.flatnonzero(self.broken[kept[:-1]]), np.nan, axis=0)

    def unpainted(self, cell: float) -> _Curve:
        """Return the part that enters a square of side `cell` for the first time, with the edges to and from it."""
        new = first_in_cells(self.points, cell)
        touched = new.copy()
        touched[1:] |= new[:-1]
        touched[:-1] |= new[1:]
        index = np.flatnonzero(touched)
        gaps = (np.diff(index) > 1) | self.broken[index[:-1]]
        return _Curve(self.points[index], (self.fixed & new)[index], gaps)


def first_in_cells(points: Floats, cell: float) -> Mask:
    """Return (n,) which points are the first in their square of side `cell`."""
    first = np.ones(len(points), dtype=bool)
    points = np.ascontiguousarray(points)
    x_low, x_high, y_low, y_high = _bounds(points, first)
    columns, rows = 1 + int((x_high - x_low) / cell), 1 + int((y_high - y_low) / cell)
    _first_in_cells(points, x_low, y_low, cell, np.zeros((columns, rows), dtype=bool), first)
    return first


@_compiled
def _first_in_cells(points, x_low, y_low, cell, occupied, first):
    for i in range(points.shape[0]):
        column, row = int((points[i, 0] - x_low) / cell), int((points[i, 1] - y_low) / cell)
        first[i] = not occupied[column, row]
        occupied[column, row] = True


@_compiled
def _bounds(points, valid):
    """Return least and greatest x and y of the valid points; points that are not finite are marked invalid."""
    x_low = y_low = np.inf
    x_high = y_high = -np.inf
    for i in range(points.shape[0]):
        x, y = points[i, 0], points[i, 1]
        if valid[i] and abs(x) < np.inf and abs(y) < np.inf:
            x_low, x_high, y_low, y_high = min(x_low, x), max(x_high, x), min(y_low, y), max(y_high, y)
        else:
            valid[i] = False
    return x_low, x_high, y_low, y_high


def longest_side(points: Floats, window: tuple[float, float, float, float] = EVERYWHERE) -> float:
    """Return the longer side of the box of the points (n, 2) within a window; 0 if there are none."""
    size: float = _longest_side(np.ascontiguousarray(points), np.array(window, dtype=float))
    return size


@_compiled
def _longest_side(points, window):
    x_low = y_low = np.inf
    x_high = y_high = -np.inf
    for i in range(points.shape[0]):
        x, y = points[i, 0], points[i, 1]
        there = abs(x) < np.inf and abs(y) < np.inf
        if there and window[0] <= x <= window[1] and window[2] <= y <= window[3]:
            x_low, x_high, y_low, y_high = min(x_low, x), max(x_high, x), min(y_low, y), max(y_high, y)
    return max(x_high - x_low, y_high - y_low, 0.0)


def spliced(points: Floats, rows: Floats, places: Indices) -> tuple[Floats, Mask]:
    """Insert rows into a curve, and return the result with a mask of these rows.

    Parameters
    ----------
    points : (n, 2) array
    rows : (k, 2) array
    places : (k,) int array
        Index of the point before which each row is inserted; ascending.

    Returns
    -------
    (n + k, 2) array and (n + k,) bool array
    """
    out, marks = np.empty((len(points) + len(rows), 2)), np.zeros(len(points) + len(rows), dtype=bool)
    marks[places + np.arange(len(places))] = True
    out[marks] = rows
    _spread(points, marks, out)
    return out, marks


@_compiled
def _spread(points, marks, out):
    k = 0
    for i in range(marks.size):
        if not marks[i]:
            out[i, 0], out[i, 1] = points[k, 0], points[k, 1]
            k += 1


def distinct_pixels(points: Floats) -> Indices:
    """Return the indices of points that a screen tells apart: the first one in each square of two pixels."""
    x_low, x_high, y_low, y_high = _bounds(np.ascontiguousarray(points), np.ones(len(points), dtype=bool))
    span = max(x_high - x_low, y_high - y_low) if len(points) else 0.0
    if span == 0.0:
        return np.arange(min(len(points), 1))
    return np.flatnonzero(first_in_cells(points, 2 * span / RESOLUTION))
