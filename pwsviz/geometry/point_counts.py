"""Points counted by pixel and kind: a million of them as one image that a browser paints at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.geometry.window import Window

__all__ = ["LEVELS", "PointCounts", "Portion", "extent_of", "visible"]

LEVELS = 16
"""Shades of each kind, by the logarithm of the number of points in a pixel."""

SPARSE = 0.15
"""Part of the pixels that have points up to which points are painted a pixel wider: a single one is hardly seen."""

BY_ONE = 64
"""Pixels for each new point from which points are counted one by one: a new array of all pixels would cost more."""


class Portion(NamedTuple):
    """Points of a cloud that came together; the arrays are not changed afterwards."""

    x: Floats
    """(n,)."""
    y: Floats
    """(n,); a point of which either is not finite is never seen."""
    kind: NDArray[np.uint8] | int
    """(n,) number of the kind of each point, or that of all."""


class PointCounts:
    """Counts of the points in each pixel of a window, by kind; points can be added.

    Parameters
    ----------
    window
        The part of the plane.
    shape : (int, int)
        Rows and columns of pixels.
    kinds
        Number of kinds, at most 15.
    """

    def __init__(self, window: Window, shape: tuple[int, int], kinds: int) -> None:
        self.window, self.shape, self.kinds = window, shape, kinds
        self._counts = np.zeros(kinds * shape[0] * shape[1], dtype=np.int32)

    @property
    def counts(self) -> NDArray[np.int32]:
        """(kinds, rows, columns) numbers of points, the first row at the bottom."""
        return self._counts.reshape(self.kinds, *self.shape)

    def add(self, portion: Portion) -> int:
        """Count more points, and return how many of them lie in the window."""
        (rows, columns), window = self.shape, self.window
        inside = visible(portion, window)
        across = (portion.x[inside] - window.x_low) * (columns / window.width)
        up = (portion.y[inside] - window.y_low) * (rows / window.height)
        pixel = np.minimum(up.astype(np.int64), rows - 1) * columns
        pixel += np.minimum(across.astype(np.int64), columns - 1)
        if isinstance(portion.kind, int):
            counts = self._counts[portion.kind * rows * columns :][: rows * columns]
        else:
            counts = self._counts
            pixel += portion.kind[inside].astype(np.int64) * (rows * columns)
        if len(pixel) * BY_ONE < len(counts):
            np.add.at(counts, pixel, 1)
        else:
            counts += np.bincount(pixel, minlength=len(counts)).astype(np.int32)
        return len(pixel)

    def image(self, wide: int = 2) -> NDArray[np.uint8]:
        """Return (rows, columns): 0 where there is no point, else 1 + shade + `LEVELS` · kind.

        Points are at most `wide` pixels wide, and less where they are many (`SPARSE`).

        The kind is the one with the most points of the pixel; the shade, from 0 to `LEVELS` − 1, grows with the
        logarithm of their number, and is the last one in the fullest pixel.
        """
        total, kind = self.counts.sum(axis=0), self.counts.argmax(axis=0)
        most = max(int(total.max(initial=0)), 2)
        shade = np.floor(np.log(np.maximum(total, 1)) * ((LEVELS - 1) / np.log(most)) + 1e-9)
        image = np.where(total > 0, 1 + shade + LEVELS * kind, 0).astype(np.uint8)
        for _ in range(wide - 1):
            if np.count_nonzero(image) >= SPARSE * image.size:
                break
            image = _widened(image)
        return image


def visible(portion: Portion, window: Window) -> NDArray[np.bool_]:
    """Return (n,) which points lie in a window."""
    across = (window.x_low <= portion.x) & (portion.x <= window.x_high)
    return np.asarray(across & (window.y_low <= portion.y) & (portion.y <= window.y_high))


def extent_of(portions: Sequence[Portion]) -> Window | None:
    """Return the smallest window that holds all finite points; None if there are none."""
    boxes = []
    for x, y, _ in portions:
        there = np.isfinite(x) & np.isfinite(y)
        if there.any():
            boxes.append((x[there].min(), x[there].max(), y[there].min(), y[there].max()))
    if not boxes:
        return None
    low, high = np.min(boxes, axis=0), np.max(boxes, axis=0)
    return Window(float(low[0]), float(high[1]), float(low[2]), float(high[3]))


def _widened(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return an image whose points are a pixel wider and higher, where they have room."""
    for part, shifted in ((np.s_[:, 1:], np.s_[:, :-1]), (np.s_[1:], np.s_[:-1])):
        before = image.copy()
        image[part] = np.where(before[part] == 0, before[shifted], before[part])
    return image
