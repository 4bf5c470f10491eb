"""Names of lines of integer slope in an order plot: each beside its line, where nothing else is drawn."""

from __future__ import annotations

from typing import Any

from bokeh.models import ColumnDataSource, CustomJS
from bokeh.models.glyphs import Text
from bokeh.plotting import figure

from pwsviz.figures.colours import GREY, GROUND
from pwsviz.figures.style import ranges

__all__ = ["name_slopes"]

PLACE_NAMES = """
const CLEAR = 14   // pixels around a name that are free enough
const APART = 3    // pixels between two points of a line at which it is looked for near a name
const RIM = 8      // pixels inside the frame that are free, so that no ground of a name lies over it in print
const PLACES = 60  // along a line at which its name may stand
const frame = size ?? cb_context.index?.query_one(view => view.model.id == plot)?.frame.bbox
const [across, up] = ranges
const place = (range, value, long) => Math.log(value / range.start) / Math.log(range.end / range.start) * long
const drawn = ({ data: { xs, ys } }) => Array.from(xs, (x, k) => Array.from(x, (one, m) =>
  [place(across, one, frame.width), place(up, ys[k][m], frame.height)]).filter(one => one.every(Number.isFinite)))
const points = line => line.flatMap(([x, y], k) => {
  const [x1, y1] = line[k + 1] ?? [x, y], parts = Math.ceil(Math.min(2000, Math.hypot(x1 - x, y1 - y) / APART)) || 1
  return Array.from({ length: parts }, (_, n) => [x + (x1 - x) * n / parts, y + (y1 - y) * n / parts])
})
const away = ([left, right, low, high], x, y) =>
  Math.hypot(Math.max(left - x, 0, x - right), Math.max(low - y, 0, y - high))
const pen = document.createElement("canvas").getContext("2d")
const [letters, font] = ["text_font_size", "text_font"].map(name => glyph[name].value ?? glyph[name])
pen.font = `${letters} ${font}`
const high = parseFloat(letters)
const placeNames = () => {
  const lines = drawn(guides), data = { ...labels.data, x: [], y: [] }
  const marked = Array.from(marks.data.x, (x, k) =>
    [place(across, x, frame.width), place(up, marks.data.y[k], frame.height)])
  const taken = [...drawn(lines_drawn).map(points), marked]
  const names = []
  lines.forEach((line, k) => {
    const [[x0, y0], [x1, y1]] = line, long = pen.measureText(labels.data.text[k]).width
    const others = [...taken, ...lines.filter((_, m) => m != k).map(points), ...names].flat()
    let best = null, most = -1
    for (let n = 0; n <= PLACES; n++) {
      const x = x0 + (x1 - x0) * n / PLACES, y = y0 + (y1 - y0) * n / PLACES
      // Where a name ends, and how low: to the left of a rising line and above it, or to its right and below it.
      for (const [right, low] of [[x - 6, y], [x + 6 + long, y - high]]) {
        const box = [right - long, right, low, low + high]
        if (box[0] < RIM || box[1] > frame.width - RIM || low < RIM || box[3] > frame.height - RIM) { continue }
        const clear = Math.min(CLEAR, ...others.map(([a, b]) => away(box, a, b)))
        if (clear > most + 0.5) { most = clear; best = [right + 6, low, box] }
      }
    }
    const [x, y, box] = best ?? [NaN, NaN, null]  // without any room for it, it is not named
    data.x.push(across.start * (across.end / across.start) ** (x / frame.width))
    data.y.push(up.start * (up.end / up.start) ** (y / frame.height))
    if (box != null) { names.push([[box[0], box[2]], [box[1], box[2]], [box[0], box[3]], [box[1], box[3]]]) }
  })
  labels.setv({ data }, { sync: false })
}
if (frame?.width > 0 && guides.data.xs.length == labels.data.text.length && Number.isFinite(across.start + up.start)) {
  placeNames()
}
"""
"""JavaScript run when other lines are drawn or other parts of the plane are seen."""


def name_slopes(
    plot: figure, guides: ColumnDataSource, curves: ColumnDataSource, marks: ColumnDataSource
) -> ColumnDataSource:
    """Let lines in a logarithmic plot have names, and return the source of these, with their texts.

    Parameters
    ----------
    plot : figure
        The plot.
    guides : ColumnDataSource
        The lines to be named, each from its lower left to its upper right end.
    curves : ColumnDataSource
        The curves, near which no name is to stand.
    marks : ColumnDataSource
        Marks x, y, near which none is to stand either.
    """
    names = ColumnDataSource({"x": [], "y": [], "text": []})
    look: dict[str, Any] = {"text_color": GREY, "text_font_size": "12px", "x_offset": -6}
    look |= {"background_fill_color": GROUND, "background_fill_alpha": 0.8}  # curves end there
    texts = plot.add_glyph(names, Text(text_align="right", text_baseline="bottom", **look))
    given = {"guides": guides, "lines_drawn": curves, "marks": marks}
    args = {"labels": names, "glyph": texts.glyph, "plot": plot.id}
    place = CustomJS(args={**given, **args, "ranges": list(ranges(plot)), "size": None}, code=PLACE_NAMES)
    texts.tags = [place]  # for pictures, in whose frames there is room elsewhere
    plot.js_on_change("inner_width", place)
    plot.js_on_change("inner_height", place)
    for axis in ranges(plot):
        axis.js_on_change("start", place)
        axis.js_on_change("end", place)
    guides.js_on_change("data", place)
    return names
