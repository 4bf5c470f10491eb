"""The lecture mode: the page fills the screen, and its type, lines and marks are large: seen from the last row."""

from __future__ import annotations

import panel as pn
import param

from pwsviz.widgets.browser import FIND
from pwsviz.widgets.focus import SPACE

NAME = "Lecture mode (L)"
"""Name of the button that turns the lecture mode on and off."""

KEY = "l"
"""Key that turns the lecture mode on and off, when no text is being typed."""

LARGER = 1.65
"""Factor of the size of all type outside figures, and of their lines and marks; less in a small window."""

ROOMY = (1100, 620)
"""Pixels of width and height from which on a window has room for larger type: by 1 % for each 1 % more of both."""

LABELS = 1.1
"""Factor by which the type in figures, smaller than that outside, grows more."""

REST = "calc(9.8rem + var(--header, 52px) - 52px)"
"""CSS height that a figure leaves free on the screen, for the header, the player and the results of two integrators."""

TOLD, TOLD_OF_RUNS = 0.5, 0.36
"""Part of the height of the screen that a figure leaves free for what is told below it, at most."""

LEAST, LEAST_PART = 326, 0.4
"""Pixels, and part of the height of the screen, that the frame of the figure of a view has whatever is told below it:
of that, whole paragraphs and rows of tables are in sight, and the others scroll."""

PLAYER = 40
"""Height of the player in pixels, for which `REST` leaves room, too: the portrait stays as it is when that opens.

A view has none, and takes that room."""

LINES = 3.9
"""Part of that which `REST` leaves free in the unit of the type: three lines."""

LOOK_AGAIN = 400
"""Milliseconds between looks for figures that have come since."""


class Lecture(pn.custom.JSComponent):
    """Invisible: fills the screen and enlarges the type of page and figures, in the browser alone."""

    large = param.Boolean(default=False, doc="Whether it is on; set in the browser.")
    plays = param.Boolean(default=False, doc="Whether the player is open, which takes the space bar; which opens it.")
    told = param.Boolean(default=False, doc="Whether the header tells the laws, so that those below the portrait go.")
    turned = param.Integer(default=0, doc="How often it was turned on or off other than by the key.")

    _esm = (
        """
const SIZES = ["axis_label_text_font_size", "major_label_text_font_size", "label_text_font_size", "text_font_size",
               "line_width", "axis_line_width", "major_tick_line_width", "size"]
SPACE
FIND
export function render({ model }) {
  const usual = new Map()  // figure part -> its own sizes, and those that it has been given
  const fitted = new Set()  // panels of views
  let timer = null
  let factor = 1, larger = null
  const root = document.documentElement
  const { CustomJSTransform } = Bokeh.loader["models/transforms/customjs_transform"]
  const setFactor = () => {
    factor = Math.min(LARGER, Math.max(1, Math.min(innerWidth / WIDE, innerHeight / HIGH)))
    larger = new CustomJSTransform({ func: `return ${factor} * x`, v_func: `return xs.map(x => ${factor} * x)` })
    root.style.fontSize = factor > 1 ? `${100 * factor}%` : ""
    root.style.setProperty("--warned", factor < LARGER ? "nowrap" : "")
    root.style.setProperty("--line", factor < LARGER ? "1lh" : "")  // pointed at, a warning lies over what follows
  }
  const enlarged = size => {
    if (typeof size == "number") return size * factor
    if (typeof size == "string") return size.replace(/[0-9.]+/, number => number * (factor > 1 ? factor * LABELS : 1))
    return typeof size.value == "string" ? { ...size, value: enlarged(size.value) } : { ...size, transform: larger }
  }
  const same = (one, other) => one === other || one?.value === other?.value && one?.field === other?.field
    && one?.transform === other?.transform && typeof one == "object" && typeof other == "object"
  const { Glyph } = Bokeh.loader["models/glyphs/glyph"]
  const enlarge = () => {
    for (const part of Bokeh.documents.flatMap(document => [...document._all_models.values()])) {
      if (!(/Axis$|^Legend$|^Span$/.test(part.type) || part instanceof Glyph)) continue
      const { sizes, given } = usual.get(part) ?? { sizes: {}, given: {} }
      const names = SIZES.filter(name => name in part.attributes && part[name] != null)
      const reset = names.filter(name => !(name in given) || !same(part[name], given[name]))  // by another theme
      if (reset.length == 0) continue
      for (const name of reset) {
        sizes[name] = part[name]
        given[name] = enlarged(part[name])
      }
      usual.set(part, { sizes, given })
      part.setv(Object.fromEntries(reset.map(name => [name, given[name]])), { sync: false })
    }
  }
  // Where room is short, tools that appear under the pointer do so in the figure: a band above is else kept for them.
  const placeTools = inner => {
    for (const view of Bokeh.index.query(view => view.model.type == "Figure" && view.model.toolbar_inner != inner)) {
      view.model.setv({ toolbar_inner: inner }, { sync: false })
      view.model.toolbar.setv({ inner }, { sync: false })
      view.invalidate_layout()
    }
  }
  const restore = () => {
    for (const [part, { sizes }] of usual) { part.setv(sizes, { sync: false }) }
    usual.clear()
  }
  const resize = () => {  // the window fills the screen only some time after it has been asked for, if at all
    const before = factor
    if (!model.large) { return }
    setFactor()
    if (factor != before) {
      restore()
      enlarge()
    }
  }
  const isPanel = element => element.getAttribute("role") == "tabpanel" || element.classList.contains("portrait")
  const panel_of = element => {
    while (element && !isPanel(element)) { element = element.parentElement ?? element.getRootNode().host }
    return element
  }
  const scrolled = element => {
    let sum = 0
    for (; element; element = element.parentElement ?? element.getRootNode().host) { sum += element.scrollTop }
    return sum
  }
  const parts_in = function* (root) {  // paragraphs and rows of tables, in the order of the page
    for (const element of root.querySelectorAll("*")) {
      if (element.matches("p, tr") && element.checkVisibility()) { yield element }
      if (element.shadowRoot) { yield* parts_in(element.shadowRoot) }
    }
  }
  // Of what is told below a figure, the height of as many whole parts as fit; of lines, if the first is too long.
  const whole = (panel, bottom, free) => {
    let told = 0
    for (const part of parts_in(panel)) {
      const { top, bottom: end, height } = part.getBoundingClientRect()
      if (height == 0 || top < bottom - 1) { continue }
      if (end - bottom > free) {
        const line = parseFloat(getComputedStyle(part).lineHeight) || height
        return told || Math.max(1, Math.floor((free - top + bottom) / line)) * line + top - bottom
      }
      told = end - bottom
    }
    return told
  }
  const tells = new Map()  // panel of a view -> pixels that its figure leaves free
  const tell = (panel, bottom, frame) => {
    const before = tells.get(panel) ?? 0
    const room = innerHeight - bottom - scrolled(panel)
    const spare = Math.floor(frame - Math.max(LEAST, LEAST_PART * innerHeight))
    const told = Math.max(0, Math.min(before + whole(panel, bottom, room + spare) - room, TOLD * innerHeight))
    tells.set(panel, told)
    return told
  }
  // Controls above a figure, a long legend, and what is told below take its room: words of warning are in sight.
  const fit = () => {
    const found = new Map()
    for (const view of Bokeh.index.query(view => view.model.type == "Figure" && view.el.checkVisibility())) {
      const panel = panel_of(view.el)
      if (!panel) { continue }
      const { top, bottom } = view.el.getBoundingClientRect(), all = panel.getBoundingClientRect()
      if (all.height == 0) { continue }  // a narrow screen has its parts in another order
      const longer = parseFloat(getComputedStyle(view.el).getPropertyValue("--legend")) || 0
      if (view.layout?.bbox.height != view.bbox.height) { view.request_layout(true) }  // Bokeh overlooks it at times
      const { above = Infinity, below = Infinity, frame = 0 } = found.get(panel) ?? {}
      found.set(panel, {
        above: Math.min(above, top - all.top + longer), below: Math.min(below, all.bottom - bottom),
        frame: frame + view.frame.bbox.height,
      })
    }
    const lines = LINES * parseFloat(getComputedStyle(root).fontSize)
    for (const [panel, { above, below, frame }] of found) {
      fitted.add(panel)
      const of_runs = panel.classList.contains("portrait"), player = model.plays ? PLAYER : 0
      const room = of_runs
        ? above + Math.max(0, Math.min(below - player, OF_RUNS * innerHeight) - lines)
        : above + tell(panel, panel.getBoundingClientRect().bottom - below, frame) - PLAYER
      panel.style.setProperty("--above", `${Math.round(room)}px`)
    }
  }
  const say_pressed = (looks = 0) => {  // the button may come later, and its tip is not its state
    const button = find(document, `button[aria-label="NAME"]`)
    if (button == null) { return looks < 300 ? setTimeout(say_pressed, 100, looks + 1) : null }
    button.ariaPressed = model.large
  }
  const turn = on => {
    if (on == model.large) return
    if (document.getElementById("cover") != null) return setTimeout(turn, LOOK_AGAIN, on)  // when the page is built
    model.large = on
    say_pressed()
    const styles = { "--rest": "REST", "--table": "0px", "--usual": "none", "--lecture": "flex" }
    for (const [name, value] of Object.entries(styles)) { root.style.setProperty(name, on ? value : "") }
    clearInterval(timer)
    if (on) {
      setFactor()
      enlarge()
      timer = setInterval(() => { enlarge(); placeTools(factor < LARGER); fit() }, LOOK_AGAIN)
      root.requestFullscreen?.().catch(refused => console.info("no full screen", refused))
    } else {
      restore()
      placeTools(false)
      root.style.fontSize = ""
      for (const name of ["--law", "--warned", "--line"]) { root.style.removeProperty(name) }
      for (const panel of fitted) { panel.style.removeProperty("--above") }
      tells.clear()
      if (document.fullscreenElement) document.exitFullscreen()
    }
  }
  const typing = node => node.tagName == "SELECT" || node.tagName == "TEXTAREA" || node.isContentEditable
    || node.tagName == "INPUT" && !["range", "checkbox", "radio", "button"].includes(node.type)
  const press = event => {
    if (event.key == "Escape") return turn(false)  // a dialog keeps keys to itself
    if (event.ctrlKey || event.altKey || event.metaKey) return
    if (event.key == " " && model.large && !model.plays && is_free(event)) {
      event.preventDefault()
      model.plays = true
    }
    if (event.key.toLowerCase() == "KEY" && !event.composedPath().some(typing)) turn(!model.large)
  }
  const leave = () => { if (!document.fullscreenElement) turn(false) }
  model.on("turned", () => turn(!model.large))
  model.on("told", () => root.style.setProperty("--law", model.told ? "none" : ""))
  say_pressed()
  document.addEventListener("keydown", press)
  document.addEventListener("fullscreenchange", leave)
  addEventListener("resize", resize)
  model.on("remove", () => {
    clearInterval(timer)
    document.removeEventListener("keydown", press)
    document.removeEventListener("fullscreenchange", leave)
    removeEventListener("resize", resize)
  })
}
""".replace("SPACE", SPACE)
        .replace("FIND", FIND)
        .replace("NAME", NAME)
        .replace("LABELS", str(LABELS))
        .replace("LARGER", str(LARGER))
        .replace("WIDE", str(ROOMY[0]))
        .replace("HIGH", str(ROOMY[1]))
        .replace("LOOK_AGAIN", str(LOOK_AGAIN))
        .replace("OF_RUNS", str(TOLD_OF_RUNS))
        .replace("LEAST_PART", str(LEAST_PART))
        .replace("LEAST", str(LEAST))
        .replace("TOLD", str(TOLD))
        .replace("PLAYER", str(PLAYER))
        .replace("LINES", str(LINES))
        .replace("REST", REST)
        .replace("KEY", KEY)
    )

    def turn(self) -> None:
        """Turn it on, or off."""
        self.turned += 1
