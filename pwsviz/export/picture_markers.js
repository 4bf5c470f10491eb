// Markers on the curves of integrators in a picture, and in its legend: without colours, and where curves coincide, dashes alone
// do not tell which integrator a curve is of.

import { copied } from "./picture_names.js"

const COUNT = 5  // markers on the only curve of an integrator; fewer on each of several
const SIZE = 8  // their diameter in pixels
const APART = 32  // pixels from all others at which one stands where even spacing along its curve asks for it …
const ELSEWHERE = [104, 52, 26]  // … and those, the first for which there is a place, of one further along the curve
const STEP = 9, TRIES = 200  // pixels along the curve to the next place looked at for one, and number of these
const OPEN = ["plus", "y", "asterisk", "x"]  // markers without an area
const EDGE = "#ffffff"

// The columns of the curves of integrators that a renderer draws, or names in a legend; null of other renderers (those of
// studies have marks of their own).
const columns_of = ({ glyph, data_source }) => {
  const { method, marker, ...others } = data_source?.data ?? {}
  const named = glyph?.type == "MultiLine" && method != null && marker != null
  return named ? { marker: Array.from(marker), ...others } : null
}

// They, in pixels.
const curves_of = ({ xs, ys, colour, marker }, to_screen) => marker.map((shape, k) => ({
  marker: shape, colour: colour[k], path: Array.from(xs[k], (x, n) => to_screen(x, ys[k][n])),
}))

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

// Places on the curves, spread over each and apart from all others: [curve, place]. Each curve has its first one before any has
// its second one, lest none be left for it where many curves coincide.
const spread_over = (curves, frame) => {
  const found = []
  const inside = ([x, y]) => 0 < x && x < frame.width && 0 < y && y < frame.height
  const free = ([x, y], apart) => found.every(([_, [a, b]]) => Math.hypot(x - a, y - b) >= apart)
  const drawn = curves.filter(({ path }) => path.length > 1).map(curve => ({ curve, ...along(curve.path) }))
  const count_of = ({ marker }) => Math.round(COUNT / Math.sqrt(drawn.filter(({ curve }) => curve.marker == marker).length)) || 1
  for (let n = 0; n < COUNT; n++) {
    for (const [k, { curve, length, place }] of drawn.entries()) {
      const count = count_of(curve)
      if (n >= count) continue
      const first = (n + (k + 0.5) / drawn.length) / count * length
      const places = Array.from({ length: TRIES }, (_, tried) => first + tried * STEP).filter(at => at <= length).map(place)
      const within = places.filter(inside)
      const at = within.slice(0, 1).find(one => free(one, APART)) ??
        ELSEWHERE.map(apart => within.find(one => free(one, apart))).find(one => one != null)
      if (at != null) found.push([curve, at])
    }
  }
  return found
}

// Scatter with the columns x, y, marker and colour.
const scatter = data => {
  const { ColumnDataSource } = Bokeh.loader["models/sources/column_data_source"]
  const { Scatter } = Bokeh.loader["models/glyphs/scatter"]
  const { GlyphRenderer } = Bokeh.loader["models/renderers/glyph_renderer"]
  const open = data.marker.map(shape => OPEN.includes(shape))
  const looks = { edge: open.map((one, k) => one ? data.colour[k] : EDGE), thickness: open.map(one => one ? 2 : 1) }
  const fields = {
    x: "x", y: "y", marker: "marker", fill_color: "colour", line_color: "edge", line_width: "thickness",
  }
  const glyph = new Scatter({
    size: { value: SIZE }, ...Object.fromEntries(Object.entries(fields).map(([name, field]) => [name, { field }])),
  })
  return new GlyphRenderer({ data_source: new ColumnDataSource({ data: { ...data, ...looks } }), glyph })
}

// What stands in a legend for the curves of a renderer: their lines, and over them their markers. Bokeh asks that both have
// one source.
const keys_of = (renderer, { marker, colour }) => {
  const nowhere = marker.map(() => NaN)
  const marks = scatter({ ...renderer.data_source.data, x: nowhere, y: nowhere, marker, colour: Array.from(colour) })
  return [copied(renderer, { data_source: marks.data_source }), marks]
}

// Of a logarithmic or linear range, a number of pixels from its start to its end: place -> pixels, and back.
export const scale_of = ({ start, end }, pixels, logarithmic) => {
  const [on, off] = logarithmic ? [Math.log, Math.exp] : [value => value, value => value]
  const [low, high] = [on(start), on(end)]
  return {
    compute: value => (on(value) - low) / (high - low) * pixels, invert: at => off(low + at / pixels * (high - low)),
  }
}

// The renderers of a plot with markers above the curves, and what stands for some of them in a legend: renderer -> renderers;
// `frame` in pixels, and `scales` across and up.
export const with_markers = (renderers, [across, up], frame) => {
  const named = new Map(renderers.map(one => [one, columns_of(one)]).filter(([_, columns]) => columns != null))
  const keys = new Map([...named].map(([one, columns]) => [one, keys_of(one, columns)]))
  const curves = [...named.values()].flatMap(one => curves_of(one, (x, y) => [across.compute(x), up.compute(y)]))
  const marks = spread_over(curves, frame)
  const markers = scatter({
    x: marks.map(([_, [x]]) => across.invert(x)), y: marks.map(([_, [__, y]]) => up.invert(y)),
    marker: marks.map(([{ marker }]) => marker), colour: marks.map(([{ colour }]) => colour),
  })
  const last = renderers.findLastIndex(one => named.has(one))
  return { keys, renderers: renderers.flatMap((one, k) => [...keys.get(one) ?? [one], ...k == last ? [markers] : []]) }
}

// The entries of a legend, those of integrators with their markers.
export const with_keys = (items, keys) => items.map(
  item => item.renderers.some(one => keys.has(one))
    ? copied(item, { renderers: item.renderers.flatMap(one => keys.get(one) ?? [one]) }) : item)
