"""The conserved quantity: how far each integrator has let ψ drift, against time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from bokeh.models import ColumnDataSource, DataRange1d

from pwsviz.curves import Floats
from pwsviz.results import ErrorCurve
from pwsviz.style import (
    MACHINE_EPSILON,
    PURPLE,
    SIDES,
    assign,
    fit_to,
    legend_below,
    line_of,
    mark_levels,
    plain_figure,
)

FLOOR = MACHINE_EPSILON / 8
"""Smaller errors, exact zeros among them, are drawn here: a logarithmic axis has no place for them."""

CEILING = 1e9
"""Where a curve ends: that of a method that blows up would leave no room for the others."""

MOST_BANDS = 400
"""More visits than this would be a grey mist; then sides and ticks are left out."""


class ConservedView:
    """One fixed figure; `show` only changes its data."""

    def __init__(self) -> None:
        self.figure = plain_figure(
            "Absolute change of the conserved quantity against time, on a logarithmic axis",
            y_axis_type="log",
            x_axis_label="time t",
            y_axis_label="|change of ψ made by the integrator|",
            x_range=DataRange1d(range_padding=0.0),
            y_range=DataRange1d(range_padding=0.06),
        )
        self._ground()
        columns = ("xs", "ys", "method", "colour", "dash")
        self.curves = ColumnDataSource({name: [] for name in columns})
        lines = self.figure.multi_line("xs", "ys", source=self.curves, color="colour", line_dash="dash", line_width=1.6)
        self.corners = ColumnDataSource({"x": [0.0, 1.0], "y": [FLOOR / 2, 1e-2]})
        frame = self.figure.scatter("x", "y", source=self.corners, alpha=0.0, size=1)
        fit_to(self.figure, frame)
        legend_below(
            self.figure,
            4,
            [
                ({"field": "method"}, lines),
                ("g < 0", self.bands),
                ("crossing", self.ticks),
            ],
        )

    def _ground(self) -> None:
        plot = self.figure
        self.visits = ColumnDataSource({"start": [], "end": []})
        self.bands = plot.vstrip(
            "start", "end", source=self.visits, fill_color=SIDES[-1], fill_alpha=0.16, line_width=0
        )
        self.instants = ColumnDataSource({"t": [], "y": []})
        self.ticks = plot.scatter(
            "t", "y", source=self.instants, marker="dash", angle=np.pi / 2, size=12, color=PURPLE, line_width=1.5
        )
        mark_levels(plot, {MACHINE_EPSILON: "machine ε", FLOOR: "less, or 0"})

    def show(self, errors: Sequence[ErrorCurve]) -> None:
        """Draw the errors of one scene."""
        lines = [line_of(curve.method) for curve in errors]
        heights = [drawable(curve.error[1:]) for curve in errors]
        self.curves.data = {
            "xs": [curve.t[1:] for curve in errors],  # at the start there is no error yet, by definition
            "ys": heights,
            "method": [curve.method for curve in errors],
            "colour": [line.colour for line in lines],
            "dash": [list(line.dash) for line in lines],
        }
        self._show_visits(errors[0])
        top = max(float(np.nanmax(y, initial=1e-14)) for y in heights)
        end = max(curve.t_end for curve in errors)
        assign(self.corners, x=[0.0, end or 1.0], y=[FLOOR / 2, 2 * top])

    def _show_visits(self, first: ErrorCurve) -> None:
        t = first.crossings if len(first.crossings) <= MOST_BANDS else first.crossings[:0]
        bounds = np.concatenate([[0.0], t, [first.t_end]])
        minus = np.flatnonzero(first.sides < 0) if len(t) == len(first.crossings) else np.empty(0, dtype=int)
        assign(self.visits, start=bounds[minus], end=bounds[minus + 1])
        assign(self.instants, t=t, y=np.full(len(t), FLOOR / 1.5))


def drawable(error: Floats) -> Floats:
    """Raise what is too small for the axis to its floor, and leave out what is beyond the ceiling; NaN stays a gap."""
    beyond = np.maximum.accumulate(error > CEILING)  # once beyond, an envelope would come back at every other point
    return np.where(beyond, np.nan, np.maximum(error, FLOOR))
