"""The tab of the bifurcation diagram: what runs leave on a surface, for each value of a parameter."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import panel as pn
import panel_material_ui as pmui
from bokeh.plotting import figure

from pwsviz.export.files import Tables
from pwsviz.export.script import sweep_program
from pwsviz.export.tables import sweep_tables
from pwsviz.figures.sweep import SweepView
from pwsviz.figures.sweep_text import (
    examined_words,
    growth_words,
    parameter_name,
    sweep_details,
    sweep_how,
    sweep_numbers,
    sweep_prospects,
    sweep_text,
)
from pwsviz.geometry.window import Window
from pwsviz.results.requests import SweepInputs
from pwsviz.results.sweeps import Diagram, of_one_value
from pwsviz.scene.presets import shown_example
from pwsviz.scene.sweeping import swept_parameter, swept_range
from pwsviz.tabs.base import LongTab, about_crossings
from pwsviz.tabs.sweep_controls import SweepControls
from pwsviz.tasks.cancellation import Cancel, Report
from pwsviz.text.advice import without_advice
from pwsviz.text.tables import Numbers
from pwsviz.text.words import complaint
from pwsviz.widgets.panes import PLAIN_SX

RESOLUTION = 500
"""Steps of the width of the picture to which the place of a click is rounded."""


class SweepTab(LongTab):
    """The diagram, which becomes finer while it is looked at."""

    settings = ("values",)

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.view: SweepView | None = None
        self._chosen: Diagram | None = None  # of one value

    def inputs(self) -> SweepInputs:
        """Return one integrator, one parameter and one section."""
        return SweepInputs.of_scene(self.scene)

    def compute(self, inputs: SweepInputs, cancel: Cancel, report: Report) -> Diagram:
        """Compute the diagram, coarse to fine."""
        return self.results.sweep(inputs, cancel, report)

    def further_inputs(self) -> SweepInputs | None:
        """Return the chosen value, once the diagram is there and if it is none of its values.

        A continuation has no points between its values: each run begins where that of the value before has ended.
        """
        found = self.outcome if self.shown == self.inputs() else None
        value = None if found is None else self.scene.values.get(found.inputs.parameter)
        if found is None or value is None or found.inputs.continuation != "none" or value in found.values:
            return None
        return of_one_value(found.inputs, value) if found.inputs.low < value < found.inputs.high else None

    def compute_further(self, inputs: SweepInputs, cancel: Cancel, report: Report) -> Diagram:
        """Compute the points of the chosen value."""
        return self.results.sweep(inputs, cancel, report)

    def add_further(self, outcome: Diagram) -> None:
        """Draw the points of the chosen value."""
        self._chosen = outcome
        self.redraw()

    def _chosen_of(self, outcome: Diagram, value: float) -> Diagram | None:
        """Return the points of the chosen value, if they have been computed for a diagram."""
        known = self._chosen is not None and self._chosen.inputs == of_one_value(outcome.inputs, value)
        return self._chosen if known else None

    def build(self) -> list[Any]:
        """Make the controls and the plot."""
        self.view = SweepView(self._go, self._look)
        self.controls = SweepControls(self.scene)
        self._narrow = pmui.Button(
            label="Sweep the visible range", size="small", variant="text", margin=(2, 0), sx=PLAIN_SX, visible=False
        )
        self._narrow.on_click(lambda _: self._sweep_in_sight())
        self._place = pn.Column(self.plot(self.view.figure), margin=0, sizing_mode="stretch_width")
        return [self.controls, self.progress, self._place, self._narrow]

    def present(self, inputs: Any, outcome: Diagram | Exception) -> None:
        """Draw the diagram, or say why there is none; a system without a parameter leaves no room for it."""
        self._place.visible = bool(inputs.parameter)
        super().present(inputs, outcome)

    def draw(self, outcome: Diagram) -> str:
        """Draw the diagram, if it has any points, and return it in words."""
        assert self.view is not None  # noqa: S101  (drawn after it was built)
        present = self.scene.values.get(outcome.inputs.parameter, math.nan)  # where another system has just been chosen
        self.view.show(outcome)
        self.controls.tell_discarded(outcome.inputs.discard)
        chosen = self._chosen_of(outcome, present)
        self.view.mark(present, parameter_name(outcome.inputs), chosen)
        self._place.visible = bool(outcome.counts.any())
        return sweep_text(outcome, present, chosen)

    def remark(self, outcome: Diagram) -> str:
        """Return what may be expected of the points, and what the runs do at crossings if that is unusual."""
        hope = sweep_prospects(outcome, shown_example(self.scene))
        return " ".join(filter(None, (growth_words(outcome), hope, about_crossings(self.scene, locates=True))))

    def details(self, outcome: Diagram) -> str:
        """Return what is plotted, and which runs were examined."""
        return sweep_details(outcome)

    def warnings(self, outcome: Diagram) -> Sequence[str]:
        """Return what is said against the step size."""
        return outcome.warnings

    def meaning(self, outcome: Diagram) -> str:
        """Return which runs are in doubt, and what the points of others mean, for captions."""
        growth = growth_words(outcome)
        said = [examined_words(outcome), *map(without_advice, outcome.warnings), growth]
        return " ".join(filter(None, said * bool(outcome.warnings or growth)))

    def pictures(self) -> list[figure]:
        """Return the diagram, if there is one, painted finely enough for print."""
        if self.view is None or not self._place.visible:
            return []
        self.view.cloud.sharpen()
        return super().pictures()

    def numbers(self, outcome: Diagram) -> Sequence[Numbers]:
        """Return how many values end early, and where."""
        return [sweep_numbers(outcome)]

    def _go(self, value: float) -> None:
        """Take the value on which the user clicked, rounded to what a screen resolves."""
        parameter = swept_parameter(self.scene)
        if parameter is None:
            return
        low, high = self._in_sight()
        bounds = parameter.bounds or (-math.inf, math.inf)
        try:
            self.scene.accept(f"values.{parameter.name}", min(max(_rounded(value, high - low), bounds[0]), bounds[1]))
        except ValueError as reason:
            self.words.object = complaint(reason)

    def _in_sight(self) -> tuple[float, float]:
        """Return the part of the range that is visible."""
        low, high = swept_range(self.scene)
        window = self.view.cloud.window if self.view is not None else None
        if window is None or window.x_low >= high or window.x_high <= low:
            return low, high
        return max(low, window.x_low), min(high, window.x_high)

    def _look(self, _window: Window) -> None:
        """Offer to sweep the visible range, where these are a part of the range."""
        (low, high), (left, right) = swept_range(self.scene), self._in_sight()
        self._narrow.visible = right - left < 0.95 * (high - low)

    def _sweep_in_sight(self) -> None:
        """Sweep the part of the range that is visible, and show all of it."""
        assert self.view is not None  # noqa: S101  (the button was made with it)
        low, high = self._in_sight()
        self.scene.accept("sweep_range", (_rounded(low, high - low), _rounded(high, high - low)))
        self._narrow.visible = False
        self.view.cloud.fit()

    def tables(self) -> Tables:
        """Return a row for each point, a row for each value, and the chosen value with its points among the others."""
        found = self.outcome
        if found is None:
            return {}
        present = self.scene.values.get(found.inputs.parameter, math.nan)
        return sweep_tables(found, present, self._chosen_of(found, present))

    def heading(self, outcome: Diagram) -> str:
        """Return what diagram it is."""
        return "Bifurcation diagram"

    def free(self) -> str:
        """Return the parameter that is swept."""
        parameter = swept_parameter(self.scene)
        return parameter.name if parameter is not None else ""

    def how(self, outcome: Diagram) -> str:
        """Return how the diagram was made."""
        return sweep_how(outcome.inputs)

    def program(self) -> str:
        """Return the lines that repeat the sweep."""
        inputs = self.inputs()
        if inputs.discard is None and self.outcome is not None:
            inputs = replace(inputs, discard=self.outcome.inputs.discard)
        return sweep_program(inputs)


def _rounded(value: float, width: float) -> float:
    """Return a value with the digits that a picture of a width resolves."""
    return round(value, -math.floor(math.log10(width / RESOLUTION)))
