// Curves as a picture has room for them. They end where it does: a run that blows up goes so far beyond that no program dashes
// all of its line, and some leave it out. Where their turns are close, they are thin.

import { copied } from "./picture_names.js"

const FAR = 20  // frames from the frame beyond which a curve is cut
const BESIDE = 1  // frames beside the frame that are kept of it

// The part of a segment within a rectangle, as two numbers from 0 at its start to 1 at its end; null of one that misses it (Liang
// and Barsky).
const within = ([x0, y0], [x1, y1], { left, right, top, bottom }) => {
  let [from, to] = [0, 1]
  for (const [step, room] of [[x0 - x1, x0 - left], [x1 - x0, right - x0], [y0 - y1, y0 - top], [y1 - y0, bottom - y0]]) {
    if (step == 0 && room < 0) return null
    if (step < 0) from = Math.max(from, room / step)
    if (step > 0) to = Math.min(to, room / step)
  }
  return from <= to ? [from, to] : null
}

// A path in pixels cut to a rectangle; its pieces are apart by a place that is not a number.
export const cut = (path, box) => {
  const found = []
  const push = ([x, y]) => {
    const last = found.at(-1)
    if (last == null || last[0] != x || last[1] != y) found.push([x, y])
  }
  for (let n = 1; n < path.length; n++) {
    const [[x0, y0], [x1, y1]] = [path[n - 1], path[n]]
    const part = [x0, y0, x1, y1].every(Number.isFinite) ? within(path[n - 1], path[n], box) : null
    if (part == null) {
      if (found.length > 0 && !Number.isNaN(found.at(-1)[0])) found.push([NaN, NaN])
      continue
    }
    if (part[0] > 0 && found.length > 0 && !Number.isNaN(found.at(-1)[0])) found.push([NaN, NaN])
    part.forEach(at => push([x0 + at * (x1 - x0), y0 + at * (y1 - y0)]))
  }
  return found
}

// The renderers of a plot, those of curves that go far beyond its frame in copies that end beside it; `scales`: place -> pixels
// from a corner of the frame, and back, across and up.
export const with_curves_cut = (renderers, [across, up], { width, height }) => {
  const box = by => ({ left: -by * width, right: (1 + by) * width, top: -by * height, bottom: (1 + by) * height })
  const [far, kept] = [box(FAR), box(BESIDE)]
  const beyond = path => path.some(([x, y]) => x < far.left || x > far.right || y < far.top || y > far.bottom)
  return renderers.map(renderer => {
    const { glyph, data_source } = renderer
    if (glyph?.type != "MultiLine" || glyph.xs?.field == null || glyph.ys?.field == null) return renderer
    const { data } = data_source, [xs, ys] = [data[glyph.xs.field], data[glyph.ys.field]]
    const paths = Array.from(xs, (x, k) => Array.from(x, (one, n) => [across.compute(one), up.compute(ys[k][n])]))
    if (!paths.some(beyond)) return renderer
    const ends = paths.map(path => beyond(path) ? cut(path, kept) : path)
    const columns = {
      [glyph.xs.field]: ends.map(path => path.map(([x]) => across.invert(x))),
      [glyph.ys.field]: ends.map(path => path.map(([_, y]) => up.invert(y))),
    }
    return copied(renderer, { data_source: copied(data_source, { data: { ...data, ...columns } }) })
  })
}

// The renderers of a plot, those of curves whose turns are so close that they are not dashed in copies that are thinner, as the
// picture is smaller than the page: a part of its width.
export const with_turns_apart = (renderers, part) => renderers.map(renderer => {
  const { data_source } = renderer, { stroke, dash, width, ...others } = data_source?.data ?? {}
  if (part >= 1 || stroke == null || width == null) return renderer  // those of a legend have no width of their own
  const thinner = Array.from(width, (one, k) => stroke[k].length < dash[k].length ? part * one : one)
  return copied(renderer, { data_source: copied(data_source, { data: { ...others, stroke, dash, width: thinner } }) })
})
