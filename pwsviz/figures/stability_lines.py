"""Drift in long runs, and runs near a tangency: |Δψ| on logarithmic axes, a curve for each integrator."""

from __future__ import annotations

from typing import Any

import numpy as np
from bokeh.models import ColumnDataSource, DataRange1d
from bokeh.models.renderers import DataRenderer

import core
from core.studies import Grazing, outcome_words
from pwsviz.figures.colours import VERMILION
from pwsviz.figures.conserved import FLOOR, drawable
from pwsviz.figures.conserved_text import CEILING, axis_name
from pwsviz.figures.legends import legend_below
from pwsviz.figures.lines import LOOK_COLUMNS, line_of, look_columns, widths_in_time
from pwsviz.figures.stability_text import side_words, wrong_number
from pwsviz.figures.style import BELOW_RANGE, BESIDE, assign, fit_to_corners, mark_levels, plain_figure, tips
from pwsviz.geometry.numbers import MACHINE_EPSILON
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.scene.names import as_met, told
from pwsviz.text.advice import on_page
from pwsviz.text.numbers import printed

__all__ = ["DriftFigure", "GrazingFigure"]

STOPS, STOPS_BEYOND = "the run stops", "the run stops (at the top: above plot range)"
"""Names of the marks of runs that stop."""

_CURVE = ("xs", "ys", *LOOK_COLUMNS, "width")


class DriftFigure:
    """One fixed figure: |Δψ| against time."""

    def __init__(self) -> None:
        self.figure = plain_figure(
            "absolute change of the conserved quantity in a long run against time, both on logarithmic axes",
            x_axis_type="log",
            y_axis_type="log",
            x_axis_label="time since the start",
            y_axis_label=axis_name(),
            x_range=DataRange1d(range_padding=2 * BESIDE),
            y_range=DataRange1d(range_padding=0.06),
        )
        plot = self.figure
        self.curves = ColumnDataSource({name: [] for name in _CURVE})
        lines = _lines(plot, self.curves)
        self.stops = ColumnDataSource({name: [] for name in ("x", "y", "colour", "method", "message")})
        stops = plot.scatter("x", "y", source=self.stops, marker="x", color="colour", size=11, line_width=2.5)
        mark_levels(plot, {MACHINE_EPSILON: "eps = 2⁻⁵²", FLOOR: BELOW_RANGE})
        self.corners = fit_to_corners(plot, [1.0, 1e3], [FLOOR / 2, 1e-12])
        plot.add_tools(tips([("", "@method"), ("", "@message")], renderers=[stops]))
        self._stopping = legend_below(plot, [({"field": "method"}, lines), (STOPS, stops)])[1]

    def show(self, study: core.StabilityStudy, met: str = "crossings") -> None:
        """Draw what is computed of the long runs, which meet crossings, jumps or both."""
        drift, methods = study.drift, study.methods
        if drift is None:
            self.curves.data = {name: [] for name in self.curves.data}
            self.stops.data = {name: [] for name in self.stops.data}
            return
        heights = [drawable(error) for error in drift.error]
        self.curves.data = _columns(methods, [drift.t] * len(methods), heights)
        stopped = [
            (k, known[-1]) for k, y in enumerate(heights) if drift.message[k] and len(known := np.flatnonzero(y > 0))
        ]
        self.stops.data = {
            "x": [drift.t[n] for _, n in stopped],
            "y": [heights[k][n] for k, n in stopped],
            "colour": [line_of(methods[k]).colour for k, _ in stopped],
            "method": [methods[k] for k, _ in stopped],
            "message": [as_met(printed(on_page(drift.message[k])), met) for k, _ in stopped],
        }
        beyond = any(drift.error[k][n] > CEILING for k, n in stopped)
        self._stopping.update(visible=bool(stopped), label={"value": STOPS_BEYOND if beyond else STOPS})
        assign(self.corners, x=drift.t[[0, -1]], y=np.array([FLOOR / 2, _top(heights)]))


class GrazingFigure:
    """One fixed figure: |Δψ| and wrong numbers of crossings against the distance from the tangency."""

    def __init__(self) -> None:
        self.figure = plain_figure(
            "worst change of the conserved quantity against the distance of the start from one whose trajectory "
            "touches the surface, both on logarithmic axes; runs that meet it a wrong number of times are marked",
            x_axis_type="log",
            y_axis_type="log",
            x_axis_label="distance δ of the start from the tangency",
            y_axis_label="largest |Δψ|",
            x_range=DataRange1d(range_padding=0.07),
            y_range=DataRange1d(range_padding=0.06),
        )
        plot = self.figure
        self.curves = ColumnDataSource({name: [] for name in _CURVE})
        lines = _lines(plot, self.curves)
        points = ("x", "y", "colour", "method", "side", "met", "expected", "error", "status")
        self.points = [ColumnDataSource({name: [] for name in points}) for _ in range(2)]
        marks: list[DataRenderer] = [
            plot.scatter("x", "y", source=source, marker=marker, color="colour", size=9)
            for source, marker in zip(self.points, ("inverted_triangle", "triangle"), strict=True)
        ]
        self.wrong = ColumnDataSource({"x": [], "y": []})
        rings = plot.scatter(
            "x", "y", source=self.wrong, marker="circle", fill_alpha=0.0, line_color=VERMILION, line_width=2, size=17
        )
        mark_levels(plot, {MACHINE_EPSILON: "eps = 2⁻⁵²", FLOOR: "\n\ntiny, 0, or\nunknown:\ndrawn here"})
        self.corners = fit_to_corners(plot, [1e-14, 0.1], [FLOOR / 2, 1e-12])
        rows = [
            ("", "@method, @side"),
            ("δ", "@x{3}"),
            ("run", "@met"),
            ("solution", "@expected"),
            ("|Δψ|", "@error"),
            ("", "@status"),
        ]
        plot.add_tools(tips(rows, renderers=marks))
        entries = [({"field": "method"}, lines), *(("", mark) for mark in marks), ("wrong number of crossings", rings)]
        self._entries = legend_below(plot, entries)[1:]

    def show(self, study: core.StabilityStudy, met: str = "crossings") -> None:
        """Draw what is computed of the runs near a tangency, which meet crossings, jumps or both."""
        grazing = study.grazing
        for source in (self.curves, *self.points, self.wrong):
            source.data = {name: [] for name in source.data}
        self._entries[2].label = {"value": as_met("wrong number of crossings", met)}
        if grazing is None or not grazing.found:
            return
        n = len(study.methods)
        heights = [_heights(grazing, k, side) for side in (0, 1) for k in range(n)]
        curves = _columns(study.methods * 2, [grazing.delta] * 2 * n, heights)
        # Each mark is a run: in print, too, none tells an integrator.
        self.curves.data = {name: column for name, column in curves.items() if name != "marker"}
        for side, (source, entry) in enumerate(zip(self.points, self._entries[:2], strict=True)):
            rows = [row for k in range(n) for row in _points(study, k, side, heights[side * n + k], met)]
            source.data = {name: [row[name] for row in rows] for name in source.data}
            entry.label = {"value": side_words(study, side)}
        self._entries[2].label = {"value": as_met(wrong_number(grazing), met)}
        wrong = [(k, side, j) for k, side, j in np.argwhere(grazing.missed != 0).tolist()]
        self.wrong.data = {
            "x": [grazing.delta[j] for _, _, j in wrong],
            "y": [heights[side * n + k][j] for k, side, j in wrong],
        }
        assign(self.corners, x=grazing.delta[[-1, 0]], y=np.array([FLOOR / 2, _top(heights)]))


def _lines(plot: Any, source: ColumnDataSource) -> Any:
    look = {"color": "colour", "line_dash": "dash", "line_width": "width"}
    return plot.multi_line("xs", "ys", source=source, **look)


def _columns(methods: tuple[str, ...], xs: list[Floats], ys: list[Floats]) -> dict[str, list[Any]]:
    """Return the columns of curves, one for each of the integrators named."""
    return {"xs": xs, "ys": ys, **look_columns(methods), "width": widths_in_time(methods)}


def _heights(grazing: Grazing, k: int, side: int) -> Floats:
    """Return the errors of an integrator on one side as drawn: the floor if no ψ is known, NaN if not computed."""
    error = grazing.error[k, side]
    there = grazing.computed[k, side]
    return np.where(there, drawable(np.where(np.isfinite(error), error, 0.0)), np.nan)


def _points(study: core.StabilityStudy, k: int, side: int, heights: Floats, met: str) -> list[dict[str, Any]]:
    """Return the columns of each run of an integrator on one side."""
    grazing = study.grazing
    assert grazing is not None  # noqa: S101  (drawn where it is found)
    error, expected = grazing.error[k, side], grazing.expected_met[side]
    return [
        {
            "x": grazing.delta[n],
            "y": heights[n],
            "colour": line_of(study.methods[k]).colour,
            "method": study.methods[k],
            "side": side_words(study, side),
            "met": told(core.Tally(*grazing.met[k, side, n].tolist()), met),
            "expected": told(core.Tally(*expected[n].tolist()), met) if grazing.judged[side, n] else "stops",
            "error": printed(f"{error[n]:.1e}") if np.isfinite(error[n]) else "no value",
            "status": as_met(outcome_words(int(grazing.status[k, side, n])), met),
        }
        for n in np.flatnonzero(grazing.computed[k, side]).tolist()
    ]


def _top(heights: list[Floats]) -> float:
    """Return the upper end of an axis that holds some curves."""
    return 2 * max(1e-14, *(float(np.fmax.reduce(y, initial=0.0)) for y in heights))
