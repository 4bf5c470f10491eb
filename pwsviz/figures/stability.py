"""The figures of a stability study: the map of outcomes, the drift in long runs, and runs near a tangency."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Literal

from bokeh.plotting import figure

import core
from pwsviz.figures.stability_lines import DriftFigure, GrazingFigure
from pwsviz.figures.stability_map import Choose, MapFigure, Shown
from pwsviz.figures.stability_tables import stability_tables
from pwsviz.figures.stability_text import stability_numbers, stability_text

__all__ = ["Part", "StabilityView", "stability_numbers", "stability_tables", "stability_text"]

Part = Literal["map", "drift", "grazing"]


class StabilityView:
    """Three figures, each made when it is first asked for; `show` only changes their data.

    Parameters
    ----------
    on_choose : callable
        Called with the place of a click on the map: a step size and a coordinate of the start.
    """

    def __init__(self, on_choose: Choose) -> None:
        self._make: dict[str, Callable[[], MapFigure | DriftFigure | GrazingFigure]] = {
            "map": partial(MapFigure, on_choose), "drift": DriftFigure, "grazing": GrazingFigure,
        }  # fmt: skip
        self._made: dict[str, MapFigure | DriftFigure | GrazingFigure] = {}

    def figure(self, part: Part) -> figure:
        """Return the figure of a part."""
        return self._of(part).figure

    def show(
        self, study: core.StabilityStudy, part: Part, method: str, what: Shown = "outcome", met: str = "crossings"
    ) -> None:
        """Draw one part of a study, or what is computed of it.

        Parameters
        ----------
        study
            The study.
        part
            The part to draw.
        method
            The integrator of the map; the other parts show all integrators.
        what
            What the colours of the map show: "outcome" or "error".
        met
            What runs meet at the surfaces: crossings, jumps or both.
        """
        drawn = self._of(part)
        if isinstance(drawn, MapFigure):
            drawn.show(study, method, what, met)
        else:
            drawn.show(study, met)

    def mark(self, tau: float, value: float) -> None:
        """Mark a step size and a coordinate of the start on the map, if it is made."""
        drawn = self._made.get("map")
        if isinstance(drawn, MapFigure):
            drawn.mark(tau, value)

    def _of(self, part: Part) -> MapFigure | DriftFigure | GrazingFigure:
        if part not in self._made:
            self._made[part] = self._make[part]()
        return self._made[part]
