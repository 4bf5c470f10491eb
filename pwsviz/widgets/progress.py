"""A progress bar with a button to cancel."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import panel as pn
import panel_material_ui as pmui

from pwsviz.widgets.panes import PLAIN_SX

BAR_CSS = """
progress { appearance: none; display: block; width: 100%; height: 4px; border: 0;
           --track: var(--mui-palette-divider, #E0E0E0); --done: var(--mui-palette-primary-main, #0072B2); }
progress, progress::-webkit-progress-bar { background: var(--track); }
progress::-webkit-progress-value { background: var(--done); }
progress::-moz-progress-bar { background: var(--done); }
progress:indeterminate { background: linear-gradient(90deg, var(--track) 33%, var(--done) 33% 67%, var(--track) 67%)
                         0 / 300%; animation: 2s linear infinite pass; }
progress:indeterminate::-webkit-progress-bar { background: none; }
progress:indeterminate::-moz-progress-bar { background: none; }
@keyframes pass { from { background-position: 100% } to { background-position: 0 } }
@media (forced-colors: active) { progress { forced-color-adjust: none; --track: GrayText; --done: Highlight; } }
@media (prefers-reduced-motion) { progress:indeterminate { animation-duration: 12s } }
"""
"""Drawn alike by all browsers: their own bars have colours of their own."""


class Progress(pn.viewable.Viewer):
    """A bar with “Cancel” while a computation is running, and “Run again” after it was cancelled.

    Parameters
    ----------
    on_cancel, on_again : callable
        Called when the buttons are pressed.
    """

    def __init__(self, on_cancel: Callable[[], None], on_again: Callable[[], None]) -> None:
        super().__init__()
        self._bar = bar_pane("the computation", margin=(9, 8))
        self._words = pmui.Typography("", variant="caption", margin=(6, 8), sx={"whiteSpace": "nowrap"})
        self._cancel = pmui.Button(label="Cancel", size="small", variant="text", margin=(2, 0), sx=PLAIN_SX)
        self._again = pmui.Button(
            label="Run again", size="small", variant="text", margin=(2, 0), sx=PLAIN_SX, visible=False
        )
        self._cancel.on_click(lambda _: self._press(on_cancel))
        self._again.on_click(lambda _: self._press(on_again))
        self._pressed = False
        self._row = pn.Row(
            self._bar, self._words, self._cancel, self._again, visible=False, margin=0, sizing_mode="stretch_width"
        )

    @property
    def busy(self) -> bool:
        """Whether a computation is running."""
        return bool(self._row.visible and self._cancel.visible)

    def begin(self, former: bool = False) -> None:
        """Show that a computation has begun, of unknown length; `former`: and that a former result is still seen."""
        self._bar.param.update(object=_bar("the computation"), visible=True)
        self._say("preparing …" + former * " (the previous result is shown below)", cancellable=True)

    def advance(self, done: int, total: int) -> None:
        """Show which part of the computation is done."""
        part = done / max(total, 1)
        self._bar.object = _bar("the computation", part)
        self._say(f"{math.floor(100 * part)} %", cancellable=True)

    def end(self) -> None:
        """Hide the bar: the computation is finished."""
        self._row.visible = self._pressed = False

    def stop(self) -> None:
        """Show that the computation was cancelled, and offer to run it again."""
        if self.busy:
            self._bar.visible = False
            self._say("cancelled", cancellable=False)

    def _press(self, act: Callable[[], None]) -> None:
        """Do what a button stands for; it will be hidden, and hands the focus on to the other one."""
        self._pressed = True
        act()

    def _say(self, words: str, cancellable: bool) -> None:
        self._words.object = words
        self._cancel.visible, self._again.visible = cancellable, not cancellable
        self._row.visible = True
        if self._pressed:
            self._pressed = False
            (self._cancel if cancellable else self._again).focus()

    def __panel__(self) -> pn.viewable.Viewable:
        """Return bar, text and buttons in a row."""
        return self._row


def bar_pane(work: str, **options: Any) -> pn.pane.HTML:
    """Return a bar that says, to screen readers too, that some work is going on."""
    return pn.pane.HTML(_bar(work), stylesheets=[BAR_CSS], sizing_mode="stretch_width", **options)


def _bar(work: str, part: float | None = None) -> str:
    """Return the bar at a part of its length; without one, that part is not known."""
    value = "" if part is None else f' value="{part:.2f}"'
    return f'<progress aria-label="Progress of {work}"{value}></progress>'
