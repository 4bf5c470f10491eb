"""Names of several surfaces and their regions in a portrait: at an end of each surface, and inside each region.

No name stands under a mark on a trajectory where there is another place for it.
"""

from __future__ import annotations

from typing import Any

from bokeh.models import ColumnDataSource
from bokeh.models.glyphs import Text
from bokeh.models.renderers import GlyphRenderer
from bokeh.plotting import figure

import core
from pwsviz.figures.colours import GREY
from pwsviz.figures.moving import FORMULAS
from pwsviz.geometry.projection import surface_texts
from pwsviz.scene.names import readable
from pwsviz.text.math_names import numbered

__all__ = ["PLACE_LABELS", "label_glyph", "surface_labels"]

LONGEST = 24
"""Characters of a switching function that a label writes out."""

_COLUMNS = ("x", "y", "text", "align", "baseline", "dx", "dy")


def surface_labels(system: core.PiecewiseSystem) -> list[str]:
    """Return what each of several surfaces is called in the portrait: “g₁ = x − 1 = 0”, or without g₁ where the names
    of regions do not tell signs; nothing of a single one. Where it would lie across another surface, it is “g₁ = 0”.
    """
    if len(system.laws.surfaces) < 2:
        return []
    texts = [readable(g, system) for g in surface_texts(system)]
    names = [f"{numbered('g', k + 1)} = " if system.surfaces else "" for k in range(len(texts))]
    return [
        f"{name}{text} = 0" if len(text) <= LONGEST else f"{name}0" for name, text in zip(names, texts, strict=True)
    ]


def label_glyph(plot: figure) -> GlyphRenderer[Any]:
    """Add the labels, without any yet, to be filled in by `PLACE_LABELS`."""
    source = ColumnDataSource({name: [] for name in _COLUMNS})
    look: dict[str, Any] = {"text_color": GREY, "text_font_size": "12px", "text_font_style": "bold"}
    place: dict[str, Any] = {"text_align": "align", "text_baseline": "baseline", "x_offset": "dx", "y_offset": "dy"}
    return plot.add_glyph(source, Text(**look, **place))


PLACE_LABELS = (
    FORMULAS
    + """
const INSETS = [0.03, 0.1, 0.2, 0.3]  // of what is seen, between its edge and the label of a surface
const ALONG = 80    // points along an edge at which a surface is sought
const CELLS = 36    // along the longer side of what is seen, by which regions are told apart
const DEEP = 2      // cells around the label of a region, at least, that belong to it
const MARK = 15, LINE = 16, GAP = 6  // pixels: of a mark without a size of its own, of a line of text, beside a surface
const [across, up] = ranges, width = across.end - across.start, height = up.end - up.start
const cell = Math.max(width, height) / CELLS
const frame = size ?? cb_context.index?.query_one(view => view.model.id == plot)?.frame.bbox
const pixel = frame?.width > 0 ? width / frame.width : cell / 12
const shown = { x: [], y: [], text: [], align: [], baseline: [], dx: [], dy: [] }
const add = (x, y, text, align, baseline, dx, dy) => {
  for (const [name, value] of Object.entries({ x, y, text, align, baseline, dx, dy })) { shown[name].push(value) }
}
const t = clock.data.t[0]
const at = (u, v) => [across.start + u * width, up.start + v * height]

// Trajectories and their marks, by the cells in which they are, and whether one of them is near a label.
const column = x => Math.floor((x - across.start) / cell), row = y => Math.floor((y - up.start) / cell)
const number = (i, j) => i * 1000 + j
const marked = new Set()
for (const { data } of marks) {
  Array.from(data.x).forEach((x, k) => {
    const half = (data.size?.[k] ?? MARK) / 2 * pixel, [i0, i1] = [x - half, x + half].map(column)
    const [j0, j1] = [data.y[k] - half, data.y[k] + half].map(row)
    for (let i = Math.max(i0, 0); i <= Math.min(i1, CELLS); i++) {  // of places far away, i + 1 is i
      for (let j = Math.max(j0, 0); j <= Math.min(j1, CELLS); j++) { marked.add(number(i, j)) }
    }
  })
}
const within = (x, y) => across.start <= x && x <= across.end && up.start <= y && y <= up.end
for (const { data: { xs, ys } } of curves) {
  Array.from(xs).forEach((x, k) => {
    for (let m = 0; m + 1 < x.length; m++) {
      const [x0, y0, x1, y1] = [x[m], ys[k][m], x[m + 1], ys[k][m + 1]]
      if (!within(x0, y0) && !within(x1, y1)) { continue }
      const parts = Math.ceil(Math.min(CELLS, 2 * Math.hypot(x1 - x0, y1 - y0) / cell))
      for (let n = 0; n <= parts; n++) {
        const share = parts > 0 ? n / parts : 0
        marked.add(number(column(x0 + share * (x1 - x0)), row(y0 + share * (y1 - y0))))
      }
    }
  })
}
const pen = document.createElement("canvas").getContext("2d")
const look = ["text_font_style", "text_font_size", "text_font"].map(name => glyph[name].value ?? glyph[name])
pen.font = look.join(" ")
const extent = ({ x, text, align }) => {
  const long = pen.measureText(text).width * pixel
  const low = x - { left: 0, center: long / 2, right: long }[align]
  return [low, low + long]
}
const isMarked = label => {
  const [low, high] = extent(label).map(column), middle = row(label.y + (label.baseline == "bottom" ? cell : 0))
  for (let i = low - 1; i <= high + 1; i++) {
    if ([-1, 0, 1].some(more => marked.has(number(i, middle + more)))) { return true }
  }
  return false
}

// Where a surface meets the edges of what is seen, all of them a little inside: top, right, bottom, left.
const EDGES = [(s, d) => [1 - s, 1 - d], (s, d) => [1 - d, 1 - s], (s, d) => [1 - s, d], (s, d) => [d, 1 - s]]
const ends = (g, inset) => EDGES.flatMap((edge, side) => {
  const places = Array.from({ length: ALONG + 1 }, (_, k) => at(...edge(inset + (1 - 2 * inset) * k / ALONG, inset)))
  const levels = places.map(([x, y]) => g(x, y, t)), found = []
  for (let k = 0; k < ALONG; k++) {
    const [a, b] = [levels[k], levels[k + 1]]
    if (a < 0 != b < 0) {
      const share = a / (a - b), [[x0, y0], [x1, y1]] = [places[k], places[k + 1]]
      found.push({ x: x0 + share * (x1 - x0), y: y0 + share * (y1 - y0), side })
    }
  }
  return found
})
// How far it is, to the left or to the right, from a place on a surface to another surface or the edge.
const room = ({ x, y }, k, way) => {
  const others = heights.filter((g, n) => g != null && n != k), signs = others.map(g => g(x, y, t) < 0)
  let steps = 0
  for (let at = x; at > across.start && at < across.end; at += way * width / ALONG) {
    if (others.some((g, n) => g(at, y, t) < 0 != signs[n])) { break }
    steps += 1
  }
  return steps
}
// A label moved into what is seen, and whether two of them touch.
const inside = label => {
  const [low, high] = extent(label), spare = GAP * pixel
  return { ...label, x: label.x - Math.max(0, high + spare - across.end) + Math.max(0, across.start + spare - low) }
}
// Whether a label of a surface lies across another one.
const reaches = (label, k) => {
  const [low, high] = extent(label), others = heights.filter((g, n) => g != null && n != k)
  const places = Array.from({ length: 9 }, (_, n) => low + (high - low) * n / 8)
  return others.some(g => new Set(places.map(x => g(x, label.y, t) < 0)).size > 1)
}
const touch = (one, other) => {
  const [[a, b], [c, d]] = [one, other].map(extent), spare = GAP * pixel
  return a < d + spare && c < b + spare && Math.abs(one.y - other.y) < 1.5 * LINE * pixel
}
const nameSurfaces = () => {
  const placed = []
  const apart = one => Math.min(...placed.map(({ x, y }) => Math.hypot(one.x - x, one.y - y)), width + height)
  heights.forEach((g, k) => {
    if (g == null) { return }
    const label = one => {
      const beside = one.side % 2 == 0  // else above the surface, from that edge on
      const right = beside ? room(one, k, -1) > room(one, k, 1) : one.side == 1  // the text then ends there
      const look = { align: right ? "right" : "left", beside, baseline: beside ? "middle" : "bottom" }
      const whole = inside({ ...one, text: given.surfaces[k], ...look })
      return reaches(whole, k) ? inside({ ...one, text: whole.text.replace(/ = .* = /, " = "), ...look }) : whole
    }
    const found = INSETS.map(inset => ends(g, inset).map(label).filter(one => !placed.some(other => touch(one, other))))
    const free = found.map(some => some.filter(one => !isMarked(one)))
    const best = (free.find(some => some.length > 0) ?? found.find(some => some.length > 0) ?? [])
      .reduce((best, one) => best == null || apart(one) > apart(best) ? one : best, null)
    if (best == null) { return }
    placed.push(best)
    const { x, y, text, align, baseline, beside } = best
    add(x, y, text, align, baseline, beside ? (align == "right" ? -GAP : GAP) : 0, beside ? 0 : -4)
  })
}

// Toward the edge of what is seen, where few trajectories are, and away from other regions, labels of surfaces and
// marks. Regions without a state are told from one another by their signs, and have the same name.
const nameRegions = () => {
  const columns = Math.max(2, Math.round(width / cell)), rows = Math.max(2, Math.round(height / cell))
  const place = (i, j) => at((i + 0.5) / columns, (j + 0.5) / rows)
  const regions = [...given.regions]
  const region = Array.from({ length: rows }, (_r, j) => Array.from({ length: columns }, (_c, i) => {
    const [x, y] = place(i, j), signs = heights.map(g => Math.sign(g(x, y, t)))
    const known = regions.findIndex(([sides]) => sides.every((sign, k) => sign == signs[k]))
    return known < 0 && signs.every(sign => sign != 0) ? regions.push([signs, given.bare]) - 1 : known
  }))
  const depth = region.map(row => row.map(() => 0))  // cells from there to another region
  let inside = region.flatMap((row, j) => row.map((_, i) => [i, j]))
  for (let level = 0; inside.length > 0 && level < CELLS; level++) {
    inside = inside.filter(([i, j]) => [-1, 0, 1].every(dj => [-1, 0, 1].every(di => {
      const other = region[j + dj]?.[i + di]
      return other == null || (other == region[j][i] && depth[j + dj][i + di] >= level)
    })))
    for (const [i, j] of inside) { depth[j][i] = level + 1 }
  }
  const surfaces = shown.text.map((text, k) => {
    const [low, high] = extent({ x: shown.x[k], text, align: shown.align[k] })
    return { low, high, y: shown.y[k] + (shown.baseline[k] == "bottom" ? LINE / 2 * pixel : 0) }
  })
  const apart = Math.max(LINE * pixel, cell)
  const free = label => {
    const [left, right] = extent(label)
    const there = left > across.start && right < across.end
    return there && surfaces.every(({ low, high, y }) =>
      right < low - apart || left > high + apart || Math.abs(label.y - y) > 1.5 * apart)
  }
  const bestPlace = (k, text, suits) => {
    let best = null, most = 0
    for (let j = rows - 1 - DEEP; j >= DEEP; j--) {
      for (let i = DEEP; i < columns - DEEP; i++) {
        if (region[j][i] != k || depth[j][i] < DEEP) { continue }
        const out = Math.max(Math.abs((i + 0.5) / columns - 0.5), Math.abs((j + 0.5) / rows - 0.5))
        const score = out + depth[j][i] / CELLS, [x, y] = place(i, j), label = { x, y, text, align: "center" }
        if (score > most + 1e-9 && free(label) && suits(label)) { most = score; best = [x, y] }
      }
    }
    return best
  }
  regions.forEach(([, name], k) => {
    const text = name.replace(/^region /, "")
    const best = bestPlace(k, text, label => !isMarked(label)) ?? bestPlace(k, text, () => true)
    if (best != null) { add(...best, text, "center", "middle", 0, 0) }
  })
}

if (given?.surfaces != null && Number.isFinite(width) && Number.isFinite(height)) {
  const several = given.surfaces.length > 1, count = given.regions.length
  if (several) { nameSurfaces() }
  if (count > 0 && (several || given.bare != "")) { nameRegions() }
}
if (shown.x.length > 0 || labels.data.x.length > 0) { labels.setv({ data: shown }, { sync: false }) }
"""
)
"""JavaScript run when another part of the plane is seen, or another time: it puts each label where there is room."""
