"""The plot of the conserved quantity: |change of ψ| that each integrator has made, against time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from bokeh.core.properties import value
from bokeh.models import ColumnDataSource, DataRange1d
from bokeh.models.glyphs import Line, Scatter

from pwsviz.figures.colours import OCCUPIED
from pwsviz.figures.conserved_text import (
    CEILING,
    CHANGE_OF_PSI,
    MOST_BANDS,
    TELLABLE,
    axis_name,
    conserved_text,
    largest,
    round_off_grows,
)
from pwsviz.figures.crowding import SAME_INSTANT, Marks, attach_shades, shade_keys
from pwsviz.figures.legends import legend_below
from pwsviz.figures.lines import LOOK_COLUMNS, line_of, look_columns, widths_in_time
from pwsviz.figures.marks import kind_columns
from pwsviz.figures.style import (
    BELOW_RANGE,
    BESIDE,
    LEVEL,
    assign,
    crossing_tips,
    describe,
    fit_to_corners,
    invisible,
    legend_lines,
    mark_levels,
    plain_figure,
    run_lines,
    segments,
    show_methods,
    side_strips,
    tips,
    unseen,
)
from pwsviz.geometry.numbers import MACHINE_EPSILON
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.results.animation import Landmarks
from pwsviz.results.error_curve import ErrorCurve

FLOOR = MACHINE_EPSILON / 8
"""|Change of ψ| at which smaller ones and exact zeros are drawn, since a logarithmic axis has no place for them."""

BELOW_ROUND_OFF = 64.0
"""Ratio of round-off and this level, which is lower for a ψ whose round-off is less than that of 1."""

FOOT, BOTTOM = 1 / 7, 1 / 25
"""Heights of the marks of crossings, below every curve, and of the lower end of the axis, relative to this level."""

BARE_BOTTOM = 1 / 2
"""Height of the lower end without such marks."""

FULL = 400.0
"""Height of the axis above this level, at least."""

TICK = 8
"""Size in pixels of the mark of a crossing."""

LINE = 0.045
"""Height of a line of text, relative to that of the frame on a phone."""

NO_BOUND = 1e300
"""Height above every curve."""

NOWHERE = 1e-300
"""Height of a mark that is not to be seen: below the axis."""

SUMMARY = "Absolute change of the conserved quantity against time, on a logarithmic axis"


class ConservedView:
    """One fixed figure; `show` only changes its data."""

    def __init__(self) -> None:
        self.figure = plain_figure(
            SUMMARY,
            y_axis_type="log",
            x_axis_label="time t",
            y_axis_label=axis_name(),
            x_range=DataRange1d(range_padding=2 * BESIDE),
            y_range=DataRange1d(range_padding=0.06),
        )
        self._band_glyphs()
        self._curve_glyphs()
        self._tick_glyphs()
        _, *entries, _, self._exit_entry = legend_below(
            self.figure,
            [
                ({"field": "method"}, self.keys),
                *shade_keys(self.figure),
                ({"field": "label"}, self.ticks.key),
                ("above plot range", self.exit_marks),
            ],
        )
        self.entries = dict(zip(OCCUPIED, entries, strict=False))
        attach_shades(self.figure, self.bands, entries)

    def _band_glyphs(self) -> None:
        plot = self.figure
        self.segments, self.bands = {}, {}
        for side in OCCUPIED:
            self.segments[side] = ColumnDataSource({"start": [], "end": []})
            self.bands[side] = plot.add_glyph(self.segments[side], side_strips(side))
        self.levels = mark_levels(plot, {MACHINE_EPSILON: "eps = 2⁻⁵²", FLOOR: BELOW_RANGE, NOWHERE: "round-off"})

    def _curve_glyphs(self) -> None:
        plot = self.figure
        columns = ("xs", "ys", *LOOK_COLUMNS, "width")
        self.methods, self.keys = legend_lines(plot)
        self.round_off = ColumnDataSource({"t": [], "y": []})
        plot.add_glyph(self.round_off, Line(x="t", y="y", **LEVEL))
        self.curves = ColumnDataSource({name: [] for name in columns})
        self.lines = plot.add_glyph(self.curves, run_lines())
        rows = [("integrator", "@method"), ("time", "$snap_x{6}"), ("|Δψ|", "$snap_y{3}")]
        here: dict[str, Any] = {"line_policy": "nearest", "attachment": "horizontal", "visible": False}
        plot.add_tools(tips(rows, renderers=[self.lines], **here))
        self.exits = ColumnDataSource({name: [] for name in ("t", "y", "colour", "words")})
        look: dict[str, Any] = {"marker": "triangle_pin", "line_color": "colour", "fill_color": "colour", "size": 12}
        self.exit_marks = plot.add_glyph(self.exits, Scatter(x="t", **look))
        plot.add_tools(tips([("", "@words")], renderers=[self.exit_marks]))
        self.corners = fit_to_corners(plot, [0.0, 1.0], [BOTTOM, 1e-2])

    def _tick_glyphs(self) -> None:
        plot = self.figure
        columns = ("t", "foot", "x", "y", "label", "kind", "marker", "colour", "size", "number", "method")
        self.instants = unseen(columns)
        self.ticks = Marks(plot, self.instants, "t", "foot", width=1.8, same=SAME_INSTANT)
        reach = plot.add_glyph(self.instants, invisible(size=18, x="t", y="foot"))
        self.hover = crossing_tips(reach, "t")
        plot.add_tools(self.hover)

    def show(self, errors: Sequence[ErrorCurve], landmarks: Landmarks | None = None) -> None:
        """Draw the errors of the runs of one scene.

        Parameters
        ----------
        errors : sequence of ErrorCurve
            One for each integrator.
        landmarks : Landmarks, optional
            Of the first integrator's run. Without them all crossings have the same marker, and a crossing under the
            pointer is marked in the portrait only if it has a mark there.
        """
        methods = [curve.method for curve in errors]
        floor = floor_of(errors)
        for ruled in (self.figure.yaxis[0], self.figure.ygrid[0]):
            ruled.bounds = (floor, NO_BOUND)  # below, marks stand at times, and no numbers at heights
        heights = [drawable(curve.error[1:], floor) for curve in errors]
        lines_drawn = [_apart(curve, y) for curve, y in zip(errors, heights, strict=True)]
        assign(
            self.curves,
            xs=[t for t, _ in lines_drawn],
            ys=[y for _, y in lines_drawn],
            **look_columns(methods),
            width=widths_in_time(methods),
        )
        self.figure.yaxis[0].axis_label = axis_name(errors)
        self._show_exits(errors, heights)
        show_methods(self.methods, methods)
        self._show_segments(errors[0])
        self._show_ticks(errors[0], landmarks, FOOT * floor)
        self._draw_round_off(errors[0], floor)
        top = max(float(np.fmax.reduce(y, initial=FULL * floor)) for y in (*heights, self.round_off.data["y"]))
        end = max(curve.t_end for curve in errors)
        bottom = floor * (BOTTOM if len(self.instants.data["t"]) else BARE_BOTTOM)
        assign(self.corners, x=[0.0, end or 1.0], y=[bottom, 2 * top])
        self._name_levels(errors[0], LINE * np.log10(2 * top / bottom), floor)
        only_g = CHANGE_OF_PSI not in axis_name(errors)
        what = SUMMARY.replace("the conserved quantity", "g while sliding") if only_g else SUMMARY
        describe(self.figure, f"{what}. {conserved_text(errors)}")

    @property
    def draws_round_off(self) -> bool:
        """Whether there is a line of round-off."""
        return len(self.round_off.data["t"]) > 0 or self.levels.ticker.ticks[-1] != NOWHERE

    def _show_exits(self, errors: Sequence[ErrorCurve], heights: Sequence[Floats]) -> None:
        """Mark where curves leave the plot at its upper end, and say how large their |Δψ| becomes."""
        gone = [(curve, y) for curve, y in zip(errors, heights, strict=True) if np.nanmax(y, initial=0.0) >= CEILING]
        assign(
            self.exits,
            t=[curve.t[1:][np.nanargmax(y)] for curve, y in gone],
            y=[CEILING] * len(gone),
            colour=[line_of(curve.method).colour for curve, _ in gone],
            words=[f"{curve.method} leaves the plot: {largest(curve.error)}" for curve, _ in gone],
        )
        self._exit_entry.visible = bool(gone)

    def _show_segments(self, first: ErrorCurve) -> None:
        bounds = np.concatenate([[0.0], first.crossings, [first.t_end]])
        for side, source in self.segments.items():
            few = slice(None) if len(first.crossings) <= MOST_BANDS else slice(0)
            shaded = segments(bounds, first.sides[few], side)
            entry, name = self.entries[side], first.names.get(side, "")
            name = name if side else f"{name}: |Δg|"
            if entry.label != value(name):  # each change rebuilds the legend
                entry.label = value(name)
            entry.visible = len(shaded["start"]) > 0
            assign(source, **shaded)  # last: the browser hides the entry of shades that are too narrow

    def _show_ticks(self, first: ErrorCurve, landmarks: Landmarks | None, foot: float) -> None:
        t = first.crossings if len(first.crossings) <= MOST_BANDS else first.crossings[:0]
        count = len(t)
        places = np.full((count, 2), np.nan) if landmarks is None else landmarks.places[:count]
        kinds = ("crossing",) * count if landmarks is None else landmarks.kinds[:count]
        looks = kind_columns(kinds, [TICK] * count)
        self.ticks.name(looks)
        assign(
            self.instants,
            t=t,
            foot=np.full(count, foot),
            x=places[:, 0],
            y=places[:, 1],
            **looks,
            number=np.arange(1, 1 + count),
            method=[first.method] * count,
        )

    def _draw_round_off(self, first: ErrorCurve, floor: float) -> None:
        """Draw the round-off of ψ as a curve where it grows along the run."""
        drawn = slice(None) if round_off_grows(first) else slice(0)
        assign(self.round_off, t=first.t[drawn], y=np.clip(first.round_off, floor, CEILING)[drawn])

    def _name_levels(self, first: ErrorCurve, line: float, floor: float) -> None:
        """Mark the round-off of ψ at the end, unless it is below all, and eps unless names would overlap.

        A line of text is as high as `line` powers of ten.
        """
        last, apart = float(first.round_off[-1]), max(TELLABLE, 10.0**line)
        told = last >= apart * floor
        beside = last if told else NOWHERE
        named = min(MACHINE_EPSILON / floor, max(beside / MACHINE_EPSILON, MACHINE_EPSILON / beside)) >= apart
        self.levels.move(MACHINE_EPSILON if named else NOWHERE, floor, beside)
        self.levels.spans[-1].visible = not round_off_grows(first)


def _apart(curve: ErrorCurve, heights: Floats) -> tuple[Floats, Floats]:
    """Return the line of a curve without its start, where the change is 0, and with gaps where sliding begins or ends.

    What changes is g there, and ψ elsewhere: no line joins the two.
    """
    gaps = 1 + np.flatnonzero(np.diff(curve.sliding[1:]))
    t = curve.t[1:]
    return np.insert(t, gaps, t[gaps]), np.insert(heights, gaps, np.nan)


def floor_of(errors: Sequence[ErrorCurve]) -> float:
    """Return the least |change of ψ| that has a place: `FLOOR`, or less if round-off is far less, as of a small ψ."""
    size = float(errors[0].round_off[-1])
    known = CHANGE_OF_PSI in axis_name(errors) and 0.0 < size < np.inf
    return min(FLOOR, size / BELOW_ROUND_OFF) if known else FLOOR


def drawable(error: Floats, floor: float = FLOOR) -> Floats:
    """Return errors raised to a level, up to the first beyond `CEILING`, which is drawn there; NaN stays a gap."""
    beyond = np.maximum.accumulate(error > CEILING)  # for good: an envelope zigzags back
    after = np.concatenate([[False], beyond[:-1]])[: len(beyond)]
    return np.where(after, np.nan, np.clip(error, floor, CEILING))
