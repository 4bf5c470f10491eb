"""The map of outcomes of runs, over step size and start."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Literal

import numpy as np
from bokeh.events import Event, PointEvent, Tap
from bokeh.models import ColumnDataSource, DataRange1d, LogColorMapper
from bokeh.models.annotations import ColorBar
from bokeh.models.renderers import GlyphRenderer
from bokeh.palettes import Cividis256
from numpy.typing import NDArray

import core
from core.studies import NOT_YET, OutcomeMap
from pwsviz.figures.colours import GREY
from pwsviz.figures.legends import legend_below
from pwsviz.figures.stability_outcomes import OUTCOMES, lasts, outcomes_shown
from pwsviz.figures.stability_text import has_limit
from pwsviz.figures.style import WITH_TABLE, assign, fit_to_corners, plain_figure, tips
from pwsviz.geometry.numbers import MACHINE_EPSILON
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.scene.names import as_met, told
from pwsviz.text.math_names import variable_name
from pwsviz.text.numbers import printed

__all__ = ["NO_VALUE", "Choose", "MapFigure", "Shown"]

Shown = Literal["outcome", "error"]

Choose = Callable[[float, float], None]
"""Called with the step size and the coordinate of the start on which the user clicks."""

NO_VALUE = "no value of |Δψ|: the numerical solution blows up, or no ψ is known"
"""Legend of grey cells."""

FLOOR = MACHINE_EPSILON / 8
"""|Δψ| at the lower end of the colour scale; smaller ones have the same colour."""

CEILING = 1.0
"""|Δψ| at the upper end of the colour scale; larger ones have the same colour."""

LIMIT = "largest successful τ"
"""Legend of the diamond."""

PLACE = "chosen τ and start"
"""Legend of the cross."""

HATCH: Mapping[str, Any] = {
    "hatch_pattern": "right_diagonal_line", "hatch_color": "#FFFFFF", "hatch_alpha": 0.6, "hatch_scale": 8.0,
}  # fmt: skip
"""What tells the colour of an outcome from one of the scale of |Δψ|."""

_CELLS = ("left", "right", "bottom", "top", "tau", "value", "words", "met", "expected", "error")


class MapFigure:
    """One fixed figure: τ across, the coordinate of the start up, a cell for each run.

    Parameters
    ----------
    on_choose : callable
        Called with the place of a click.
    """

    def __init__(self, on_choose: Choose) -> None:
        self.figure = plain_figure(
            "outcome of runs, in colours, over step size (logarithmic) and one coordinate of the start",
            x_axis_type="log",
            x_axis_label="step size τ",
            y_axis_label="start",
            styles=WITH_TABLE,
            x_range=DataRange1d(range_padding=0.0),
            y_range=DataRange1d(range_padding=0.0),
        )
        plot = self.figure
        edges: dict[str, Any] = {"left": "left", "right": "right", "bottom": "bottom", "top": "top"}
        self.cells = ColumnDataSource({name: [] for name in (*_CELLS, "colour")})
        outcomes = plot.quad(**edges, source=self.cells, color="colour")
        self.heat = ColumnDataSource({name: [] for name in (*_CELLS, "height")})
        mapper = LogColorMapper(palette=Cividis256, low=FLOOR, high=CEILING)
        errors = plot.quad(**edges, source=self.heat, color={"field": "height", "transform": mapper})
        self.ended = ColumnDataSource({name: [] for name in (*_CELLS, "colour")})
        ended = plot.quad(**edges, source=self.ended, color="colour", **HATCH)
        self.blank = ColumnDataSource({name: [] for name in _CELLS})
        blanks = plot.quad(**edges, source=self.blank, color=GREY)
        self.bar = ColorBar(color_mapper=mapper, title="|Δψ|", visible=False, width=12)
        plot.add_layout(self.bar, "right")
        limits, crosses = self._limit_glyphs(), self._place_glyphs()
        self.corners = fit_to_corners(plot, [1e-3, 1.0], [-1.0, 1.0])
        rows = [
            ("", "@words"),
            ("τ", "@tau"),
            ("start", "@value"),
            ("run", "@met"),
            ("solution", "@expected"),
            ("|Δψ|", "@error"),
        ]
        plot.add_tools(tips(rows, renderers=[outcomes, errors, ended, blanks]))
        entries = [
            ({"field": "words"}, outcomes),
            (NO_VALUE, blanks),
            ({"field": "words"}, ended),
            (LIMIT, limits),
            (PLACE, crosses),
        ]
        self._outcomes, self._blanks, self._ended, self._limit, self._place = legend_below(plot, entries)
        self._limit.visible = self._place.visible = False
        plot.on_event(Tap, lambda event: _choose(event, on_choose))

    def _limit_glyphs(self) -> GlyphRenderer[Any]:
        """Make the diamond at the largest step size that works: dark about light, seen on every cell; return it."""
        self.limits = ColumnDataSource({"x": [], "y": []})
        look: dict[str, Any] = {"fill_color": "#FFFFFF", "line_color": "#000000", "line_width": 2.5}
        return self.figure.scatter("x", "y", source=self.limits, marker="diamond", size=18, **look)

    def _place_glyphs(self) -> list[GlyphRenderer[Any]]:
        """Make the cross at the step size and the start of the page: a dark one on a light one, seen on every cell."""
        self.place = ColumnDataSource({"x": [], "y": []})
        return [
            self.figure.scatter("x", "y", source=self.place, marker="cross", size=26, color=colour, line_width=width)
            for colour, width in (("#FFFFFF", 6), ("#000000", 2.5))
        ]

    def show(self, study: core.StabilityStudy, method: str, what: Shown, met: str = "crossings") -> None:
        """Draw what is computed of the map of one integrator, and its largest successful step size."""
        self.figure.yaxis[0].axis_label = f"initial {variable_name(study.coordinate_name)}"
        cells = {} if study.map is None else _cells(study.map, study.methods.index(method), met)
        known, whole = np.isfinite(cells.get("height", np.empty(0))), cells.get("lasts", np.empty(0, dtype=bool))
        every = np.ones(len(known), dtype=bool)
        rows = {"outcome": every, "error": known & whole, "blank": ~known & whole, "ended": ~whole}
        for source, which, wanted in (
            (self.cells, "outcome", "outcome"), (self.heat, "error", "error"), (self.blank, "blank", "error"),
            (self.ended, "ended", "error"),
        ):  # fmt: skip
            kept = rows[which] & (what == wanted)
            assign(source, **{name: cells[name][kept] if cells else [] for name in source.data})
        self._outcomes.visible, self.bar.visible = what == "outcome", what == "error"
        self._blanks.visible = what == "error" and bool(rows["blank"].any())
        self._ended.visible = what == "error" and bool(rows["ended"].any())
        self._show_limit(study, method)
        if study.map is not None:
            assign(self.corners, x=study.map.taus[[0, -1]], y=study.map.values[[0, -1]])

    def mark(self, tau: float, value: float) -> None:
        """Put the cross at a step size and a coordinate of the start."""
        assign(self.place, x=[tau], y=[value])
        self._place.visible = True

    def _show_limit(self, study: core.StabilityStudy, method: str) -> None:
        """Mark the largest successful step size at the start for which it holds."""
        there = study.map is not None and has_limit(study, method)
        self._limit.visible = there
        place = study.largest_tau.tau[study.methods.index(method)] if study.largest_tau is not None else np.nan
        assign(self.limits, x=[place] * there, y=[study.x0[study.coordinate]] * there)


def _edges(centres: Floats) -> Floats:
    """Return (n + 1,) edges of cells around (n,) increasing places, of which the outer ones are edges themselves.

    So every place of the map lies among those that were tried.
    """
    return np.concatenate([centres[:1], (centres[1:] + centres[:-1]) / 2, centres[-1:]])


def _choose(event: Event, on_choose: Choose) -> None:
    if isinstance(event, PointEvent) and event.x is not None and event.y is not None:
        on_choose(float(event.x), float(event.y))


def _cells(found: OutcomeMap, k: int, met: str) -> dict[str, NDArray[Any]]:
    """Return the columns of the computed cells of one integrator; they reach to the middle between computed starts."""
    shown = outcomes_shown(found, k)
    row, column = np.nonzero(shown != NOT_YET)
    across, up = np.exp(_edges(np.log(found.taus))), _edges(found.values)
    known, place = np.unique(column, return_inverse=True)
    middles = (found.values[known[1:]] + found.values[known[:-1]]) / 2
    bottom, top = np.append(up[0], middles)[place], np.append(middles, up[-1])[place]
    error, codes = found.error[k][row, column], shown[row, column].tolist()
    return {
        "left": across[row],
        "right": across[row + 1],
        "bottom": bottom,
        "top": top,
        "tau": np.array([printed(f"{tau:.3g}") for tau in found.taus[row]]),
        "value": np.array([printed(f"{value:.4g}") for value in found.values[column]]),
        "words": np.array([as_met(OUTCOMES[code].words, met) for code in codes]),
        "met": np.array([told(core.Tally(*one), met) for one in found.met[k][row, column].tolist()]),
        "expected": np.array([told(core.Tally(*one), met) for one in found.expected_met[column].tolist()]),
        "error": np.array([printed(f"{e:.1e}") if np.isfinite(e) else "no value" for e in error]),
        "colour": np.array([OUTCOMES[code].colour for code in codes]),
        "height": np.maximum(error, FLOOR),
        "lasts": lasts(found, k)[row, column],
    }
