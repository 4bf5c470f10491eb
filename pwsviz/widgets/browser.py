"""What only the browser knows or can do: window, keys, colour scheme, address bar."""

from __future__ import annotations

import panel as pn
import param

NARROW = 600
"""Pixels; on a screen less wide the controls would cover the picture, and start hidden."""

DARK = "pwsviz.dark"
"""Under this name the browser remembers a choice of light or dark that is not what the person prefers elsewhere."""

REMEMBER_DARK = """
try {
  const usual = window.matchMedia("(prefers-color-scheme: dark)").matches
  if (cb_obj.dark_theme == usual) localStorage.removeItem("DARK")
  else localStorage.setItem("DARK", cb_obj.dark_theme)
} catch (refused) { console.info("no storage: the colours will be forgotten", refused) }
""".replace("DARK", DARK)
"""What the page's ``dark_theme`` does in the browser when it changes."""


class Browser(pn.custom.JSComponent):
    """Invisible. Says once whether the window is narrow, or to be dark; counts undo and redo; writes the address."""

    narrow = param.Boolean(default=False)
    dark = param.Boolean(default=False)
    undone = param.Integer(default=0)
    redone = param.Integer(default=0)
    query = param.String(default="", doc="What the address bar holds after the question mark.")

    _esm = """
export function render({ model }) {
  model.narrow = window.innerWidth < NARROW
  let chosen = null
  try { chosen = localStorage.getItem("DARK") } catch (refused) { console.info("no storage: as usual", refused) }
  model.dark = chosen == null ? window.matchMedia("(prefers-color-scheme: dark)").matches : chosen == "true"
  const press = event => {
    const typing = event.composedPath().some(node => node.tagName == "INPUT" && node.type == "text"
      || node.tagName == "TEXTAREA")
    const key = event.key.toLowerCase()
    if (typing || !(event.ctrlKey || event.metaKey) || !(key == "z" || key == "y" && !event.shiftKey)) return
    event.preventDefault()
    if (key == "z" && !event.shiftKey) model.undone += 1
    else model.redone += 1
  }
  document.addEventListener("keydown", press)
  model.on("remove", () => document.removeEventListener("keydown", press))
  model.on("query", () => {
    const address = new URL(window.location.href)
    address.search = model.query
    window.history.replaceState(window.history.state, "", address)
  })
}
""".replace("NARROW", str(NARROW)).replace("DARK", DARK)
