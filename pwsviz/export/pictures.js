// Pictures of a figure for a paper or a lecture, made in the browser: SVG, PDF and PNG, with a caption.
// A copy of the figure is laid out anew at the width and the text size asked for; it is drawn as vectors.

const FONT = "DejaVu Sans"
const HERE = new URL(".", import.meta.url)
const TEXT = 12  // pixels of text in the copy, which is then scaled so that they become the points asked for
const SHAPE = 0.62  // height of a frame by its width where neither is bound to the other
const SHAPES = 1.2  // the same of several frames together
const GAP = 10  // pixels between figure and caption, and around the caption
const LEADING = 1.35  // of the lines of the caption, in heights of its text
const POINTS_PER_MM = 72 / 25.4
const PIXELS_PER_MM = 96 / 25.4  // of a PNG at scale 1

const INK = "#000000", PAPER = "#ffffff", RULE = "#e2e2e2"
const text = (name, size) => ({ [`${name}_text_font`]: FONT, [`${name}_text_font_size`]: `${size}px` })
const SIZES = {
  axis: { ...text("axis_label", TEXT), ...text("major_label", TEXT - 1) },
  legend: text("label", TEXT),
  bar: { ...text("title", TEXT), ...text("major_label", TEXT - 1) },
}
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

let bytes = null  // of the font, fetched once
const load_font = async () => {
  if (bytes == null) {
    bytes = await (await fetch(new URL("vendor/DejaVuSans-subset.ttf", HERE))).arrayBuffer()
    document.fonts.add(await new FontFace(FONT, bytes.slice(0)).load())
  }
  return btoa(Array.from(new Uint8Array(bytes), byte => String.fromCharCode(byte)).join(""))
}

// The same model with some properties changed; models that it refers to are shared, callbacks are left out.
const LEFT_OUT = new Set(["js_event_callbacks", "js_property_callbacks", "subscribed_events", "name", "tags"])
const copied = (model, changes) => {
  const values = {}
  for (const property of model) {
    const { attr } = property
    if (!property.internal && !property.readonly && !property.is_unset && !LEFT_OUT.has(attr)) {
      values[attr] = property.get_value()
    }
  }
  return new model.constructor({ ...values, ...changes })
}

const kind_of = model => {
  if ("axis_label" in model) return "axis"
  if (model.type == "Legend") return "legend"
  if (model.type == "ColorBar") return "bar"
  return model.type == "Grid" ? "grid" : null
}

// With `borders`, its frame stands between these, in pixels; else between those that the figure has on the page.
const copy_of = (view, width, printed, height, borders) => {
  const { model } = view, looks = printed ? PRINTED : {}, grids = new Map()
  const part = one => {
    const kind = kind_of(one)
    if (kind == null) return one
    const changes = { ...SIZES[kind], ...looks[kind] }
    if (kind == "legend") {  // which is laid out before its glyphs have a size
      changes.stylesheets = [`svg { width: ${one.glyph_width}px; height: ${one.glyph_height}px }`]
    }
    if (kind == "axis" || kind == "legend" || kind == "bar") return copied(one, changes)
    return copied(one, { ...changes, axis: null, ticker: one.ticker ?? one.axis?.ticker })
  }
  const range = one => new (Bokeh.loader["models/ranges/range1d"].Range1d)({ start: one.start, end: one.end })
  const { bbox } = view.frame
  const across = width - (borders == null ? view.bbox.width - bbox.width : borders.left + borders.right)
  const sides = borders == null ? {} : { min_border_left: borders.left, min_border_right: borders.right }
  const shape = model.match_aspect ? bbox.height / bbox.width : height
  return copied(model, {
    ...looks.plot, ...sides, sizing_mode: "fixed", width: null, height: null, styles: {}, match_aspect: false,
    output_backend: "svg",  // the legend is drawn on layers of its own
    frame_width: Math.round(across), frame_height: Math.round(across * shape),
    x_range: range(model.x_range), y_range: range(model.y_range), toolbar_location: null,
    toolbar: new model.toolbar.constructor({ tools: [] }),
    ...Object.fromEntries(["left", "right", "above", "below", "center"].map(place => [place, model[place].map(part)])),
  })
}

// The figure as an SVG element, its size and what is left and right of its frame, in pixels.
const drawn = async (view, width, printed, height, borders) => {
  const host = document.createElement("div")
  host.style.cssText = "position: fixed; left: -10000px; top: 0; visibility: hidden"
  document.body.append(host)
  const copy = copy_of(view, width, printed, height, borders)
  const { build_view } = Bokeh.loader["core/build_views"]
  const { ViewManager } = Bokeh.loader["core/view_manager"]
  const other = await build_view(copy, { parent: null, owner: new ViewManager() })
  try {
    other.build(host)
    await other.ready
    for (let k = 0; k < 3; k++) await new Promise(resolve => setTimeout(resolve, 60))
    const svg = other.export("svg", false).canvas, { bbox, frame } = other
    return { svg, width: bbox.width, height: bbox.height, left: frame.bbox.left, right: bbox.width - frame.bbox.right }
  } finally {
    other.remove()
    host.remove()
  }
}

const lines_of = (caption, width) => {
  const pen = document.createElement("canvas").getContext("2d")
  pen.font = `${TEXT - 1}px "${FONT}"`
  const lines = [""]
  for (const word of caption.split(" ").filter(Boolean)) {
    const longer = `${lines.at(-1)} ${word}`.trim()
    if (pen.measureText(longer).width <= width) lines[lines.length - 1] = longer
    else lines.push(word)
  }
  return caption == "" ? [] : lines
}

const node = (name, attributes, words) => {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name)
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value)
  if (words != null) made.textContent = words
  return made
}

// One SVG element of the figures, one below the other, with the caption below.
const composed = async (views, wish) => {
  const font = await load_font()
  const width = wish.millimetres * POINTS_PER_MM / wish.points * TEXT
  const shape = Math.min(SHAPE, SHAPES / views.length), pictures = []
  for (const view of views) pictures.push(await drawn(view, width, wish.printed, shape))
  if (views.length > 1) {  // frames below one another: the labels of each axis get the room of the widest
    const most = side => Math.ceil(Math.max(...pictures.map(one => one[side])))
    const borders = { left: most("left"), right: most("right") }
    for (const [k, view] of views.entries()) pictures[k] = await drawn(view, width, wish.printed, shape, borders)
  }
  const picture = { width: pictures[0].width, height: pictures.reduce((sum, one) => sum + one.height, 0) }
  const lines = lines_of(wish.caption, picture.width - 2 * GAP), step = LEADING * (TEXT - 1)
  const height = picture.height + (lines.length > 0 ? 2 * GAP + step * lines.length : 0)
  const svg = node("svg", {
    xmlns: "http://www.w3.org/2000/svg", width: `${wish.millimetres}mm`,
    height: `${wish.millimetres * height / picture.width}mm`, viewBox: `0 0 ${picture.width} ${height}`,
  })
  svg.append(node("title", {}, wish.title), node("style", {},
    `@font-face { font-family: "${FONT}"; src: url(data:font/ttf;base64,${font}) }`))
  const [ground, ink] = wish.printed ? [PAPER, INK] : colours_of(views[0].el)
  svg.append(node("rect", { x: 0, y: 0, width: picture.width, height, fill: ground }))
  let top = 0
  for (const one of pictures) {
    const part = node("g", { transform: `translate(0, ${top})` })
    part.append(...one.svg.childNodes)
    svg.append(part)
    top += one.height
  }
  for (const written of svg.querySelectorAll("text")) written.setAttribute("font-family", FONT)
  lines.forEach((line, k) => svg.append(node("text", {
    x: GAP, y: picture.height + GAP + step * (k + 0.8), fill: ink, "font-family": FONT, "font-size": `${TEXT - 1}px`,
  }, line)))
  return { svg, width: picture.width, height }
}

// Colours of the page behind a figure, and of its text.
const colours_of = el => {
  for (let at = el; at != null; at = at.parentElement ?? at.getRootNode().host) {
    const { backgroundColor, color } = getComputedStyle(at)
    if (!/^transparent$|, 0\)$/.test(backgroundColor)) return [backgroundColor, color]
  }
  return [PAPER, INK]
}

const script = path => new Promise((resolve, reject) => {
  const element = document.createElement("script")
  element.src = new URL(path, HERE)
  element.onload = resolve
  element.onerror = () => reject(new Error(`${path} was not found`))
  document.head.append(element)
})

const checksum = bytes => {  // the CRC of PNG
  let rest = ~0
  for (const byte of bytes) {
    rest ^= byte
    for (let k = 0; k < 8; k++) rest = rest & 1 ? rest >>> 1 ^ 0xedb88320 : rest >>> 1
  }
  return ~rest >>> 0
}

// A PNG that says how wide it is meant to be: with the chunk pHYs after its header.
const PNG_HEADER = 33  // bytes: the signature and the chunk IHDR
const of_width = (png, pixels_per_metre) => {
  const chunk = new DataView(new ArrayBuffer(21))
  chunk.setUint32(0, 9)
  chunk.setUint32(4, 0x70485973)  // "pHYs"
  chunk.setUint32(8, pixels_per_metre)
  chunk.setUint32(12, pixels_per_metre)
  chunk.setUint8(16, 1)  // metres
  chunk.setUint32(17, checksum(new Uint8Array(chunk.buffer, 4, 13)))
  return new Blob([png.slice(0, PNG_HEADER), chunk, png.slice(PNG_HEADER)], { type: png.type })
}

// jsPDF names the character collection of a font after its encoding; ISO 32000-1, 9.7.3, asks for that of the identity.
// As long as before: the table at the end of the file tells where each object begins.
const conforming = pdf => pdf.replaceAll("/Ordering (Identity-H)", "/Ordering (Identity)  ")

const WRITERS = {
  async svg({ svg }) {
    return new Blob([new XMLSerializer().serializeToString(svg)], { type: "image/svg+xml" })
  },
  async png({ svg, width, height }, wish) {
    const image = new Image()
    const address = URL.createObjectURL(await WRITERS.svg({ svg }))
    image.src = address
    await image.decode()
    const canvas = document.createElement("canvas")
    canvas.width = Math.round(wish.millimetres * PIXELS_PER_MM * wish.scale)
    canvas.height = Math.round(canvas.width * height / width)
    canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height)
    URL.revokeObjectURL(address)
    const made = await new Promise(resolve => canvas.toBlob(resolve, "image/png"))
    return of_width(made, Math.round(canvas.width / wish.millimetres * 1000))
  },
  async pdf({ svg, width, height }, wish) {
    if (globalThis.svg2pdf == null) {  // half a megabyte, which only a PDF needs
      await script("vendor/jspdf.umd.min.js")
      await script("vendor/svg2pdf.umd.min.js")
    }
    const size = [wish.millimetres, wish.millimetres * height / width]
    const paper = new jspdf.jsPDF({ unit: "mm", format: size, orientation: size[0] > size[1] ? "l" : "p", compress: true })
    paper.setProperties({ title: wish.title, subject: wish.caption, creator: "pwsviz" })
    paper.addFileToVFS("font.ttf", await load_font())
    for (const style of ["normal", "italic", "bold"]) paper.addFont("font.ttf", FONT, style)
    paper.setFont(FONT)
    await paper.svg(svg, { x: 0, y: 0, width: size[0], height: size[1] })
    return new Blob([Uint8Array.from(conforming(paper.output()), byte => byte.charCodeAt(0))], { type: "application/pdf" })
  },
}

const amount = words => Number(/[0-9]+/.exec(words)[0])  // such as that of “175 mm”

// Save figures as one picture. `chosen` has kind ("svg", "pdf" or "png"), name, title, caption, and the choices width, points, scale
// and look as they are offered.
export const save = async (ids, chosen) => {
  const views = ids.map(id => Bokeh.index.find_one_by_id(id)).filter(view => view != null)
  if (views.length == 0) return
  const [millimetres, points, scale] = [chosen.width, chosen.points, chosen.scale].map(amount)
  const wish = { ...chosen, millimetres, points, scale, printed: chosen.look == "for print" }
  const blob = await WRITERS[wish.kind](await composed(views, wish), wish)
  const link = document.createElement("a")
  link.href = URL.createObjectURL(blob)
  link.download = wish.name
  link.click()
  setTimeout(() => URL.revokeObjectURL(link.href), 60000)
}
