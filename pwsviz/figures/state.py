"""The plot of the state against time: a panel for each coordinate, one below the other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from bokeh.core.properties import value
from bokeh.models import ColumnDataSource, CustomJS, DataRange1d, HoverTool, Range1d
from bokeh.models.glyphs import Scatter
from bokeh.models.labeling import NoOverlap

import core
from pwsviz.figures.colours import OCCUPIED
from pwsviz.figures.crowding import SAME_INSTANT, Marks, attach_shades, shade_keys
from pwsviz.figures.legends import legend_below
from pwsviz.figures.lines import LOOK_COLUMNS, line_of, look_columns, widths_in_time
from pwsviz.figures.marks import kind_columns
from pwsviz.figures.style import (
    BESIDE,
    HEIGHT,
    ROOM,
    assign,
    crossing_tips,
    invisible,
    plain_figure,
    run_lines,
    segments,
    side_strips,
    tips,
    unseen,
)
from pwsviz.geometry.numbers import MACHINE_EPSILON
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.geometry.shades import shade_names, shades_of
from pwsviz.results.states import StateCurves
from pwsviz.text.math_names import variable_name
from pwsviz.text.words import whose_marks

MOST_PANELS = 6
"""Most coordinates that are drawn: more panels would be too flat."""

MOST_MARKS = 400
"""Most crossings that are marked, and segments that are shaded; more of them could not be told apart."""

MARK = 6
"""Size in pixels of the mark of a crossing."""

MARGIN = 0.04
"""Margin of a panel above and below its curves, relative to their range."""

WIDEST = 3.0
"""Ranges of the first integrator that the axis may hold; one that runs off leaves the picture."""

LOWEST_PANEL = 80
"""Pixels of the height of a panel, at least, without legend and label."""

LEGEND_HEIGHT = 64
"""Pixels of the lowest panel that its legend and the label of its axis take."""

LEFT = 64
"""Pixels left of each panel, so that their axes stand below one another."""

ROUND_OFF = 4.0
"""Units of round-off of the larger end of a range within which its other end is told as 0."""

FARTHEST = 100.0
"""Heights of a panel up to which curves leave it: browsers draw no dashes on lines that are longer by far."""

SUMMARY = "Coordinate against time"


class Shared:
    """What all panels show alike: the time, the sides occupied and the crossings of the first integrator."""

    def __init__(self) -> None:
        self.across = Range1d(start=0.0, end=1.0)
        self.segments = {side: ColumnDataSource({"start": [], "end": []}) for side in OCCUPIED}
        columns = ("t", "x", "y", "label", "kind", "marker", "colour", "size", "number", "method")
        self.t_end = 1.0
        self.instants = unseen((*columns, *map(_column, range(MOST_PANELS))))

    def look_at(self, t_end: float) -> None:
        """Show the whole time, and a little more, so that the marks at its ends are whole."""
        self.t_end, beside = t_end, BESIDE * t_end
        ends = {"start": -beside, "end": t_end + beside}
        self.across.update(**ends, **{f"reset_{end}": place for end, place in ends.items()})


def _column(k: int) -> str:
    """Column of the k-th coordinate at the crossings."""
    return f"state{k}"


class Panel:
    """One coordinate against time; `show` only changes its data."""

    def __init__(self, k: int, shared: Shared) -> None:
        self.up = DataRange1d(range_padding=0)
        self.figure = plain_figure(SUMMARY, x_range=shared.across, y_range=self.up, min_border_left=LEFT)
        self.figure.yaxis.major_label_policy = NoOverlap(min_distance=2)  # panels may be flat
        self.bands = {
            side: self.figure.add_glyph(source, side_strips(side)) for side, source in shared.segments.items()
        }
        self.curves = ColumnDataSource({name: [] for name in ("xs", "ys", *LOOK_COLUMNS, "width")})
        self.steps = ColumnDataSource({name: [] for name in ("t", "y", "colour")})
        # Below the curves: dots of one integrator would hide the curve of another.
        self.figure.add_glyph(self.steps, Scatter(x="t", line_color="colour", fill_color="colour", size=4))
        self.lines = self.figure.add_glyph(self.curves, run_lines())
        self.corners = ColumnDataSource({"x": [0.0, 0.0], "y": [-1.0, 1.0]})
        self.up.renderers = [self.figure.add_glyph(self.corners, invisible(size=1))]
        # The browser keeps what it last saw of a panel that went, and would join it to what is seen once it is back.
        self.corners.js_on_change("data", CustomJS(args={"up": self.up}, code="up._plot_bounds.clear()"))
        self.marks, self.hover = self._add_marks(_column(k), shared.instants)
        entries = [({"field": "method"}, self.lines), *shade_keys(self.figure), ({"field": "label"}, self.marks.key)]
        self.entries = legend_below(self.figure, entries)
        attach_shades(self.figure, self.bands, self.entries[1:-1])

    def _add_marks(self, column: str, instants: ColumnDataSource) -> tuple[Marks, HoverTool]:
        plot = self.figure
        marks = Marks(plot, instants, "t", column, width=1.8, same=SAME_INSTANT)
        reach = plot.add_glyph(instants, invisible(x="t", y=column, size=14))  # easier to hit than the mark
        hover = crossing_tips(reach, "t")
        rows = [("integrator", "@method"), ("time", "$snap_x{6}"), ("value", "$snap_y{6}")]
        values = tips(rows, renderers=[self.lines], line_policy="nearest", attachment="horizontal", visible=False)
        plot.add_tools(hover, values)
        return marks, hover

    def forget_range(self) -> None:
        """Let the range follow the data where the panel is sent anew: the browser keeps ends that it is sent."""
        self.up.update(start=math.nan, end=math.nan)

    def place(self, name: str, panels: int, lowest: bool) -> None:
        """Name the coordinate, and give the panel its part of the height; the lowest one has the legend."""
        self.figure.yaxis.axis_label = variable_name(name)
        self.figure.xaxis.axis_label = "time t" if lowest else None
        self.figure.xaxis.major_label_text_alpha = 1.0 if lowest else 0.0
        self.figure.legend.visible = lowest
        apart = LEGEND_HEIGHT * (panels > 1)
        extra = f" + {apart}px + {ROOM}" if lowest else ""
        each = f"max({LOWEST_PANEL}px, ({HEIGHT} - {apart}px) / {panels})"
        self.figure.styles = {"height": f"calc({each}{extra})", "flex": "none"}

    def show(self, k: int, runs: Sequence[StateCurves]) -> None:
        """Draw the k-th coordinate of the runs."""
        low, high = _range([run.bounds[k] for run in runs])
        reach = FARTHEST * (high - low)
        self.curves.data = {
            "xs": [run.curves[k][0] for run in runs],
            "ys": [np.clip(run.curves[k][1], low - reach, high + reach) for run in runs],
            **look_columns([run.method for run in runs]),
            "width": widths_in_time(run.method for run in runs),
        }
        assign(
            self.steps,
            t=np.concatenate([run.steps[0] for run in runs]),
            y=np.concatenate([run.steps[1][:, k] for run in runs]),
            colour=[line_of(run.method).colour for run in runs for _ in run.steps[0]],
        )
        assign(self.corners, x=[0.0, 0.0], y=[low, high])


class StateView:
    """Panels that share the axis of time, each made when a system first needs it."""

    def __init__(self) -> None:
        self.shared = Shared()
        self.panels: list[Panel] = []
        self.drawn = 0  # of these, from the first on

    def panel(self, k: int) -> Panel:
        """Return the k-th panel."""
        while len(self.panels) <= k:
            self.panels.append(Panel(len(self.panels), self.shared))
        return self.panels[k]

    def show(self, runs: Sequence[StateCurves], names: Sequence[str], first: core.Trajectory, places: Floats) -> None:
        """Draw the runs of one scene.

        Parameters
        ----------
        runs : sequence of StateCurves
            One for each integrator.
        names : sequence of str
            Names of the coordinates, of which the first `MOST_PANELS` are drawn.
        first : core.Trajectory
            The first integrator's run, whose crossings and sides are marked.
        places : (k, 2) array
            Place of each of its crossings in the portrait.
        """
        drawn, t_end = names[:MOST_PANELS], max(run.t_end for run in runs) or 1.0
        if self.shared.t_end != t_end:  # else the user's zoom stays
            self.shared.look_at(t_end)
        for panel in self.panels[self.drawn :]:
            panel.forget_range()
        self.drawn = len(drawn)
        for k, name in enumerate(drawn):
            self.panel(k).place(name, len(drawn), lowest=k + 1 == len(drawn))
            self.panel(k).show(k, runs)
        self._show_segments(first)
        self._show_crossings(first.crossings.first(MOST_MARKS), first.method, places[:MOST_MARKS])

    def _show_segments(self, run: core.Trajectory) -> None:
        label: Any
        bounds = np.concatenate([[run.t[0]], run.crossings.t, [run.t[-1]]])[: MOST_MARKS + 1]
        sides = shades_of(run.system, np.concatenate([run.mode[:1], run.crossings.mode])[:MOST_MARKS])
        names = shade_names(run.system)
        for k, (side, source) in enumerate(self.shared.segments.items()):
            shaded = segments(bounds, sides, side)
            for panel in self.panels:
                label = value(names.get(side, ""))
                if panel.entries[1 + k].label != label:  # each change rebuilds the legend
                    panel.entries[1 + k].label = label
                panel.entries[1 + k].visible = len(shaded["start"]) > 0
            assign(source, **shaded)  # last: the browser hides the entry of shades that are too narrow

    def _show_crossings(self, crossings: core.Crossings, method: str, places: Floats) -> None:
        count = len(crossings)
        states = {_column(k): crossings.x[:, k] for k in range(min(crossings.x.shape[1], MOST_PANELS))}
        looks = kind_columns(tuple(map(str, crossings.kind)), [MARK] * count)
        for panel in self.panels:
            panel.marks.name(looks)
        states |= {_column(k): np.full(count, np.nan) for k in range(len(states), MOST_PANELS)}
        assign(
            self.shared.instants,
            t=crossings.t,
            x=places[:, 0],
            y=places[:, 1],
            **looks,
            number=np.arange(1, 1 + count),
            method=[method] * count,
            **states,
        )


def _range(bounds: Sequence[Floats]) -> tuple[float, float]:
    """Range that holds the first curve, and the others as far as they stay near it, and a margin."""
    low, high = bounds[0]
    around, size = 0.5 * (low + high), max(high - low, 1e-9 * abs(high), 1e-300)
    near = np.clip(np.array(bounds), around - 0.5 * WIDEST * size, around + 0.5 * WIDEST * size)
    margin = MARGIN * float(np.ptp(near))
    return float(near.min()) - margin, float(near.max()) + margin


def state_text(names: Sequence[str], runs: Sequence[StateCurves], crossings: int = 0) -> str:
    """Return the range of each coordinate drawn, of the first integrator's run, and what is not drawn.

    Parameters
    ----------
    names : sequence of str
        Names of the coordinates.
    runs : sequence of StateCurves
        One for each integrator.
    crossings : int
        How many crossings the first one's run has.
    """
    first = runs[0]
    ranges = [_told(name, runs, k) for k, name in enumerate(names[:MOST_PANELS])]
    off = " Its last part leaves the plot." if first.runs_off else ""
    more = f" Only the first {MOST_PANELS} of {len(names)} coordinates are drawn." if len(names) > MOST_PANELS else ""
    marks = f" {whose_marks([run.method for run in runs], crossings)}".rstrip() + _how_many(crossings)
    return f"{first.method} up to t = {first.t_end:.4g}: {', '.join(ranges)}.{off}{more}{marks}"


def panel_text(name: str, runs: Sequence[StateCurves], k: int) -> str:
    """Return what the panel of the k-th coordinate shows, for screen readers."""
    others = f", and {', '.join(run.method for run in runs[1:])} beside it" if len(runs) > 1 else ""
    return f"{SUMMARY.replace('Coordinate', f'Coordinate {name}')}. {runs[0].method}: {_told(name, runs, k)}{others}."


def _told(name: str, runs: Sequence[StateCurves], k: int) -> str:
    """Return the range of the first run in words, to the ends of the axis where it is cut; mere round-off is 0."""
    ends = runs[0].reached[k]
    seen = np.clip(ends, *_range([run.bounds[k] for run in runs]))
    below, above = ends != seen
    low, high = np.where(np.abs(seen) < ROUND_OFF * MACHINE_EPSILON * np.abs(seen).max(), 0.0, seen)
    if below and above:
        return f"{name} drawn from {low:.4g} to {high:.4g}"
    if below:
        return f"{name} up to {high:.4g}, drawn down to {name} = {low:.4g}"
    return f"{name} from {low:.4g}{f', drawn up to {name} =' if above else ' to'} {high:.4g}"


def _how_many(crossings: int) -> str:
    """Say that not all crossings are marked, if they are too many."""
    if crossings <= MOST_MARKS:
        return ""
    return f" Only the first {MOST_MARKS} of {crossings:,} crossings are marked; the sides are shaded up to there."
