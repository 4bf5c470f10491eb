"""Which example a scene is: a link to one opens with what it says to look at and to try."""

from __future__ import annotations

from functools import lru_cache

from pwsviz.scene.permalink import query
from pwsviz.scene.presets import PRESETS, Preset
from pwsviz.scene.scene import Scene

__all__ = ["example_of"]


def example_of(scene: Scene) -> Preset | None:
    """Return the example whose link is that of a scene; None if there is none."""
    if scene.own is not None:
        return None
    usual, link = Scene().system, query(scene)
    alike = (preset for preset in PRESETS.values() if preset.settings.get("system", usual) == scene.system)
    return next((preset for preset in alike if _link(preset.key) == link), None)


@lru_cache(maxsize=len(PRESETS))
def _link(key: str) -> str:
    """The link of an example, by its key; a scene takes some hundredths of a second."""
    scene = Scene()
    scene.load(PRESETS[key].settings)
    return query(scene)
