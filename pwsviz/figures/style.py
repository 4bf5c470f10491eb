"""The common look of the figures, and what several of them draw."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from bokeh.models import (
    ColumnDataSource,
    CustomJS,
    CustomJSHover,
    CustomJSTickFormatter,
    CustomLabelingPolicy,
    DataRange1d,
    FixedTicker,
    HoverTool,
    LogAxis,
    WheelZoomTool,
)
from bokeh.models.annotations import Span
from bokeh.models.glyphs import MultiLine, Scatter, VStrip
from bokeh.models.renderers import GlyphRenderer
from bokeh.plotting import figure
from numpy.typing import NDArray

from pwsviz.figures.colours import (
    GREY,
    OCCUPIED,
    OPACITY,
    RULE,
)
from pwsviz.figures.keys import FOCUS_CSS, REACHED, attach_keys
from pwsviz.figures.lines import (
    LEGEND_WIDTH,
    LOOK_COLUMNS,
    look_columns,
)
from pwsviz.figures.sent_arrays import sent
from pwsviz.figures.ticks import print_ticks
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.text.numbers import PRINTED, printed

HEIGHT = "clamp(340px, min(100vh - var(--rest, 15.6rem) - var(--above, 0px), 90vw, 400px + 30vw), 1400px)"
"""CSS height of a figure: what the screen leaves free, but neither too flat nor too tall for its width, also where the
window is; a lecture sets the two."""

ROOM = "var(--legend, 0px)"
"""CSS height by which a legend is taller than usual, set by `legends`: added to a figure, whose frame then stays."""

PLOT_STYLES = {"height": f"calc({HEIGHT} + {ROOM})", "flex": "none"}

WITH_TABLE = {"height": f"calc(max(14rem + 76px, {HEIGHT} - var(--table, 190px)) + {ROOM})", "flex": "none"}
"""Styles of a figure that leaves room on the screen for a table below; a lecture leaves room for all that is told."""

TOOLS_CSS = ":host { pointer-events: none; } :host > * { pointer-events: auto; }"
"""Style sheet of the tools: beside them, what lies below takes the pointer, as in a lecture they lie in the figure."""

FRAME = 0.25
"""Opacity of the frame of a figure on the page, on light and on dark ground."""

NEAR_ROUND_OFF = 100.0
"""Ratio of the least error to the level of round-off up to which an axis goes down to that level."""

FAINT = 128.0
"""Part of the level of round-off at which smaller errors and exact zeros are drawn, as ε/8 is to 16ε."""

TIP_CSS = """
.bk-Tooltip { color: var(--mui-palette-text-primary, black); background: var(--mui-palette-background-paper, white);
              border-color: var(--mui-palette-divider, #808080); opacity: 1; }
[data-dragging] .bk-Tooltip { visibility: hidden; }
"""
"""Style sheet of the whole page, for what tells of the place under the pointer: Bokeh adds that to the page itself.
While a star is dragged, it would tell of where the pointer was before."""

TIP_CELLS = "display: grid; grid-template-columns: max-content 1fr; gap: 0 8px"
"""Of its labels and texts."""

TIP_NUMBER = f"{PRINTED}return printed(String(Number(value.toPrecision(Number(format)))))"
"""JavaScript that prints one of its numbers, to as many digits as its format says."""


def plain_figure(summary: str, **options: Any) -> figure:
    """Make a figure with the common look.

    Parameters
    ----------
    summary : str
        What the figure shows, for screen readers: the beginning of a sentence.
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
        "html_attributes": {**_named(summary[:1].upper() + summary[1:]), **REACHED},
        "stylesheets": [FOCUS_CSS],
    }
    plot = figure(**{**settings, **options})
    for wheel in plot.select(WheelZoomTool):  # without Ctrl the wheel scrolls the page
        wheel.update(modifiers="ctrl", zoom_on_axis=False, description="Zoom with Ctrl and the wheel")
    print_ticks(plot)
    attach_keys(plot)
    # In the browser the theme of the page leaves out the frame on light ground alone; in print it is always there.
    plot.js_on_change("outline_line_alpha", CustomJS(code=f"cb_obj.outline_line_alpha = {FRAME}"))
    plot.toolbar.logo = None
    plot.toolbar.autohide = True
    plot.toolbar.stylesheets = [TOOLS_CSS]
    return plot


def describe(plot: figure, words: str) -> None:
    """Name and describe a figure for screen readers; the browser applies it at once.

    The name, which is heard whenever the focus comes to the figure, are the words before the first comma, colon or end
    of a sentence; the others are its description, which may be passed over.
    """
    plot.html_attributes = {**plot.html_attributes, **_named(printed(words))}


def described(plot: figure) -> str:
    """Return name and description of a figure, as one text."""
    name, words = (str(plot.html_attributes[key]) for key in ("aria-label", "aria-description"))
    return f"{name}{'. ' if words[:1].isupper() else ', '}{words}" if words else name


def _named(words: str) -> dict[str, str]:
    name, _, others = [*re.split("([,:.]) ", words, maxsplit=1), "", ""][:3]
    return {"aria-label": name, "aria-description": others}


def tips(rows: list[tuple[str, str]], **options: Any) -> HoverTool:
    """Make a tool that tells of what is under the pointer, in the colours of the page.

    Parameters
    ----------
    rows : list of (label, text)
        As of a `HoverTool`; ``@t{6}`` is a number of the column ``t`` as it is printed, to six digits.
    **options
        Passed on to `HoverTool`.
    """
    cells = "".join(f'<span style="opacity: 0.75">{label}</span><span>{text}</span>' for label, text in rows)
    numbers = re.findall(r"([@$]\w+){[0-9]+}", cells)
    formatters: dict[str, Any] = dict.fromkeys(numbers, CustomJSHover(code=TIP_NUMBER))
    return HoverTool(tooltips=f'<div style="{TIP_CELLS}">{cells}</div>', formatters=formatters, **options)


def crossing_tips(reach: GlyphRenderer[Any], time: str, run: str = "@method") -> HoverTool:
    """Make a tool that tells of a crossing in two lines, beside it: above it they might be cut by the window's edge.

    Parameters
    ----------
    reach
        Marks with columns ``label`` and ``number``.
    time
        The column of its time.
    run
        Of which run it is.
    """
    rows = [("@label @number", f"t = @{time}{{9}}"), ("of", run)]
    return tips(rows, renderers=[reach], attachment="horizontal", visible=False, limit=2)


BESIDE = 0.025
"""Part of an axis before the first and after the last mark, so that both are whole on a phone, too."""

LEVEL: dict[str, Any] = {"line_color": RULE, "line_dash": "dotted", "line_width": 1.5}
"""Look of what marks a level."""


BELOW_RANGE = "\ntiny, or 0:\ndrawn here"
"""Name of the level at which smaller errors are drawn; its first line is empty, so that it stands below its level.

In a narrow picture a name ends before its colon or its “=”."""

APART = """
const seen = [...ticker.ticks].filter(tick => range.min <= tick && tick <= range.max)
const places = seen.map((tick, k) => {
  const lines = names.compute(tick).split("\\n"), { top, bottom } = bboxes[k], line = (bottom - top) / lines.length
  const blank = Math.max(0, lines.findIndex(words => words != ""))
  return { top: top + (blank + SPARE) * line, bottom: bottom - SPARE * line }
})
const touch = (one, other) => one.top < other.bottom && other.top < one.bottom
const kept = []
for (let k = seen.length - 1; k >= 0; k--) {
  if (!kept.some(other => touch(places[k], places[other]))) { kept.push(k) }
}
return kept.reverse()
""".replace("SPARE", "0.12")
"""JavaScript that leaves out names that would lie over later ones, in a low figure or in large type; spare is the room
above and below letters, in lines. A picture for print, which has other sizes, places names for itself."""


@dataclass(frozen=True)
class NamedLevels:
    """Horizontal lines across a plot, labelled at its right edge."""

    ticker: FixedTicker
    names: CustomJSTickFormatter
    spans: list[Span]

    def move(self, *levels: float) -> None:
        """Move the lines to other heights."""
        self.names.args = {**self.names.args, "levels": list(levels)}
        self.ticker.ticks = list(levels)
        for span, level in zip(self.spans, levels, strict=True):
            span.location = level


def mark_levels(plot: figure, levels: dict[float, str]) -> NamedLevels:
    """Draw labelled lines across a logarithmic plot; the labels are at its right edge, where no curve runs.

    Where there is no room for all labels, those of the last levels are shown.
    """
    ticker = FixedTicker(ticks=list(levels))
    spans = [Span(location=level, dimension="width", **LEVEL) for level in levels]
    # Labels are looked up by height, since the browser numbers only the ticks in view.
    args = {"names": list(levels.values()), "levels": list(levels)}
    names = CustomJSTickFormatter(args=args, code="return names[levels.indexOf(tick)] ?? ''")
    apart = CustomLabelingPolicy(args={"ticker": ticker, "names": names, "range": plot.y_range}, code=APART)
    labels: dict[str, Any] = {"ticker": ticker, "formatter": names, "major_label_policy": apart}
    plot.add_layout(LogAxis(**labels), "right")
    for span in spans:
        plot.add_layout(span)
    return NamedLevels(ticker, names, spans)


def fit_to_corners(plot: figure, x: list[float], y: list[float]) -> ColumnDataSource:
    """Let the ranges follow two invisible corner points and nothing else; return the source of these points."""
    corners = ColumnDataSource({"x": x, "y": y})
    renderer = plot.add_glyph(corners, invisible(size=1))
    for axis in ranges(plot):
        axis.renderers = [renderer]
    return corners


def lowest(errors: Floats, level: float) -> float:
    """Return where an axis of errors ends: at the level of round-off if the least positive one is near it, else there.

    An axis without positive errors ends at the level, too.
    """
    least = float(errors[errors > 0].min(initial=np.inf))
    return least if NEAR_ROUND_OFF * level < least < np.inf else min(least, level)


def invisible(**place: Any) -> Scatter:
    """Return marks that are not seen: points to fit a range to, or to be hit by the pointer."""
    return Scatter(fill_alpha=0.0, line_alpha=0.0, **place)


def run_lines() -> MultiLine:
    """Return the curves of runs against time, each in the look of its integrator.

    Round joins tell those who print a picture that a dashed curve may lie on another (see `pictures.js`).
    """
    return MultiLine(line_color="colour", line_dash="dash", line_width="width", line_join="round")


def side_strips(side: int) -> VStrip:
    """Return the shade of the times between ``start`` and ``end``, which a run spends on one side, or sliding."""
    return VStrip(x0="start", x1="end", fill_color=OCCUPIED[side][1], fill_alpha=OPACITY[side], line_width=0)


def segments(t: Floats, sides: NDArray[np.int64], side: int) -> dict[str, Floats]:
    """Return the columns of `side_strips` for one side, from the ends of segments and the sides of the first ones.

    Segments that follow one another on the same side, between which the state jumps, are one.
    """
    first = np.flatnonzero(np.append(True, sides[1:] != sides[:-1])[: len(sides)])
    starts, ends = t[first], t[np.append(first[1:], len(sides))[: len(first)]]
    there = (sides[first] == side) & (ends > starts)
    return {"start": starts[there], "end": ends[there]}


def ranges(plot: figure) -> tuple[DataRange1d, DataRange1d]:
    """Return the ranges of a figure; TypeError unless they follow data."""
    across, up = plot.x_range, plot.y_range
    if not (isinstance(across, DataRange1d) and isinstance(up, DataRange1d)):
        raise TypeError("the ranges of a figure on this page follow its data")
    return across, up


def legend_lines(plot: figure) -> tuple[ColumnDataSource, Any]:
    """Return a source of methods, whose looks `show_methods` sets, and what a legend draws of them: no curve."""
    source = ColumnDataSource({name: [] for name in ("xs", "ys", *LOOK_COLUMNS, "stroke")})
    look: dict[str, Any] = {"line_color": "colour", "line_dash": "stroke", "line_width": LEGEND_WIDTH}
    return source, plot.add_glyph(source, MultiLine(**look))


def show_methods(source: ColumnDataSource, methods: Iterable[str], strokes: Mapping[str, Any] | None = None) -> None:
    """Name these integrators in a legend made of `legend_lines`; `strokes` are those of curves without their dashes."""
    names = list(dict.fromkeys(methods))
    looks, nowhere = look_columns(names), [[np.nan]] * len(names)
    stroke = [(strokes or {}).get(name, dash) for name, dash in zip(names, looks["dash"], strict=True)]
    if names != source.data["method"] or stroke != source.data["stroke"]:
        source.data = {"xs": nowhere, "ys": nowhere, **looks, "stroke": stroke}


def unseen(columns: Iterable[str]) -> ColumnDataSource:
    """Return a source of one mark without a place (NaN).

    A legend may be drawn before the first marks arrive, and the browser cannot draw the entry of a glyph without marks.
    """
    words = {"marker": "circle", "colour": GREY, "fill": GREY, "label": "crossing", "kind": "crossing"}
    return ColumnDataSource({name: [words.get(name, np.nan)] for name in columns})


def assign(source: ColumnDataSource, **columns: Any) -> None:
    """Give a source new data unless they equal its own, which saves sending and painting them."""
    if source.data.keys() != columns.keys() or any(_differ(source.data[name], columns[name]) for name in columns):
        source.data = {name: sent(column) for name, column in columns.items()}


def _differ(old: Any, new: Any) -> bool:
    """Whether two columns differ; NaN, which ends a piece of a line, equals NaN."""
    if len(old) != len(new):
        return True
    if len(new) and isinstance(new[0], list | np.ndarray):  # cells may differ in length
        return any(map(_differ, old, new))
    old, new = np.asarray(old), np.asarray(new)
    numbers = old.dtype.kind == new.dtype.kind == "f"
    return not np.array_equal(old, new, equal_nan=numbers)


def refit(plot: figure) -> None:
    """Undo the user's zoom, so that the ranges follow their data again.

    The browser resumes following whenever a property of the range changes; ``default_span``, toggled here, matters only
    for data of a single point.
    """
    for axis in ranges(plot):
        axis.default_span = 1.0 if axis.default_span == 2.0 else 2.0
