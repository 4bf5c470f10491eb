"""What only the browser knows or can do: window, keys, colour scheme, address bar."""

from __future__ import annotations

import panel as pn
import param

NARROW = 600
"""Pixels; on a screen less wide the controls would cover the picture, and start hidden."""


class Browser(pn.custom.JSComponent):
    """Invisible. Says once whether the window is narrow or darkness preferred; counts Ctrl+Z; writes the address."""

    narrow = param.Boolean(default=False)
    dark = param.Boolean(default=False)
    undone = param.Integer(default=0)
    query = param.String(default="", doc="What the address bar holds after the question mark.")

    _esm = """
export function render({ model }) {
  model.narrow = window.innerWidth < NARROW
  model.dark = window.matchMedia("(prefers-color-scheme: dark)").matches
  const undo = event => {
    const typing = event.composedPath().some(node => node.tagName == "INPUT" && node.type == "text"
      || node.tagName == "TEXTAREA")
    if ((event.ctrlKey || event.metaKey) && !event.shiftKey && event.key == "z" && !typing) {
      event.preventDefault()
      model.undone += 1
    }
  }
  document.addEventListener("keydown", undo)
  model.on("remove", () => document.removeEventListener("keydown", undo))
  model.on("query", () => {
    const address = new URL(window.location.href)
    address.search = model.query
    window.history.replaceState(window.history.state, "", address)
  })
}
""".replace("NARROW", str(NARROW))
