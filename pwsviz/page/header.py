"""The bar at the head of the page: undo and redo, export, lecture mode, help, and what the page is; and its foot."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import Any

import panel as pn
import panel_material_ui as pmui

from pwsviz.page.export_dialog import OPEN_AT_ONCE, TITLE
from pwsviz.page.help import ABOUT, CITATION
from pwsviz.page.look import ABOUT_CSS, FOR_FINGERS, HEADER_SX, NOT_IN_LECTURES, NOT_ON_PHONES
from pwsviz.scene.history import History
from pwsviz.widgets.focus import hand_on
from pwsviz.widgets.kept import kept
from pwsviz.widgets.lecture import NAME as LECTURE
from pwsviz.widgets.panes import markup_pane

__all__ = ["footer", "header"]


def header(
    history: History,
    tagline: Any,
    *,
    undo: Callable[[], None],
    redo: Callable[[], None],
    export: Callable[[], None],
    lecture: Callable[[], None],
    ask: Callable[[], None],
) -> list[Any]:
    """Return the parts of the bar, from left to right; each button calls the function of its name."""
    back = _button("undo", "Undo (Ctrl+Z)", undo, (4, 0, 4, 4), NOT_IN_LECTURES)
    forth = _button("redo", "Redo (Ctrl+Y)", redo, (4, 4, 4, 0), NOT_IN_LECTURES)
    history.param.watch(kept(back, disabled=lambda: not history.can_undo), "can_undo")
    history.param.watch(kept(forth, disabled=lambda: not history.can_redo), "can_redo")
    for button, other in ((back, forth), (forth, back)):
        hand_on(button, other)
    share = pmui.Button(
        label=TITLE, icon="ios_share", variant="text", size="small", margin=4,
        sx=HEADER_SX | FOR_FINGERS | NOT_IN_LECTURES,
    )  # fmt: skip
    share.js_on_click(code=OPEN_AT_ONCE)
    share.on_click(lambda _: export())
    parts = [
        back, forth, share, _button("co_present", LECTURE, lecture, 4, NOT_ON_PHONES),
        _button("help_outline", "Help (?)", ask, 4, {}), tagline,
    ]  # fmt: skip
    for part in parts:
        part.align = "center"
    return parts


def _button(icon: str, name: str, call: Callable[[], None], margin: Any, sx: dict[str, Any]) -> Any:
    button = pmui.IconButton(icon=icon, description=name, size="small", margin=margin, sx=FOR_FINGERS | sx)
    button.on_click(lambda _: call())
    return button


def footer() -> pn.pane.HTML:
    """Return what the page is, for whom, and where its method comes from."""
    pane = markup_pane(ABOUT_CSS)
    pane.object = f'<footer><p class="about">{escape(ABOUT)}</p><p>Method: {CITATION}</p></footer>'
    return pane
