"""What only the browser can read or write: window width, keys, colour scheme, address bar."""

from __future__ import annotations

import json

import panel as pn
import param

from pwsviz.figures.colours import ON_DARK
from pwsviz.widgets.dialog import KEEP_FOCUS
from pwsviz.widgets.dropdown import CHOOSER
from pwsviz.widgets.more_tabs import MORE_TABS
from pwsviz.widgets.panes import FADED
from pwsviz.widgets.widths import LOW, NARROW

CRAMPED = f"(innerWidth < {NARROW} || innerHeight < {LOW})"
"""JavaScript of whether the window is so small that the controls start hidden."""

PATIENCE = 3000
"""Milliseconds for which a picture that is to be replaced is faded, unless the server does it."""

DARK = "pwsviz.dark"
"""Key in the browser's storage of a choice of light or dark that differs from the system's setting."""

IS_DARK = """() => {
  let chosen = null
  try { chosen = localStorage.getItem("DARK") } catch (refused) { console.info("no storage: as usual", refused) }
  return chosen == null ? window.matchMedia("(prefers-color-scheme: dark)").matches : chosen == "true"
}""".replace("DARK", DARK)
"""JavaScript function that tells whether the page is to be dark."""

REMEMBER_DARK = """
try {
  const usual = window.matchMedia("(prefers-color-scheme: dark)").matches
  if (cb_obj.dark_theme == usual) localStorage.removeItem("DARK")
  else localStorage.setItem("DARK", cb_obj.dark_theme)
} catch (refused) { console.info("no storage: the colours will be forgotten", refused) }
""".replace("DARK", DARK)
"""JavaScript run in the browser when ``dark_theme`` of the page changes."""


FIND = """
const find = (node, chosen) => {
  const parts = [...node.querySelectorAll("*")]
  const found = parts.find(part => part.matches(chosen))
  return found ?? parts.filter(part => part.shadowRoot).map(part => find(part.shadowRoot, chosen)).find(part => part)
}
"""
"""JavaScript function that finds an element in the page and all its shadow trees."""

NAME_BUTTONS = """
// Call the button with three bars as people do, who may speak its name: “menu” in place of “drawer”; and that of the
// theme by what a click does.
const name_button = (ending, name, looks = 0) => {
  const button = find(document, `button[aria-label$=${ending}]`)
  if (button == null) { if (looks < 300) { setTimeout(name_button, 100, ending, name, looks + 1) }; return }
  const root = button.getRootNode()  // its tip is made anew at each visit of the pointer
  const say_tip = () => root.querySelectorAll("[role=tooltip] > *").forEach(({ firstChild: words }) => {
    const better = button.getAttribute("aria-label")
    if (words?.data?.endsWith(ending) && words.data != better) { words.data = better }
  })
  const say = () => {
    const better = name(button)
    if (better != button.getAttribute("aria-label")) { button.setAttribute("aria-label", better) }
    say_tip()
  }
  new MutationObserver(say).observe(button, { attributeFilter: ["aria-label"], childList: true, subtree: true })
  new MutationObserver(say_tip).observe(root, { childList: true, subtree: true, characterData: true })
  say()
}
name_button("drawer", button => {
  find(document, "nav:not([aria-label])")?.setAttribute("aria-label", "Controls")
  return button.getAttribute("aria-label").replace("drawer", "menu")
})
name_button("theme", () => {
  const { data } = Bokeh.documents.flatMap(one => one.roots()).find(root => "dark_theme" in (root.data ?? {})) ?? {}
  return data?.dark_theme ? "Light theme" : "Dark theme"
})
"""
"""JavaScript that renames two buttons, and their tips; in panel-material-ui they say “drawer” and “Toggle theme”."""

NAME_PANEL = """
// Give the view below the tabs the role that goes with theirs, and the name of the tab that is chosen.
let searches = 0
const name_panel = () => {
  const tabs = find(document, ".MuiTabsPanel")
  if (tabs == null) { if (searches++ < 300) { setTimeout(name_panel, 100) }; return }
  const panel = tabs.lastElementChild, list = tabs.querySelector("[role=tablist]")
  const titles = [...list.querySelectorAll("[role=tab]")]
  const say = () => panel.setAttribute("aria-labelledby", titles.find(title => title.ariaSelected == "true")?.id ?? "")
  panel.id = "view"
  panel.role = "tabpanel"
  titles.forEach((title, k) => {
    title.id = `title-${k}`
    title.setAttribute("aria-controls", panel.id)
    new MutationObserver(say).observe(title, { attributeFilter: ["aria-selected"] })
    // On a phone the view begins below the screen: whoever has chosen it wants to see it, as soon as it has its height.
    title.addEventListener("click", () => {
      if (innerWidth >= NARROW) { return }
      const grown = new ResizeObserver(() => list.scrollIntoView({ block: "start" }))
      grown.observe(panel)
      for (const moved of ["touchmove", "wheel", "keydown"]) {
        addEventListener(moved, () => grown.disconnect(), { once: true, passive: true })
      }
      setTimeout(() => grown.disconnect(), 2000)
    })
  })
  list.style.scrollMarginTop = "calc(var(--header, 52px) + 8px)"
  say()
}
name_panel()
""".replace("NARROW", str(NARROW))
"""JavaScript that makes the tabs' content a tab panel, which the tabs of panel-material-ui leave out."""


TELL_HEADER = """
// The header is fixed, and higher where the type is large: what begins below it is told its height.
let glances = 0
const tell_header = () => {
  const header = find(document, ".MuiAppBar-root")
  if (header == null) { if (glances++ < 300) { setTimeout(tell_header, 100) }; return }
  const tell = () => document.documentElement.style.setProperty("--header", `${header.offsetHeight}px`)
  new ResizeObserver(tell).observe(header)
}
tell_header()
"""
"""JavaScript that keeps the height of the header in a variable of CSS."""


PAINT_WHOLE = """
// Bokeh takes the rows of a source at once, and their colours only some promises later. A change of layout has a figure
// painted in between: the legend then looks for the colour of a row that has none yet, and the painting ends there
// (“Offset is outside the bounds of the DataView”). So it waits; Bokeh asks for another when the colours are there.
const paint_whole = () => {
  const view = name => Bokeh.Models.get(name).prototype.default_view.prototype
  const renderer = view("GlyphRenderer"), plot = view("Plot")
  const { set_data } = renderer, { paint } = plot, begun = new WeakMap()
  const count = (figure, more) => begun.set(figure, (begun.get(figure) ?? 0) + more)
  renderer.set_data = async function(...given) {
    count(this.plot_view, 1)
    try { await set_data.apply(this, given) } finally { count(this.plot_view, -1) }
  }
  plot.paint = function() { if (!(begun.get(this) > 0)) { paint.call(this) } }
}
paint_whole()
"""
"""JavaScript that lets no figure be painted with rows that have no colours yet."""


KEEP_TO_ROWS = """
// A filter chosen for the rows before is applied once to fewer rows, until one is chosen for these.
const keep_to_rows = () => {
  const filter = Bokeh.Models.get("IndexFilter").prototype, { compute_indices } = filter
  filter.compute_indices = function(source) {
    const rows = source.get_length() ?? 1, indices = this.indices?.filter(k => k < rows) ?? null
    return compute_indices.call({ indices }, source)
  }
}
keep_to_rows()
"""
"""JavaScript that applies filters to rows that exist alone; else Bokeh warns of each row that does not."""

FADE = (
    """
// A picture that is to be replaced fades as soon as another is chosen from a list; the server takes longer.
const fade_at_choice = () => {
  const list = Bokeh.Models.get("Select").prototype.default_view.prototype, { render } = list
  let given_up = null  // what is chosen may be refused
  model.on("choosing", () => {
    document.documentElement.style.setProperty("--past", model.choosing ? "FADED" : "")
    clearTimeout(given_up)
    if (model.choosing) { given_up = setTimeout(() => { model.choosing = false }, PATIENCE) }
  })
  list.render = function() {
    render.call(this)
    if (!this.model.css_classes.includes("CHOOSER")) { return }
    this.input_el.addEventListener("change", () => { model.choosing = true })
  }
}
fade_at_choice()
""".replace("FADED", FADED["opacity"])
    .replace("PATIENCE", str(PATIENCE))
    .replace("CHOOSER", CHOOSER)
)
"""JavaScript that fades the figures at a choice from a list of the class `CHOOSER`, until `choosing` is false again."""


DESCRIBE = """
// What the “?” beside the name of a list says is told of the list itself, too, which the keyboard reaches.
const describe_lists = () => {
  const list = Bokeh.Models.get("Select").prototype.default_view.prototype, { render } = list
  list.render = function() {
    render.call(this)
    const markup = [this.model.description?.content?.html ?? []].flat().filter(part => typeof part == "string").join("")
    if (markup == "") { return }
    const words = new DOMParser().parseFromString(markup, "text/html").body.textContent
    this.input_el.setAttribute("aria-description", words.trim())
    // Shown while the keyboard is at it, until something is chosen: what that is for stands below.
    const show = on => {
      if (on) { this.group_el?.setAttribute("data-about", words.trim()) } else { delete this.group_el?.dataset.about }
    }
    show(true)
    this.input_el.addEventListener("change", () => show(false))
    this.input_el.addEventListener("keydown", event => { if (event.key == "Escape") { show(false) } })
    this.input_el.addEventListener("blur", () => show(true))
  }
}
describe_lists()
"""
"""JavaScript that gives lists the words of their tips as a description."""


TONE = """
// On dark ground the colours of glyphs are others: a figure is painted with those that go with its own ground.
const tone_figures = on_dark => {
  const { GlyphView } = Bokeh.loader["models/glyphs/glyph"], { color2rgba } = Bokeh.loader["core/util/color"]
  const plot = Bokeh.Models.get("Plot").prototype.default_view.prototype, { paint } = plot
  const image = Bokeh.Models.get("Image").prototype.default_view.prototype, { _flat_img_to_buf8 } = image
  const { set_visuals } = GlyphView.prototype, dark = new WeakSet()  // renderers that have them
  const number = colour => parseInt(colour.slice(1), 16)
  const tones = new Map(Object.entries(on_dark).map(pair => pair.map(number)))
  const is_dark = ({ model }) => {
    const [r, g, b] = color2rgba(model.background_fill_color ?? "white")
    return r + g + b < 384
  }
  const toned = rgba => {  // of a glyph that is one line, it is as it was given
    if (typeof rgba == "string") { return on_dark[rgba] ?? rgba }
    const tone = tones.get(rgba >>> 8)
    return tone == null ? rgba : (tone << 8 | rgba & 255) >>> 0
  }
  GlyphView.prototype.set_visuals = function(...given) {
    set_visuals.apply(this, given)
    if (!is_dark(this.renderer.plot_view)) { dark.delete(this.renderer); return }
    dark.add(this.renderer)
    for (const name of ["line_color", "fill_color", "text_color", "background_fill_color"]) {
      const colours = this[name]
      if (colours == null) { continue }
      if (colours.is_Scalar()) { colours.value = toned(colours.value); continue }
      for (let k = 0; k < colours.length; k++) { colours._view.setUint32(4 * k, toned(colours.get(k))) }
    }
  }
  image._flat_img_to_buf8 = function(values) {
    const bytes = _flat_img_to_buf8.call(this, values)
    if (!is_dark(this.renderer.plot_view)) { return bytes }
    const pixels = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength)
    for (let k = 0; k < bytes.byteLength; k += 4) { pixels.setUint32(k, toned(pixels.getUint32(k))) }
    return bytes
  }
  plot.paint = function() {
    for (const view of this.renderer_views.values()) {
      if (view.glyph != null && dark.has(view) != is_dark(this)) { view.update_data() }
    }
    paint.call(this)
  }
}
tone_figures(ON_DARK)
""".replace("ON_DARK", json.dumps(ON_DARK))
"""JavaScript that paints the colours of `ON_DARK` on dark ground, in figures and legends, on the page and in files."""


class Browser(pn.custom.JSComponent):
    """Invisible: tells whether the window is narrow or dark, and of keys for undo, redo, help; writes the address.

    Each of these keys is a message of its own, “undo”, “redo” or “help”: changes of a setting are reported every 50 ms,
    and a key that is held comes more often.
    """

    narrow = param.Boolean(default=False)
    dark = param.Boolean(default=False)
    query = param.String(default="", doc="The query in the address bar.")
    title = param.String(
        default="", doc="Title of the page, and of its entry in the history; of none it keeps its own."
    )
    choosing = param.Boolean(
        default=False, doc="Whether an entry has been chosen whose picture has not come; set in the browser."
    )

    _esm = (
        """
// Bokeh sends models that came from the server back with the next event, in full. To see that fail without this, add a
// panel-material-ui button with `js_on_click` to a page that is shown, and press any button: beside that CustomJS
// ("dom_event") Panel has put a function ("esm_event") in `js_event_callbacks`, so that nothing at all is sent.
const keep_known = document => {
  const apply = document.apply_json_patch.bind(document)
  document.apply_json_patch = (patch, buffers) => {
    const before = new Set(document._new_models)
    apply(patch, buffers)
    for (const sent of [...document._new_models].filter(one => !before.has(one))) document._new_models.delete(sent)
  }
}
export function render({ model }) {
  Bokeh.documents.forEach(keep_known)
  model.narrow = CRAMPED
  model.dark = (IS_DARK)()
  const press = event => {
    const field = event.composedPath().find(node => node.tagName == "INPUT" && node.type == "text"
      || node.tagName == "TEXTAREA")
    const typing = field != null && !field.hasAttribute("data-settled")  // what is typed there is undone first
    const key = event.key.toLowerCase()
    if (key == "?" && field == null) { model.send_msg("help") }
    if (typing || !(event.ctrlKey || event.metaKey) || !(key == "z" || key == "y" && !event.shiftKey)) return
    event.preventDefault()
    model.send_msg(key == "z" && !event.shiftKey ? "undo" : "redo")
  }
  document.addEventListener("keydown", press)
  FIND
  KEEP_FOCUS
  document.addEventListener("keydown", keep_focus, { capture: true })
  NAME_PANEL
  MORE_TABS
  NAME_BUTTONS
  TELL_HEADER
  PAINT_WHOLE
  KEEP_TO_ROWS
  FADE
  DESCRIBE
  TONE
  model.on("remove", () => {
    document.removeEventListener("keydown", press)
    document.removeEventListener("keydown", keep_focus, { capture: true })
  })
  const write = () => {
    const address = new URL(window.location.href)
    address.search = model.query
    window.history.replaceState(window.history.state, "", address)
  }
  const name = () => { if (model.title != "") { document.title = model.title } }
  model.on("query", write)
  model.on("title", name)
  name()
  if (model.query != "") write()  // the scene is not what the link asked for
}
""".replace("CRAMPED", CRAMPED)
        .replace("IS_DARK", IS_DARK)
        .replace("FIND", FIND)
        .replace("KEEP_FOCUS", KEEP_FOCUS)
        .replace("NAME_PANEL", NAME_PANEL)
        .replace("MORE_TABS", MORE_TABS)
        .replace("NAME_BUTTONS", NAME_BUTTONS)
        .replace("TELL_HEADER", TELL_HEADER)
        .replace("PAINT_WHOLE", PAINT_WHOLE)
        .replace("KEEP_TO_ROWS", KEEP_TO_ROWS)
        .replace("FADE", FADE)
        .replace("DESCRIBE", DESCRIBE)
        .replace("TONE", TONE)
    )
