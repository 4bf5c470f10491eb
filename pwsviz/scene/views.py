"""The table of the views beside the portrait: a view is a line here, and a file in `pwsviz.tabs`."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["VIEWS", "View"]


class View(NamedTuple):
    """A view: what a link and the scene know of it, and where its tab is found."""

    title: str
    tab: str
    """Constructor of its tab as "module:name", for it stands above the scene and is loaded when a page is made."""


VIEWS = {
    "conserved": View("Conserved quantity", "pwsviz.tabs.conserved:ConservedTab"),
    "state": View("State", "pwsviz.tabs.state:StateTab"),
    "order": View("Order", "pwsviz.tabs.order:state_order_tab"),
    "time": View("Crossing time", "pwsviz.tabs.order:time_order_tab"),
    "cost": View("Cost", "pwsviz.tabs.cost:CostTab"),
    "section": View("Section", "pwsviz.tabs.section:SectionTab"),
    "stability": View("Stability", "pwsviz.tabs.stability:StabilityTab"),
    "sweep": View("Sweep", "pwsviz.tabs.sweep:SweepTab"),
    "scheme": View("Scheme", "pwsviz.tabs.scheme:SchemeTab"),
}
"""Each view by its key, in display order; links contain the key."""
