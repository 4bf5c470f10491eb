"""The limits of the portrait as numbers, and a button that fits it to the trajectories."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import panel as pn
import panel_material_ui as pmui

from pwsviz.scene.names import LABELS as SETTINGS
from pwsviz.scene.scene import Scene
from pwsviz.widgets.number_field import NumberField
from pwsviz.widgets.panes import PLAIN_SX

__all__ = ["WindowFields"]

LABELS = ("Left end", "Right end", "Bottom end", "Top end")
"""Of the fields, in the order of `Scene.window`."""

Ends = tuple[float, ...]

ROW_CSS = ":host { flex-wrap: wrap; gap: 0 8px; } :host > * { flex: 1 1 90px !important; min-width: 80px; }"
"""Side by side where at least 80 px remain for each."""


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
            icon="crop_free", size="small", description=SETTINGS["window"], margin=2, on_click=self._toggle
        )
        self.fields: list[NumberField] = []
        self.box = pn.Row(margin=(0, 8), sizing_mode="stretch_width", visible=False, stylesheets=[ROW_CSS])

    def sync(self) -> None:
        """Show the present ends, while the fields are shown."""
        if self.box.visible:
            for field in self.fields:
                field.sync()

    def _toggle(self, _event: Any) -> None:
        if not self.fields:
            self.fields = [
                NumberField(label, partial(self._read, k), partial(self._accept, k)) for k, label in enumerate(LABELS)
            ]
            fit = pmui.Button(label="Fit", variant="text", size="small", margin=(9, 0), sx=PLAIN_SX)
            fit.on_click(lambda _: self._on_fit())
            self.box.objects = [*self.fields, fit]
        self.box.visible = not self.box.visible
        self.sync()

    def _read(self, k: int) -> float:
        return float(self._seen()[k])

    def _accept(self, k: int, value: object) -> None:
        ends: list[object] = list(self._seen())
        ends[k] = value
        self.scene.accept("window", tuple(ends))

    def __panel__(self) -> pn.viewable.Viewable:
        """Return the fields; the button stands elsewhere."""
        return self.box
