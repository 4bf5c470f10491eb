"""A cloud of points in a figure: marks while few are in sight, an image of their numbers when many are."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from bokeh.models import ColumnDataSource, CustomJS, LinearColorMapper
from bokeh.models.glyphs import Image, Scatter
from bokeh.plotting import figure

from pwsviz.figures.style import assign, fit_to_corners, invisible, ranges, refit
from pwsviz.geometry.point_counts import LEVELS, PointCounts, Portion, extent_of, visible
from pwsviz.geometry.window import Window

__all__ = ["FEW", "PointCloud", "Portion"]

FEW = 4000
"""Most points in sight that are drawn as marks: of more, a browser takes longer to paint the marks than an image."""

MARK, LARGE_MARK = 4.0, 8.0
"""Diameters in pixels of a mark: usually, and where only `SPARSE` pixels have any."""

SPARSE = 200
"""Most pixels with points whose marks are large, as of a closed orbit, which would be lost in the figure."""

FAINTEST = 0.7
"""Opacity of a pixel with one point, where the fullest pixel has many."""

USUAL_SHAPE = (400, 560)
"""Rows and columns of pixels of a figure that no browser shows yet."""

MOST_PIXELS = 4_000_000
"""Most pixels of an image, so that a page that says it is huge does not exhaust the memory."""

FINE = 4
"""Pixels of a sharp image along each side of one on the screen: 600 and more an inch in a column of 85 mm."""

MARGIN, MARGIN_OF_A_LINE = 0.04, 0.2
"""Margin around all points, relative to their extent: usually, and along a line on which all lie."""

TELL = """
const wait = 80  // milliseconds between two messages, each of which brings a new image
seen.timer_ ??= setTimeout(() => {
  seen.timer_ = null
  const length = name => plot.properties[name].is_unset ? 0 : plot[name]  // it is, until the figure is laid out
  const [x, y] = ranges, size = [length("inner_height"), length("inner_width")]
  const followed = sources.flatMap((source, k) => Array.from(source.data["xy"[k]]))
  const away = (end, wanted, width) => Math.abs(end - wanted) > 1e-6 * Math.abs(width)
  const short = (low, high) => plot.match_aspect ? low > high : true  // at equal scales more is seen than asked for
  const late = (range, low, high) => away(range.start, low, high - low) && short(range.start, low)
    || away(range.end, high, high - low) && short(high, range.end)
  const [left, right, bottom, top] = followed
  if (!x.have_updated_interactively && late(x, left, right)) return  // it is about to follow, and to call this again
  if (!y.have_updated_interactively && late(y, bottom, top)) return
  const now = [x.start, x.end, y.start, y.end, ...size, ...followed, x.default_span]
  if (size[0] > 1 && now.every(Number.isFinite) && now.some((value, k) => value != seen.data.value[k])) {
    seen.data = { value: now }
  }
}, wait)
"""
"""JavaScript that tells the server what part of the plane the browser shows, and in how many pixels.

It adds what the ranges follow, by which the server knows of what was told before the browser had its last changes.
"""


def _nothing(_window: Window) -> Window | None:
    return None


class PointCloud:
    """Points of several kinds, each with its colour; `show` again with more of them as they come.

    Parameters
    ----------
    plot : figure
        Where they are drawn. Its ranges have to be `DataRange1d`, and follow the points until the user zooms.
    colours : sequence of str
        Colour of each kind as #RRGGBB, at most 15.
    on_window : callable, optional
        Called with the visible part of the plane, when the user has changed it.
    across : ColumnDataSource, optional
        Two places, x and y, of which the range of x follows the x instead of the points.

    Attributes
    ----------
    marks : list of GlyphRenderer
        What is drawn while few points are in sight, of each kind; the columns are x, y, and kind, counted from 1.
    image : GlyphRenderer
        What is drawn of many points.
    window : Window or None
        The visible part of the plane, as far as it is known.
    """

    def __init__(
        self,
        plot: figure,
        colours: Sequence[str],
        on_window: Callable[[Window], None] = lambda _window: None,
        across: ColumnDataSource | None = None,
    ) -> None:
        self.figure, self.colours, self._on_window = plot, tuple(colours), on_window
        self._portions: list[Portion] = []
        self._extent: Window | None = None
        self._least = 0.0
        self._around: Callable[[Window], Window | None] = _nothing
        self._counts: PointCounts | None = None
        self._in_sight = 0
        self._shape = USUAL_SHAPE
        self.window: Window | None = None
        self._picture = ColumnDataSource({name: [] for name in ("image", "x", "y", "dw", "dh")})
        palette = ["#00000000", *(f"{colour}{alpha:02X}" for colour in colours for alpha in _alphas())]
        mapper = LinearColorMapper(palette=palette, low=-0.5, high=len(palette) - 0.5)
        self.image = plot.add_glyph(
            self._picture, Image(image="image", x="x", y="y", dw="dw", dh="dh", color_mapper=mapper)
        )
        # A renderer for each kind, not a column of colours: while Bokeh takes longer columns, it may paint all rows by
        # the shorter column of colours before, and fail.
        self._few = [ColumnDataSource({"x": [], "y": [], "kind": []}) for _ in colours]
        looks = [Scatter(size=MARK, fill_color=colour, line_color=None) for colour in colours]
        self.marks = [plot.add_glyph(source, look) for source, look in zip(self._few, looks, strict=True)]
        self.corners = fit_to_corners(plot, [0.0, 1.0], [0.0, 1.0])
        if across is not None:
            ranges(plot)[0].renderers = [plot.add_glyph(across, invisible(size=1))]
        self._sources = [across or self.corners, self.corners]
        self._watch()

    def _watch(self) -> None:
        """Let the browser tell what it shows."""
        plot, (across, up) = self.figure, ranges(self.figure)
        for axis in (across, up):
            axis.range_padding = 0.0
        seen = ColumnDataSource({"value": []})
        given = {"plot": plot, "ranges": [across, up], "sources": self._sources, "seen": seen}
        tell = CustomJS(args=given, code=TELL)
        for source in {id(one): one for one in self._sources}.values():
            source.js_on_change("data", tell)
        for model, name in ((across, "start"), (across, "end"), (up, "start"), (up, "end")):
            model.js_on_change(name, tell)
        across.js_on_change("default_span", tell)
        for name in ("inner_width", "inner_height"):
            plot.js_on_change(name, tell)
        seen.on_change("data", lambda _attribute, _old, new: self._look_at(new["value"]))
        self._seen = seen

    def _followed(self) -> list[float]:
        """Return what the ranges follow, and the mark that `refit` changes, as the browser tells them."""
        x, y = (source.data[name] for source, name in zip(self._sources, "xy", strict=True))
        return [float(value) for value in (*x, *y, ranges(self.figure)[0].default_span)]

    def _look_at(self, told: Sequence[Any]) -> None:
        """Paint what the browser says it shows, unless it said so before it had the last changes."""
        left, right, bottom, top, rows, columns, *followed = (float(value) for value in told)
        if followed != self._followed():
            return
        if not (right > left and top > bottom and 1 <= rows * columns <= MOST_PIXELS):
            return
        window, shape = Window(left, right, bottom, top), (round(rows), round(columns))
        if (window, shape) != (self.window, self._shape):
            moved = window != self.window
            self.window, self._shape = window, shape
            self._recount()
            self._paint()
            if moved:
                self._on_window(window)

    # What is drawn ---------------------------------------------------------------------------------------------------

    @property
    def count(self) -> int:
        """Number of points."""
        return sum(len(portion.x) for portion in self._portions)

    def show(
        self, portions: Sequence[Portion], least: float = 0.0, around: Callable[[Window], Window | None] = _nothing
    ) -> None:
        """Draw these points, and no others; those that were drawn before and come first again are not counted anew.

        Parameters
        ----------
        portions
            The points. Of the same objects as before, and further ones, only the latter cost anything.
        least
            Extent of points, across or up, that is round-off: below it they are drawn on a line.
        around
            Returns what else is to be seen, of a window that holds all points with some margin.
        """
        self._least, self._around = least, around
        known = len(self._portions)
        if len(portions) < known or any(one is not old for one, old in zip(portions, self._portions, strict=False)):
            known, self._counts = 0, None
        fresh = list(portions[known:])
        self._portions = list(portions)
        if known and not fresh:
            return
        self._follow(extent_of(fresh), known > 0)
        if self._counts is None or self._counts.window != self._target():
            self._recount()
        else:
            for portion in fresh:
                self._count(portion)
        self._paint()

    def fit(self) -> None:
        """Show all points: undo the user's zoom."""
        self.window = None
        refit(self.figure)
        self._recount()
        self._paint()

    def sharpen(self) -> None:
        """Paint what is in sight in finer pixels, for a picture to be printed, until it is painted next."""
        factor = min(FINE, math.isqrt(MOST_PIXELS // (self._shape[0] * self._shape[1])))
        if self._counts is None or self._in_sight <= FEW or factor <= 1:
            return
        fine = PointCounts(self._target(), (factor * self._shape[0], factor * self._shape[1]), len(self.colours))
        for portion in self._portions:
            fine.add(portion)
        self._picture.data = {**self._picture.data, "image": [fine.image(FINE)]}

    def _follow(self, fresh: Window | None, further: bool) -> None:
        """Let the ranges of the figure hold all points, as long as the user has not zoomed.

        Parameters
        ----------
        fresh
            What the fresh points take.
        further
            Whether they are further ones.
        """
        extent = self._extent = _joined(self._extent if further else None, fresh)
        if extent is None:
            return
        held = Window(*self.corners.data["x"], *self.corners.data["y"])
        room = _roomy(extent, self._least)
        if (more := self._around(room)) is not None:
            extent = _joined(extent, more) or extent
            room = _roomy(extent, self._least)
        ample = held.width <= 1.5 * room.width and held.height <= 1.5 * room.height
        if not (held.covers(extent) and ample):
            if self.window == held:
                self.window = None  # the browser is about to follow
            assign(self.corners, x=[room.x_low, room.x_high], y=[room.y_low, room.y_high])

    def _target(self) -> Window:
        """Return the visible part of the plane, or what it is likely to be."""
        return self.window or Window(*self.corners.data["x"], *self.corners.data["y"])

    def _recount(self) -> None:
        self._counts, self._in_sight = PointCounts(self._target(), self._shape, len(self.colours)), 0
        for portion in self._portions:
            self._count(portion)

    def _count(self, portion: Portion) -> None:
        assert self._counts is not None  # noqa: S101  (made before)
        self._in_sight += self._counts.add(portion)

    def _paint(self) -> None:
        counts = self._counts
        if counts is None:
            return
        if self._in_sight <= FEW:
            self._picture.data = {name: [] for name in self._picture.data}
            size = LARGE_MARK if np.count_nonzero(counts.counts.sum(axis=0)) <= SPARSE else MARK
            for one in self.marks:
                one.glyph.size = size
            for kind, source in enumerate(self._few):
                assign(source, **self._marks_in(counts.window, kind))
            return
        window = counts.window
        place = {"x": [window.x_low], "y": [window.y_low], "dw": [window.width], "dh": [window.height]}
        self._picture.data = {"image": [counts.image()], **place}
        for source in self._few:
            assign(source, x=[], y=[], kind=[])

    def _marks_in(self, window: Window, kind: int) -> dict[str, Any]:
        """Return the columns of the points of one kind that are in sight."""
        parts = [(part, visible(part, window) & (part.kind == kind)) for part in self._portions]
        x = np.concatenate([np.empty(0), *(part.x[there] for part, there in parts)])
        y = np.concatenate([np.empty(0), *(part.y[there] for part, there in parts)])
        return {"x": x, "y": y, "kind": np.full(len(x), kind + 1)}


def _joined(one: Window | None, other: Window | None) -> Window | None:
    """Return the smallest window that holds both."""
    if one is None or other is None:
        return one or other
    low, high = np.minimum(one, other), np.maximum(one, other)
    return Window(float(low[0]), float(high[1]), float(low[2]), float(high[3]))


def _alphas() -> list[int]:
    """Return the opacity of each shade, of 255."""
    return [round(255 * (FAINTEST + (1 - FAINTEST) * k / (LEVELS - 1))) for k in range(LEVELS)]


def _roomy(extent: Window, least: float) -> Window:
    """Return a window with some margin; of points on a line, as wide on either side as they are far from the origin."""
    flat = extent.width <= least or extent.height <= least
    margin = MARGIN_OF_A_LINE if flat else MARGIN
    across = margin * extent.width if extent.width > least else max(abs(extent.x_low), 1.0)
    up = margin * extent.height if extent.height > least else max(abs(extent.y_low), 1.0)
    return Window(extent.x_low - across, extent.x_high + across, extent.y_low - up, extent.y_high + up)
