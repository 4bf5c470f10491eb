"""Marks that would cover one another, and shades too narrow to tell apart, are left out, and the legend says so.

What is left out depends on the zoom and on the size of the screen, so the browser chooses it. Keys in the legend have
sources of their own: from the marks themselves, a legend would be made anew at each zoom.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from bokeh.models import CDSView, ColumnDataSource, CustomJS, IndexFilter
from bokeh.models.annotations import LegendItem
from bokeh.models.glyphs import Scatter, VStrip
from bokeh.models.renderers import GlyphRenderer
from bokeh.plotting import figure

from pwsviz.figures.colours import GREY, OCCUPIED
from pwsviz.figures.style import assign, side_strips, unseen

__all__ = ["NARROW_SHADES", "SAME_INSTANT", "SOME", "Marks", "attach_shades", "shade_keys"]

APART = 8
"""Pixels between the middles of two marks, at least: they then cover each other by little."""

SAME_INSTANT = 0.5
"""Pixels between marks along a time axis that count as one: they are of one run, and so differ."""

NARROWEST = 6
"""Mean width in pixels of neighbouring shades from which on they are told apart."""

WEIGHTS = [0.5, 1.0, 1.0, 1.0, 0.5]
"""Of a shade and of two on either side in this mean: two sides that alternate have the same."""

SOME = " (some)"
"""What a legend adds to the name of marks of which some are left out, as they would cover others like them."""

NONE = " (omitted)"
"""What it adds if all of them are."""

NARROW_SHADES = "brief stays not shaded"
"""What a legend says where some shades are left out."""

NO_SHADES = "sides not shaded"
"""What it says where all are."""

FACTOR = "const factor = parseFloat(getComputedStyle(document.documentElement).fontSize) / 16  // large in a lecture\n"
"""JavaScript of the size of what is painted, relative to the usual one."""

THIN = (
    FACTOR
    + """
const view = cb_context.index.query_one(one => one.model.id == plot)
const across = view?.frame?.x_scale, up = view?.frame?.y_scale
const columns = source.data, xs = columns[x], ys = columns[y], kinds = columns.label
if (across == null || !(view.frame.bbox.width > 0) || xs == null) { return }
const apart = APART * factor, { left, right, top, bottom } = view.frame.bbox
const counts = new Map()
for (const kind of kinds) { counts.set(kind, (counts.get(kind) ?? 0) + 1) }
const order = Array.from(kinds, (_, k) => k).sort((a, b) => counts.get(kinds[a]) - counts.get(kinds[b]) || a - b)
const cells = new Map(), kept = [], hidden = new Set()
for (const k of order) {  // rare kinds first, so that none is lost among many of another
  const px = across.compute(xs[k]), py = up.compute(ys[k])
  const seen = left - apart <= px && px <= right + apart && top - apart <= py && py <= bottom + apart
  if (!seen) { continue }  // of places far away, i + 1 is i
  const i = Math.floor(px / apart), j = Math.floor(py / apart)
  let nearest = Infinity
  for (let a = i - 1; a <= i + 1; a++) {
    for (let b = j - 1; b <= j + 1; b++) {
      for (const [qx, qy] of cells.get(`${a},${b}`) ?? []) {
        nearest = Math.min(nearest, Math.hypot(px - qx, py - qy))
      }
    }
  }
  if (nearest >= apart) {
    kept.push(k)
    const cell = `${i},${j}`
    if (cells.has(cell)) { cells.get(cell).push([px, py]) } else { cells.set(cell, [[px, py]]) }
  } else if (nearest > same * factor) {
    hidden.add(kinds[k])
  }
}
kept.sort((a, b) => a - b)
if (String(filter.indices) != String(kept)) { filter.setv({ indices: kept }, { sync: false }) }
const some = new Set(kept.map(k => kinds[k]))
const label = keys.data.kind.map(kind => !hidden.has(kind) ? kind : kind + (some.has(kind) ? SOME : NONE))
if (String(label) != String(keys.data.label)) { keys.setv({ data: { ...keys.data, label } }, { sync: false }) }
""".replace("APART", str(APART))
    .replace("SOME", repr(SOME))
    .replace("NONE", repr(NONE))
)
"""JavaScript that chooses the marks to paint: none nearer than a mark to one before it.

Those that coincide on the screen, nearer than `same`, count as one, of which nothing is left out.
"""

SHADE = (
    FACTOR
    + """
const view = cb_context.index.query_one(one => one.model.id == plot), across = view?.frame?.x_scale
if (across == null || !(view.frame.bbox.width > 0)) { return }
const width = (start, end) => Math.abs(across.compute(end) - across.compute(start))
const bands = sources.flatMap(({ data }, shade) =>
  Array.from(data.start, (start, k) => [start, width(start, data.end[k]), shade, k]))
bands.sort((a, b) => a[0] - b[0])
const kept = sources.map(() => [])
const first = bands.length > 6 ? 3 : 2  // the run cuts the first and the last one short: these are no measure
bands.forEach(([_start, _width, shade, k], n) => {
  const middle = Math.max(Math.min(n, bands.length - 1 - first), first)
  const near = WEIGHTS.map((weight, m) => [weight, bands[middle + m - 2]]).filter(([, band]) => band != null)
  const total = near.reduce((sum, [weight]) => sum + weight, 0)
  const mean = near.reduce((sum, [weight, [, width]]) => sum + weight * width, 0) / total
  if (mean >= NARROWEST * factor) { kept[shade].push(k) }
})
let left_out = false
sources.forEach(({ data }, shade) => {
  const indices = kept[shade].sort((a, b) => a - b)
  if (String(filters[shade].indices) != String(indices)) { filters[shade].setv({ indices }, { sync: false }) }
  left_out ||= indices.length < data.start.length
  const visible = indices.length > 0
  if (entries[shade].visible != visible) { entries[shade].setv({ visible }, { sync: false }) }
})
const value = kept.some(one => one.length > 0) ? SOME_LEFT : NONE_LEFT
if (narrow.label.value != value) { narrow.setv({ label: { value } }, { sync: false }) }
if (narrow.visible != left_out) { narrow.setv({ visible: left_out }, { sync: false }) }
""".replace("WEIGHTS", str(WEIGHTS))
    .replace("NARROWEST", str(NARROWEST))
    .replace("SOME_LEFT", repr(NARROW_SHADES))
    .replace("NONE_LEFT", repr(NO_SHADES))
)
"""JavaScript that chooses the shades to paint: those that are wide enough, on the mean with their neighbours."""


class Marks:
    """Marks of crossings, of which the browser paints those that do not cover one another.

    Parameters
    ----------
    plot : figure
        The figure.
    source : ColumnDataSource
        A row for each crossing, with the columns of `kind_columns`.
    x, y : str
        Columns of their places.
    width : float
        Of their lines, in pixels.
    same : float
        Distance in pixels up to which two of them count as one.
    """

    def __init__(
        self, plot: figure, source: ColumnDataSource, x: str = "x", y: str = "y", width: float = 2.0,
        same: float = APART / 2,
    ) -> None:  # fmt: skip
        look: dict[str, Any] = {
            "marker": "marker", "fill_alpha": 0.0, "line_color": "colour", "line_width": width, "size": "size",
        }  # fmt: skip
        self.filter = IndexFilter()
        self.painted = plot.add_glyph(source, Scatter(x=x, y=y, **look), view=CDSView(filter=self.filter))
        self._keys = unseen(("x", "y", "kind", "label", "marker", "colour", "size"))
        self.key = plot.add_glyph(self._keys, Scatter(**look))
        given = {
            "plot": plot.id,
            "source": source,
            "filter": self.filter,
            "keys": self._keys,
            "x": x,
            "y": y,
            "same": same,
        }
        _on_change(plot, CustomJS(args=given, code=THIN), [source])

    def name(self, columns: Mapping[str, Sequence[Any]]) -> None:
        """Name the kinds of these marks in the legend; called before they are assigned to the source."""
        first = {label: k for k, label in reversed(list(enumerate(columns["label"])))}
        rows = sorted(first.values())
        kept = {name: [columns[name][k] for k in rows] for name in ("label", "marker", "colour", "size")}
        nowhere = [np.nan] * len(rows)
        assign(self._keys, x=nowhere, y=nowhere, kind=kept["label"], **kept)


def shade_keys(plot: figure) -> list[tuple[str, GlyphRenderer[Any]]]:
    """Return the entries of the shades for a legend, and one that says that some are left out; for `attach_shades`."""
    return [
        *((name if side else f"{name}: |Δg|", _key(plot, side)) for side, (name, _) in OCCUPIED.items()),
        (NARROW_SHADES, _key(plot, None)),
    ]


def _key(plot: figure, side: int | None) -> GlyphRenderer[Any]:
    """Return what a legend paints of a shade, or an empty frame for none: nothing in the figure."""
    empty: dict[str, Any] = {"fill_color": None, "line_color": GREY, "line_width": 1}
    strip = VStrip(x0="start", x1="end", **empty) if side is None else side_strips(side)
    nowhere = ColumnDataSource({"start": [np.nan], "end": [np.nan]})
    return plot.add_glyph(nowhere, strip)


def attach_shades(plot: figure, bands: Mapping[int, GlyphRenderer[Any]], entries: Sequence[LegendItem]) -> None:
    """Let the browser leave out shades that are too narrow.

    Parameters
    ----------
    plot : figure
        The figure.
    bands : dict
        Renderer of each shade, with the columns start and end.
    entries : sequence of LegendItem
        The entry of each shade in the legend, in the same order, and the one that says that some are left out.
    """
    *named, narrow = entries
    filters = [IndexFilter() for _ in bands]
    for band, chosen in zip(bands.values(), filters, strict=True):
        band.view = CDSView(filter=chosen)
    narrow.visible = False
    sources = [band.data_source for band in bands.values()]
    given = {"plot": plot.id, "sources": sources, "filters": filters, "entries": named, "narrow": narrow}
    _on_change(plot, CustomJS(args=given, code=SHADE), sources, across_alone=True)


def _on_change(plot: figure, code: CustomJS, sources: Sequence[Any], across_alone: bool = False) -> None:
    """Run code when the zoom, the size or the data change."""
    for axis in (plot.x_range,) if across_alone else (plot.x_range, plot.y_range):
        axis.js_on_change("start", code)
        axis.js_on_change("end", code)
    for name in ("inner_width",) if across_alone else ("inner_width", "inner_height"):
        plot.js_on_change(name, code)
    for source in sources:
        source.js_on_change("data", code)
