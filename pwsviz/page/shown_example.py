"""The example on the page, and whether the scene is still that of the example."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import param

from pwsviz.scene.examples import settings_of
from pwsviz.scene.presets import Preset
from pwsviz.scene.scene import Scene

__all__ = ["ShownExample"]


class ShownExample(param.Parameterized):
    """The example that a scene was loaded with last, as long as the scene has its system.

    Parameters
    ----------
    scene : Scene
        The settings.
    preset : Preset, optional
        The example that the scene shows from the beginning.
    """

    preset: Any = param.ClassSelector(default=None, class_=Preset, doc="The example; None if there is none.")
    changed = param.Boolean(default=False, doc="Whether the scene differs from it in more than what is shown of it.")

    def __init__(self, scene: Scene, preset: Preset | None = None) -> None:
        super().__init__()
        self._scene, self._loading = scene, False
        self._loaded: Preset | None = None
        self._system = scene.declaration
        self._settings: Mapping[str, object] = {}
        scene.param.watch(self._compare, [*scene.settings()])
        if preset is not None:
            self._take(preset)

    def load(self, preset: Preset) -> None:
        """Load an example into the scene."""
        self._loading = True
        try:
            self._scene.load(preset.settings)
        finally:
            self._loading = False
        self._take(preset)

    def _take(self, preset: Preset) -> None:
        self._loaded, self._system = preset, self._scene.declaration
        self._settings = settings_of(self._scene, preset)
        self._compare()

    def _compare(self, *_: Any) -> None:
        if self._loading or self._loaded is None:
            return
        there = self._scene.declaration == self._system
        changed = there and settings_of(self._scene, self._loaded) != self._settings
        now = {"preset": self._loaded if there else None, "changed": changed}
        self.param.update(**{name: value for name, value in now.items() if value != getattr(self, name)})
