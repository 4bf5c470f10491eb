"""The table of the views beside the portrait: a view is a line here, and a file in `pwsviz.tabs`."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["LOOKS", "SWEEP_SETTINGS", "VIEWS", "View"]


class View(NamedTuple):
    """A view: what a link and the scene know of it, and where its tab is found."""

    title: str
    subject: str
    """What it looks at; views of one subject stand together."""
    tab: str
    """Constructor of its tab as "module:name", for it stands above the scene and is loaded when a page is made."""
    settings: tuple[str, ...] = ()
    """The settings of the scene that it reads, and the portrait does not."""


_ORDER = ("study_method", "order_all")
_STABILITY = ("stability_part", "stability_shown", "stability_coordinate", "stability_around")
_SECTION = (
    "section_of", "section_direction", "section_axes", "section_points", "section_discard", "section_map",
)  # fmt: skip
SWEEP_SETTINGS = (
    "sweep_parameter", "sweep_range", "sweep_coordinate", "sweep_of", "sweep_direction", "sweep_continuation",
    "sweep_values", "sweep_points", "sweep_discard", "sweep_end",
)  # fmt: skip
"""The parameter stands before its range, which a link can only set once the parameter is known."""

VIEWS = {
    "conserved": View("Conserved quantity", "run", "pwsviz.tabs.conserved:ConservedTab"),
    "state": View("State", "run", "pwsviz.tabs.state:StateTab"),
    "order": View("Order", "integrators", "pwsviz.tabs.order:state_order_tab", _ORDER),
    "time": View("Crossing time", "integrators", "pwsviz.tabs.order:time_order_tab", _ORDER),
    "cost": View("Cost", "integrators", "pwsviz.tabs.cost:CostTab", ("peers", "cost_across", "cost_up")),
    "stability": View("Stability", "integrators", "pwsviz.tabs.stability:StabilityTab", ("study_method", *_STABILITY)),
    "section": View("Section", "system", "pwsviz.tabs.section:SectionTab", ("study_method", *_SECTION)),
    "sweep": View("Sweep", "system", "pwsviz.tabs.sweep:SweepTab", ("study_method", *SWEEP_SETTINGS)),
    "scheme": View("Scheme", "formulas", "pwsviz.tabs.scheme:SchemeTab", ("study_method",)),
}
"""Each view by its key, in display order; links contain the key."""

LOOKS = frozenset({
    "view", "window", "axes", "selected", "peers", "cost_across", "cost_up", "order_all", "section_axes", "section_map",
    "stability_part", "stability_shown", "sweep_coordinate",
})  # fmt: skip
"""The settings that only say what is shown of a scene, on which axes, and beside what."""
