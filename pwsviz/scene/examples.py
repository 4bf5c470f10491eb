"""Which example a scene is, whatever of it is shown: a page says what to look at in it and what to try."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

from pwsviz.scene.permalink import adopt, query
from pwsviz.scene.presets import PRESETS, Preset
from pwsviz.scene.scene import Scene
from pwsviz.scene.views import LOOKS, VIEWS

__all__ = ["example_of", "settings_of"]


def settings_of(scene: Scene, example: Preset) -> Mapping[str, object]:
    """Return the settings of a scene that an example is about: those of its runs, and those of its own view.

    How these are shown, and what other views compute, makes no other example.
    """
    own = VIEWS[str(example.settings.get("view", Scene.param.view.default))].settings
    others = {name for view in VIEWS.values() for name in view.settings} - set(own)
    return {name: value for name, value in scene.settings().items() if name not in LOOKS | others}


def example_of(scene: Scene) -> Preset | None:
    """Return the example that a scene is, as its link describes it; None if it is none."""
    if scene.own is not None:
        return None
    usual = Scene().system
    alike = [preset for preset in PRESETS.values() if preset.settings.get("system", usual) == scene.system]
    return next((preset for preset in alike if settings_of(scene, preset) == _linked_settings(preset.key)), None)


@lru_cache(maxsize=len(PRESETS))
def _linked_settings(key: str) -> Mapping[str, object]:
    """Return the settings that the link of an example gives, by its key; a scene takes some hundredths of a second."""
    scene, linked = Scene(), Scene()
    scene.load(PRESETS[key].settings)
    adopt(linked, query(scene))
    return settings_of(linked, PRESETS[key])
