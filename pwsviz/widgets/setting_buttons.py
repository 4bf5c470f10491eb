"""A choice of one among a few, kept with a setting of the scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import panel_material_ui as pmui

from pwsviz.scene.scene import Scene
from pwsviz.widgets.panes import PLAIN_SX

BUTTONS_SX = {".MuiToggleButton-root": {**PLAIN_SX, "paddingY": "2px"}}

Options = Mapping[str, Any]
"""Label and value of each."""


def choice(scene: Scene, setting: str, options: Callable[[], Options], follows: Sequence[str] = ()) -> Any:
    """Return a row of buttons, one of which is pressed: the value of a setting.

    Parameters
    ----------
    options : callable
        Returns what there is to choose from now.
    follows : sequence of str
        Settings on which that depends.
    """
    buttons = pmui.RadioButtonGroup(options=dict(options()), size="small", margin=(4, 10, 4, 0), sx=BUTTONS_SX)

    syncing = False

    def sync(*_: Any) -> None:
        """Show the setting; where it is not offered now another is pressed, and the setting stays."""
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
