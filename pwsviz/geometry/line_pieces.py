"""Lines of several pieces in one array, with rows of NaN between them: cut, joined, resampled and measured."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from pwsviz.geometry.polyline_reduction import Floats

__all__ = ["area", "cut", "joined", "pieces", "resampled", "with_value"]


def cut(lines: Floats, g: Floats) -> Floats:
    """Return the parts of lines where g > 0, cut where g, interpolated linearly, vanishes."""
    change = np.flatnonzero(g[:-1] * g[1:] < 0)
    share = g[change] / (g[change] - g[change + 1])
    ends = lines[change] + share[:, None] * (lines[change + 1] - lines[change])
    lines, g = np.insert(lines, change + 1, ends, axis=0), np.insert(g, change + 1, 0.0)
    gap = np.isnan(lines[:, 0])
    inside = ((g[:-1] > 0) | (g[1:] > 0)) & ~gap[:-1] & ~gap[1:]  # of each piece of a line between two vertices
    met = np.zeros(len(lines), dtype=bool)
    met[:-1] |= inside
    met[1:] |= inside
    kept = np.flatnonzero(met)
    return np.insert(lines[kept], 1 + np.flatnonzero(~inside[kept[:-1]]), np.nan, axis=0)


def with_value(lines: Floats, value: float) -> Floats:
    """Return lines with a third column that holds a value."""
    return np.column_stack([lines, np.full(len(lines), value)])


def resampled(line: Floats, spacing: float) -> Floats:
    """Return a line with vertices at this spacing or less, and its ends."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line[:, :2], axis=0).T))])
    at = np.linspace(0.0, along[-1], 2 + int(along[-1] / spacing))
    return np.column_stack([np.interp(at, along, column) for column in line.T])


def pieces(lines: Floats) -> list[Floats]:
    """Return the lines between the gaps of one array."""
    there = np.flatnonzero(~np.isnan(lines[:, 0]))
    starts = 1 + np.flatnonzero(np.diff(there) > 1)
    return [lines[part] for part in np.split(there, starts) if len(part)]


def joined(lines: Iterable[Floats], width: int = 2) -> Floats:
    """Return one array of all lines, each followed by a gap."""
    gap = np.full((1, width), np.nan)
    return np.concatenate([part for line in lines for part in (line, gap)] or [gap])


def area(ring: Floats) -> float:
    """Return the area within a closed ring."""
    (x, y), (across, up) = ring[:-1].T, np.diff(ring, axis=0).T
    return 0.5 * abs(float((x * up - y * across).sum()))
