"""The figure of a Poincaré section, or of its return map: points coloured by start."""

from __future__ import annotations

import math
from collections.abc import Callable
from time import monotonic
from typing import Any

import numpy as np
from bokeh.events import DoubleTap, Event, PointEvent, Tap
from bokeh.models import ColumnDataSource, DataRange1d
from bokeh.models.annotations import Slope
from bokeh.models.glyphs import Scatter, Text

import core
from pwsviz.figures.point_cloud import PointCloud, Portion
from pwsviz.figures.style import (
    BERRY,
    BLUE,
    BROWN,
    GREEN,
    GREY,
    LEVEL,
    OCHRE,
    ORANGE,
    PURPLE,
    SAND,
    SKY,
    VERMILION,
    VIOLET,
    assign,
    legend_below,
    plain_figure,
    tips,
)
from pwsviz.figures.touch import attach_touch
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.geometry.section_plane import coordinate_label, in_first_turn
from pwsviz.results.resting import ROUND_OFF
from pwsviz.results.sections import SectionPoints, SectionPortion

__all__ = ["START_COLOURS", "SectionView"]

START_COLOURS = (
    BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, VIOLET, OCHRE, BROWN, BERRY, GREY, SAND,
)  # fmt: skip
"""Colour of each start."""

DOUBLE = 0.5
"""Seconds between two clicks that are one double click."""

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
        self.cloud = PointCloud(self.figure, START_COLOURS)
        self._key: Any = None
        self._made: list[tuple[SectionPortion, Portion]] = []
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
        self.keys = ColumnDataSource({**place, "label": _labels(1)})
        key = plot.add_glyph(self.keys, Scatter(size=9, fill_color="colour", line_color=None))
        legend_below(plot, 6, [({"field": "label"}, key)], usual=6)

    def _tell_points(self) -> None:
        rows = [("start", "@kind"), ("across", "@x{7}"), ("up", "@y{7}")]
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

    def show(self, outcome: SectionPoints, axes: tuple[int, int], return_map: bool) -> None:
        """Draw the points there are.

        Parameters
        ----------
        outcome
            The points; further ones of the same section may follow.
        axes
            Numbers of the coordinates, that of time being the dimension.
        return_map
            Whether to draw the first of them at a point against that at the next one of the same start.
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
        self.cloud.show([made for _, made in self._made], ROUND_OFF * _size(outcome))
        self._number(outcome, return_map)

    def _name(self, system: core.PiecewiseSystem, axes: tuple[int, int], return_map: bool) -> None:
        across, up = (coordinate_label(system, k) for k in axes)
        self.diagonal.visible = return_map
        self.figure.xaxis.axis_label = f"{across} at a point" if return_map else across
        self.figure.yaxis.axis_label = f"{across} at the next point" if return_map else up

    def _make(self, outcome: SectionPoints, axes: tuple[int, int], return_map: bool) -> None:
        """Bring the portions of the cloud up to date; those that are there stay the same objects."""
        kept = self._made if _begins(outcome.portions, [source for source, _ in self._made]) else []
        system, last = outcome.inputs.problem.declaration, {source.start: source for source, _ in kept}
        made = list(kept)
        for source in outcome.portions[len(kept) :]:
            across = _coordinate(system, source, axes[0])
            if return_map:
                earlier = _coordinate(system, last[source.start], axes[0])[-1:] if source.start in last else across[:0]
                values = np.concatenate([earlier, across])
                made.append((source, Portion(values[:-1], values[1:], source.start)))
            else:
                made.append((source, Portion(across, _coordinate(system, source, axes[1]), source.start)))
            last[source.start] = source
        self._made = made

    def _number(self, outcome: SectionPoints, return_map: bool) -> None:
        """Name the starts: in the legend, and of a section at their first points."""
        assign(self.keys, **{**self.keys.data, "label": _labels(len(outcome.inputs.starts))})
        x, y = ([math.nan] * len(START_COLOURS) for _ in range(2))
        for source, portion in reversed([] if return_map else self._made):
            x[source.start], y[source.start] = float(portion.x[0]), float(portion.y[0])
        assign(self.firsts, **{**self.firsts.data, "x": x, "y": y})


def _size(outcome: SectionPoints) -> float:
    """Return the largest |number| of the starts and the points, by which round-off is told."""
    parts = (np.array(outcome.inputs.starts), *(portion.x for portion in outcome.portions))
    return max(float(np.abs(part).max(initial=0.0)) for part in parts)


def _labels(count: int) -> list[str]:
    """Return the label of each start there may be; of those there are not, that of the first."""
    return [f"start {k + 1 if k < count else 1}" for k in range(len(START_COLOURS))]


def _coordinate(system: core.PiecewiseSystem, portion: SectionPortion, k: int) -> Floats:
    """Return (n,) values of a coordinate as they are shown."""
    return in_first_turn(system, k, portion.t if k == system.dimension else portion.x[:, k])


def _begins(portions: tuple[SectionPortion, ...], before: list[SectionPortion]) -> bool:
    """Whether portions begin with those before, the same objects."""
    return len(before) <= len(portions) and all(a is b for a, b in zip(portions, before, strict=False))
