"""The backdrop of a phase portrait: sides, surface, field and level sets, on a window of the plane."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeAlias

import numpy as np
from contourpy import FillType, LineType, contour_generator
from numpy.typing import NDArray

import core
from core.diagnostics import inhabited
from pwsviz.geometry.formulas import formulas
from pwsviz.geometry.line_pieces import area, cut, joined, pieces, resampled, with_value
from pwsviz.geometry.plane import XY, Plane
from pwsviz.geometry.polyline_reduction import Floats, simplify
from pwsviz.geometry.projection import (
    moves,
    shows_field,
    shows_levels,
    shows_regions,
    shows_sliding,
    surfaces_shown,
    time_shown,
)
from pwsviz.geometry.shades import regions_of
from pwsviz.geometry.walls import bare_name
from pwsviz.geometry.window import ARROWS, Window

GRID = 160
"""Cells along the shorter side of the grid on which surfaces and level sets are traced: 4 to 8 pixels each."""

SLENDER = 3.0
"""Ratio of the sides from which cells follow the longer side, lest they be too many."""

FINENESS = 10_000
"""Parts of the shorter side by which a line may be off its vertices: a tenth of a millimetre on a page, at most."""

FINEST = 16
"""Parts of a cell beyond which values are not defined: half a pixel each."""

ROWS = 6
"""Rows of an arrow."""

LEVELS = 7
"""Level sets drawn on each side, besides those through the orbits."""

LEAST_AREA = 1e-9
"""Area of a region, relative to the window, below which it is a line of the grid on which g = 0."""

SMOOTH = 0.8
"""Least mean cosine of the angle by which the gradient of ψ turns from one vertex of a level set to the next: 37°."""

BESIDE = 1e-3
"""Part of a cell over which differences of ψ give its gradient."""

FINE = 300
"""Vertices along the shorter side, at least, of a line of which a moving surface hides a part."""

Columns: TypeAlias = "dict[str, Floats]"


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
    bare_outer, bare_holes : list
        The same of where no state can be: no law is declared, or a wall is in the way.
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
    bare_outer: list[NDArray[np.float64]]
    bare_holes: list[list[NDArray[np.float64]]]
    arrows: dict[int, Floats]
    levels: dict[int, Floats]
    orbit_levels: dict[int, Floats]
    whole: dict[int, list[Columns]]
    formulas: dict[str, Any]


def backdrop(
    system: core.PiecewiseSystem, window: Window, orbits: dict[int, tuple[float, ...]], plane: Plane = XY
) -> Backdrop:
    """Trace what depends only on the system and the window, at t = 0.

    Parameters
    ----------
    system : core.PiecewiseSystem
        The system. What cannot be drawn in the plane (see `projection`) is left empty.
    window : Window
        The part of the plane to cover.
    orbits : dict
        Values of ψ of the visible orbits in each region where these are, by its number.
    plane : Plane
        The two variables that span it, and their units.
    """
    grid, there = _Grid(system, window, plane), inhabited(system, orbits)
    shades = {shade: [mode for mode in regions_of(system, shade) if mode in there] for shade in (-1, 1)}
    rings = grid.rings(shades[-1])
    bare = grid.rings(sorted(there), outside=True) if bare_name(system, there) else []
    return Backdrop(
        window=window,
        surface=grid.surface(),
        attracting=grid.where_both_point(1),
        repelling=grid.where_both_point(-1),
        minus_outer=[ring[0] for ring in rings],
        minus_holes=[ring[1:] for ring in rings],
        bare_outer=[ring[0] for ring in bare],
        bare_holes=[ring[1:] for ring in bare],
        arrows={side: np.concatenate([*map(grid.arrows, modes), joined([])]) for side, modes in shades.items()},
        levels={side: joined(map(grid.usual_level_sets, modes), 3) for side, modes in shades.items()},
        orbit_levels={
            side: joined((grid.level_sets(mode, orbits.get(mode, ())) for mode in modes), 3)
            for side, modes in shades.items()
        },
        whole={
            side: grid.whole(modes[0], orbits.get(modes[0], ()))
            for side, modes in shades.items()
            if moves(system) and system.two_sided and modes
        },
        formulas=formulas(system, plane, there),
    )


def closed_surface(system: core.PiecewiseSystem, window: Window, plane: Plane = XY) -> Floats:
    """Return the points (k, 2) of the pieces of the surface that are closed curves within a window."""
    lines = pieces(_Grid(system, window, plane).surface())
    loops = [line for line in lines if len(line) > 3 and np.array_equal(line[0], line[-1])]
    return np.concatenate([*loops, np.empty((0, 2))])


class _Grid:
    """The functions of the system on a grid over the window."""

    def __init__(self, system: core.PiecewiseSystem, window: Window, plane: Plane) -> None:
        self.system = system
        self.window = window
        self.plane = plane
        self.time = time_shown(system)
        self.side = max(min(window.width, window.height), window.longest / SLENDER)  # to which lines are fine
        self.x, self.y = self._axes(self.side / GRID)
        self.grid = self._states(*np.meshgrid(self.x, self.y))
        self.shown = surfaces_shown(system, plane.axes)
        # What several parts of the picture need, computed once:
        self._psi, self._levels = cache(self._conserved), cache(self._level_contours)
        self._inside, self._surface = cache(self._heights), cache(self._traced_surface)

    def _axes(self, cell: float) -> tuple[Floats, Floats]:
        """Return grid lines in x and y: nearly square cells of about this size."""
        w = self.window
        nx, ny = max(2, round(w.width / cell)), max(2, round(w.height / cell))
        return np.linspace(w.x_low, w.x_high, nx + 1), np.linspace(w.y_low, w.y_high, ny + 1)

    def _states(self, x: Floats, y: Floats) -> Floats:
        """Return states over points of the plane; further variables are 0, as nothing drawn depends on them."""
        states = np.zeros((*x.shape, self.system.dimension))
        (a, b), (across, up) = self.plane
        states[..., a], states[..., b] = x * across, y * up
        return states

    def _switching(self, k: int) -> Floats:
        """Return a switching function on the grid, by its number."""
        laws = self.system.laws
        values = laws.evaluate(("g", k), (laws.surfaces[k],), self.time, self.grid, self.system.parameter_array)
        return np.asarray(values)[..., 0]

    def _height(self, mode: int, states: Floats) -> Floats:
        """Return the least guard of a mode, which is positive inside it."""
        heights: Floats = self.system.heights(mode, self.time, states).min(axis=-1)
        return heights

    def _heights(self, mode: int) -> Floats:
        """Return the least guard of a mode on the grid."""
        return self._height(mode, self.grid)

    def _conserved(self, mode: int) -> Floats | None:
        """Return the first ψ of a mode on the grid; None if it has none whose level sets can be drawn in the plane."""
        if not shows_levels(self.system):
            return None
        return self._first_psi(mode, self.grid)

    def _first_psi(self, mode: int, states: Floats) -> Floats | None:
        with np.errstate(all="ignore"):
            psi = np.asarray(self.system.conserved(self.system.laws.name(mode), 0.0, states))
        return psi[..., 0] if psi.shape[-1] else None

    @staticmethod
    def _contours(x: Floats, y: Floats, values: Floats) -> Callable[[float], Floats]:
        """Return a function that traces a level set of values on a grid."""
        contours = contour_generator(x, y, values, line_type=LineType.ChunkCombinedNan)

        def at(level: float) -> Floats:
            (line,) = contours.lines(level)[0]
            return np.empty((0, 2)) if line is None else np.asarray(line)

        return at

    def _level_contours(self, mode: int) -> Callable[[float], Floats] | None:
        """Return a function that traces a level set of the first ψ of a mode; None if there is none to draw."""
        psi = self._psi(mode)
        if psi is None:
            return None
        known = np.isfinite(psi)
        x = _finer(self.x, (known[:, 1:] != known[:, :-1]).any(axis=0))
        y = _finer(self.y, (known[1:] != known[:-1]).any(axis=1))
        finer = len(x) > len(self.x) or len(y) > len(self.y)
        values = self._first_psi(mode, self._states(*np.meshgrid(x, y))) if finer else psi
        return None if values is None else self._contours(x, y, values)

    def _simplified(self, lines: Floats) -> Floats:
        """Return lines without the vertices that are close to what is left (`FINENESS`)."""
        gaps = np.isnan(lines[:, 0])
        kept = gaps.copy()
        kept[1:] |= gaps[:-1]
        kept[:-1] |= gaps[1:]
        return lines[simplify(lines, self.side / FINENESS, kept)]

    def surface(self) -> Floats:
        """Return the curves g = 0; none of a surface that is no curve in the plane."""
        return joined(map(self._surface, self.shown))

    def _traced_surface(self, k: int) -> Floats:
        return self._simplified(self._contours(self.x, self.y, self._switching(k))(0.0))

    def where_both_point(self, way: int) -> Floats:
        """Return the parts of the surfaces to which both fields point (way = 1), or from which both do (−1).

        None where this changes with time, or depends on variables that are not shown, or where the state jumps.
        """
        if not shows_sliding(self.system):
            return joined([])
        parts = []
        for mode, (_, _, k) in enumerate(self.system.laws.pairs, start=len(self.system.laws.regions)):
            if k in self.shown:
                fine = self._finely(self._surface(k))
                heights = np.asarray(self.system.heights(mode, 0.0, self._states(*fine.T)), dtype=float)
                heights[:, :2] *= way  # the rates; then the other surfaces between which the part lies
                parts.append(cut(fine, heights.min(axis=1)))
        return joined(parts)

    def _finely(self, lines: Floats) -> Floats:
        """Return lines with vertices as close as those of a line that a moving surface hides in part."""
        return joined((resampled(line, self.side / FINE) for line in pieces(lines)), lines.shape[1])

    def rings(self, modes: list[int], outside: bool = False) -> list[list[Floats]]:
        """Return the outlines of regions, or of the plane outside them, each followed by those of its holes."""
        if not modes or not shows_regions(self.system, self.plane.axes):
            return []
        height = np.max([self._inside(mode) for mode in modes], axis=0)
        values = height if outside else -height
        inside = contour_generator(self.x, self.y, values, fill_type=FillType.OuterOffset)
        filled: Any = inside.filled(-np.inf, 0.0)
        outlines, offsets = filled
        found = (np.split(points, offset[1:-1].astype(int)) for points, offset in zip(outlines, offsets, strict=True))
        return [rings for rings in found if area(rings[0]) > LEAST_AREA * self.window.width * self.window.height]

    def usual_level_sets(self, mode: int) -> Floats:
        """Return the usual level sets of a region."""
        return self.level_sets(mode, self.usual_levels(mode))

    def usual_levels(self, mode: int) -> tuple[float, ...]:
        """Return quantiles of ψ, so that level sets divide the visible part of a region into strips of equal area."""
        psi = self._psi(mode)
        if psi is None:
            return ()
        there = psi[(self._inside(mode) > 0) & np.isfinite(psi)]
        return tuple(np.quantile(there, (np.arange(LEVELS) + 0.5) / LEVELS)) if there.size else ()

    def level_sets(self, mode: int, levels: tuple[float, ...]) -> Floats:
        """Return level sets of ψ in one region, cut off at its surfaces."""
        lines = self._lines(mode, levels)
        return self._simplified(cut(lines, self._height(mode, self._states(*lines[:, :2].T))))

    def _lines(self, mode: int, levels: tuple[float, ...]) -> Floats:
        """Return level sets, beyond the surfaces, too, with the value of ψ in a third column.

        They have a vertex wherever they leave a cell of the grid, so that a region between two ends is met.
        """
        trace = self._levels(mode)
        lines = ((level, trace(level)) for level in levels if trace is not None)
        return joined((with_value(line, level) for level, line in lines if self._is_smooth(mode, line)), 3)

    def _is_smooth(self, mode: int, line: Floats) -> bool:
        """Whether the grid resolves a level set; one along a field with too many periods in the window is a thicket."""
        turning = self._turning(mode, line)
        known = turning[np.isfinite(turning)]
        return not known.size or float(known.mean()) > SMOOTH

    def _turning(self, mode: int, line: Floats) -> Floats:
        """Return the cosine of the angle by which the gradient of ψ turns from each vertex to the next."""
        (x, y), step = line.T, BESIDE * self.side / GRID

        def psi(dx: float, dy: float) -> Floats:
            values = self._first_psi(mode, self._states(x + dx, y + dy))
            return np.zeros_like(x) if values is None else values

        slopes = np.column_stack([psi(step, 0.0) - psi(-step, 0.0), psi(0.0, step) - psi(0.0, -step)])
        with np.errstate(all="ignore"):
            directions = slopes / np.linalg.norm(slopes, axis=1, keepdims=True)
            return np.asarray((directions[1:] * directions[:-1]).sum(axis=1))

    def whole(self, mode: int, orbits: tuple[float, ...]) -> list[Columns]:
        """Return level sets, those of the orbits, and arrows, of which a moving surface hides the part beyond it."""
        sets = [self._finely(self._lines(mode, levels)) for levels in (self.usual_levels(mode), orbits)]
        arrows, centres = self._all_arrows(mode)
        parts = [(lines[:, :2], lines[:, :2], lines[:, 2]) for lines in sets]
        parts.append((arrows, np.repeat(centres, ROWS, axis=0), np.full(len(arrows), np.nan)))
        return [self._hidden(mode, *part) for part in parts]

    def _hidden(self, mode: int, lines: Floats, at: Floats, psi: Floats) -> Columns:
        """Return lines as columns; x is NaN where the point `at` lies on the other side at t = 0."""
        x = np.where(self._height(mode, self._states(*at.T)) > 0, lines[:, 0], np.nan)
        return {"x": x, "y": lines[:, 1], "psi": psi, "whole": lines[:, 0], "at_x": at[:, 0], "at_y": at[:, 1]}

    def arrows(self, mode: int) -> Floats:
        """Return the directions of the field of one region, as open arrows of equal length."""
        lines, centres = self._all_arrows(mode)
        there = self._height(mode, self._states(*centres.T)) > 0
        return lines[np.repeat(there, ROWS)]

    def _all_arrows(self, mode: int) -> tuple[Floats, Floats]:
        """Return the arrows of a region's field in the whole window, and their middles."""
        if not shows_field(self.system):
            return np.empty((0, 2)), np.empty((0, 2))
        x, y = (values.ravel() for values in np.meshgrid(*self._axes(self.window.longest / ARROWS)))
        with np.errstate(all="ignore"):
            field = np.asarray(self.system.field(self.system.laws.name(mode), 0.0, self._states(x, y)))
            drawn = self.plane.points(field)
            u, v = (drawn / np.linalg.norm(drawn, axis=1, keepdims=True)).T
        flows = np.isfinite(u) & np.isfinite(v)
        lines = _arrow_lines(x[flows], y[flows], u[flows], v[flows], self._arrow_length())
        return lines, np.column_stack([x[flows], y[flows]])

    def _arrow_length(self) -> float:
        return 0.5 * self.window.longest / ARROWS


def _finer(lines: Floats, ends: NDArray[np.bool_]) -> Floats:
    """Return grid lines (n,), with more of them in and beside intervals (n − 1,) in which values cease to be defined.

    A level set is traced linearly through the cells whose corners all have a value. Where ψ has a logarithm of x, it
    would end a cell before x = 0 and be far off in the cell before that one. Where too many intervals would have to be
    divided, as along an oblique border, none is.
    """
    ends = np.convolve(ends, np.ones(3), mode="same") > 0
    count = int(ends.sum())
    parts = min(FINEST, GRID // count) if count else 1
    if parts < 2:
        return lines
    k = np.flatnonzero(ends)
    between = lines[k, None] + np.diff(lines)[k, None] * np.arange(1, parts) / parts
    return np.sort(np.concatenate([lines, between.ravel()]))


def _arrow_lines(x: Floats, y: Floats, u: Floats, v: Floats, length: float) -> Floats:
    """Return `ROWS` rows for each arrow: tail, tip, barb, tip, barb, and a gap."""
    forward = 0.5 * length * np.column_stack([u, v])
    sideways = 0.28 * np.column_stack([-forward[:, 1], forward[:, 0]])
    middle = np.column_stack([x, y])
    tip, neck = middle + forward, middle + 0.4 * forward
    gap = np.full_like(middle, np.nan)
    return np.stack([middle - forward, tip, neck + sideways, tip, neck - sideways, gap], axis=1).reshape(-1, 2)
