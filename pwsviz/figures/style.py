"""Colours, dashes and the common look of the figures: calm, and readable without telling colours apart."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from bokeh.models import (
    ColumnDataSource,
    CustomJS,
    CustomJSTickFormatter,
    DataRange1d,
    FixedTicker,
    LogAxis,
    WheelZoomTool,
)
from bokeh.models.annotations import Legend, LegendItem, Span
from bokeh.plotting import figure

import core

# The palette of Okabe and Ito, legible in the common kinds of colour blindness, on light and dark ground alike.
BLUE, VERMILION, GREEN, ORANGE, SKY, PURPLE = "#0072B2", "#D55E00", "#009E73", "#E69F00", "#56B4E9", "#CC79A7"
# Four more, as far from those and from one another as these are, in the same kinds of colour blindness.
VIOLET, OCHRE, BROWN, BERRY = "#9000F0", "#C0A860", "#786030", "#903C6C"
GREY = "#808080"
SAND = "#A89A80"

SIDES = {-1: SKY, 1: SAND}
HEIGHT = "clamp(340px, min(100vh - 250px, 100vw), 720px)"
"""Of a figure on the page: what the screen has left, within reason."""


PLOT_STYLES = {"height": HEIGHT, "flex": "none"}


class Line(NamedTuple):
    """How one curve is drawn."""

    colour: str
    dash: tuple[int, ...]
    marker: str
    width: float


LOOKS: dict[str, tuple[Line, ...]] = {
    "DiscreteMultiplier": (Line(BLUE, (), "circle", 4.5),),
    "Composition": (
        Line(SKY, (14, 4), "hex", 1.6),
        Line(PURPLE, (10, 4, 2, 4), "diamond", 1.6),
        Line(ORANGE, (3, 3), "inverted_triangle", 2.4),
    ),
    "ButcherTableau": (
        Line(VERMILION, (8, 6), "square", 1.6),
        Line(GREEN, (4, 4), "triangle", 1.6),
        Line(BROWN, (10, 4, 2, 4, 2, 4), "star", 1.6),
        Line(BERRY, (2, 5), "y", 2.4),
    ),
    "Projected": (Line(OCHRE, (6, 2), "plus", 2.4),),
    "TaylorSeries": (Line(VIOLET, (14, 4, 5, 4), "asterisk", 1.6),),
}
"""Of each family's integrators, in their order, and then again from the first: no two agree in colour, nor in dash."""

LEGEND_GLYPH = 34
"""Pixels of line in a legend: the longest pattern of dashes once and a little more."""


def line_of(method: str) -> Line:
    """Return the look of an integrator, the same in every plot."""
    family = type(core.METHODS[method].scheme)
    looks = LOOKS[family.__name__]
    members = [name for name, one in core.METHODS.items() if type(one.scheme) is family]
    return looks[members.index(method) % len(looks)]


def plain_figure(summary: str, **options: Any) -> figure:
    """Make a figure with the common look.

    Parameters
    ----------
    summary : str
        What the figure shows, for those who cannot see it.
    **options
        Passed on to `bokeh.plotting.figure`.
    """
    settings: dict[str, Any] = {
        "sizing_mode": "stretch_width",
        "styles": PLOT_STYLES,
        "tools": "pan,wheel_zoom,box_zoom,reset,save",
        "toolbar_location": "above",
        "active_drag": None,
        "output_backend": "canvas",
        "min_border_right": 12,
        "html_attributes": {"role": "img", "aria-label": summary},
    }
    plot = figure(**{**settings, **options})
    for wheel in plot.select(WheelZoomTool):  # the bare wheel scrolls the page
        wheel.update(modifiers="ctrl", zoom_on_axis=False)
    plot.toolbar.logo = None
    plot.toolbar.autohide = True
    return plot


def describe(plot: figure, words: str) -> None:
    """Say what a figure shows now, for those who cannot see it; the browser takes it over at once."""
    plot.html_attributes = {**plot.html_attributes, "aria-label": words}


@dataclass(frozen=True)
class NamedLevels:
    """Heights marked across a plot."""

    ticker: FixedTicker
    names: CustomJSTickFormatter
    spans: list[Span]

    def move(self, *levels: float) -> None:
        """Put the marks at other heights."""
        self.names.args = {**self.names.args, "levels": list(levels)}
        self.ticker.ticks = list(levels)
        for span, level in zip(self.spans, levels, strict=True):
            span.location = level


def mark_levels(plot: figure, levels: dict[float, str]) -> NamedLevels:
    """Name heights of a logarithmic plot at its right edge, where no curve runs, each with a line across."""
    ticker = FixedTicker(ticks=list(levels))
    look: dict[str, Any] = {"line_color": GREY, "line_dash": "dotted", "line_width": 1.5}
    spans = [Span(location=level, dimension="width", **look) for level in levels]
    # By height: the browser counts only the ticks in view.
    args = {"names": list(levels.values()), "levels": list(levels)}
    names = CustomJSTickFormatter(args=args, code="return names[levels.indexOf(tick)] ?? ''")
    labels: dict[str, Any] = {"ticker": ticker, "formatter": names}
    plot.add_layout(LogAxis(**labels), "right")
    for span in spans:
        plot.add_layout(span)
    return NamedLevels(ticker, names, spans)


def fit_to_corners(plot: figure, x: list[float], y: list[float]) -> ColumnDataSource:
    """Let the ranges hold two corners, which are not drawn, and follow nothing else; return their source."""
    corners = ColumnDataSource({"x": x, "y": y})
    renderer = plot.scatter("x", "y", source=corners, alpha=0.0, size=1)
    for axis in ranges(plot):
        axis.renderers = [renderer]
    return corners


def ranges(plot: figure) -> tuple[DataRange1d, DataRange1d]:
    """Return the ranges of a figure, which all follow data."""
    across, up = plot.x_range, plot.y_range
    if not (isinstance(across, DataRange1d) and isinstance(up, DataRange1d)):
        raise TypeError("the ranges of a figure on this page follow its data")
    return across, up


def legend_below(plot: figure, columns: int, entries: list[tuple[Any, Any]], widest: int = 115) -> list[LegendItem]:
    """Put a legend under the plot, where it covers nothing, and return its entries.

    Parameters
    ----------
    plot : figure
        Gets the legend.
    columns : int
        Entries a row, at the most.
    widest : int
        Pixels that an entry may need: of a narrow plot a row has so many fewer.
    entries : list of (label, renderer)
        A label is a text, or ``{"field": name}`` for one entry per distinct value in that column.
    """
    items = [LegendItem(label=label, renderers=[renderer]) for label, renderer in entries]
    look: dict[str, Any] = {"orientation": "horizontal", "ncols": columns, "margin": 0, "padding": 4}
    legend = Legend(items=items, location="center", glyph_width=LEGEND_GLYPH, **look)
    # The page's theme narrows the glyphs in the browser, so far that dashes could not be told apart.
    legend.js_on_change("glyph_width", CustomJS(code=f"cb_obj.glyph_width = {LEGEND_GLYPH}"))
    fewer = f"legend.ncols = Math.max(1, Math.min({columns}, Math.floor(cb_obj.outer_width / {widest})))"
    plot.js_on_change("outer_width", CustomJS(args={"legend": legend}, code=fewer))
    plot.add_layout(legend, "below")
    return items


def unseen(columns: Iterable[str]) -> ColumnDataSource:
    """Return a source of one mark that is nowhere.

    A legend may be drawn before the first marks have arrived at their glyph; the browser fails to draw a mark of none.
    """
    words = {"marker": "circle", "colour": GREY, "fill": GREY, "label": "crossing"}
    return ColumnDataSource({name: [words.get(name, np.nan)] for name in columns})


def assign(source: ColumnDataSource, **columns: Any) -> None:
    """Give a source of plain columns new data, unless they are what it has: what is not sent need not be painted."""
    if any(not np.array_equal(source.data[name], values) for name, values in columns.items()):
        source.data = columns


def refit(plot: figure) -> None:
    """Forget a zoom made by hand: the ranges follow their data again.

    The browser resumes following whenever a setting of the range changes; the one touched here matters only for a
    single point.
    """
    for axis in ranges(plot):
        axis.default_span = 1.0 if axis.default_span == 2.0 else 2.0
