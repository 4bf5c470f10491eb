"""The order plot: an error against the step size, one curve for each number of crossings, with fitted slopes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from bokeh.models import ColumnDataSource, DataRange1d
from numpy.typing import ArrayLike

import core
from pwsviz.figures.style import GREEN, GREY, ORANGE, SKY, Line, fit_to_corners, legend_below, mark_levels, plain_figure
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.text.numbers import printed

LINES = (
    Line(GREY, (), "circle", 1.6),
    Line(SKY, (8, 4), "square", 1.6),
    Line(GREEN, (3, 3), "triangle", 1.6),
    Line(ORANGE, (10, 4, 2, 4), "diamond", 1.6),
)
"""Looks of the curves; they do not stand for integrators, whose looks are in `style`."""


STATE_ERROR = ("state error", "‖x − x̂‖₂")
TIME_ERROR = ("crossing time error", "|t* − t̂|")
"""What an order plot may show: the error in words, and in symbols with its norm; a hat marks what is computed."""

ROOM = 2.0
"""Factor between the largest error and the point in which the lines of integer slopes meet."""

NAMED = 0.2
"""Part of a line of integer slope after which its name stands above it."""


@dataclass(frozen=True)
class Row:
    """One curve of an order plot."""

    name: str
    short: str
    """The name in the legend."""
    error: Floats
    """(m,) error at each step size."""
    slope: float
    window: tuple[float, float]
    """Least and greatest step size of the fit."""

    @property
    def label(self) -> str:
        """Name and fitted slope, for the legend."""
        return f"{self.short}: {self.slope_text}"

    @property
    def slope_text(self) -> str:
        """The fitted slope in words."""
        return printed(f"slope {self.slope:.2f}") if np.isfinite(self.slope) else "no slope"


def state_rows(study: core.OrderStudy) -> list[Row]:
    """Return the curves of the state error before the first crossing and after each of the studied ones."""
    names = [("before the first crossing", "before")]
    names += [(f"after {count} crossing{'s' * (count > 1)}", f"after {count}") for count in study.crossings]
    return [
        Row(name, short, study.state_error[k], float(study.state_slope[k]), _ends(study.window[k]))
        for k, (name, short) in enumerate(names)
    ]


def time_rows(study: core.OrderStudy) -> list[Row]:
    """Return the curves of the error of the time of each studied crossing."""
    return [
        Row(name, name, study.time_error[k], float(study.time_slope[k]), _ends(study.time_window[k]))
        for k, name in enumerate(f"crossing {count}" for count in study.crossings)
    ]


def order_tables(study: core.OrderStudy, rows: Sequence[Row]) -> Mapping[str, Callable[[], Mapping[str, ArrayLike]]]:
    """Return what a plot of these rows draws: the errors, a row for each curve and step size, and the fits."""
    curves = np.array([row.name for row in rows])

    def errors() -> Mapping[str, ArrayLike]:
        return {
            "integrator": np.repeat(np.array([study.method]), curves.size * study.taus.size),
            "curve": np.repeat(curves, study.taus.size),
            "tau": np.tile(study.taus, curves.size),
            "error": np.concatenate([row.error for row in rows]),
        }

    def fits() -> Mapping[str, ArrayLike]:
        windows = np.array([row.window for row in rows])
        return {
            "integrator": np.repeat(np.array([study.method]), curves.size),
            "curve": curves,
            "slope": np.array([row.slope for row in rows]),
            "fit_from": windows[:, 0],
            "fit_to": windows[:, 1],
            "round_off": np.full(curves.size, study.floor),
            "reference": np.repeat(np.array([study.reference]), curves.size),
        }

    return {"errors": errors, "fits": fits}


def _ends(window: Floats) -> tuple[float, float]:
    return float(window[0]), float(window[1])


class OrderView:
    """One fixed figure; `show` only changes its data.

    Parameters
    ----------
    error : str
        Which error it shows, in words.
    symbol : str
        The same in symbols, for the axis.
    """

    def __init__(self, error: str, symbol: str = "") -> None:
        self.figure = plain_figure(
            f"{error} against the step size, both on logarithmic axes, with fitted slopes",
            x_axis_type="log",
            y_axis_type="log",
            x_axis_label="step size τ",
            y_axis_label=", ".join(filter(None, (error, symbol))),
            x_range=DataRange1d(range_padding=0.06),
            y_range=DataRange1d(range_padding=0.06),
        )
        self._guide_glyphs()
        self._curve_glyphs()

    def _guide_glyphs(self) -> None:
        plot = self.figure
        self.guides = ColumnDataSource({"xs": [], "ys": []})
        plot.multi_line("xs", "ys", source=self.guides, color=GREY, line_dash="dotted", line_width=1.5)
        self.guide_names = ColumnDataSource({"x": [], "y": [], "text": []})
        plot.text(
            "x",
            "y",
            "text",
            source=self.guide_names,
            text_color=GREY,
            text_font_size="12px",
            text_align="right",
            text_baseline="bottom",
            x_offset=-2,
        )
        self.floor = mark_levels(plot, {1e-15: "round-off"})

    def _curve_glyphs(self) -> None:
        plot = self.figure
        self.fits = ColumnDataSource({"xs": [], "ys": [], "colour": []})
        fits = plot.multi_line("xs", "ys", source=self.fits, color="colour", alpha=0.25, line_width=9, line_cap="round")
        self.curves = ColumnDataSource({name: [] for name in ("xs", "ys", "colour", "dash", "label")})
        lines = plot.multi_line("xs", "ys", source=self.curves, color="colour", line_dash="dash", line_width=1.6)
        self.points = ColumnDataSource({name: [] for name in ("x", "y", "colour", "marker")})
        plot.scatter("x", "y", source=self.points, marker="marker", color="colour", size=6)
        self.corners = fit_to_corners(plot, [1e-4, 1e-1], [1e-15, 1.0])
        legend_below(
            plot,
            2,
            [
                ({"field": "label"}, lines),
                ("fit", fits),
            ],
            usual=5,
            widest=200,
        )

    def show(self, taus: Floats, rows: list[Row], floor: float, order: int) -> None:
        """Draw one study."""
        drawn = [(row, LINES[k % len(LINES)], np.isfinite(row.error) & (row.error > 0)) for k, row in enumerate(rows)]
        self.curves.data = {
            "xs": [taus for _ in drawn],
            "ys": [np.where(there, row.error, np.nan) for row, _, there in drawn],  # NaN leaves a gap
            "colour": [line.colour for _, line, _ in drawn],
            "dash": [list(line.dash) for _, line, _ in drawn],
            "label": [row.label for row, _, _ in drawn],
        }
        counts = [int(there.sum()) for _, _, there in drawn]
        self.points.data = {
            "x": np.concatenate([taus[there] for _, _, there in drawn]),
            "y": np.concatenate([row.error[there] for row, _, there in drawn]),
            "colour": [line.colour for (_, line, _), n in zip(drawn, counts, strict=True) for _ in range(n)],
            "marker": [line.marker for (_, line, _), n in zip(drawn, counts, strict=True) for _ in range(n)],
        }
        fits = [(fitted_line(taus, row), line.colour) for row, line, _ in drawn]
        shown = [(fit, colour) for fit, colour in fits if fit is not None]
        self.fits.data = {
            "xs": [fit[0] for fit, _ in shown],
            "ys": [fit[1] for fit, _ in shown],
            "colour": [colour for _, colour in shown],
        }
        self.floor.move(floor)
        self._show_guides(taus, rows, floor, order)

    def _show_guides(self, taus: Floats, rows: list[Row], floor: float, order: int) -> None:
        """Draw lines of integer slopes through one point above the curves, and end the axes where the data do."""
        there = np.array([np.isfinite(row.error) & (row.error > 0) for row in rows])
        errors = np.concatenate([row.error[known] for row, known in zip(rows, there, strict=True)])
        top, bottom = ROOM * float(errors.max(initial=floor)), min(float(errors.min(initial=1.0)), floor)
        used = taus[there.any(axis=0)] if there.any() else taus
        near, far = float(used.min()), float(used.max())
        slopes = sorted({1, 2, order})
        starts = np.array([max(near, far * (bottom / top) ** (1 / slope)) for slope in slopes])
        heights = top * (starts / far) ** np.array(slopes)
        self.guides.data = {
            "xs": [np.array([start, far]) for start in starts],
            "ys": [np.array([height, top]) for height in heights],
        }
        named = starts * (far / starts) ** NAMED, heights * (top / heights) ** NAMED
        self.guide_names.data = {"x": named[0], "y": named[1], "text": [f"slope {slope}" for slope in slopes]}
        self.corners.data = {"x": [near, far], "y": [bottom, top]}


def fitted_line(taus: Floats, row: Row) -> tuple[Floats, Floats] | None:
    """Return the fitted power law (τ, error) at the ends of its fit; None if there is no fit."""
    low, high = row.window
    used = (taus >= low * (1 - 1e-9)) & (taus <= high * (1 + 1e-9)) & np.isfinite(row.error) & (row.error > 0)
    if not np.isfinite(row.slope) or used.sum() < 2:
        return None
    log_constant = np.mean(np.log(row.error[used]) - row.slope * np.log(taus[used]))
    ends = np.array([taus[used].min(), taus[used].max()])
    return ends, np.exp(log_constant) * ends**row.slope
