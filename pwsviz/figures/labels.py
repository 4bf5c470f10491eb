"""Names of several surfaces and their regions in a portrait: at an end of each surface, and inside each region.

No name stands across a surface, a trajectory or a mark on it where there is another place for it, nor across level sets
and arrows without a light ground of its own.
"""

from __future__ import annotations

from typing import Any

from bokeh.core.properties import value
from bokeh.models import ColumnDataSource
from bokeh.models.glyphs import Text
from bokeh.models.renderers import GlyphRenderer
from bokeh.plotting import figure

import core
from pwsviz.figures.colours import GREY, GROUND
from pwsviz.figures.moving import FORMULAS
from pwsviz.geometry.projection import surface_texts
from pwsviz.scene.names import readable
from pwsviz.text.math_names import numbered

__all__ = ["PLACE_LABELS", "label_glyph", "surface_labels"]

FONT = "Roboto, Helvetica, Arial, sans-serif"
"""Typeface of labels, that of the page."""

LINE_HEIGHT = 1.1
"""Height of a line of a label of several, in heights of its letters."""

LONGEST = 24
"""Characters of a switching function that a label writes out."""

_COLUMNS = ("x", "y", "text", "align", "baseline", "dx", "dy", "veil")


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
    look: dict[str, Any] = {"text_color": GREY, "text_font_size": "12px", "text_font": value(FONT)}
    look |= {"background_fill_color": GROUND, "background_fill_alpha": "veil", "text_line_height": LINE_HEIGHT}
    place: dict[str, Any] = {"text_align": "align", "text_baseline": "baseline", "x_offset": "dx", "y_offset": "dy"}
    return plot.add_glyph(source, Text(**look, **place))


PLACE_LABELS = (
    FORMULAS
    + """
const INSETS = [0.03, 0.1, 0.2, 0.3, 0.4]  // of what is seen, between its edge and the label of a surface
const ALONG = 80    // points along an edge at which a surface is sought
const CELLS = 36    // along the longer side of what is seen, by which regions are told apart
const DEEP = 2      // cells around the label of a region, at least, that belong to it
const MARK = 15, GAP = 6  // pixels: of a mark without a size of its own, beside a surface
const VEIL = 0.8    // opacity of the ground of a label that lies across something
const [across, up] = ranges, width = across.end - across.start, height = up.end - up.start
const cell = Math.max(width, height) / CELLS
const frame = size ?? cb_context.index?.query_one(view => view.model.id == plot)?.frame.bbox
const pixel = frame?.width > 0 ? width / frame.width : cell / 12
const shown = { x: [], y: [], text: [], align: [], baseline: [], dx: [], dy: [], veil: [] }
const t = clock.data.t[0]
const at = (u, v) => [across.start + u * width, up.start + v * height]

// Trajectories and their marks, by the cells in which they are, and whether one of them is near a label.
const column = x => Math.floor((x - across.start) / cell), row = y => Math.floor((y - up.start) / cell)
const number = (i, j) => i * 1000 + j
const within = (x, y) => across.start <= x && x <= across.end && up.start <= y && y <= up.end
const follow = (x, y, found) => {  // the cells that a line goes through
  for (let m = 0; m + 1 < x.length; m++) {
    const [x0, y0, x1, y1] = [x[m], y[m], x[m + 1], y[m + 1]]
    if (!within(x0, y0) && !within(x1, y1)) { continue }
    const parts = Math.ceil(Math.min(CELLS, 2 * Math.hypot(x1 - x0, y1 - y0) / cell))
    for (let n = 0; n <= parts; n++) {
      const share = parts > 0 ? n / parts : 0
      found.add(number(column(x0 + share * (x1 - x0)), row(y0 + share * (y1 - y0))))
    }
  }
}
const marked = new Set(), lined = new Set()
for (const { data } of marks) {
  Array.from(data.x).forEach((x, k) => {
    const half = (data.size?.[k] ?? MARK) / 2 * pixel, [i0, i1] = [x - half, x + half].map(column)
    const [j0, j1] = [data.y[k] - half, data.y[k] + half].map(row)
    for (let i = Math.max(i0, 0); i <= Math.min(i1, CELLS); i++) {  // of places far away, i + 1 is i
      for (let j = Math.max(j0, 0); j <= Math.min(j1, CELLS); j++) { marked.add(number(i, j)) }
    }
  })
}
for (const { data: { xs, ys } } of curves) { Array.from(xs).forEach((x, k) => follow(x, ys[k], marked)) }
if (given?.surfaces != null) { for (const { data: { x, y } } of lines) { follow(x, y, lined) } }

// The box of a label, in units of the plane, with a number of pixels around it; texts may have several lines.
const pen = document.createElement("canvas").getContext("2d")
const look = ["text_font_style", "text_font_size", "text_font"].map(name => glyph[name].value ?? glyph[name])
pen.font = look.join(" ")
const LINE = 4 / 3 * parseFloat(look[1])  // pixels
const box = ({ x, y, text, align, baseline, dx, dy }, spare = 0) => {
  const parts = text.split("\\n"), long = Math.max(...parts.map(part => pen.measureText(part).width))
  const left = dx - { left: 0, center: long / 2, right: long }[align], high = parts.length * LINE
  const low = -dy - { bottom: 0, middle: high / 2, top: high }[baseline]
  return {
    left: x + (left - spare) * pixel, right: x + (left + long + spare) * pixel,
    low: y + (low - spare) * pixel, high: y + (low + high + spare) * pixel,
  }
}
const isWithin = ({ left, right, low, high }) => within(left, low) && within(right, high)
const overlap = (one, other) =>
  one.left < other.right && other.left < one.right && one.low < other.high && other.low < one.high
const reaches = ({ left, right, low, high }, cells) => {
  for (let i = column(left); i <= column(right); i++) {
    for (let j = row(low); j <= row(high); j++) { if (cells.has(number(i, j))) { return true } }
  }
  return false
}
const crosses = ({ left, right, low, high }) => heights.some(g => {  // a surface
  if (g == null) { return false }
  const before = g(left, low, t) < 0
  for (let n = 0; n <= 8; n++) {
    const x = left + (right - left) * n / 8
    if (g(x, low, t) < 0 != before || g(x, high, t) < 0 != before) { return true }
  }
  return false
})
const add = (label, hatched = false) => {
  const all = box(label), veil = hatched || crosses(all) || reaches(all, marked) || reaches(all, lined) ? VEIL : 0
  for (const [name, value] of Object.entries({ ...label, veil })) { shown[name].push(value) }
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
// A label moved into what is seen.
const inside = label => {
  const { left, right, low, high } = box(label, GAP), moved = (low, high, start, end) =>
    Math.max(0, start - low) - Math.max(0, high - end)
  return {
    ...label, dx: label.dx + moved(left, right, across.start, across.end) / pixel,
    dy: label.dy - moved(low, high, up.start, up.end) / pixel,
  }
}
// The label of a surface beside one of its ends, on either side of it: those first with the most room.
const CLOSE = GAP - 2
const beside = (one, k) => {
  const { x, y, side } = one
  const label = (align, baseline) => inside({
    x, y, text: given.surfaces[k], align, baseline, dx: side % 2 ? 0 : align == "right" ? -GAP : GAP,
    dy: { bottom: -CLOSE, middle: 0, top: CLOSE }[baseline],
  })
  if (side % 2) { return ["bottom", "top"].map(baseline => label(side == 1 ? "right" : "left", baseline)) }
  const ways = room(one, k, -1) > room(one, k, 1) ? ["right", "left"] : ["left", "right"]
  return ways.flatMap(align => ["middle", "bottom", "top"].map(baseline => label(align, baseline)))
}
const nameSurfaces = () => {
  const placed = []
  const apart = one => Math.min(...placed.map(({ x, y }) => Math.hypot(one.x - x, one.y - y)), width + height)
  const farthest = some => some.reduce((best, one) => best == null || apart(one) > apart(best) ? one : best, null)
  const first = (some, suits) => {
    for (const labels of some) {
      const best = farthest(labels.filter(suits))
      if (best != null) { return best }
    }
    return null
  }
  heights.forEach((g, k) => {
    if (g == null) { return }
    const alone = one => !placed.some(other => overlap(box(one, GAP), box(other)))
    const whole = INSETS.map(inset => ends(g, inset).flatMap(one => beside(one, k)).filter(alone))
    const short = whole.map(labels => labels.map(one => inside({ ...one, text: one.text.replace(/ = .* = /, " = ") })))
    const clear = one => !crosses(box(one, 1)), free = one => clear(one) && !reaches(box(one, 1), marked)
    const best = first(whole, free) ?? first(short, free) ?? first(whole, clear) ?? first(short, clear) ??
      first(whole, () => true)
    if (best != null) { placed.push(best) }
  })
  for (const one of placed) { add(one) }
  return placed
}

// The same words in two lines, as even as may be: “beyond” and “the wall”.
const inLines = text => {
  const words = text.split(" "), halves = words.slice(1).map((_, k) => [words.slice(0, k + 1), words.slice(k + 1)]
    .map(line => line.join(" ")))
  const longer = ([one, other]) => Math.max(one.length, other.length)
  return halves.reduce((best, two) => longer(best) <= longer(two) ? best : two, [text, ""]).join("\\n").trim()
}

// Toward the edge of what is seen, where few trajectories are, and away from other regions, labels of surfaces and
// marks. Regions without a state are told from one another by their signs, and have the same name.
const nameRegions = surfaces => {
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
  const apart = Math.max(LINE, cell / pixel)  // pixels
  const bestPlace = (k, text, suits) => {
    let best = null, most = 0
    for (let j = rows - 1 - DEEP; j >= DEEP; j--) {
      for (let i = DEEP; i < columns - DEEP; i++) {
        if (region[j][i] != k || depth[j][i] < DEEP) { continue }
        const out = Math.max(Math.abs((i + 0.5) / columns - 0.5), Math.abs((j + 0.5) / rows - 0.5))
        const score = out + depth[j][i] / CELLS
        if (score <= most + 1e-9) { continue }
        const [x, y] = place(i, j), label = { x, y, text, align: "center", baseline: "middle", dx: 0, dy: 0 }
        const around = box(label, apart)
        if (isWithin(box(label)) && !surfaces.some(one => overlap(around, box(one))) && suits(label)) {
          most = score
          best = label
        }
      }
    }
    return best
  }
  const clear = label => isWithin(box(label, GAP)) && !crosses(box(label, GAP))
  const free = label => clear(label) && !reaches(box(label, CLOSE), marked)
  regions.forEach(([, name], k) => {
    const text = name.replace(/^region /, ""), halves = inLines(text)
    const best = bestPlace(k, text, free) ?? bestPlace(k, halves, free) ?? bestPlace(k, text, clear) ??
      bestPlace(k, halves, clear) ?? bestPlace(k, text, () => true)
    if (best != null) { add(best, name == given.bare && size == null) }  // pictures have no hatches
  })
}

if (given?.surfaces != null && Number.isFinite(width) && Number.isFinite(height)) {
  const several = given.surfaces.length > 1, count = given.regions.length
  const placed = several ? nameSurfaces() : []
  if (count > 0 && (several || given.bare != "")) { nameRegions(placed) }
}
if (shown.x.length > 0 || labels.data.x.length > 0) { labels.setv({ data: shown }, { sync: false }) }
"""
)
"""JavaScript run when another part of the plane is seen, or another time: it puts each label where there is room."""
