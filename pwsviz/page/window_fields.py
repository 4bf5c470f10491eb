"""The limits of the portrait as numbers, and a button that fits it to the trajectories."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import panel as pn
import panel_material_ui as pmui

from pwsviz.page.look import FOR_TOUCH
from pwsviz.scene.names import LABELS as SETTINGS
from pwsviz.scene.scene import Scene
from pwsviz.scene.validation import window
from pwsviz.widgets.number_field import NumberField
from pwsviz.widgets.panes import PLAIN_SX, TEXT_CSS

__all__ = ["WindowFields"]

LABELS = ("Left end", "Right end", "Bottom end", "Top end")
"""Of the fields, in the order of `Scene.window`."""

Ends = tuple[float, ...]

ROW_CSS = ":host { flex-wrap: wrap; gap: 0 8px; } :host > * { flex: 1 1 90px !important; min-width: 80px; }"
"""Side by side where at least 80 px remain for each."""


EQUAL = '<p class="about">Scales are equal: the ends of the other axis follow what is typed.</p>'

NOTE_CSS = ":host { flex: 1 1 100% !important; }"


def at_equal_scales(typed: Ends, seen: Ends, across: bool) -> tuple[float, float, float, float]:
    """Return a window that fills a frame of equal scales in which another one is seen.

    Parameters
    ----------
    typed : (left, right, bottom, top)
        Of which two ends are kept exactly; the other two keep their middle.
    seen : (left, right, bottom, top)
        What the frame shows, from edge to edge.
    across : bool
        Whether left and right are kept, or else bottom and top.
    """
    left, right, bottom, top = typed
    shape = (seen[3] - seen[2]) / (seen[1] - seen[0])
    if across:
        middle, half = (bottom + top) / 2, (right - left) * shape / 2
        return left, right, middle - half, middle + half
    middle, half = (left + right) / 2, (top - bottom) / shape / 2
    return middle - half, middle + half, bottom, top


class WindowFields(pn.viewable.Viewer):
    """A field for each end of the window, made when they are first wanted.

    Parameters
    ----------
    scene : Scene
        The settings.
    seen : callable
        Returns the four ends of what is visible: more than was typed where equal scales need more.
    on_fit : callable
        Called when the user wants to see the trajectories again.
    """

    def __init__(self, scene: Scene, seen: Callable[[], Ends], on_fit: Callable[[], None]) -> None:
        super().__init__()
        self.scene, self._seen, self._on_fit = scene, seen, on_fit
        self.button = pmui.IconButton(
            icon="straighten",
            size="small",
            description=SETTINGS["window"],
            margin=2,
            sx=FOR_TOUCH,
            on_click=self._toggle,
        )
        self.fields: list[NumberField] = []
        self.box = pn.Row(margin=(0, 8), sizing_mode="stretch_width", visible=False, stylesheets=[ROW_CSS])

    def sync(self) -> None:
        """Show the present ends, while the fields are shown."""
        if self.box.visible:
            for field in self.fields:
                field.sync()

    def close(self) -> None:
        """Hide the fields."""
        self.box.visible = False

    def _toggle(self, _event: Any) -> None:
        if not self.fields:
            self.fields = [
                NumberField(label, partial(self._read, k), partial(self._accept, k)) for k, label in enumerate(LABELS)
            ]
            fit = pmui.Button(label="Fit", variant="text", size="small", margin=(9, 0), sx=PLAIN_SX)
            fit.on_click(lambda _: self._on_fit())
            self.box.objects = [*self.fields, fit, pn.pane.HTML(EQUAL, margin=(0, 4), stylesheets=[TEXT_CSS, NOTE_CSS])]
        self.box.visible = not self.box.visible
        self.sync()

    def _read(self, k: int) -> float:
        return float(self._seen()[k])

    def _accept(self, k: int, value: object) -> None:
        seen = self._seen()
        typed = window((*seen[:k], value, *seen[k + 1 :]))
        if typed is not None:
            self.scene.accept("window", at_equal_scales(typed, seen, across=k < len(LABELS) // 2))

    def __panel__(self) -> pn.viewable.Viewable:
        """Return the fields; the button stands elsewhere."""
        return self.box
