"""The views beside the portrait, one file each; `pwsviz.scene.views` lists them."""

from __future__ import annotations

from pkgutil import resolve_name

from pwsviz.results.results import Results
from pwsviz.scene.scene import Scene
from pwsviz.scene.views import VIEWS
from pwsviz.tabs.base import LongTab, Tab

__all__ = ["LongTab", "Tab", "make_tab"]


def make_tab(view: str, scene: Scene, results: Results) -> Tab:
    """Make the tab of the view with this key."""
    tab: Tab = resolve_name(VIEWS[view].tab)(scene, results)
    return tab
