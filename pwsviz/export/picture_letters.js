// The mathematics in the texts of a picture: names of quantities in italics, products without a dot, exponents raised.

// What there is of each typeface: its family, that of its slanted face, its files, and the hat over a letter, which is a letter of
// its own, as a PDF sets a combining one beside it: its width, how far right of the middle of a slanted letter it begins, and how
// much a tall one raises it.
const TYPEFACES = {
  "sans serif": {
    family: "Pwsviz Sans", slanted: "Pwsviz Sans Italic", hat: { width: 0.457, aside: -0.2, raised: 0.15 },
    files: { normal: "PwsvizSans-subset.ttf", italic: "PwsvizSans-Italic-subset.ttf" },
  },
  serif: {
    family: "Pwsviz Serif", slanted: "Pwsviz Serif Italic", hat: { width: 0.333, aside: -0.1, raised: 0.2 },
    files: { normal: "PwsvizSerif-subset.ttf", italic: "PwsvizSerif-Italic-subset.ttf" },
  },
}

export let face = TYPEFACES["sans serif"]  // that of the picture which is being made
export const choose_typeface = name => { face = TYPEFACES[name] }

const pen = document.createElement("canvas").getContext("2d")
export const width_of = (words, size) => {
  pen.font = `${size}px "${face.family}"`
  return pen.measureText(words).width
}

const LETTER = "A-Za-zΑ-Ωα-ωϑϕ", UPRIGHT = "ΔΣΠ", ACCENT = "\u0302\u0304\u0307"
const OF_WORD = LETTER + "À-ÖØ-öø-ɏ"  // beside one of these a letter is part of a word: “Hénon”
const INDEX = "₀-₉₊₋ₐₑₕᵢⱼₖₗₘₙₒₚᵣₛₜᵤᵥₓ⁰¹²³⁴-⁹⁺⁻′*,"  // beside a name
// An exponent and a comma between two indices: their size, and how far they are raised, in heights of the text.
const SMALLER = 0.72, SHIFTS = { raised: 0.38, lowered: -0.12 }
const HAT = "\u02c6", TALL = /[A-Zbdfhklt]/

// A name is one letter, after Δ or ∂ too, but no part of a word, nor the article “a”, the “s” of “ψ’s” or the unit in “(s)”.
const NAME = new RegExp(`(?<![${OF_WORD}’'])([${UPRIGHT}]?)((?![AIa] (?!(?:from|to|at|is|and|in|with) )[${LETTER}]{2}|(?<= \\()s\\))[${LETTER}][${ACCENT}]?)(?![${OF_WORD}])`, "g")
const PRODUCT = new RegExp(`(?<=(?<![${LETTER}])[${LETTER}][${INDEX}]*)·(?=(?:[${LETTER}](?![${LETTER}])|\\())`, "g")
const EXPONENT = /\^\(?([^\s()^]+)\)?/g, COMMA = /(?<=[₊₋]),(?=[₀-₉])/g

// The parts of a text that differ in their looks: [its words, "" or "italic" or one of the `SHIFTS`].
export const parts_of = words => {
  const marked = words.replace(PRODUCT, "\u0003").replace(EXPONENT, (_, power) => `\u0001${power}\u0002`)
    .replace(COMMA, "\u0004,\u0002")
  return marked.split(/([\u0001\u0004][^\u0002]*\u0002)/).flatMap(piece => {
    if (piece.startsWith("\u0001")) return [[piece.slice(1, -1), "raised"]]
    if (piece.startsWith("\u0004")) return [[piece.slice(1, -1), "lowered"]]
    const found = []
    let end = 0
    for (const match of piece.matchAll(NAME)) {
      const start = match.index + match[1].length
      if (UPRIGHT.includes(match[2])) continue
      found.push([piece.slice(end, start), ""], [match[2], "italic"])
      end = start + match[2].length
    }
    return [...found, [piece.slice(end), ""]]
  }).map(([part, look]) => [part.replaceAll("\u0003", ""), look]).filter(([part]) => part != "")
}

// How such a part is set: what it is, and by how many pixels up and aside; a hat takes no room beside its letter.
const set = ([words, look], size) => {
  if (look in SHIFTS) return [{ words, size: SMALLER * size, up: SHIFTS[look] * size }]
  const [letter, hat] = [words.replace("\u0302", ""), words.endsWith("\u0302")], style = look
  if (!hat) return [{ words, style }]
  const { hat: { width, aside: beside, raised } } = face
  const aside = beside * size - width_of(letter, size) / 2, up = TALL.test(letter) ? raised * size : 0
  return [{ words: letter, style }, { words: HAT, style, up, aside, back: -aside - width * size }]
}

// Set the text of an SVG element in its parts; `size` in pixels.
export const typeset = (element, size) => {
  const parts = parts_of(element.textContent)
  if (parts.length < 2 && parts.every(([_, look]) => look == "")) return
  element.textContent = ""
  let raised = 0, before = 0  // what follows such a part is shifted back
  for (const { words, style = "", size: own, up = 0, aside = 0, back = 0 } of parts.flatMap(part => set(part, size))) {
    const span = document.createElementNS("http://www.w3.org/2000/svg", "tspan")
    span.textContent = words
    if (style != "") span.setAttribute("font-style", style)
    if (own != null) span.setAttribute("font-size", `${own}px`)
    if (up != raised) span.setAttribute("dy", raised - up)
    if (before + aside != 0) span.setAttribute("dx", before + aside)
    raised = up
    before = back
    element.append(span)
  }
}
