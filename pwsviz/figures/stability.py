"""The figures of a stability study: the map of outcomes, the drift in long runs, and runs near a tangency."""

from __future__ import annotations

from typing import Literal

from bokeh.plotting import figure

import core
from pwsviz.figures.stability_lines import DriftFigure, GrazingFigure
from pwsviz.figures.stability_map import MapFigure, Shown
from pwsviz.figures.stability_tables import stability_tables
from pwsviz.figures.stability_text import stability_text

__all__ = ["Part", "StabilityView", "stability_tables", "stability_text"]

Part = Literal["map", "drift", "grazing"]

_FIGURES: dict[str, type[MapFigure | DriftFigure | GrazingFigure]] = {
    "map": MapFigure,
    "drift": DriftFigure,
    "grazing": GrazingFigure,
}


class StabilityView:
    """Three figures, each made when it is first asked for; `show` only changes their data."""

    def __init__(self) -> None:
        self._made: dict[str, MapFigure | DriftFigure | GrazingFigure] = {}

    def figure(self, part: Part) -> figure:
        """Return the figure of a part."""
        return self._of(part).figure

    def show(self, study: core.StabilityStudy, part: Part, method: str, what: Shown = "outcome") -> None:
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
        """
        drawn = self._of(part)
        if isinstance(drawn, MapFigure):
            drawn.show(study, method, what)
        else:
            drawn.show(study)

    def _of(self, part: Part) -> MapFigure | DriftFigure | GrazingFigure:
        if part not in self._made:
            self._made[part] = _FIGURES[part]()
        return self._made[part]
