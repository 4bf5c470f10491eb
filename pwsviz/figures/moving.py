"""JavaScript that evaluates formulas, follows a moving surface, and tells what is under the pointer."""

from __future__ import annotations

from pwsviz.geometry.formulas import FUNCTIONS
from pwsviz.text.numbers import PRINTED

__all__ = ["AWAIT", "ELSEWHEN", "REPAINT", "TELL_PLACE"]

ELSEWHEN = " (at other times)"
"""What follows the name of tinted regions in a legend while they are not in sight."""

FORMULAS = """
const KNOWN = new Set(FUNCTIONS)
// A function of (x, y, t) for a tree of numbers, names and known operations; nothing is run as code.
const formula = tree => {
  if (tree == null) { return null }
  if (typeof tree == "number") { return () => tree }
  if (tree == "x") { return x => x }
  if (tree == "y") { return (_x, y) => y }
  if (tree == "t") { return (_x, _y, t) => t }
  const [name, ...rest] = tree, parts = rest.map(formula), [a, b] = parts
  if (name == "add") { return (x, y, t) => parts.reduce((sum, part) => sum + part(x, y, t), 0) }
  if (name == "mul") { return (x, y, t) => parts.reduce((product, part) => product * part(x, y, t), 1) }
  if (name == "pow") { return (x, y, t) => Math.pow(a(x, y, t), b(x, y, t)) }
  if (name == "abs") { return (x, y, t) => Math.abs(a(x, y, t)) }
  if (!KNOWN.has(name)) { return () => NaN }
  const operation = Math[name]
  return (x, y, t) => operation(a(x, y, t))
}
const given = JSON.parse(formulas.data.text[0] || "null")
const heights = (given?.g ?? []).map(formula)
""".replace("FUNCTIONS", str(list(FUNCTIONS)))

REPAINT = (
    FORMULAS
    + """
const t = clock.data.t[0] + (given?.after ?? 0), running = clock.data.running[0]
// Outline where values at the nodes of a grid are below 0: in pieces to fill, and in the segments of its edge.
const trace = (xs, ys, values, fill, edge) => {
  for (let j = 0; j + 1 < ys.length; j++) {
    let from = null  // first of the cells in this row that lie wholly below
    const close = i => {
      if (from != null) { fill([xs[from], xs[i], xs[i], xs[from]], [ys[j], ys[j], ys[j + 1], ys[j + 1]]) }
      from = null
    }
    for (let i = 0; i + 1 < xs.length; i++) {
      const corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]]
      const levels = corners.map(([k, l]) => values[l][k])
      const below = levels.filter(value => value < 0).length
      if (below == 4) { from ??= i; continue }
      close(i)
      if (below == 0) { continue }
      const rx = [], ry = [], met = []
      for (let k = 0; k < 4; k++) {
        const [[i0, j0], [i1, j1]] = [corners[k], corners[(k + 1) % 4]], [u, v] = [levels[k], levels[(k + 1) % 4]]
        if (u < 0) { rx.push(xs[i0]); ry.push(ys[j0]) }
        if (u < 0 != v < 0) {
          const share = u / (u - v)
          const place = [xs[i0] + share * (xs[i1] - xs[i0]), ys[j0] + share * (ys[j1] - ys[j0])]
          rx.push(place[0]); ry.push(place[1]); met.push(place)
        }
      }
      fill(rx, ry)
      for (let k = 0; k + 1 < met.length; k += 2) { edge(met[k], met[k + 1]) }
    }
    close(xs.length - 1)
  }
}
if (given?.moving && given.regions.length > 0) {
  const [across, up] = ranges
  const CELLS = 150   // along the longer side of what is painted
  const ROOM = 0.25   // of that beyond each edge of what is seen, for a pan
  const left = across.start - ROOM * (across.end - across.start), width = (1 + 2 * ROOM) * (across.end - across.start)
  const low = up.start - ROOM * (up.end - up.start), height = (1 + 2 * ROOM) * (up.end - up.start)
  const cell = Math.max(width, height) / CELLS
  const columns = Math.max(2, Math.round(width / cell)), rows = Math.max(2, Math.round(height / cell))
  const xs = Array.from({ length: columns + 1 }, (_, i) => left + i * width / columns)
  const ys = Array.from({ length: rows + 1 }, (_, j) => low + j * height / rows)
  const nodes = heights.map(g => ys.map(y => xs.map(x => g(x, y, t))))
  const name_entry = (entry, value) => {  // each change rebuilds the legend
    if (entry.label?.value != value) { entry.setv({ label: { value } }, { sync: false }) }
  }
  const sx = [], sy = []
  const nothing = () => {}
  const line = (a, b) => { sx.push(a[0], b[0], NaN); sy.push(a[1], b[1], NaN) }
  for (const g of nodes) { trace(xs, ys, g, nothing, line) }
  // Of regions of the first shade, an odd number of signs is −. A region that that is left out has no tint.
  const tinted = given.regions.map(([sides]) => sides).filter(sides => sides.reduce((a, b) => a * b, 1) < 0)
  const highest = (regions, i, j) =>
    Math.max(...regions.map(sides => Math.min(...sides.map((s, k) => s * nodes[k][j][i]))))
  const filled = (source, regions, sign) => {  // where none of these regions is (+), or one of them (-)
    const px = [], py = []
    const levels = ys.map((_y, j) => xs.map((_x, i) => sign * highest(regions, i, j)))
    trace(xs, ys, levels, (x, y) => { px.push([x]); py.push([y]) }, nothing)
    source.setv({ data: px.length > 0 ? { xs: [px], ys: [py] } : { xs: [], ys: [] } }, { sync: false })
    const meets = ([values], { start, end }) => Math.min(...values) < end && Math.max(...values) > start
    return px.some((rings, k) => meets(rings, across) && meets(py[k], up))  // whether any of it is in sight
  }
  name_entry(tint_entry, filled(side, tinted, -1) ? given.tint : `${given.tint}ELSEWHEN`)
  if (given.bare != "") { filled(bare, given.regions.map(([sides]) => sides), 1) }
  surface.setv({ data: { x: sx, y: sy } }, { sync: false })
  const name = heights.length == 1 ? "S: g = 0" : "surfaces"
  name_entry(entry, running || !given.curves_move ? name : `${name} at t = 0`)
  for (const [sources, sign] of [[lines_below, -1], [lines_above, 1]]) {
    for (const source of sources) {  // lines that are hidden on the other side
      const { whole, y, psi, at_x, at_y } = source.data
      if (whole == null) { continue }
      const x = Array.from(whole, (value, k) => sign * heights[0](at_x[k], at_y[k], t) > 0 ? value : NaN)
      source.setv({ data: { x, y, psi, whole, at_x, at_y } }, { sync: false })
    }
  }
}
if (given?.forced) {
  for (const renderer of arrows) { renderer.setv({ visible: !running }, { sync: false }) }  // they are those of t = 0
}
"""
).replace("ELSEWHEN", ELSEWHEN)
"""JavaScript run when the player shows another time, or the backdrop is new: what moves is painted as it is then."""

TELL_PLACE = (
    FORMULAS
    + PRINTED
    + """
const { x, y } = cb_obj, [across, up] = ranges
const inside = across.start <= x && x <= across.end && up.start <= y && y <= up.end
const words = []
if (inside && cb_obj.event_name != "mouseleave") {
  const fixed = (drawn, unit) => {
    const digits = Math.min(20, Math.max(0, Math.ceil(2.5 - Math.log10((across.end - across.start) * unit))))
    return printed((Math.abs(drawn * unit) < 0.5 * 10 ** -digits ? 0 : drawn * unit).toFixed(digits))
  }
  const [of_x, of_y] = given?.units ?? [1, 1]
  words.push(`${formulas.data.across[0]} = ${fixed(x, of_x)}, ${formulas.data.up[0]} = ${fixed(y, of_y)}`)
  const t = clock.data.t[0] + (given?.after ?? 0), signs = heights.map(height => Math.sign(height?.(x, y, t)))
  const region = (given?.regions ?? []).find(([sides]) => sides.every((sign, k) => sign == signs[k]))
  if (region != null) {
    words.push(region[1])
    const psi = formula(region[3])?.(x, y, t)
    if (Number.isFinite(psi)) { words.push(`${region[2]} = ${printed(psi.toPrecision(4))}`) }
  } else if (given?.regions?.length > 0 && signs.every(sign => sign != 0)) {
    words.push(given.bare)
  }
}
readout.setv({ text: words.join(" \\u00b7 ") || "GESTURES" }, { sync: false })
"""
)
"""JavaScript run when the pointer moves over the portrait: place, side, ψ of that side; else GESTURES."""

AWAIT = """
const [left, right, low, high] = JSON.parse(formulas.data.text[0] || "null")?.window ?? []
const [across, up] = ranges
const lacks = across.start < left || across.end > right || up.start < low || up.end > high
const text = lacks ? "drawing what lies here \u2026" : ""
if (waiting.text != text) { waiting.setv({ text }, { sync: false }) }
"""
"""JavaScript run when the user pans or zooms: it says so as long as the backdrop does not cover what is seen."""
