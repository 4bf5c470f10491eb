"""A row of buttons bound to a setting of the scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import panel_material_ui as pmui

from pwsviz.scene.scene import Scene
from pwsviz.widgets.panes import PLAIN_SX

BUTTONS_SX = {".MuiToggleButton-root": {**PLAIN_SX, "paddingY": "2px"}}

Options = Mapping[str, Any]
"""Value of each option by its label."""


def choice(scene: Scene, setting: str, options: Callable[[], Options], follows: Sequence[str] = ()) -> Any:
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
    """
    buttons = pmui.RadioButtonGroup(options=dict(options()), size="small", margin=(4, 10, 4, 0), sx=BUTTONS_SX)

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
