// Pictures of a figure for a paper or a lecture, made in the browser: SVG, PDF and PNG, with a caption.
// A copy of the figure is laid out anew at the width and the text size asked for (by `picture_layout.js`); it is drawn as
// vectors.

import { choose_typeface, face, typeset } from "./picture_letters.js"
import { drawn, explained_levels, GAP, INK, is_of_drawing, NARROW, PAPER, paragraph, SMALL, TEXT, thinned } from "./picture_layout.js"

const HERE = new URL(".", import.meta.url)
const LEADING = 1.35  // of the lines of the caption, in heights of its text
const DENSE = 0.85, CLOSE = 1.2, FEWEST = 7, LEGIBLE = 7  // a caption of so many lines and more in a picture of one column is set
// smaller and closer, in no less than so many points
const INCH = 25.4  // mm
const SLACK = 4  // pixels by which a layout may be higher than the one before it, which tells what is around the frame
const LEAST = 1.2, PART = 0.62  // of the picture's width, or of the greatest height if that is less: what frames may take
// at least, however long the caption is

const EDGE = 0.6  // pixels of white on both sides of a dashed curve, at most
const BARED = 0.5  // part of what a dashed curve leaves free of the solid one that is white at most: the rest keeps its colour

const THINNED = "Where marks would crowd, some are omitted."
const loaded = {}  // of each family the upright and the slanted letters in base 64, fetched once
const load_face = async ([style, file]) => {
  const answer = await fetch(new URL(`vendor/${file}`, HERE))
  if (!answer.ok) throw new Error("its font was not found")
  const bytes = await answer.arrayBuffer()
  document.fonts.add(await new FontFace(face.family, bytes.slice(0), { style }).load())
  if (style == "italic") document.fonts.add(await new FontFace(face.slanted, bytes.slice(0)).load())  // a PDF is measured by it
  return [style, btoa(Array.from(new Uint8Array(bytes), byte => String.fromCharCode(byte)).join(""))]
}
const load_font = async () => {
  const { family, files } = face
  return loaded[family] ??= Object.fromEntries(await Promise.all(Object.entries(files).map(load_face)))
}

const node = (name, attributes, words) => {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name)
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value)
  if (words != null) made.textContent = words
  return made
}

const below = ({ lines, step }) => lines.length > 0 ? 2 * GAP + step * lines.length : GAP / 2  // what a caption takes below figures

// The lines of a caption, with the size of their text and their distance.
const set_caption = (words, width, points) => {
  const usual = { lines: paragraph(words, width - 2 * GAP, SMALL), size: SMALL, step: LEADING * SMALL }
  if (width >= NARROW || usual.lines.length < FEWEST) return usual
  const size = Math.min(SMALL, Math.max(DENSE * SMALL, LEGIBLE / points * TEXT))
  return { lines: paragraph(words, width - 2 * GAP, size), size, step: CLOSE * size }
}

// Figures of a width in pixels, with the lines of the caption below them. The caption that was asked for is always there: where
// it leaves the figures too little of the greatest height, the picture is higher.
const fitted = async (views, wish, width) => {
  const { printed, shades } = wish, captioned = wish.captions[wish.caption] != null
  const keys = views.map(view => explained_levels(view, width, captioned))
  const [caption, ...last] = (wish.captions[wish.caption] ?? "").split("\n")
  const words = [caption, caption && views.some(thinned) ? THINNED : "", ...keys, ...last].filter(Boolean).join(" ")
  const set = set_caption(words, width, wish.points), tallest = width / wish.millimetres * wish.tallest
  const least = Math.min(LEAST * width, PART * tallest)
  return { set, pictures: await drawn(views, width, { printed, shades, captioned }, tallest - below(set) - SLACK, least) }
}

// Of the curves of runs, which alone have round joins, the dashed ones lie on the solid one painted before them: without
// colours only white edges tell them from it. The edges lie below those dashed curves, none of which they interrupt, and within
// the solid one, which many turns would hide otherwise.
const CURVES = "path[stroke-linejoin=round]", DASHED = "[stroke-dasharray]"
const give_edges = picture => {
  const width = curve => Number(curve.getAttribute("stroke-width"))
  let solid = null
  for (const curve of picture.querySelectorAll(CURVES)) {
    if (!curve.matches(DASHED)) { solid = curve }
    if (solid == null || solid == curve || solid.parentNode != curve.parentNode) { continue }  // in a legend each is alone
    const edges = curve.cloneNode(), free = Math.max(0, width(solid) - width(curve)) / 2
    edges.setAttribute("stroke", PAPER)
    edges.setAttribute("stroke-width", width(curve) + 2 * Math.min(EDGE, BARED * free))
    solid.after(edges)
  }
}

// A surface is a double line: without its colour it would be taken for a curve. The ends of its strokes tell it, here and in the legend.
const SURFACES = "path[stroke-linecap=square]", WIDER = 1.5, HOLLOW = 0.5  // times its width
const open_surfaces = picture => {
  for (const surface of picture.querySelectorAll(SURFACES)) {
    const width = WIDER * Number(surface.getAttribute("stroke-width")), inner = surface.cloneNode()
    surface.setAttribute("stroke-width", width)
    inner.setAttribute("stroke", PAPER)
    inner.setAttribute("stroke-width", HOLLOW * width)
    surface.after(inner)
  }
}

// One SVG element of the figures, one below the other, with the caption below.
const composed = async (views, wish) => {
  const faces = Object.entries(await load_font()).map(([style, font]) =>
    `@font-face { font-family: "${face.family}"; font-style: ${style}; src: url(data:font/ttf;base64,${font}) }`)
  const width = wish.millimetres / INCH * 72 / wish.points * TEXT
  const { pictures, set } = await fitted(views, wish, width)
  const picture = { width: pictures[0].width, height: pictures.reduce((sum, one) => sum + one.height, 0) }
  const height = picture.height + below(set)
  const svg = node("svg", {
    xmlns: "http://www.w3.org/2000/svg", width: `${wish.millimetres}mm`,
    height: `${wish.millimetres * height / picture.width}mm`, viewBox: `0 0 ${picture.width} ${height}`,
  })
  svg.append(node("title", {}, wish.title), node("desc", {}, described(wish)), node("style", {}, faces.join(" ")))
  const [ground, ink] = wish.printed ? [PAPER, INK] : colours_of(views[0].el)
  svg.append(node("rect", { x: 0, y: 0, width: picture.width, height, fill: ground }))
  let top = 0
  for (const one of pictures) {
    const part = node("g", { transform: `translate(0, ${top})` })
    part.append(...one.svg.childNodes)
    if (wish.printed) {
      give_edges(part)
      open_surfaces(part)
    }
    svg.append(part)
    top += one.height
  }
  for (const [k, line] of set.lines.entries()) {
    const y = picture.height + GAP + set.step * (k + 0.8)
    const text = node("text", { x: GAP, y, fill: ink, "font-family": face.family, "font-size": `${set.size}px` }, line)
    typeset(text, set.size)
    svg.append(text)
  }
  return { svg, width: picture.width, height, described: below(set) / height }
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

// Put a question mark in place of each character that its font in a PDF does not have; return these characters.
const replace_unknown = (svg, paper) => {
  const lacks = new Set(), texts = document.createTreeWalker(svg, NodeFilter.SHOW_TEXT)
  while (texts.nextNode()) {
    const { currentNode: words } = texts
    if (words.parentNode.closest("text") == null) continue
    const slanted = words.parentNode.getAttribute("font-family") == face.slanted
    const font = paper.getFont(slanted ? face.slanted : face.family, "normal").metadata
    words.data = Array.from(words.data, one => {
      if (font.characterToGlyph(one.codePointAt(0)) > 0) return one
      lacks.add(one)
      return "?"
    }).join("")
  }
  return [...lacks].join(" ")
}

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
    canvas.width = Math.round(wish.millimetres / INCH * wish.dpi)
    canvas.height = Math.round(canvas.width * height / width)
    canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height)
    URL.revokeObjectURL(address)
    const made = await new Promise(resolve => canvas.toBlob(resolve, "image/png"))
    if (made == null) throw new Error("a PNG of so many pixels is too large for this browser")
    return of_width(made, Math.round(canvas.width / wish.millimetres * 1000))
  },
  async pdf(made, wish) {
    const { svg, width, height } = made
    if (globalThis.svg2pdf == null) {  // half a megabyte, which only a PDF needs
      await script("vendor/jspdf.umd.min.js")
      await script("vendor/svg2pdf.umd.min.js")
    }
    const size = [wish.millimetres, wish.millimetres * height / width]
    const paper = new jspdf.jsPDF({ unit: "mm", format: size, orientation: size[0] > size[1] ? "l" : "p", putOnlyUsedFonts: true, compress: true })
    paper.setProperties({ title: wish.title, subject: described(wish), creator: "pwsviz" })
    const faces = await load_font()
    for (const [style, font] of Object.entries(faces)) paper.addFileToVFS(`${style}.ttf`, font)
    for (const style of ["normal", "italic", "bold"]) paper.addFont("normal.ttf", face.family, style)
    for (const style of ["normal", "bold"]) paper.addFont("italic.ttf", face.slanted, style)  // named after its family in the file
    for (const words of svg.querySelectorAll("tspan[font-style]")) {
      words.removeAttribute("font-style")
      words.setAttribute("font-family", face.slanted)
    }
    paper.setFont(face.family)
    made.lacks = replace_unknown(svg, paper)
    await paper.svg(svg, { x: 0, y: 0, width: size[0], height: size[1] })
    return new Blob([Uint8Array.from(conforming(paper.output()), byte => byte.charCodeAt(0))], { type: "application/pdf" })
  },
}

const PATIENCE = 10000  // milliseconds

// Wait until all of the figures is drawn.
const finish = async views => {
  const until = Date.now() + PATIENCE, says = one => is_of_drawing(one) && one.text != ""
  while (views.some(view => view.model.center.some(says))) {
    if (Date.now() > until) throw new Error("a part of the figure is still being drawn; try again when it is there")
    await new Promise(resolve => setTimeout(resolve, 100))
  }
}

const described = wish => wish.captions.full.replace("\n", " ")

const amount = words => Number(/[0-9]+/.exec(words)[0])  // such as that of “175 mm”
const checked_width = (words, [least, most]) => {
  const given = Number(/^\s*([0-9]+([.][0-9]+)?)\s*(mm)?\s*$/.exec(words)?.[1])
  if (given >= least && given <= most) return given
  throw Object.assign(new Error(`its width, “${words}”, is not a number from ${least} to ${most}, in mm`), { told: true })
}

// Save figures as one picture. `chosen` has kind ("svg", "pdf" or "png"), name, title, captions ("short" and "full", which is always
// in the metadata of SVG and PDF), shades (the opacity in print of each colour), widths (the least and the greatest in mm), and the choices as they are offered. Returns what is to be said of it; empty if that is nothing.
const made_one = async (ids, chosen) => {
  choose_typeface(chosen.typeface)
  const views = ids.map(id => Bokeh.index.find_one_by_id(id)).filter(view => view != null)
  if (views.length == 0) throw new Error("the figure is no longer on the page")
  const millimetres = checked_width(chosen.width, chosen.widths)
  const [tallest, points, dpi] = [chosen.height, chosen.points, chosen.dpi].map(amount)
  const wish = { ...chosen, millimetres, tallest, points, dpi, printed: chosen.look == "for print" }
  await finish(views)
  const made = await composed(views, wish)
  const blob = await WRITERS[wish.kind](made, wish)
  const link = document.createElement("a")
  link.href = URL.createObjectURL(blob)
  link.download = wish.name
  link.click()
  setTimeout(() => URL.revokeObjectURL(link.href), 60000)
  const lacks = made.lacks ? `${wish.name} has “?” in place of ${made.lacks}: its font lacks them; SVG and PNG have them.` : ""
  const tall = wish.millimetres * made.height / made.width, over = Math.ceil(tall - tallest)
  if (over <= 0) return lacks
  const cause = (1 - made.described) * tall <= tallest ? "caption needs" : "figures need"
  return `${wish.name} is ${tallest + over} mm high: its ${cause} ${over} mm more than the height chosen. ${lacks}`.trim()
}

// The same one after another: each has a typeface of its own.
let before = Promise.resolve()
export const save = (ids, chosen) => {
  const made = before.then(() => made_one(ids, chosen))
  before = made.catch(() => {})
  return made
}
