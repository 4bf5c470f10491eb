"""The views beside the portrait: the one table of them. What draws each is attached in `pwsviz.tabs`."""

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
"""Title of each view by its key, which stands in links; in display order, one view at a time."""
