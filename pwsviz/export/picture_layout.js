// A figure laid out anew for a picture of a given width: text keeps its size, and everything is inside.

import { face, typeset, width_of } from "./picture_letters.js"
import { with_curves_cut, with_turns_apart } from "./picture_clip.js"
import { scale_of, with_keys, with_markers } from "./picture_markers.js"
import { copied, with_names_placed } from "./picture_names.js"

export const TEXT = 17  // pixels of text in the copy, which is then scaled so that they become the points asked for; it is
// larger than on the page, as marks and lines are finer in print
export const INK = "#000000", PAPER = "#ffffff"

export const GAP = 10  // pixels between figure and caption, and around the caption

const RULE = "#e2e2e2"
export const SMALL = TEXT - 1  // of labels and captions
const ON_PAGE = 12  // pixels of names within a frame on the page; smaller ones are parts of marks, and have as many in print
const PASSES = 3  // layouts, each of which knows the one before: titles in lines, then the room beside them, then all
const RIM = 3  // pixels inside of a frame that are free of names
const SPARE = 8  // pixels beside a text, where another may begin
const LINE = 1.3  // height of a line of text, in heights of its letters
const NAMED = 0.16  // most of the width of the picture that the names of levels take beside the frame; and in a column above a
const NAMED_IN_COLUMN = 0.03  // caption that tells them

const text = (name, size) => ({ [`${name}_text_font`]: face.family, [`${name}_text_font_size`]: `${size}px` })
const letters_of = kind => ({
  axis: {
    ...text("axis_label", TEXT), ...text("major_label", SMALL), axis_label_standoff: 2, major_label_standoff: 3,
    major_tick_in: 0, major_tick_out: 5,
  },
  legend: text("label", TEXT),
  bar: { ...text("title", TEXT), ...text("major_label", SMALL) },
})[kind]
const shown = name => ({ [`${name}_line_color`]: INK, [`${name}_line_alpha`]: 1, [`${name}_line_width`]: 1 })
const PRINTED = {
  plot: { background_fill_color: PAPER, border_fill_color: PAPER, ...shown("outline") },
  axis: {
    axis_label_text_color: INK, major_label_text_color: INK, ...shown("axis"), ...shown("major_tick"),
    minor_tick_line_color: null,
  },
  legend: { label_text_color: INK, background_fill_color: PAPER, border_line_color: null },
  bar: { title_text_color: INK, major_label_text_color: INK, background_fill_color: PAPER },
  grid: { grid_line_color: RULE },
}

// The spaces of a text but those in formulas, after a comma in brackets, and after an article and words with a number: t = 20,
// (1, 2), x² + y², ‖x − x*‖ and “order 2” stay on one line.
const BETWEEN_WORDS = /(?<![=<>≤≥≈×+−·Σᵢ])(?<!\b(?:order|region))(?<!(?<![^ (“])[Aa])(?<!\((?:[^() ]+, )*[^() ]+,) (?![=<>≤≥≈]|[+−×·] )/

// The spaces at which a formula that is wider than a line breaks: after a sign between terms.
const BETWEEN_TERMS = /(?<= [+−]) /

// The words of a text, or its parts between other separators; what is wider than a number of pixels is broken between terms, and
// what is still too wide at any space.
const unbroken = (words, width, size, between) => {
  const parted = (parts, at) => parts.flatMap(one => width_of(one, size) > width ? one.split(at) : [one])
  return parted(parted(words.split(between).filter(Boolean), BETWEEN_TERMS), " ")
}
// The lines of a text, none wider than a number of pixels where there is a place to break it.
export const wrapped = (words, width, size, between = BETWEEN_WORDS) => {
  const lines = []
  for (const word of unbroken(words, width, size, between)) {
    const longer = lines.length > 0 ? `${lines.at(-1)} ${word}` : word
    if (lines.length > 0 && width_of(longer, size) <= width) lines[lines.length - 1] = longer
    else lines.push(word)
  }
  return lines
}

// The same as a paragraph of even lines: of all ways to break it, that with the least white at the ends of lines. A formula breaks
// after “=” only where this saves white.
const AFTER_RELATION = /(?<= [=≈]) /, IN_FORMULA = 0.04, SHORT = 0.3  // cost of such a break; part of the width of a last line
export const paragraph = (words, width, size) => {
  const pieces = unbroken(words, width, size, BETWEEN_WORDS).flatMap(
    piece => piece.split(AFTER_RELATION).map((word, k) => ({ word, within: k > 0 })))
  const space = width_of(" ", size), wide = pieces.map(({ word }) => width_of(word, size)), count = pieces.length
  const best = [{ cost: 0, from: 0 }]  // of the lines before each piece
  for (let end = 1; end <= count; end++) {
    best.push({ cost: Infinity, from: end - 1 })
    for (let from = end - 1, long = -space; from >= 0; from--) {
      long += wide[from] + space
      if (long > width && from < end - 1) break
      const white = end < count ? Math.max(0, 1 - long / width) : Math.max(0, SHORT - long / width)
      const cost = best[from].cost + white ** 2 + (end < count && pieces[end].within ? IN_FORMULA : 0)
      if (cost < best[end].cost) best[end] = { cost, from }
    }
  }
  const lines = []
  for (let end = count; end > 0; end = best[end].from) {
    lines.unshift(pieces.slice(best[end].from, end).map(({ word }) => word).join(" "))
  }
  return lines
}

// Whether a model has words as long as a part of the figure is being drawn.
export const is_of_drawing = model => model.tags.includes("drawing")

const kind_of = model => {
  if ("axis_label" in model) return "axis"
  if (model.type == "Legend") return "legend"
  if (model.type == "ColorBar") return "bar"
  return model.type == "Grid" ? "grid" : null
}

// Places near the wished ones, in ascending order, but some distances apart and between two ends, if there is the room.
const spread = (wished, apart, [start, end]) => {
  const places = [...wished]
  places.forEach((_, k) => { places[k] = Math.max(places[k], k > 0 ? places[k - 1] + apart[k - 1] : start) })
  for (let k = places.length - 1; k >= 0; k--) {
    places[k] = Math.min(places[k], k + 1 < places.length ? places[k + 1] - apart[k] : end)
  }
  return places
}

// Whether an axis beside a plot names levels in it.
const names_levels = (axis, side) => axis.ticker?.type == "FixedTicker" && axis.formatter.doFormat != null && side == "right"

// The levels of an axis that are seen, downwards, their names, and how they are labelled: by these in a line; else by what they
// begin with, such as “eps” of “eps = 2⁻⁵²”; and by letters where one of these is too wide, too.
const levels_of = (axis, { start, end }, width, captioned) => {
  const seen = [...axis.ticker.ticks].filter(tick => start <= tick && tick <= end).sort((a, b) => b - a)
  const words = axis.formatter.doFormat(seen, { loc: 0 }).map(name => name.replaceAll("\n", " ").trim())
  const levels = seen.filter((_, k) => words[k] != ""), names = words.filter(name => name != "")
  const short = names.map(name => name.split(/ = |: /)[0]), letters = names.map((_, k) => String.fromCharCode(97 + k))
  const fit = labels => labels.every(label => width_of(label, SMALL) <= (captioned && width < NARROW ? NAMED_IN_COLUMN : NAMED) * width)
  return { levels, names, short, labels: [names, short].find(fit) ?? letters }
}

// What the labels of levels stand for, in a sentence; null where they are the names. `captioned`: whether there is a caption,
// without which short names are not explained.
export const explained_levels = ({ frame, model }, width, captioned) => {
  const meanings = model.right.filter(axis => names_levels(axis, "right")).flatMap(axis => {
    const { names, short, labels } = levels_of(axis, frame.y_scale.source_range, width, captioned)
    if (labels == names) return []
    if (labels == short) return captioned ? names.filter((name, k) => name != short[k]) : []
    return names.map((name, k) => `(${labels[k]}) ${name}`)
  })
  return meanings.length > 0 ? `Dotted: ${meanings.join("; ")}.` : null
}

// Whether not all marks are drawn: the legend says so on the page, where each panel has one.
export const thinned = ({ model }) => model.below.filter(one => kind_of(one) == "legend").flatMap(one => one.items)
  .some(item => item.visible && item.get_labels_list_from_label_prop().some(label => label.endsWith("omitted)")))

// Names of levels beside a plot, apart from one another.
const named_levels = (axis, { scale, captioned }, width) => {
  const { start, end } = scale.source_range, { levels, labels } = levels_of(axis, scale.source_range, width, captioned)
  const letters = labels.every(label => label.length == 1), apart = labels.map(() => (letters ? 1 : LINE) * SMALL)  // closer
  const places = spread(levels.map(tick => scale.compute(tick)), apart, [end, start].map(one => scale.compute(one)))
  const moved = places.map(place => scale.invert(place))
  const { AllLabels } = Bokeh.loader["models/policies/labeling"]
  const { FixedTicker } = Bokeh.loader["models/tickers/fixed_ticker"]
  const { BasicTickFormatter } = Bokeh.loader["models/formatters/basic_tick_formatter"]
  return {
    ticker: new FixedTicker({ ticks: moved }), formatter: new BasicTickFormatter(), major_label_policy: new AllLabels(),
    major_label_overrides: new Map(moved.map((tick, k) => [tick, labels[k]])),
    major_tick_line_color: null, major_tick_out: 0, major_label_standoff: letters ? 1 : SPARE / 2,
  }
}

// The ticker of an axis of numbers, with as many ticks as have room for their labels along a length in pixels, and two at least.
const fitted_ticker = ({ ticker, formatter }, range, length, across) => {
  if (ticker?.type != "BasicTicker") return ticker
  const per_unit = length / Math.abs(range.end - range.start)
  let least = ticker
  for (let count = ticker.desired_num_ticks; count > 1; count--) {
    const fewer = copied(ticker, { desired_num_ticks: count })
    const ticks = fewer.get_ticks(range.start, range.end, range, NaN).major
    if (ticks.length < 2) break
    least = fewer
    const sizes = formatter.doFormat(ticks, { loc: 0 }).map(label => across ? width_of(label, SMALL) : LINE * SMALL)
    const room = k => (ticks[k + 1] - ticks[k]) * per_unit - (sizes[k] + sizes[k + 1]) / 2
    if (ticks.slice(1).every((_, k) => room(k) >= (across ? SPARE : 0))) break
  }
  return least
}

// An axis whose title is within the picture, and whose labels are apart.
const fitted_axis = (axis, side, seen, width) => {
  const { NoOverlap } = Bokeh.loader["models/policies/labeling"]
  const across = side == "below" || side == "above", { left, right } = seen
  const room = across ? 2 * Math.min((left + width - right) / 2, width - (left + width - right) / 2) : seen.tall
  const phrases = wrapped(axis.axis_label ?? "", room, TEXT, /(?<=,) /)  // a formula stays on one line where it can
  const title = { axis_label: phrases.flatMap(phrase => wrapped(phrase, room, TEXT)).join("\n") || null }
  if (names_levels(axis, side)) return { ...title, ...named_levels(axis, seen, width) }
  return { ...title, major_label_policy: new NoOverlap({ min_distance: SPARE / 2 }) }
}

// The widths of the entries of a legend.
const entry_widths = ({ items, glyph_width, label_standoff }) => items.filter(item => item.visible)
  .flatMap(item => item.get_labels_list_from_label_prop())
  .map(label => glyph_width + label_standoff + width_of(label, TEXT) + SPARE)

// A legend beside a frame that is narrower than the picture, in one column.
const column_width = legend => Math.ceil(Math.max(0, ...entry_widths(legend))) + 2 * SPARE
const legend_beside = legend => ({
  ncols: 1, spacing: SPARE / 2, location: "top_left", orientation: "vertical", margin: 0, stylesheets: [
    `svg { width: ${legend.glyph_width}px; height: ${legend.glyph_height}px }
     :host { width: ${column_width(legend)}px; translate: ${SPARE}px 0 }`],
})

// A legend in the middle of the picture, as wide as its caption at most: in one line, in lines of entries one after another, or in
// columns where these are fewer.
const fitted_legend = (legend, seen, width) => {
  const { glyph_width, glyph_height } = legend, room = width - 2 * GAP, widths = entry_widths(legend)
  const fits = count => {  // each column is as wide as its widest entry
    const wide = Array(count).fill(0)
    widths.forEach((one, k) => { wide[k % count] = Math.max(wide[k % count], one) })
    return wide.reduce((sum, one) => sum + one, 0) <= room
  }
  let ncols = Math.max(1, widths.length)
  while (ncols > 1 && !fits(ncols)) ncols -= 1
  const lines = widths.reduce(([count, used], one) => used + one <= room ? [count, used + one] : [count + 1, one], [1, 0])[0]
  const rows = Math.ceil(widths.length / ncols), flows = rows > 1 && lines <= rows, narrow = 100
  const shift = (seen.right - seen.left) / 2  // it stands below the frame
  return {
    ncols, spacing: SPARE / 2, stylesheets: [  // it is laid out before its glyphs have a size, and as a narrow one, lest
      // it widen the plot
      `svg { width: ${glyph_width}px; height: ${glyph_height}px }
       :host { width: ${narrow}px; translate: ${shift}px 0 }
       .bk-grid.bk-grid { width: ${room}px; position: relative; left: ${(narrow - room) / 2}px; justify-content: center;
                          gap: 2px ${SPARE}px; ${flows ? "display: flex; flex-wrap: wrap" : ""} }`,
    ],
  }
}

// The parts around a frame, its legend beside it rather than below.
const placed_anew = (parts, beside) => {
  if (!beside) return parts
  const legends = parts.below.filter(one => kind_of(one) == "legend")
  return { ...parts, below: parts.below.filter(one => !legends.includes(one)), right: [...parts.right, ...legends] }
}

// With `seen`, the layout before this one, in pixels: what is left and right of the frame, its height, and its scale.
const copy_of = async (view, width, printed, { height, inset, beside }, seen) => {
  const { model } = view, looks = printed ? PRINTED : {}
  const range = one => new (Bokeh.loader["models/ranges/range1d"].Range1d)({ start: one.start, end: one.end })
  const ranges = [range(model.x_range), range(model.y_range)], [left, right] = [seen.left + inset, seen.right + inset]
  const frame = { width: Math.round(width - left - right), height: Math.round(height) }
  const letters = { text_font: { value: face.family }, text_font_size: { value: `${SMALL}px` } }
  const named = await with_names_placed(model.renderers, ranges, frame, letters)
  const scales = [model.x_scale, model.y_scale].map(
    ({ type }, k) => scale_of(ranges[k], [frame.width, frame.height][k], type == "LogScale"))
  const curves = with_turns_apart(with_curves_cut(named, scales, frame), frame.width / view.frame.bbox.width)
  const marked = printed ? with_markers(curves, scales, frame) : { renderers: curves, keys: new Map() }
  const keys = new Map(named.flatMap((one, k) => {  // what stands in the legend for a renderer of the page
    const key = marked.keys.get(curves[k]) ?? (curves[k] == one ? null : [curves[k]])
    return key == null ? [] : [[one, key]]
  }))
  const tickers = new Map(["below", "left"].flatMap((place, k) => model[place].filter(one => kind_of(one) == "axis").map(
    axis => [axis.ticker, fitted_ticker(axis, ranges[k], [frame.width, frame.height][k], k == 0)])))
  const part = (one, side) => {
    const kind = kind_of(one)
    if (kind == null) return one
    const changes = { ...letters_of(kind), ...looks[kind] }
    const own = one.ticker ?? one.axis?.ticker, ticker = tickers.get(own) ?? own
    if (kind == "axis") return copied(one, { ...changes, ticker, ...fitted_axis(one, side, seen, width) })
    if (kind == "legend") {
      const placed = beside ? legend_beside(one) : fitted_legend(one, seen, width)
      return copied(one, { ...changes, ...placed, items: with_keys(one.items, keys) })
    }
    if (kind == "bar") return copied(one, changes)
    return copied(one, { ...changes, axis: null, ticker })
  }
  return copied(model, {
    ...looks.plot, min_border_left: left, min_border_right: right,
    sizing_mode: "fixed", width: null, height: null, styles: {}, match_aspect: false,
    output_backend: "svg",  // the legend is drawn on layers of its own
    frame_width: frame.width, frame_height: frame.height,
    renderers: marked.renderers, x_range: ranges[0], y_range: ranges[1], toolbar_location: null,
    toolbar: new model.toolbar.constructor({ tools: [] }),
    ...placed_anew(Object.fromEntries(["left", "right", "above", "below", "center"].map(
      place => [place, model[place].filter(one => !is_of_drawing(one)).map(one => part(one, place))])), beside),
  })
}

// What `use` makes of a copy laid out in this way.
const laid_out = async (copy, use) => {
  const host = document.createElement("div")
  host.style.cssText = "position: fixed; left: -10000px; top: 0; visibility: hidden"
  document.body.append(host)
  const { build_view } = Bokeh.loader["core/build_views"]
  const { ViewManager } = Bokeh.loader["core/view_manager"]
  const view = await build_view(copy, { parent: null, owner: new ViewManager() })
  try {
    view.build(host)
    await view.ready
    for (let k = 0; k < 3; k++) await new Promise(resolve => setTimeout(resolve, 60))
    return use(view, host)
  } finally {
    view.remove()
    host.remove()
  }
}

// Images with all of their pixels: Bokeh paints them anew at the size of the frame, where those between its pixels are lost.
const keep_pixels = (svg, plot) => {
  const painted = [...plot.renderer_views.values()].flatMap(one => one.glyph?.image_data ?? []).filter(one => one != null)
  const images = svg.querySelectorAll("image")
  if (images.length == painted.length) images.forEach((one, k) => one.setAttribute("href", painted[k].toDataURL()))
}

// Without the second copy of each text, of its outline, where that is not seen: it would be read and copied twice.
const drop_unseen = svg => {
  svg.querySelectorAll('text[fill="none"][stroke-opacity="0"]').forEach(words => words.remove())
}

// Each shade of ground as opaque as it is to be in print: deep enough to be told from others without its colour, and the same in
// every picture. `shades`: colour -> opacity.
const SHADE = 0.25  // what is less opaque on the page is a shade
const hexadecimal = colour => `#${colour.match(/[0-9]+/g).map(part => Number(part).toString(16).padStart(2, "0")).join("")}`
const deepen_shades = (svg, shades) => {
  for (const area of svg.querySelectorAll("[fill^=rgb][fill-opacity]")) {
    const opacity = shades[hexadecimal(area.getAttribute("fill")).toUpperCase()]
    if (opacity != null && parseFloat(area.getAttribute("fill-opacity")) < SHADE) area.setAttribute("fill-opacity", opacity)
  }
}

// Names within the frame, whose places were found on the page, where the frame is larger beside them.
const keep_inside = (svg, frame) => {
  const page = svg.getBoundingClientRect(), left = page.left + frame.left + RIM, top = page.top + frame.top + RIM
  const moved = (start, end, low, high) => {
    const middle = (start + end) / 2
    return low < middle && middle < high ? Math.max(0, low - start) + Math.min(0, high - end) : 0
  }
  for (const words of svg.querySelectorAll("text")) {
    words.setAttribute("font-family", face.family)
    if (words.closest("[clip-path]") == null) continue
    const large = parseFloat(words.getAttribute("font-size")) >= ON_PAGE
    words.setAttribute("font-size", `${large ? SMALL : ON_PAGE}px`)
    const box = words.getBoundingClientRect()
    const across = moved(box.left, box.right, left, left + frame.width - 2 * RIM)
    const down = moved(box.top, box.bottom, top, top + frame.height - 2 * RIM)
    const already = words.getAttribute("transform") ?? ""
    if (across != 0 || down != 0) words.setAttribute("transform", `translate(${across}, ${down}) ${already}`)
  }
}

// How far the texts beside a frame reach to its right.
const reach_of = (svg, frame) => {
  const edge = svg.getBoundingClientRect().left + frame.right
  const texts = [...svg.querySelectorAll("text")].filter(words => words.closest("[clip-path]") == null)
  return Math.max(0, ...texts.map(words => words.getBoundingClientRect().right - edge))
}

const SHAPE = 0.5  // height of a frame by the width of the picture, where neither is bound to the other
export const NARROW = 600, TALLER = 0.64  // pixels up to which a picture is of one column, and the same of its frame
const SHAPES = 1  // the same of several frames together

const LOWEST = 60  // pixels of a frame, however many there are

// A frame of at most a width and a height that shows what the screen shows, no more and no less, at equal scales; where it is
// narrower, it stands in the middle.
const equal_scales = ({ frame: { bbox } }, across, most) => {
  const height = Math.min(most, across * bbox.height / bbox.width)
  return { height, inset: (across - height * bbox.width / bbox.height) / 2 }
}

const AXES = 64  // pixels that axes take beside and below a frame, about

// Whether the legend of a figure at equal scales has room beside its frame, which is then taller, and so wider.
const has_room_beside = ({ model, frame: { bbox } }, width, tallest, least) => {
  const legend = model.below.find(one => kind_of(one) == "legend")
  const across = Math.max(least, tallest - AXES) * bbox.width / bbox.height
  return model.match_aspect && legend != null && width - AXES - across >= column_width(legend)
}

// Figures for a picture of a given width, together at most so tall where their frames have at least a height then: each as an SVG element with its size
// and the height of its frame in pixels. Frames have one left edge and one right edge.
export const drawn = async (views, width, { printed, shades, captioned }, tallest, least) => {
  const shape = Math.min(width < NARROW ? TALLER : SHAPE, SHAPES / views.length)
  let seen = views.map(({ frame }) => ({ left: 0, right: RIM, around: 0, tall: shape * width, scale: frame.y_scale, captioned }))
  const shape_of = (view, k) => {
    const around = seen.reduce((sum, one) => sum + one.around, 0)
    const most = Math.max(LOWEST, Math.max(least, tallest - around) / views.length), across = width - seen[k].left - seen[k].right
    const beside = has_room_beside(view, width, tallest, least)
    if (view.model.match_aspect) return { ...equal_scales(view, across, most), beside }
    return { height: Math.min(shape * width, most), inset: 0 }
  }
  const copy = (view, k) => copy_of(view, width, printed, shape_of(view, k), seen[k])
  for (let pass = 1; pass < PASSES; pass++) {
    const found = []
    for (const [k, view] of views.entries()) {
      const { inset } = shape_of(view, k)
      found.push(await laid_out(await copy(view, k), (other, host) => {
        const { bbox, frame } = other, svg = other.export("svg", false).canvas
        host.append(svg)
        const right = Math.max(bbox.width - frame.bbox.right, RIM + reach_of(svg, frame.bbox)) - inset
        const around = bbox.height - frame.bbox.height
        return { left: frame.bbox.left - inset, right, around, tall: frame.bbox.height, scale: frame.y_scale }
      }))
    }
    const most = side => Math.ceil(Math.max(...found.map(one => one[side])))
    seen = found.map(one => ({ ...one, captioned, left: most("left"), right: most("right") }))
  }
  const pictures = []
  for (const [k, view] of views.entries()) {
    pictures.push(await laid_out(await copy(view, k), (other, host) => {
      const { frame, bbox: { width, height } } = other, svg = other.export("svg", false).canvas
      host.append(svg)
      drop_unseen(svg)
      if (printed) deepen_shades(svg, shades)
      for (const words of svg.querySelectorAll("text")) typeset(words, parseFloat(words.getAttribute("font-size")) || SMALL)
      keep_pixels(svg, other)
      keep_inside(svg, frame.bbox)
      return { svg, width, height }
    }))
  }
  return pictures
}
