"""The scene of a page that is opened without a link."""

from __future__ import annotations

from pwsviz.scene.presets import FIRST_LOOK, PRESETS
from pwsviz.scene.scene import Scene

__all__ = ["first_scene"]


def first_scene() -> Scene:
    """Return the scene of the first example."""
    scene = Scene()
    scene.load(PRESETS[FIRST_LOOK].settings)
    return scene
