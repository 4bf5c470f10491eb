"""Long curves at the resolution of a screen: no more vertices than the eye can use.

Everything here is vectorised NumPy on plain arrays, and every reduction comes with a bound that the tests hold it to.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]

RESOLUTION = 1500
"""Pixels along the longer side of a plot, at a generous guess."""


def simplify(points: Floats, tolerance: float, pinned: Mask | None = None) -> Indices:
    """Choose vertices by shape: many where the curve bends, few where it is straight.

    Vertices are dropped in rounds, every second one at most. Each edge of the curve that remains carries a bound on
    its distance to what was dropped beneath it, and no bound may exceed the tolerance.

    Parameters
    ----------
    points : (n, 2) array
        The curve.
    tolerance : float
        The largest distance (Hausdorff) allowed between the curve and what remains of it.
    pinned : (n,) bool array, optional
        Vertices to keep in any case. The two ends are always kept.

    Returns
    -------
    (k,) int array
        Indices of the vertices to keep, ascending.
    """
    n = len(points)
    fixed = np.zeros(n, dtype=bool) if pinned is None else pinned.copy()
    z = points[:, 0] + 1j * points[:, 1]
    kept, debt = np.arange(n), np.zeros(n)  # debt[i]: the bound of the edge that starts at vertex i
    parity, idle = 0, 0
    while idle < 2 and len(z) > 2:
        before, here = slice(parity, -2, 2), slice(1 + parity, -1, 2)
        cost = _gap(z[before], z[here], z[2 + parity :: 2]) + np.maximum(debt[before], debt[here])
        gone = (cost <= tolerance) & ~fixed[here]
        parity = 1 - parity
        idle = 0 if gone.any() else idle + 1
        debt[before][gone] = cost[gone]
        stays = np.ones(len(z), dtype=bool)
        stays[here] = ~gone
        z, kept, debt, fixed = z[stays], kept[stays], debt[stays], fixed[stays]
    return kept


def _gap(before: Complexes, vertex: Complexes, after: Complexes) -> Floats:
    """Distance of each vertex to the segment between its neighbours."""
    chord, offset = after - before, vertex - before
    product = offset * chord.conj()
    share = product.real / np.maximum(chord.real**2 + chord.imag**2, np.finfo(np.float64).tiny)
    rest = offset - np.clip(share, 0.0, 1.0, out=share) * chord
    gap: Floats = np.sqrt(rest.real**2 + rest.imag**2)
    return gap


def screen_path(points: Floats, pinned: Mask | None = None, shown: Mask | None = None, limit: int = 4000) -> Floats:
    """Reduce a trajectory to at most `limit` vertices that draw the same picture.

    First by shape alone, to a quarter of a pixel. An orbit that goes round so often that this is not enough repeats
    itself on the screen: then only what reaches pixels not painted before is kept, in pieces. Where even that is
    too much (a trajectory that fills an area), the pixels grow until it fits.

    Parameters
    ----------
    points : (n, 2) array
        The trajectory; states that are not finite are left out.
    pinned : (n,) bool array, optional
        Vertices that carry a kink, such as crossings, kept unless already painted.
    shown : (n,) bool array, optional
        Vertices to draw at all; the others leave a gap.
    limit : int
        Bound on the rows returned.

    Returns
    -------
    (k, 2) array
        Vertices, pieces parted by a row of NaN.
    """
    valid = np.isfinite(points).all(axis=1) if shown is None else shown & np.isfinite(points).all(axis=1)
    fixed = np.zeros(len(points), dtype=bool) if pinned is None else pinned
    curve = _Curve(points[valid], fixed[valid], np.diff(np.flatnonzero(valid)) > 1)
    pixel = float(np.ptp(curve.points, axis=0).max(initial=0.0)) / RESOLUTION if valid.any() else 0.0
    if pixel == 0.0:
        return curve.points[:1]
    curve = curve.strided(pixel / 2)
    eighth = simplify(curve.points[: len(curve.points) // 8], pixel / 4)
    if 8 * len(eighth) <= 2 * limit:  # else the whole would only be looked at in vain
        path = curve.path(pixel / 4)
        if len(path) <= limit:
            return path
    while len(path := curve.unpainted(pixel).path(pixel / 4)) > limit:
        pixel *= 1.5
    return path


@dataclass(frozen=True)
class _Curve:
    """A polyline with kinks to keep and gaps.

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
        """Vertices chosen by shape, with NaN in the gaps."""
        ends = np.zeros(len(self.points), dtype=bool)
        ends[:-1] |= self.broken
        ends[1:] |= self.broken
        kept = simplify(self.points, tolerance, self.fixed | ends)
        return np.insert(self.points[kept], 1 + np.flatnonzero(self.broken[kept[:-1]]), np.nan, axis=0)

    def only(self, stays: Mask, bridged: bool) -> _Curve:
        """Some of the vertices; where others were left out there is an edge (`bridged`) or a gap."""
        index = np.flatnonzero(stays)
        gaps = np.concatenate([[0], np.cumsum(self.broken)])
        broken = gaps[index[1:]] > gaps[index[:-1]]
        if not bridged:
            broken |= np.diff(index) > 1
        return _Curve(self.points[stays], self.fixed[stays], broken)

    def strided(self, spacing: float) -> _Curve:
        """Every k-th vertex, k such that these are at most about `spacing` apart: for steps far finer than a pixel."""
        lengths = np.abs(np.diff(self.points, axis=0)).max(axis=1)
        longest = float(lengths[~self.broken].max(initial=0.0))
        stride = int(spacing / longest) if longest > 0 else 1
        if stride < 2:
            return self
        stays = self.fixed.copy()
        stays[::stride] = stays[-1] = True
        stays[:-1] |= self.broken
        stays[1:] |= self.broken
        return self.only(stays, bridged=True)

    def unpainted(self, cell: float) -> _Curve:
        """Only what enters a square of side `cell` for the first time, with the edges that lead there and away."""
        new = first_visits(self.points, cell)
        touched = new.copy()
        touched[1:] |= new[:-1]
        touched[:-1] |= new[1:]
        return _Curve(self.points, self.fixed & new, self.broken).only(touched, bridged=False)


def first_visits(points: Floats, cell: float) -> Mask:
    """Mark the points that are the first of all in their square of side `cell`."""
    square = ((points - points.min(axis=0)) / cell).astype(np.int64)
    number = square[:, 0] * (square[:, 1].max() + 1) + square[:, 1]
    earliest = np.empty(number.max() + 1, dtype=np.int64)
    earliest[number[::-1]] = np.arange(len(points) - 1, -1, -1)  # of equal indices the last assignment stays
    mask: Mask = earliest[number] == np.arange(len(points))
    return mask


def distinct_pixels(points: Floats, limit: int = 1000) -> Indices:
    """Indices of points that do not hide one another, at most `limit` of them."""
    span = float(np.ptp(points, axis=0).max(initial=0.0)) if len(points) else 0.0
    if span == 0.0:
        return np.arange(min(len(points), 1))
    return np.flatnonzero(first_visits(points, 2 * span / RESOLUTION))[:limit]


def envelope(t: Floats, y: Floats, columns: int = 1200) -> tuple[Floats, Floats]:
    """Smallest and largest value in each pixel column, as one zigzag line.

    Parameters
    ----------
    t : (n,) array
        Ascending.
    y : (n,) array
        NaN where there is no value.
    columns : int
        Pixel columns across the plot.

    Returns
    -------
    t, y : (k,) arrays with k ≤ 2 columns
        The series itself where it is short enough; else two points a column, at its first instant.
    """
    if len(t) <= 2 * columns:
        return t, y
    share = (t - t[0]) / (t[-1] - t[0])
    starts = np.unique(np.searchsorted(share, np.arange(columns) / columns))
    starts = starts[starts < len(t)]
    low, high = np.fmin.reduceat(y, starts), np.fmax.reduceat(y, starts)
    return np.repeat(t[starts], 2), np.column_stack([low, high]).ravel()
