"""The table of the views beside the portrait. `pwsviz.tabs` has the tab of each."""

from __future__ import annotations

__all__ = ["VIEWS"]

VIEWS = {
    "conserved": "Conserved quantity",
    "order": "Order",
    "time": "Crossing time",
    "cost": "Cost",
    "stability": "Stability",
    "scheme": "Scheme",
}
"""Title of each view by its key, in display order; links contain the key."""
