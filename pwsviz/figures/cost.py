"""The work-precision diagram: an error against its cost, with one curve for each integrator."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from bokeh.core.properties import value
from bokeh.models import ColumnDataSource, DataRange1d
from numpy.typing import ArrayLike

import core
from core.studies import CostCurve
from pwsviz.figures.colours import GREY, PALE_GREY
from pwsviz.figures.conserved import NOWHERE
from pwsviz.figures.cost_text import (
    ACROSS,
    MEANING,
    UP,
    Across,
    Up,
    bottom_of,
    compared_with,
    cost_details,
    cost_numbers,
    cost_of,
    cost_text,
    cost_words,
    error_of,
    setting_text,
    timed_how,
)
from pwsviz.figures.legends import MARK_COLUMNS, legend_below, legend_marks, mark_columns
from pwsviz.figures.lines import Line, line_of, together
from pwsviz.figures.style import (
    BELOW_RANGE,
    WITH_TABLE,
    assign,
    fit_to_corners,
    lowest,
    mark_levels,
    plain_figure,
    tips,
)
from pwsviz.geometry.numbers import MACHINE_EPSILON
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.scene.names import as_met
from pwsviz.text.numbers import printed

__all__ = [
    "MEANING",
    "CostView",
    "compared_with",
    "cost_details",
    "cost_numbers",
    "cost_rows",
    "cost_text",
    "timed_how",
]

EXTERNAL_LINES = {
    "scipy": Line(GREY, (6, 3, 1, 3), "x", 1.6),
    "heyoka": Line(PALE_GREY, (20, 6), "triangle_pin", 1.6),
}
"""Looks of external solvers: grey, with dashes and markers that none of our methods has."""

WRONG = "incorrect sequence of crossings"
"""Legend of runs that have not the crossings of the solution; they are drawn hollow."""


class CostView:
    """One fixed figure; `show` only changes its data and the names of its axes."""

    def __init__(self) -> None:
        self.figure = plain_figure(
            "error against run time or number of evaluations, both on logarithmic axes, one curve for each integrator",
            x_axis_type="log",
            y_axis_type="log",
            x_axis_label=ACROSS["seconds"],
            y_axis_label=UP["state"],
            styles=WITH_TABLE,
            x_range=DataRange1d(range_padding=0.06),
            y_range=DataRange1d(range_padding=0.06),
        )
        plot = self.figure
        self._across, self._up = plot.xaxis[0], plot.yaxis[0]
        self.levels = mark_levels(plot, {1e-15: "round-off", NOWHERE: BELOW_RANGE})
        self.curves = ColumnDataSource(
            {name: [] for name in ("xs", "ys", "colour", "dash", "width", "label", *MARK_COLUMNS)}
        )
        lines = plot.multi_line("xs", "ys", source=self.curves, color="colour", line_dash="dash", line_width="width")
        names = ("x", "y", "colour", "marker", "label", "setting", "cost", "error", "status")
        self.points = ColumnDataSource({name: [] for name in names})
        look: dict[str, Any] = {"color": "colour", "size": 8, "line_width": 1.6}
        points = plot.scatter("x", "y", source=self.points, marker="marker", **look)
        self.wrong = ColumnDataSource({name: [] for name in names})
        hollow = plot.scatter("x", "y", source=self.wrong, marker="marker", **look, fill_alpha=0.0)
        self.below = ColumnDataSource({name: [] for name in names})
        down = plot.scatter("x", "y", source=self.below, marker="inverted_triangle", **look)
        self.corners = fit_to_corners(plot, [1e-4, 1e-1], [1e-15, 1.0])
        rows = [("", "@label"), ("", "@setting"), ("", "@cost"), ("error", "@error"), ("", "@status")]
        plot.add_tools(tips(rows, renderers=[points, hollow, down]))
        keys = legend_marks(plot, self.curves, size=look["size"])
        _, self._hollow = legend_below(plot, [({"field": "label"}, [lines, keys]), (WRONG, hollow)])

    def show(self, study: core.WorkPrecision, across: Across, up: Up, met: str = "crossings") -> None:
        """Draw a study, or the part that is computed.

        Parameters
        ----------
        study
            The study.
        across
            The cost on the horizontal axis.
        up
            The error on the vertical axis.
        met
            What runs meet at the surfaces: crossings, jumps or both.
        """
        self._across.axis_label, self._up.axis_label = ACROSS[across], as_met(UP[up], met)
        self._hollow.label = value(as_met(WRONG, met))
        level = study.floor[up] or MACHINE_EPSILON
        bottom = bottom_of(study, up)
        drawn = [_Drawn(curve, across, up, bottom) for curve in study.curves]
        drawn = [one for one in drawn if one.there.any()]
        self.curves.data = {
            "xs": [one.joined for one in drawn],
            "ys": [one.height for one in drawn],
            "colour": [one.line.colour for one in drawn],
            "dash": [list(line.dash) for line in together(one.line for one in drawn)],
            "width": [min(one.line.width, 2.5) for one in drawn],
            "label": [one.curve.title for one in drawn],
            **mark_columns([one.line.marker for one in drawn]),
        }
        rows = [row | {"status": as_met(row["status"], met)} for one in drawn for row in one.points()]
        for source, place in ((self.points, "right"), (self.wrong, "wrong"), (self.below, "below")):
            source.data = {name: [row[name] for row in rows if row["place"] == place] for name in source.data}
        self._hollow.visible = bool(self.wrong.data["x"])
        below = bool(self.below.data["x"])
        self.levels.move(level, bottom if below else NOWHERE)
        if rows:
            x, y = (np.array([row[name] for row in rows]) for name in ("x", "y"))
            end = bottom / 2 if below else lowest(y, level)
            assign(self.corners, x=[x.min(), x.max()], y=[end, max(y.max(), 10 * end)])


class _Drawn:
    """The drawn form of one curve: points with a cost and an error, and gaps between them."""

    def __init__(self, curve: CostCurve, across: Across, up: Up, bottom: float) -> None:
        self.curve, self._across = curve, across
        self.line = line_of(curve.name) if not curve.peer else EXTERNAL_LINES[curve.name]
        self.error = error_of(curve, up)
        cost = cost_of(curve, across)
        self.there = np.isfinite(cost) & np.isfinite(self.error) & (cost > 0)
        self.cost: Floats = np.where(self.there, cost, np.nan)
        self.height: Floats = np.where(self.there, np.maximum(self.error, bottom), np.nan)
        """(m,) errors as drawn, those below the plot at its lower end, and NaN for a gap."""

    @property
    def joined(self) -> Floats:
        """(m,) costs of the points that are joined: not those of another sequence of crossings, or below the plot."""
        joined = self.curve.correct_sequence & (self.error >= self.height)
        return np.where(joined, self.cost, np.nan)

    def points(self) -> Iterator[dict[str, Any]]:
        """Yield the columns of each point."""
        for k in np.flatnonzero(self.there).tolist():
            cost, right = float(self.cost[k]), bool(self.curve.correct_sequence[k])
            yield {
                "x": cost,
                "y": float(self.height[k]),
                "colour": self.line.colour,
                "marker": self.line.marker,
                "label": self.curve.title,
                "setting": printed(setting_text(self.curve, k)),
                "cost": cost_words(cost, self._across),
                "error": printed(f"{self.error[k]:.1e}") if self.error[k] else "0",
                "status": self.curve.status[k],
                "place": "wrong" if not right else "below" if self.error[k] < self.height[k] else "right",
            }


def cost_rows(study: core.WorkPrecision) -> dict[str, ArrayLike]:
    """Return a study as columns (n,) by name, a row for each integrator and setting."""
    curves = study.curves
    counts = [len(curve.setting) for curve in curves]
    columns: dict[str, ArrayLike] = {
        name: np.repeat(np.array([getattr(curve, key) for curve in curves]), counts)
        for name, key in (("integrator", "title"), ("setting_name", "setting_name"))
    }
    numbers = (
        "setting",
        "seconds",
        "evaluations",
        "state_error",
        "time_error",
        "invariant_error",
        "crossings",
        "correct_sequence",
    )
    columns |= {name: np.concatenate([getattr(curve, name) for curve in curves]) for name in numbers}
    columns["compile_seconds"] = np.repeat([curve.compile_seconds for curve in curves], counts)
    return columns | {"outcome": np.concatenate([np.array(curve.status) for curve in curves])}
