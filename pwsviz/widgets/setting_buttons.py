"""A row of buttons bound to a setting of the scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import panel_material_ui as pmui

from pwsviz.scene.names import LABELS
from pwsviz.scene.scene import Scene
from pwsviz.widgets.panes import PLAIN_SX

PRESSED = {
    "@media (forced-colors: active)": {
        ".MuiToggleButton-root.Mui-selected": {
            "forcedColorAdjust": "none", "color": "HighlightText !important",
            "backgroundColor": "Highlight !important",
        }
    }
}  # fmt: skip
"""The pressed button where the colours are those of the system."""

BUTTONS_SX = {
    ".MuiToggleButton-root": {**PLAIN_SX, "padding": "2px 8px"},
    **PRESSED,
}

UNSEEN_LABEL = """
label { position: absolute !important; width: 1px; height: 1px; overflow: hidden; clip-path: inset(50%); }
"""
"""Style sheet of buttons whose name is told to screen readers alone."""

Options = Mapping[str, Any]
"""Value of each option by its label."""


def choice(
    scene: Scene, setting: str, options: Callable[[], Options], follows: Sequence[str] = (), name: str = ""
) -> Any:
    """Return a row of buttons, of which the pressed one is the value of a setting.

    Parameters
    ----------
    scene : Scene
        The settings.
    setting : str
        Name of the setting.
    options : callable
        Returns the present options.
    follows : sequence of str
        Names of the settings on which the options depend.
    name : str
        What screen readers call the row; by default the label of the setting.
    """
    buttons = pmui.RadioButtonGroup(
        options=dict(options()), label=name or LABELS[setting], size="small", margin=(4, 10, 4, 0), sx=BUTTONS_SX,
        stylesheets=[UNSEEN_LABEL],
    )  # fmt: skip

    syncing = False

    def sync(*_: Any) -> None:
        """Press the button of the setting; if there is none, the first one, and the setting stays."""
        nonlocal syncing
        now, value = dict(options()), getattr(scene, setting)
        syncing = True
        buttons.param.update(options=now, value=value if value in now.values() else next(iter(now.values())))
        syncing = False

    def take(event: Any) -> None:
        if not syncing and event.new in options().values():
            scene.accept(setting, event.new)

    sync()
    scene.param.watch(sync, [setting, *follows])
    buttons.param.watch(take, "value")
    return buttons
