"""The backdrop of a phase portrait: sides, surface, field and level sets, on a window of the plane."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from contourpy import FillType, LineType, contour_generator
from numpy.typing import NDArray

import core
from pwsviz.geometry.formulas import formulas
from pwsviz.geometry.polyline_reduction import Floats, simplify
from pwsviz.geometry.projection import (
    Axes,
    moves,
    shows_field,
    shows_levels,
    shows_regions,
    shows_sliding,
    surfaces_shown,
)
from pwsviz.geometry.shades import regions_of

GRID = 160
"""Cells along the longer side of the grid on which surfaces and level sets are traced."""

ARROWS = 24
"""Arrows of the field along the longer side."""

ROWS = 6
"""Rows of an arrow."""

LEVELS = 7
"""Level sets drawn on each side, besides those through the orbits."""


FINE = 300
"""Vertices along the longer side, at least, of a line of which a moving surface hides a part."""

Columns: TypeAlias = "dict[str, Floats]"


class Window(NamedTuple):
    """A rectangle of the plane."""

    x_low: float
    x_high: float
    y_low: float
    y_high: float

    @property
    def width(self) -> float:
        """Extent in x."""
        return self.x_high - self.x_low

    @property
    def height(self) -> float:
        """Extent in y."""
        return self.y_high - self.y_low

    @classmethod
    def around(cls, points: Floats) -> Window:
        """Return the bounding box of points (n, 2) with a margin, ignoring NaN."""
        low, high = np.nanmin(points, axis=0), np.nanmax(points, axis=0)
        size, away = float((high - low).max()), float(np.abs(high + low).max()) / 2
        if size <= 1e-6 * max(away, 1e-3):  # one point: its largest |coordinate| becomes the margin, or 1
            size = 5 * max(away, 1.0)
        margin = 0.2 * size
        return cls(*(float(end) for end in (low[0] - margin, high[0] + margin, low[1] - margin, high[1] + margin)))

    def holds(self, points: Floats) -> NDArray[np.bool_]:
        """Return (n,) which of the points (n, 2) lie within."""
        x, y = points[:, 0], points[:, 1]
        return (self.x_low <= x) & (x <= self.x_high) & (self.y_low <= y) & (y <= self.y_high)

    def scaled(self, factor: float) -> Window:
        """Return the window scaled about its centre."""
        x, y = (self.x_low + self.x_high) / 2, (self.y_low + self.y_high) / 2
        w, h = factor * self.width / 2, factor * self.height / 2
        return Window(x - w, x + w, y - h, y + h)

    def covers(self, other: Window) -> bool:
        """Whether `other` lies within."""
        across = self.x_low <= other.x_low and other.x_high <= self.x_high
        return across and self.y_low <= other.y_low and other.y_high <= self.y_high

    def shows_well(self, other: Window) -> bool:
        """Whether this backdrop suits the view `other`: it covers it and is at most four times as large."""
        return self.covers(other) and self.width <= 4 * other.width and self.height <= 4 * other.height


@dataclass(frozen=True)
class Backdrop:
    """The backdrop of a portrait; each curve is an array with rows of NaN between its pieces.

    Attributes
    ----------
    window : Window
        The part of the plane that it covers.
    surface : (k, 2) array
        The curves g = 0.
    attracting, repelling : (k, 2) array
        The pieces of these curves to which both fields point, and from which both do.
    minus_outer, minus_holes : list
        Outlines of the regions of the first shade, where g < 0, and those of their holes.
    arrows : dict
        For each shade, which is a side of one surface, (k, 2): the field as arrows.
    levels, orbit_levels : dict
        For each shade, (k, 3): level sets, the usual ones and those of the orbits, with the value of ψ.
    whole : dict
        For each side, if one surface moves: levels, orbit_levels and arrows (columns x, y, psi as they are at t = 0)
        beyond the surface, too, in the column "whole" in place of x; (at_x, at_y) is the point whose side counts.
    formulas : dict
        What the browser can evaluate at a point, see `formulas`.
    """

    window: Window
    surface: Floats
    attracting: Floats
    repelling: Floats
    minus_outer: list[NDArray[np.float64]]
    minus_holes: list[list[NDArray[np.float64]]]
    arrows: dict[int, Floats]
    levels: dict[int, Floats]
    orbit_levels: dict[int, Floats]
    whole: dict[int, list[Columns]]
    formulas: dict[str, Any]


def backdrop(
    system: core.PiecewiseSystem, window: Window, orbits: dict[int, tuple[float, ...]], axes: Axes = (0, 1)
) -> Backdrop:
    """Trace what depends only on the system and the window, at t = 0.

    Parameters
    ----------
    system : core.PiecewiseSystem
        The system. What cannot be drawn in the plane (see `projection`) is left empty.
    window : Window
        The part of the plane to cover.
    orbits : dict
        Values of ψ of the visible orbits in each region, by its number.
    axes : (int, int)
        The variables that span the plane.
    """
    plane, shades = _Plane(system, window, axes), {shade: regions_of(system, shade) for shade in (-1, 1)}
    rings = plane.minus_rings()
    return Backdrop(
        window=window,
        surface=_joined(plane.surface()),
        attracting=_joined(plane.where_both_point(1)),
        repelling=_joined(plane.where_both_point(-1)),
        minus_outer=[ring[0] for ring in rings],
        minus_holes=[ring[1:] for ring in rings],
        arrows={side: np.concatenate([*map(plane.arrows, modes), _joined([])]) for side, modes in shades.items()},
        levels={side: _joined_sets(map(plane.usual_level_sets, modes)) for side, modes in shades.items()},
        orbit_levels={
            side: _joined_sets(plane.level_sets(mode, orbits.get(mode, ())) for mode in modes)
            for side, modes in shades.items()
        },
        whole={
            side: plane.whole(modes[0], orbits.get(modes[0], ()))
            for side, modes in shades.items()
            if moves(system) and system.two_sided
        },
        formulas=formulas(system, axes),
    )


def closed_surface(system: core.PiecewiseSystem, window: Window, axes: Axes = (0, 1)) -> Floats:
    """Return the points (k, 2) of the pieces of the surface that are closed curves within a window."""
    lines = _Plane(system, window, axes).surface()
    loops = [line for line in lines if len(line) > 3 and np.array_equal(line[0], line[-1])]
    return np.concatenate([*loops, np.empty((0, 2))])


class _Plane:
    """The functions of the system on a grid over the window."""

    def __init__(self, system: core.PiecewiseSystem, window: Window, axes: Axes) -> None:
        self.system = system
        self.window = window
        self.axes = axes
        self.x, self.y = self._axes(GRID)
        self.shown = surfaces_shown(system, axes)
        self._psi: dict[int, Floats | None] = {}

    def psi(self, mode: int) -> Floats | None:
        """Return the first conserved quantity of a mode on the grid, or None."""
        if mode not in self._psi:
            self._psi[mode] = self._conserved(mode)
        return self._psi[mode]

    def _axes(self, count: int) -> tuple[Floats, Floats]:
        """Return grid lines in x and y: nearly square cells, `count` of them along the longer side."""
        w = self.window
        cell = max(w.width, w.height) / count
        nx, ny = max(2, round(w.width / cell)), max(2, round(w.height / cell))
        return np.linspace(w.x_low, w.x_high, nx + 1), np.linspace(w.y_low, w.y_high, ny + 1)

    def _states(self, x: Floats, y: Floats) -> Floats:
        """Return states over points of the plane; further variables are 0, as nothing drawn depends on them."""
        states = np.zeros((*x.shape, self.system.dimension))
        states[..., self.axes[0]], states[..., self.axes[1]] = x, y
        return states

    def _switching(self, k: int, x: Floats, y: Floats) -> Floats:
        """Return a switching function, by its number."""
        return np.asarray(self.system.laws.evaluate(("g", k), (self.system.laws.surfaces[k],), 0.0, self._states(x, y),
                                                    self.system.parameter_array))[..., 0]  # fmt: skip

    def _height(self, mode: int, x: Floats, y: Floats) -> Floats:
        """Return the least guard of a mode, which is positive inside it."""
        heights: Floats = self.system.heights(mode, 0.0, self._states(x, y)).min(axis=-1)
        return heights

    def _conserved(self, mode: int) -> Floats | None:
        """Return ψ on the grid; None if there is none, or its level sets cannot be drawn in the plane."""
        if not shows_levels(self.system):
            return None
        with np.errstate(all="ignore"):
            states = self._states(*np.meshgrid(self.x, self.y))
            psi = np.asarray(self.system.conserved(self.system.laws.name(mode), 0.0, states))
        return np.ma.masked_invalid(psi[..., 0]) if psi.shape[-1] else None

    def _contours(self, values: Floats) -> Any:
        return contour_generator(self.x, self.y, values, line_type=LineType.Separate)

    def _simplified(self, line: Floats) -> Floats:
        """Return a line without the vertices within 1/4000 of the longer side of what is left."""
        return line[simplify(line, max(self.window.width, self.window.height) / 4000)]

    def surface(self) -> list[Floats]:
        """Return the pieces of the curves g = 0; none of a surface that is no curve in the plane."""
        return [line for k in self.shown for line in self._surface(k)]

    def _surface(self, k: int) -> list[Floats]:
        lines = self._contours(self._switching(k, *np.meshgrid(self.x, self.y))).lines(0.0)
        return [self._simplified(line) for line in lines]

    def where_both_point(self, way: int) -> list[Floats]:
        """Return the pieces of the surfaces to which both fields point (way = 1), or from which both do (−1).

        None where this changes with time, or depends on variables that are not shown, or where the state jumps.
        """
        if not shows_sliding(self.system):
            return []
        pieces = []
        for mode, (_, _, k) in enumerate(self.system.laws.pairs, start=len(self.system.laws.regions)):
            for line in self._surface(k) if k in self.shown else []:
                fine = _resampled(line, max(self.window.width, self.window.height) / FINE)
                heights = np.asarray(self.system.heights(mode, 0.0, self._states(*fine.T)), dtype=float)
                heights[:, :2] *= way  # the rates; then the other surfaces between which the piece lies
                pieces += _cut(fine, heights.min(axis=1))
        return pieces

    def minus_rings(self) -> list[list[Floats]]:
        """Return the outlines of the regions of the first shade, where g < 0, each followed by those of its holes."""
        modes = regions_of(self.system, -1)
        if not modes or not shows_regions(self.system, self.axes):
            return []
        grid = np.meshgrid(self.x, self.y)
        g = -np.max([self._height(mode, *grid) for mode in modes], axis=0)
        inside = contour_generator(self.x, self.y, g, fill_type=FillType.OuterOffset)
        filled: Any = inside.filled(-np.inf, 0.0)
        pieces, offsets = filled
        return [np.split(points, offset[1:-1].astype(int)) for points, offset in zip(pieces, offsets, strict=True)]

    def usual_level_sets(self, mode: int) -> Floats:
        """Return the usual level sets of a region."""
        return self.level_sets(mode, self.usual_levels(mode))

    def usual_levels(self, mode: int) -> tuple[float, ...]:
        """Return quantiles of ψ, so that level sets divide the visible part of a region into strips of equal area."""
        psi = self.psi(mode)
        if psi is None:
            return ()
        there = np.ma.compressed(psi[self._height(mode, *np.meshgrid(self.x, self.y)) > 0])
        return tuple(np.quantile(there, (np.arange(LEVELS) + 0.5) / LEVELS)) if there.size else ()

    def level_sets(self, mode: int, levels: tuple[float, ...]) -> Floats:
        """Return level sets of ψ in one region, cut off at its surfaces."""
        lines = self._lines(mode, levels)
        if not lines:
            return _joined([], 3)
        g = self._height(mode, *np.concatenate([line for _, line in lines]).T)
        ends = np.cumsum([len(line) for _, line in lines])
        whole = zip(lines, np.split(g, ends[:-1]), strict=True)
        pieces = [(level, piece) for (level, line), there in whole for piece in _cut(line, there)]
        return _joined([_with_value(self._simplified(piece), level) for level, piece in pieces], 3)

    def _lines(self, mode: int, levels: tuple[float, ...]) -> list[tuple[float, Floats]]:
        """Return the pieces of level sets, beyond the surfaces, too, each with its value of ψ.

        They have a vertex wherever they leave a cell of the grid, so that a region between two ends is met.
        """
        psi = self.psi(mode)
        if psi is None or not levels:
            return []
        contours = self._contours(psi)
        return [(at, line) for at in levels for line in contours.lines(at)]

    def whole(self, mode: int, orbits: tuple[float, ...]) -> list[Columns]:
        """Return level sets, those of the orbits, and arrows, of which a moving surface hides the part beyond it."""
        fine = max(self.window.width, self.window.height) / FINE
        sets = [
            _joined([_with_value(_resampled(line, fine), level) for level, line in self._lines(mode, levels)], 3)
            for levels in (self.usual_levels(mode), orbits)
        ]
        arrows, centres = self._all_arrows(mode)
        parts = [(lines[:, :2], lines[:, :2], lines[:, 2]) for lines in sets]
        parts.append((arrows, np.repeat(centres, ROWS, axis=0), np.full(len(arrows), np.nan)))
        return [self._hidden(mode, *part) for part in parts]

    def _hidden(self, mode: int, lines: Floats, at: Floats, psi: Floats) -> Columns:
        """Return lines as columns; x is NaN where the point `at` lies on the other side at t = 0."""
        x = np.where(self._height(mode, at[:, 0], at[:, 1]) > 0, lines[:, 0], np.nan)
        return {"x": x, "y": lines[:, 1], "psi": psi, "whole": lines[:, 0], "at_x": at[:, 0], "at_y": at[:, 1]}

    def arrows(self, mode: int) -> Floats:
        """Return the directions of the field of one region, as open arrows of equal length."""
        lines, centres = self._all_arrows(mode)
        there = self._height(mode, centres[:, 0], centres[:, 1]) > 0
        return lines[np.repeat(there, ROWS)]

    def _all_arrows(self, mode: int) -> tuple[Floats, Floats]:
        """Return the arrows of a region's field in the whole window, and their middles."""
        if not shows_field(self.system):
            return np.empty((0, 2)), np.empty((0, 2))
        x, y = (values.ravel() for values in np.meshgrid(*self._axes(ARROWS)))
        with np.errstate(all="ignore"):
            field = np.asarray(self.system.field(self.system.laws.name(mode), 0.0, self._states(x, y)))
            u, v = (field[:, self.axes] / np.linalg.norm(field, axis=1, keepdims=True)).T
        flows = np.isfinite(u) & np.isfinite(v)
        lines = _arrow_lines(x[flows], y[flows], u[flows], v[flows], self._arrow_length())
        return lines, np.column_stack([x[flows], y[flows]])

    def _arrow_length(self) -> float:
        return 0.5 * max(self.window.width, self.window.height) / ARROWS


def _arrow_lines(x: Floats, y: Floats, u: Floats, v: Floats, length: float) -> Floats:
    """Return `ROWS` rows for each arrow: tail, tip, barb, tip, barb, and a gap."""
    forward = 0.5 * length * np.column_stack([u, v])
    sideways = 0.28 * np.column_stack([-forward[:, 1], forward[:, 0]])
    middle = np.column_stack([x, y])
    tip, neck = middle + forward, middle + 0.4 * forward
    gap = np.full_like(middle, np.nan)
    return np.stack([middle - forward, tip, neck + sideways, tip, neck - sideways, gap], axis=1).reshape(-1, 2)


def _cut(line: Floats, g: Floats) -> list[Floats]:
    """Return the pieces of a line where g > 0, cut where g, interpolated linearly, vanishes."""
    change = np.flatnonzero(g[:-1] * g[1:] < 0)
    share = g[change] / (g[change] - g[change + 1])
    ends = line[change] + share[:, None] * (line[change + 1] - line[change])
    line = np.insert(line, change + 1, ends, axis=0)
    g = np.insert(g, change + 1, 0.0)
    bounds = np.unique([0, *np.flatnonzero(g == 0.0), len(g) - 1]).tolist()
    return [line[a : b + 1] for a, b in pairwise(bounds) if g[a : b + 1].sum() > 0]


def _with_value(line: Floats, value: float) -> Floats:
    return np.column_stack([line, np.full(len(line), value)])


def _resampled(line: Floats, spacing: float) -> Floats:
    """Return a line with vertices at this spacing or less, and its ends."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    at = np.linspace(0.0, along[-1], 2 + int(along[-1] / spacing))
    return np.column_stack([np.interp(at, along, line[:, k]) for k in range(2)])


def _joined_sets(sets: Iterable[Floats]) -> Floats:
    """Return the level sets of several regions in one array."""
    return np.concatenate([*sets, _joined([], 3)])


def _joined(lines: list[Floats], width: int = 2) -> Floats:
    """Return one array of all lines, each followed by a gap."""
    gap = np.full((1, width), np.nan)
    return np.concatenate([part for line in lines for part in (line, gap)] or [gap])
