"""A window over the page, closed by Esc, by its button, or by a click beside it."""

from __future__ import annotations

from typing import Any

import panel_material_ui as pmui

__all__ = ["dialog"]

LOOK = {"& [aria-label=close]": {"color": "var(--mui-palette-text-secondary) !important"}}
"""The button to close it is otherwise dark on dark."""

RETURN_FOCUS = """
let focused = document.activeElement
while (focused?.shadowRoot?.activeElement) { focused = focused.shadowRoot.activeElement }
if (cb_obj.open) { cb_obj.opener = focused }
else { requestAnimationFrame(() => setTimeout(() => cb_obj.opener?.focus({ preventScroll: true }))) }
"""
"""JavaScript run at opening and closing: Material UI looks for what had the focus outside of all shadow roots."""


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
