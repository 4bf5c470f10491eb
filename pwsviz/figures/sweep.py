"""The bifurcation diagram: points of a section over the values of a parameter."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from bokeh.core.properties import value
from bokeh.events import Event, PointEvent, Tap
from bokeh.models import ColumnDataSource, CrosshairTool, DataRange1d
from bokeh.models.glyphs import Scatter, VSpan, VStrip

from pwsviz.figures.colours import AMBER, CALM, GREY, RULE, VERMILION
from pwsviz.figures.legends import legend_below
from pwsviz.figures.point_cloud import PointCloud
from pwsviz.figures.style import WITH_TABLE, assign, plain_figure, tips
from pwsviz.figures.sweep_text import (
    SUMMARY,
    coordinate_name,
    ending,
    of_examined,
    parameter_name,
    stretches,
    stretches_of,
)
from pwsviz.figures.touch import attach_touch
from pwsviz.geometry.window import Window
from pwsviz.results.sweeps import Diagram
from pwsviz.text.numbers import printed

__all__ = ["SweepView"]

MARGIN = 0.02
"""Margin beside the range of the parameter, relative to it."""

CHOSEN = 4.5
"""Diameter in pixels of a point of the chosen value."""

NO_STRIP: dict[str, Any] = {"start": [np.nan], "end": [np.nan], "words": [""], "colour": [GREY], "values": [""]}
"""Columns of a strip without a place."""


class SweepView:
    """One fixed figure; `show` only changes its data.

    Parameters
    ----------
    on_choose : callable
        Called with the value of the parameter on which the user clicks.
    on_window : callable
        Called with the visible part of the plane, when the user has changed it.
    """

    def __init__(self, on_choose: Callable[[float], None], on_window: Callable[[Window], None]) -> None:
        self.figure = plain_figure(
            SUMMARY,
            x_axis_label="parameter",
            y_axis_label="coordinate",
            x_range=DataRange1d(),
            y_range=DataRange1d(),
            active_scroll="wheel_zoom",
            styles=WITH_TABLE,
        )
        plot = self.figure
        attach_touch(plot)
        self.early = ColumnDataSource(NO_STRIP)
        strips = plot.add_glyph(
            self.early, VStrip(x0="start", x1="end", fill_color="colour", fill_alpha=0.15, line_width=0)
        )
        self.ends = ColumnDataSource({"x": [0.0, 1.0], "y": [0.0, 0.0]})
        self.growing = ColumnDataSource({"start": [np.nan], "end": [np.nan]})
        calm = VStrip(x0="start", x1="end", fill_color=CALM, fill_alpha=0.4, line_width=0)
        growing = plot.add_glyph(self.growing, calm, level="underlay")
        self.cloud = PointCloud(plot, [GREY], on_window, self.ends)
        self.present = ColumnDataSource({"x": [0.0]})
        line = plot.add_glyph(self.present, VSpan(x="x", line_color=AMBER, line_width=1.5, line_dash=[6, 4]))
        self.chosen = ColumnDataSource({"x": [], "y": []})
        plot.add_glyph(self.chosen, Scatter(size=CHOSEN, fill_color=AMBER, line_color=None))
        plot.add_tools(
            tips([("", "@words"), ("", "@values")], renderers=[strips]),
            CrosshairTool(dimensions="height", line_color=RULE, line_alpha=1.0, visible=False),
        )
        self.warned = ColumnDataSource({"x": [np.nan]})
        self.doubtful = ColumnDataSource({"start": [np.nan], "end": [np.nan]})
        between = VStrip(x0="start", x1="end", fill_color=VERMILION, fill_alpha=0.1, line_width=0)
        shade = plot.add_glyph(self.doubtful, between, level="underlay")
        doubt = plot.add_glyph(self.warned, VSpan(x="x", line_color=VERMILION, line_width=1.5, line_dash=[2, 4]))
        self._in_doubt: list[Any] = [shade, doubt]
        entries = [
            ("chosen value", line),
            ({"field": "words"}, strips),
            ("in doubt", doubt),
            ("errors grow", growing),
        ]
        self._present, self._early, self._doubt, self._growth = legend_below(plot, entries)
        plot.on_event(Tap, lambda event: _choose(event, on_choose))

    def show(self, found: Diagram) -> None:
        """Draw a diagram, or what is computed of it."""
        inputs = found.inputs
        self.figure.xaxis[0].axis_label = parameter_name(inputs)
        self.figure.yaxis[0].axis_label = coordinate_name(inputs)
        margin = MARGIN * (inputs.high - inputs.low)
        assign(self.ends, x=[inputs.low - margin, inputs.high + margin], y=[0.0, 0.0])
        self.cloud.show(found.portions, found.round_off)
        assign(self.early, **_strips(found))
        self._early.visible = self.early.data["words"] != NO_STRIP["words"]
        assign(self.warned, x=found.warned if len(found.warned) else [np.nan])
        doubtful = [ends for ends in stretches_of(found, found.warned) if ends[0] < ends[1]]
        assign(self.doubtful, **_ends(doubtful))
        self._doubt.visible = bool(found.warnings)
        self._doubt.renderers = self._in_doubt[0 if doubtful else 1 :]
        self._doubt.label = value(f"in doubt: {of_examined(found, found.warned)}")
        half = found.spacing / 2
        growing = [(low - half, high + half) for low, high in stretches_of(found, found.sensitive)]
        assign(self.growing, **_ends(growing))
        self._growth.visible = bool(growing)
        self._growth.label = value(f"small errors grow: {of_examined(found, found.sensitive)}")

    def mark(self, present: float, name: str, chosen: Diagram | None = None) -> None:
        """Put the line at the chosen value of the parameter, with the points of this value alone, if they are known."""
        assign(self.present, x=[present])
        points = np.empty(0) if chosen is None else chosen.points_at(present)
        assign(self.chosen, x=np.full(len(points), present), y=points)
        low, high = self.ends.data["x"]
        self._present.visible = bool(low <= present <= high)
        self._present.label = value(printed(f"chosen value, {name} = {present:.6g}"))


def _ends(there: list[tuple[float, float]]) -> dict[str, list[float]]:
    """Return the columns of strips, one of them without a place if there are none."""
    there = there or [(np.nan, np.nan)]
    return {"start": [low for low, _ in there], "end": [high for _, high in there]}


def _strips(found: Diagram) -> dict[str, Any]:
    """Return the columns of the stretches of values whose runs end early, each as wide as its values.

    They are never empty: the browser cannot draw the entry of a legend of a glyph without marks.
    """
    half = found.spacing / 2
    there = list(stretches(found))
    if not there:
        return NO_STRIP
    looks = [ending(code) for code, _, _ in there]
    first, last = (np.array([found.values[one[k]] for one in there]) for k in (1, 2))
    return {
        "start": first - half,
        "end": last + half,
        "words": [look.words for look in looks],
        "colour": [look.colour for look in looks],
        "values": [printed(f"{a:.6g}" if a == b else f"{a:.6g} to {b:.6g}") for a, b in zip(first, last, strict=True)],
    }


def _choose(event: Event, on_choose: Callable[[float], None]) -> None:
    if isinstance(event, PointEvent) and event.x is not None:
        on_choose(float(event.x))
