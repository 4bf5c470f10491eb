"""A window over the page, closed by Esc, by its button, or by a click beside it."""

from __future__ import annotations

from typing import Any

import panel_material_ui as pmui

__all__ = ["KEEP_FOCUS", "dialog"]

LOOK = {
    "& [aria-label=close]": {"color": "var(--mui-palette-text-secondary) !important"},
    "& .MuiDialog-paper": {"width": "100%"},
}
"""The button to close it is otherwise dark on dark, and a window whose contents are yet to come narrow."""

RETURN_FOCUS = """
let focused = document.activeElement
while (focused?.shadowRoot?.activeElement) { focused = focused.shadowRoot.activeElement }
if (cb_obj.open) { cb_obj.opener = focused }
else { requestAnimationFrame(() => setTimeout(() => cb_obj.opener?.focus({ preventScroll: true }))) }
"""
"""JavaScript run at opening and closing: Material UI looks for what had the focus outside of all shadow roots."""


KEEP_FOCUS = """
// While a window is open over the page, Tab goes round in it, Esc closes it wherever the focus is, and keys that open
// or change something else do nothing. Material UI looks for the focus outside of all shadow roots, and does neither.
const keep_focus = event => {
  const { key } = event, taken = ["Tab", "Escape", "?", "l", "L"].includes(key)
  const opened = taken && !event.ctrlKey && !event.altKey && !event.metaKey && find(document, "[role=dialog]")
  if (!opened) { return }
  const within = event.composedPath().includes(opened)
  if (key == "Escape") {
    if (!within) { find(opened, "[aria-label=close]")?.click() }
  } else if (key == "Tab") {
    const stops = []
    const look = node => {
      for (const part of node.children) {
        if (part.tabIndex >= 0 && !part.disabled && part.checkVisibility({ visibilityProperty: true })) stops.push(part)
        if (part.shadowRoot) { look(part.shadowRoot) }
        look(part)
      }
    }
    look(opened)
    const [from, to] = event.shiftKey ? [stops[0], stops.at(-1)] : [stops.at(-1), stops[0]]
    if (within && event.composedPath()[0] != from && (!event.shiftKey || event.composedPath()[0] != opened)) { return }
    event.preventDefault()
    to?.focus()
  } else { event.stopPropagation() }  // before the listeners of the page
}
"""
"""JavaScript function that takes the keys of the page first; it needs `FIND`."""


def dialog(title: str, *contents: Any, width: str = "md") -> pmui.Dialog:
    """Return a window that is closed; focus then returns to what had it when the window opened.

    Parameters
    ----------
    title : str
        Its heading.
    contents : viewables
        What it shows.
    width : str
        Its largest width, by the names of Material UI: "sm", "md", ….
    """
    window = pmui.Dialog(
        *contents, title=title, title_variant="h6", width_option=width, close_on_click=True, show_close_button=True,
        sx=LOOK,
    )  # fmt: skip
    window.jscallback(open=RETURN_FOCUS)
    return window
