"""The views beside the portrait, one file each."""

from __future__ import annotations

from collections.abc import Callable

from pwsviz.results.results import Results
from pwsviz.scene.scene import Scene
from pwsviz.tabs.base import LongTab, Tab
from pwsviz.tabs.conserved import ConservedTab
from pwsviz.tabs.cost import CostTab
from pwsviz.tabs.order import state_order_tab, time_order_tab
from pwsviz.tabs.scheme import SchemeTab
from pwsviz.tabs.stability import StabilityTab

__all__ = ["TABS", "LongTab", "Tab"]

TABS: dict[str, Callable[[Scene, Results], Tab]] = {
    "conserved": ConservedTab,
    "order": state_order_tab,
    "time": time_order_tab,
    "cost": CostTab,
    "stability": StabilityTab,
    "scheme": SchemeTab,
}
"""Constructor of the tab of each of `pwsviz.scene.views.VIEWS`, by key."""
