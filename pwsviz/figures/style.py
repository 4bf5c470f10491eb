"""Colours, dashes and the common look of the figures, legible without telling colours apart."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from bokeh.models import (
    ColumnDataSource,
    CustomJS,
    CustomJSHover,
    CustomJSTickFormatter,
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

import core
from pwsviz.figures.keys import FOCUS_CSS, REACHED, attach_keys
from pwsviz.figures.sent_arrays import sent
from pwsviz.figures.ticks import print_ticks
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.text.numbers import PRINTED, printed

# Of light ground. Each has 3:1 or more on every shade of a figure, and 4.5:1 on the page itself, so that none is pale;
# any two differ in the common kinds of colour blindness, too.
BLUE = "#0064A6"
VERMILION = "#A23400"
GREEN = "#00885A"
ORANGE = "#B26800"
SKY = "#69769F"
CALM = "#C3D0EE"  # of areas that recede: lighter than every other colour, in print too
PURPLE = "#994F71"
VIOLET = "#9006F0"
OCHRE = "#837738"
BROWN = "#6D512D"
BERRY = "#752355"
AMBER = "#7F5300"  # of marks alone
LAKE = "#2B7CA8"  # of level sets, with sand
SAND = "#776B52"
GREY = "#4A4A4A"
PALE_GREY = "#767676"
GROUND = "#FEFEFE"  # behind names among curves: a white that is another one in the dark

RULE = "#7A7A7A"
"""Grey of what Bokeh draws beside the glyphs, which keeps its colour: as far from light as from dark ground."""

ON_DARK = {
    BLUE: "#2D81C7", VERMILION: "#D55E01", GREEN: "#19A87B", ORANGE: "#E9A005", SKY: "#65BEF3", PURPLE: "#E18DBC",
    VIOLET: "#BD31FF", OCHRE: "#BDA55D", BROWN: "#947947", BERRY: "#B7608F", AMBER: "#C98A10", LAKE: "#5DB3E6",
    SAND: "#B5A88F", CALM: "#34507A", GREY: "#A8A8A8", PALE_GREY: "#CFCFCF", GROUND: "#121212",
}  # fmt: skip
"""The same on dark ground, where the browser paints these in their place (see `widgets.browser`)."""

SHADES = {-1: "#56B4E9", 1: "#D9B84A", 2: "#D55E00", 3: "#9000F0", 0: "#009E73"}
"""Colour of each shade of ground, painted transparently, on light and on dark."""

SIDES = {-1: LAKE, 1: SAND}
"""Colour of lines on each side of the surface; of several, in the first two shades of regions."""

OCCUPIED = {
    shade: (name, SHADES[shade]) for shade, name in {-1: "g < 0", 1: "g > 0", 2: "", 3: "", 0: "sliding"}.items()
}
"""Name, of one surface, and colour of where a run is, by its shade: on a side, in a further region, or sliding."""

SURFACE: dict[str, Any] = {"line_color": PURPLE, "line_cap": "square"}
"""Look of the lines of surfaces; pictures know these by their ends."""

TINT = 0.13
"""Opacity of the first shade in the portrait, beneath arrows and level sets."""

OPACITY = {-1: 0.19, 1: 0.14, 2: 0.2, 3: 0.14, 0: 0.19}
"""Opacity of each shade behind curves against time."""

PRINTED_OPACITY = {SHADES[shade]: opacity for shade, opacity in {-1: 0.45, 1: 0.15, 2: 0.45, 3: 0.4, 0: 0.55}.items()}
"""Opacity in print of each colour of `SHADES`, in every figure; without colours, too, they differ."""

HEIGHT = "clamp(340px, min(100vh - var(--rest, 15.6rem), 90vw), 1400px)"
"""CSS height of a figure: what the screen leaves free, but neither too flat nor too tall; a lecture sets `--rest`."""

ROOM = "var(--legend, 0px)"
"""CSS height by which a legend is taller than usual, set by `legends`: added to a figure, whose frame then stays."""

PLOT_STYLES = {"height": f"calc({HEIGHT} + {ROOM})", "flex": "none"}

WITH_TABLE = {"height": f"calc(max(300px, {HEIGHT} - 190px) + {ROOM})", "flex": "none"}
"""Styles of a figure that leaves room on the screen for a small table below it."""

FRAME = 0.25
"""Opacity of the frame of a figure on the page, on light and on dark ground."""

TIP_CSS = """
.bk-Tooltip { color: var(--mui-palette-text-primary, black); background: var(--mui-palette-background-paper, white);
              border-color: var(--mui-palette-divider, #808080); opacity: 1; }
"""
"""Style sheet of the whole page, for what tells of the place under the pointer: Bokeh adds that to the page itself."""

TIP_CELLS = "display: grid; grid-template-columns: max-content 1fr; gap: 0 8px"
"""Of its labels and texts."""

TIP_NUMBER = f"{PRINTED}return printed(String(Number(value.toPrecision(Number(format)))))"
"""JavaScript that prints one of its numbers, to as many digits as its format says."""


class Line(NamedTuple):
    """The look of one curve."""

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
"""Looks of the integrators of each family, in their order (cyclically); all differ in colour and in dash."""

WIDEST = 4.5
"""Width in pixels of the first of several curves that are drawn together."""

NARROWEST = 1.6
"""Width of the last of them, and of a curve against time that is alone."""

SLIM = 0.7
"""Widths of curves against time, relative to those of curves in the plane."""

NEAR_ROUND_OFF = 100.0
"""Ratio of the least error to the level of round-off up to which an axis goes down to that level."""

LEGEND_WIDTH = 2.5
"""Width in pixels of a line in every legend, whatever its width in the plot."""


def line_of(method: str) -> Line:
    """Return the look of an integrator, the same in every plot."""
    family = type(core.METHODS[method].scheme)
    looks = LOOKS[family.__name__]
    members = [name for name, one in core.METHODS.items() if type(one.scheme) is family]
    return looks[members.index(method) % len(looks)]


def on_either_ground(colour: str) -> str:
    """Return the CSS of a colour, which is that of `ON_DARK` on a dark page."""
    return f"light-dark({colour}, {ON_DARK[colour]})"


def together(lines: Iterable[Line]) -> list[Line]:
    """Return the looks of curves that are drawn together, each over those before it.

    Alike ones are solid, for there is none to tell apart. Else each look is narrower than those before it, which are so
    seen beside it where the curves coincide.
    """
    found = list(lines)
    looks = list(dict.fromkeys(found))
    if len(looks) == 1:
        return [line._replace(dash=()) for line in found]
    widths = dict(zip(looks, np.linspace(WIDEST, NARROWEST, len(looks)).tolist(), strict=True))
    return [line._replace(width=widths[line]) for line in found]


def widths_in_time(methods: Iterable[str]) -> list[float]:
    """Return the widths of curves of integrators against time, where they wind closely."""
    lines = together(map(line_of, methods))
    alike = len(set(lines)) == 1
    return [NARROWEST if alike else SLIM * line.width for line in lines]


LOOK_COLUMNS = ("method", "colour", "dash", "marker")
"""Columns of curves by integrator, see `look_columns`; in print dashed ones have markers (see `picture_markers.js`)."""


def look_columns(methods: Sequence[str]) -> dict[str, list[Any]]:
    """Return `LOOK_COLUMNS` of curves that are drawn together, of these integrators."""
    lines = together(map(line_of, methods))
    return {
        "method": list(methods),
        "colour": [line.colour for line in lines],
        "dash": [list(line.dash) for line in lines],
        "marker": [line.marker for line in lines],
    }


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
        "html_attributes": {"role": "img", "aria-label": summary[:1].upper() + summary[1:], **REACHED},
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
    return plot


def describe(plot: figure, words: str) -> None:
    """Set the description of a figure for screen readers; the browser applies it at once."""
    plot.html_attributes = {**plot.html_attributes, "aria-label": printed(words)}


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


BELOW_RANGE = "\nbelow plot\nrange, or 0"
"""Name of the level at which smaller errors are drawn; its first line is empty, so that it stands below its level."""


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
    """Draw labelled lines across a logarithmic plot; the labels are at its right edge, where no curve runs."""
    ticker = FixedTicker(ticks=list(levels))
    spans = [Span(location=level, dimension="width", **LEVEL) for level in levels]
    # Labels are looked up by height, since the browser numbers only the ticks in view.
    args = {"names": list(levels.values()), "levels": list(levels)}
    names = CustomJSTickFormatter(args=args, code="return names[levels.indexOf(tick)] ?? ''")
    labels: dict[str, Any] = {"ticker": ticker, "formatter": names}
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
    """Return the curves of runs against time, each in the look of its integrator."""
    return MultiLine(line_color="colour", line_dash="dash", line_width="width")


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
    source = ColumnDataSource({name: [] for name in ("xs", "ys", *LOOK_COLUMNS)})
    look: dict[str, Any] = {"line_color": "colour", "line_dash": "dash", "line_width": LEGEND_WIDTH}
    return source, plot.add_glyph(source, MultiLine(**look))


def show_methods(source: ColumnDataSource, methods: Iterable[str]) -> None:
    """Name these integrators in a legend made of `legend_lines`."""
    names = list(dict.fromkeys(methods))
    if names == source.data["method"]:
        return
    nowhere = [[np.nan]] * len(names)
    source.data = {"xs": nowhere, "ys": nowhere, **look_columns(names)}


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
