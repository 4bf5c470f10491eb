"""The figure of a Poincaré section, or of its return map: points coloured by start."""

from __future__ import annotations

import math
from collections.abc import Callable
from time import monotonic
from typing import Any

import numpy as np
from bokeh.core.properties import value
from bokeh.events import DoubleTap, Event, PointEvent, Tap
from bokeh.models import ColumnDataSource, DataRange1d
from bokeh.models.annotations import Slope
from bokeh.models.glyphs import Line, Scatter, Text
from numpy.typing import NDArray

import core
from pwsviz.figures.colours import (
    BERRY,
    BLUE,
    BROWN,
    GREEN,
    GREY,
    OCHRE,
    ORANGE,
    PURPLE,
    SAND,
    SKY,
    SURFACE,
    VERMILION,
    VIOLET,
)
from pwsviz.figures.labels import surface_labels
from pwsviz.figures.legends import legend_below
from pwsviz.figures.point_cloud import PointCloud, Portion
from pwsviz.figures.style import LEVEL, assign, plain_figure, tips
from pwsviz.figures.touch import attach_touch
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.geometry.section_plane import coordinate_label, in_first_turn, surface_curves
from pwsviz.geometry.window import Window
from pwsviz.results.sections import SectionPoints, SectionPortion

__all__ = ["START_COLOURS", "SectionView"]

START_COLOURS = (
    BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, VIOLET, OCHRE, BROWN, BERRY, GREY, SAND,
)  # fmt: skip
"""Colour of each start; where there are several surfaces, of the points of each start on each surface."""

SURFACE_MARKERS = ("circle", "square", "triangle", "diamond", "inverted_triangle", "hex")
"""Marker of the points on each surface."""

DOUBLE = 0.5
"""Seconds between two clicks that are one double click."""

CLOSED = 4.0
"""Size of the window within which a surface is looked for that is to be seen whole, relative to that of the points."""

STRIP = 5.0
"""Ratio of the extents of two coordinates above which equal scales would make a strip of the section."""

BEYOND = 2.0
"""Size of the window in which the surface is drawn, relative to what is seen: a pan shows it at once."""

NUMBER_SIZE = 15
"""Diameter in pixels of the disc with the number of a start."""


class SectionView:
    """One fixed figure; `show` only changes its data.

    Parameters
    ----------
    on_place : callable
        Called with the place of a click on a section.
    on_double_click : callable
        Called after a double click, of which the first click has called `on_place`.
    """

    def __init__(self, on_place: Callable[[float, float], None], on_double_click: Callable[[], None]) -> None:
        self.figure = plain_figure(
            "Poincaré section",
            x_range=DataRange1d(range_padding=0.0),
            y_range=DataRange1d(range_padding=0.0),
            active_drag="pan",
            active_scroll="wheel_zoom",
        )
        self.surface = ColumnDataSource({"x": [], "y": []})
        self._surface_line = self.figure.add_glyph(self.surface, Line(line_width=1.5, **SURFACE))
        self.cloud = PointCloud(self.figure, START_COLOURS, lambda _window: self._trace_surface())
        self._key: Any = None
        self._made: list[tuple[SectionPortion, tuple[Portion, ...]]] = []
        self.diagonal = Slope(gradient=1.0, y_intercept=0.0, visible=False, **LEVEL)
        self.figure.add_layout(self.diagonal)
        self._number_glyphs()
        self._tell_points()
        self._listen(on_place, on_double_click)
        attach_touch(self.figure)

    def _number_glyphs(self) -> None:
        """Make the discs that name the starts at their first points, and the legend."""
        plot = self.figure
        # The columns always have a row for each start there may be: see `PointCloud` on columns that become longer.
        nowhere = [math.nan] * len(START_COLOURS)
        numbers = [str(k + 1) for k in range(len(START_COLOURS))]
        place = {"x": nowhere, "y": nowhere, "colour": list(START_COLOURS)}
        self.firsts = ColumnDataSource({**place, "number": numbers})
        look: dict[str, Any] = {"size": NUMBER_SIZE, "fill_color": "white", "line_color": "colour", "line_width": 2.5}
        self.discs = plot.add_glyph(self.firsts, Scatter(**look))
        letters: dict[str, Any] = {"text_color": "black", "text_font_size": "10px", "text_font_style": "bold"}
        centred: dict[str, Any] = {"text_align": "center", "text_baseline": "middle"}
        plot.add_glyph(self.firsts, Text(text="number", **letters, **centred))
        self.keys = ColumnDataSource(
            {**place, "label": ["start 1"] * len(numbers), "marker": ["circle"] * len(numbers)}
        )
        key = plot.add_glyph(self.keys, Scatter(size=9, marker="marker", fill_color="colour", line_color=None))
        entries = [({"field": "label"}, key), ("S: g = 0", self._surface_line)]
        self._surface_entry = legend_below(plot, entries)[1]
        self._surface_entry.visible = False

    def _tell_points(self) -> None:
        rows = [("of", "$name"), ("across", "@x{7}"), ("up", "@y{7}")]
        self.figure.add_tools(tips(rows, renderers=self.cloud.marks, visible=False, limit=2))

    def _listen(self, on_place: Callable[[float, float], None], on_double_click: Callable[[], None]) -> None:
        last = -DOUBLE

        def place(event: Event) -> None:
            nonlocal last
            since, last = monotonic() - last, monotonic()
            if not isinstance(event, PointEvent) or event.x is None or event.y is None or since <= DOUBLE:
                return
            x, y, window = float(event.x), float(event.y), self.cloud.window
            if window is None or window.holds(np.array([[x, y]])).all():  # else the click was on an axis
                on_place(x, y)

        self.figure.on_event(Tap, place)
        self.figure.on_event(DoubleTap, lambda _event: on_double_click())

    def show(self, outcome: SectionPoints, axes: tuple[int, int], return_map: bool, alike: bool = False) -> None:
        """Draw the points there are.

        Parameters
        ----------
        outcome
            The points; further ones of the same section may follow.
        axes
            Numbers of the coordinates, that of time being the dimension.
        return_map
            Whether to draw the first of them at a point against that at the next one of the same start.
        alike
            Whether the coordinates are drawn at equal scales, unless that would make a strip of the section.
        """
        inputs = outcome.inputs
        system = inputs.problem.declaration
        key = (inputs.problem.declaration, inputs.of, axes, return_map)
        if key != self._key:
            self._made = []
            self.cloud.fit()
            self._name(system, axes, return_map)
        self._key = key
        self._make(outcome, axes, return_map)
        points = [one for _, made in self._made for one in made]
        self.cloud.show(points, outcome.noise, self._closed_surface)
        self._set_scales(alike)
        self._number(outcome, axes, return_map)
        self._trace_surface()

    def _set_scales(self, alike: bool) -> None:
        """Draw both coordinates at equal scales, or each at its own."""
        (left, right), (bottom, top) = (self.cloud.corners.data[name] for name in "xy")
        equal = alike and 1 / STRIP <= (right - left) / (top - bottom) <= STRIP
        if equal != self.figure.match_aspect:
            self.figure.match_aspect = equal
            self.cloud.fit()

    def _trace_surface(self) -> None:
        """Draw the surface where it is a curve in the plane shown."""
        if self._key is None:
            return
        system, of, axes, return_map = self._key
        x, y = self.cloud.corners.data["x"], self.cloud.corners.data["y"]
        window = (self.cloud.window or Window(*x, *y)).scaled(BEYOND)
        lines = surface_curves(system, of, axes, window) if not return_map else np.empty((0, 2))
        assign(self.surface, x=lines[:, 0], y=lines[:, 1])
        self._surface_entry.label = value("h = 0" if of else "S: g = 0")
        self._surface_entry.visible = bool(np.isfinite(lines).any())

    def _closed_surface(self, window: Window) -> Window | None:
        """Return what holds the surface, if it is drawn as closed curves that reach little beyond a window."""
        if self._key is None or self._key[-1]:
            return None
        system, of, axes, _ = self._key
        wide = window.scaled(CLOSED)
        lines = surface_curves(system, of, axes, wide)
        lines = lines[np.isfinite(lines).all(axis=1)]
        if not len(lines):
            return None
        (x_low, y_low), (x_high, y_high) = lines.min(axis=0).tolist(), lines.max(axis=0).tolist()
        held = Window(x_low, x_high, y_low, y_high)
        return held if wide.scaled(0.99).covers(held) else None

    def _name(self, system: core.PiecewiseSystem, axes: tuple[int, int], return_map: bool) -> None:
        across, up = (coordinate_label(system, k) for k in axes)
        self.diagonal.visible = return_map
        self.figure.xaxis.axis_label = f"{across} at a point" if return_map else across
        self.figure.yaxis.axis_label = f"{across} at the next point" if return_map else up

    def _make(self, outcome: SectionPoints, axes: tuple[int, int], return_map: bool) -> None:
        """Bring the portions of the cloud up to date; those that are there stay the same objects."""
        kept = self._made if _begins(outcome.portions, [source for source, _ in self._made]) else []
        system, last = outcome.inputs.problem.declaration, {source.start: source for source, _ in kept}
        made, count = list(kept), len(_surfaces(outcome))
        for source in outcome.portions[len(kept) :]:
            across, kinds = _coordinate(system, source, axes[0]), _kinds(source, count)
            up = _coordinate(system, source, axes[1])
            if return_map:
                if before := last.get(source.start):
                    across = np.concatenate([_coordinate(system, before, axes[0])[-1:], across])
                    kinds = np.concatenate([_kinds(before, count)[-1:], kinds])
                across, up, kinds = across[:-1], across[1:], kinds[:-1]
            parts = ((kind, kinds == kind) for kind in np.unique(kinds).tolist())
            made.append((source, tuple(Portion(across[there], up[there], kind) for kind, there in parts)))
            last[source.start] = source
        self._made = made

    def _number(self, outcome: SectionPoints, axes: tuple[int, int], return_map: bool) -> None:
        """Name starts and surfaces in the legend, and the starts of a section at their first points."""
        system, surfaces, places = outcome.inputs.problem.declaration, _surfaces(outcome), range(len(START_COLOURS))
        labels = _labels(len(outcome.inputs.starts), surfaces)
        markers = [SURFACE_MARKERS[k % len(surfaces)] for k in places]
        assign(self.keys, **{**self.keys.data, "label": labels, "marker": markers})
        for mark, label, marker in zip(self.cloud.marks, labels, markers, strict=True):
            mark.name, mark.glyph.marker = label, marker
        x, y, colours = [math.nan] * len(places), [math.nan] * len(places), list(START_COLOURS)
        for source, _ in reversed([] if return_map else self._made):
            x[source.start], y[source.start] = (float(_coordinate(system, source, k)[0]) for k in axes)
            colours[source.start] = START_COLOURS[int(_kinds(source, len(surfaces))[0])]
        assign(self.firsts, **{**self.firsts.data, "x": x, "y": y, "colour": colours})


def _surfaces(outcome: SectionPoints) -> list[str]:
    """Return the names of the surfaces that are told apart; one without a name where there are too few colours."""
    inputs = outcome.inputs
    names = [] if inputs.of else surface_labels(inputs.problem.declaration)
    return names if 0 < len(names) * len(inputs.starts) <= len(START_COLOURS) else [""]


def _kinds(portion: SectionPortion, surfaces: int) -> NDArray[np.int64]:
    """Return (n,) the number of the colour of each point."""
    return portion.start * surfaces + (portion.surface if surfaces > 1 else 0 * portion.mode).astype(np.int64)


def _labels(starts: int, surfaces: list[str]) -> list[str]:
    """Return the label of each colour; of those that are not used, that of the first."""
    several = starts > 1 or len(surfaces) == 1
    pairs = [(f"start {k + 1}" * several, name) for k in range(starts) for name in surfaces]
    labels = [": ".join(filter(None, pair)) for pair in pairs]
    return labels + labels[:1] * (len(START_COLOURS) - len(labels))


def _coordinate(system: core.PiecewiseSystem, portion: SectionPortion, k: int) -> Floats:
    """Return (n,) values of a coordinate as they are shown."""
    return in_first_turn(system, k, portion.t if k == system.dimension else portion.x[:, k])


def _begins(portions: tuple[SectionPortion, ...], before: list[SectionPortion]) -> bool:
    """Whether portions begin with those before, the same objects."""
    return len(before) <= len(portions) and all(a is b for a, b in zip(portions, before, strict=False))
