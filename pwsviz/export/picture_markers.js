// Markers on the dashed curves of a picture, and in its legend: without colours, and where curves coincide, dashes alone do not
// tell which integrator a curve is of. A solid one needs none.

import { copied } from "./picture_names.js"

const COUNT = 5  // markers on a curve
const SIZE = 8  // their diameter in pixels
const APART = 26  // pixels at least between any two
const TRIES = 200  // places looked at for one, each a third of that distance further along the curve
const OPEN = ["plus", "y", "asterisk", "x"]  // markers without an area
const EDGE = "#ffffff"

// The curves of a renderer in pixels, with the columns of each; null unless they are curves of integrators that differ in dash.
const curves_of = ({ glyph, data_source }, to_screen) => {
  const { xs, ys, method, dash, marker, colour } = Object.fromEntries(data_source?.data ?? [])
  if (glyph?.type != "MultiLine" || marker == null || new Set(Array.from(dash, String)).size < 2) return null
  return Array.from(method, (name, k) => ({
    name, marker: marker[k], colour: colour[k], dashed: dash[k].length > 0,
    path: Array.from(xs[k], (x, n) => to_screen(x, ys[k][n])),
  }))
}

// A function: part of the length of a curve, in pixels -> the place there.
const along = path => {
  const ends = [0]
  for (let n = 1; n < path.length; n++) {
    const step = Math.hypot(path[n][0] - path[n - 1][0], path[n][1] - path[n - 1][1])
    ends.push(ends[n - 1] + (Number.isFinite(step) ? step : 0))  // there is nothing between two pieces
  }
  const place = length => {
    let low = 0, high = ends.length - 1
    while (high - low > 1) {
      const middle = low + high >> 1
      if (ends[middle] <= length) low = middle
      else high = middle
    }
    const part = (length - ends[low]) / (ends[high] - ends[low])
    return path[low].map((one, k) => one + part * (path[high][k] - one))
  }
  return { length: ends.at(-1), place }
}

// Places on the curves, spread over each and apart from all others: [curve, place].
const spread_over = (curves, frame) => {
  const found = []
  const free = ([x, y]) => 0 < x && x < frame.width && 0 < y && y < frame.height &&
    found.every(([_, [a, b]]) => Math.hypot(x - a, y - b) >= APART)
  for (const [k, curve] of curves.entries()) {
    const { length, place } = along(curve.path)
    for (let n = 0; n < COUNT && curve.path.length > 1; n++) {
      const first = (n + (k + 0.5) / curves.length) / COUNT * length
      for (let tried = 0; tried < TRIES; tried++) {
        const at = place(first + tried * APART / 3)
        if (first + tried * APART / 3 > length) break
        if (free(at)) {
          found.push([curve, at])
          break
        }
      }
    }
  }
  return found
}

const marks_on = (curves, frame, [across, up]) => {
  const named = [...new Map(curves.map(curve => [curve.name, curve])).values()]
  const rows = [...named.map(curve => [curve, [NaN, NaN]]), ...spread_over(curves, frame)]  // the first stand for the legend
  const data = {
    x: rows.map(([_, [x]]) => across.invert(x)), y: rows.map(([_, [__, y]]) => up.invert(y)),
    method: rows.map(([{ name }]) => name), marker: rows.map(([{ marker }]) => marker),
    colour: rows.map(([{ colour }]) => colour),
    edge: rows.map(([{ marker, colour }]) => OPEN.includes(marker) ? colour : EDGE),
    width: rows.map(([{ marker }]) => OPEN.includes(marker) ? 2 : 1),
  }
  const { ColumnDataSource } = Bokeh.loader["models/sources/column_data_source"]
  const { Scatter } = Bokeh.loader["models/glyphs/scatter"]
  const { GlyphRenderer } = Bokeh.loader["models/renderers/glyph_renderer"]
  const fields = { marker: "marker", fill_color: "colour", line_color: "edge", line_width: "width" }
  const glyph = new Scatter({
    x: { field: "x" }, y: { field: "y" }, size: { value: SIZE },
    ...Object.fromEntries(Object.entries(fields).map(([name, field]) => [name, { field }])),
  })
  return new GlyphRenderer({ data_source: new ColumnDataSource({ data }), glyph })
}

// Of a logarithmic or linear range, a number of pixels from its start to its end: place -> pixels, and back.
const scale_of = ({ start, end }, pixels, logarithmic) => {
  const [on, off] = logarithmic ? [Math.log, Math.exp] : [value => value, value => value]
  const [low, high] = [on(start), on(end)]
  return {
    compute: value => (on(value) - low) / (high - low) * pixels, invert: at => off(low + at / pixels * (high - low)),
  }
}

// The renderers of a plot with markers above the curves, and those markers; `frame` in pixels.
export const with_markers = (renderers, ranges, logarithmic, frame) => {
  const [across, up] = ranges.map((one, k) => scale_of(one, [frame.width, frame.height][k], logarithmic[k]))
  const found = renderers.map(one => curves_of(one, (x, y) => [across.compute(x), up.compute(y)]))
  const last = found.findLastIndex(curves => curves?.some(({ path }) => path.length > 1))
  if (last < 0) return { renderers, markers: null }
  const dashed = found.flatMap(curves => curves ?? []).filter(curve => curve.dashed)
  const markers = marks_on(dashed, frame, [across, up])
  return { renderers: renderers.toSpliced(last + 1, 0, markers), markers }
}

// The entries of a legend, those of integrators with their markers.
export const with_keys = (items, markers) => markers == null ? items : items.map(
  item => item.label?.field == "method" ? copied(item, { renderers: [...item.renderers, markers] }) : item)
