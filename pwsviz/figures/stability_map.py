"""The map of outcomes of runs, over step size and start."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from bokeh.models import ColumnDataSource, DataRange1d, HoverTool, LogColorMapper
from bokeh.models.annotations import ColorBar
from bokeh.palettes import Cividis256

import core
from core.studies import NO_START, NOT_YET, WENT_ON, WRONG_CROSSINGS, OutcomeMap
from pwsviz.figures.stability_text import cell_words
from pwsviz.figures.style import (
    BLUE,
    BROWN,
    GREEN,
    GREY,
    OCHRE,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    VIOLET,
    assign,
    fit_to_corners,
    legend_below,
    line_of,
    plain_figure,
)
from pwsviz.geometry.numbers import MACHINE_EPSILON
from pwsviz.geometry.polyline_reduction import Floats

__all__ = ["COLOURS", "MapFigure", "Shown"]

Shown = Literal["outcome", "error"]

FLOOR = MACHINE_EPSILON / 8
"""|Δψ| at the lower end of the colour scale; smaller ones have the same colour."""

CEILING = 1.0
"""|Δψ| at the upper end of the colour scale; larger ones have the same colour."""

COLOURS: Mapping[int, str] = {
    core.Status.COMPLETED: SKY,  # and every run with the correct sequence of crossings
    WRONG_CROSSINGS: ORANGE,
    WENT_ON: OCHRE,
    core.Status.ESCAPED: VERMILION,
    core.Status.UNSTABLE: "#7f1d1d",
    core.Status.CONTRADICTION: "#000000",
    core.Status.NO_CONVERGENCE: PURPLE,
    core.Status.SLIDING: GREEN,
    core.Status.GRAZING: BROWN,
    core.Status.ZENO: VIOLET,
    core.Status.REPELLING: BLUE,
    core.Status.STEP_LIMIT: GREY,
    core.Status.CROSSING_LIMIT: GREY,
    NO_START: "#404040",
}
"""Colour of each outcome."""

_CELLS = ("left", "right", "bottom", "top", "tau", "value", "words", "crossings", "error")


class MapFigure:
    """One fixed figure: τ across, the coordinate of the start up, a cell for each run."""

    def __init__(self) -> None:
        self.figure = plain_figure(
            "what comes of a run, in colours, over step size (logarithmic) and one coordinate of the start",
            x_axis_type="log",
            x_axis_label="step size τ",
            y_axis_label="start",
            x_range=DataRange1d(range_padding=0.0),
            y_range=DataRange1d(range_padding=0.0),
        )
        plot = self.figure
        edges: dict[str, Any] = {"left": "left", "right": "right", "bottom": "bottom", "top": "top", "line_width": 0}
        self.cells = ColumnDataSource({name: [] for name in (*_CELLS, "colour")})
        outcomes = plot.quad(**edges, source=self.cells, fill_color="colour")
        self.heat = ColumnDataSource({name: [] for name in (*_CELLS, "height")})
        mapper = LogColorMapper(palette=Cividis256, low=FLOOR, high=CEILING, nan_color=GREY)
        errors = plot.quad(**edges, source=self.heat, fill_color={"field": "height", "transform": mapper})
        self.bar = ColorBar(color_mapper=mapper, title="|Δψ|", visible=False, width=12)
        plot.add_layout(self.bar, "right")
        self._limit_glyphs()
        self.corners = fit_to_corners(plot, [1e-3, 1.0], [-1.0, 1.0])
        tips = [("", "@words"), ("τ", "@tau"), ("start", "@value"), ("crossings", "@crossings"), ("|Δψ|", "@error")]
        plot.add_tools(HoverTool(renderers=[outcomes, errors], tooltips=tips))
        legend_below(plot, 2, [({"field": "words"}, outcomes)], widest=240)
        self._legend = plot.legend[0]

    def _limit_glyphs(self) -> None:
        """Make the labelled lines at the largest step size that works for each integrator."""
        self.limits = ColumnDataSource({name: [] for name in ("x", "y", "text", "colour", "dash")})
        self.figure.vspan("x", source=self.limits, line_color="#FFFFFF", line_width=5)
        self.figure.vspan("x", source=self.limits, line_color="colour", line_dash="dash", line_width=2.5)
        box: dict[str, Any] = {"background_fill_color": "#FFFFFF", "background_fill_alpha": 0.75, "padding": 1}
        self.figure.text(
            "x", "y", "text", source=self.limits, angle=np.pi / 2, text_color="#000000", text_font_size="12px",
            text_baseline="bottom", x_offset=-3, y_offset=-6, **box,
        )  # fmt: skip

    def show(self, study: core.StabilityStudy, method: str, what: Shown) -> None:
        """Draw what is computed of the map of one integrator, and the largest step size of each integrator."""
        self.figure.yaxis[0].axis_label = f"{study.coordinate_name} at the start"
        self._legend.visible, self.bar.visible = what == "outcome", what == "error"
        cells = {} if study.map is None else _cells(study.map, study.methods.index(method))
        for source, wanted in ((self.cells, "outcome"), (self.heat, "error")):
            source.data = {name: cells[name] if cells and what == wanted else [] for name in source.data}
        self._show_limits(study)
        if study.map is not None:
            across, up = _edges(np.log(study.map.taus)), _edges(study.map.values)
            assign(self.corners, x=np.exp(across[[0, -1]]), y=up[[0, -1]])

    def _show_limits(self, study: core.StabilityStudy) -> None:
        largest = study.largest_tau
        there = [] if largest is None else np.flatnonzero(np.isfinite(largest.tau)).tolist()
        names = [study.methods[k] for k in there]
        bottom = 0.0 if study.map is None else float(_edges(study.map.values)[0])
        self.limits.data = {
            "x": [] if largest is None else largest.tau[there],
            "y": [bottom] * len(there),
            "text": [f" {name}" for name in names],
            "colour": [line_of(name).colour for name in names],
            "dash": [list(line_of(name).dash) for name in names],
        }


def _edges(centres: Floats) -> Floats:
    """Return (n + 1,) edges of cells around (n,) increasing centres."""
    middles = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - middles[0]], middles, [2 * centres[-1] - middles[-1]]])


def _cells(found: OutcomeMap, k: int) -> dict[str, Floats | list[str]]:
    """Return the columns of the computed cells of one integrator."""
    row, column = np.nonzero(found.outcome[k] != NOT_YET)
    across, up = np.exp(_edges(np.log(found.taus))), _edges(found.values)
    outcome, error, works = (a[k][row, column] for a in (found.outcome, found.error, found.works))
    codes = np.where(works, core.Status.COMPLETED, outcome)
    counts = zip(found.crossings[k][row, column], found.expected_crossings[column], strict=True)
    return {
        "left": across[row],
        "right": across[row + 1],
        "bottom": up[column],
        "top": up[column + 1],
        "tau": [f"{tau:.3g}" for tau in found.taus[row]],
        "value": [f"{value:.4g}" for value in found.values[column]],
        "words": [cell_words(*given) for given in zip(codes, found.expected[column], strict=True)],
        "crossings": [f"{has} of {should}" for has, should in counts],
        "error": [f"{e:.1e}" if np.isfinite(e) else "no value" for e in error],
        "colour": [COLOURS[code] for code in codes],
        "height": np.maximum(error, FLOOR),
    }
