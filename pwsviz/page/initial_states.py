"""Buttons that select, add and remove starts of trajectories."""

from __future__ import annotations

from typing import Any

import panel as pn
import panel_material_ui as pmui

from pwsviz.scene.checks import MAX_STARTS
from pwsviz.scene.names import LABELS
from pwsviz.scene.scene import Scene
from pwsviz.text.words import as_text
from pwsviz.widgets.focus import hand_on
from pwsviz.widgets.kept import kept
from pwsviz.widgets.panes import heading_with, text_pane
from pwsviz.widgets.setting_buttons import PRESSED, UNSEEN_LABEL

NUMBERS_SX = {
    "flexWrap": "wrap", "gap": "4px",
    ".MuiToggleButton-root.MuiToggleButton-root": {
        "width": "auto", "paddingX": "12px", "margin": 0, "border": "1px solid var(--mui-palette-divider)",
        "borderRadius": "4px",
    },
    **PRESSED,
}  # fmt: skip
"""Each button has a border of its own, since those of a wrapped row are not joined to the row above."""

ASIDE = 0.1
"""Distance of a new start from the selected one in its first coordinate, relative to its largest |coordinate|."""


class Trajectories(pn.viewable.Viewer):
    """A numbered button for each start, and buttons to add and to remove one."""

    def __init__(self, scene: Scene) -> None:
        super().__init__()
        self.scene = scene
        self.numbers = pmui.RadioButtonGroup(
            options=[1], value=1, label=LABELS["starts"], size="small", margin=(4, 4, 4, 0), sx=NUMBERS_SX,
            stylesheets=[UNSEEN_LABEL],
        )  # fmt: skip
        self.more = pmui.IconButton(icon="add", size="small", description="Add a trajectory", margin=2)
        self.less = pmui.IconButton(icon="delete", size="small", description="Remove this trajectory", margin=2)
        self.message = text_pane("", "error")
        self.numbers.param.watch(self._select, "value")
        self.more.on_click(lambda _: self._try(self._add))
        self.less.on_click(lambda _: self._try(lambda: scene.remove(scene.selected)))
        for button, other in ((self.more, self.less), (self.less, self.more)):
            hand_on(button, other)
        for settle in (
            kept(self.numbers, options=self._numbers, value=lambda: 1 + min(scene.selected, len(scene.starts) - 1)),
            kept(self.more, disabled=lambda: len(scene.starts) >= MAX_STARTS),
            kept(self.less, disabled=lambda: len(scene.starts) == 1),
            self._forget,
        ):
            scene.param.watch(settle, ["starts", "selected"])

    def _numbers(self) -> list[int]:
        return list(range(1, len(self.scene.starts) + 1))

    def _forget(self, *_: Any) -> None:
        self.message.object = ""

    def _select(self, event: Any) -> None:
        if event.new is not None and event.new - 1 != self.scene.selected and event.new <= len(self.scene.starts):
            self.scene.selected = event.new - 1

    def _add(self) -> None:
        """Add a start beside the selected one, where there is none yet."""
        size = max(map(abs, self.scene.x0)) or 1.0
        first, *others = self.scene.x0
        while (placed := (float(f"{first + ASIDE * size:.6g}"), *others)) in self.scene.starts:
            first = placed[0]
        self.scene.place(placed)

    def _try(self, change: Any) -> None:
        try:
            change()
        except ValueError as reason:
            self.message.object = as_text(str(reason), "error")

    def __panel__(self) -> pn.viewable.Viewable:
        """Buttons beside their heading; the numbers come last, so that many of them wrap without the others."""
        return pn.Column(
            heading_with("Starts", self.more, self.less, self.numbers), self.message,
            margin=0, sizing_mode="stretch_width",
        )  # fmt: skip
