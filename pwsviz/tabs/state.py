"""The tab of the state against time."""

from __future__ import annotations

from typing import Any, NamedTuple

import panel as pn
from bokeh.plotting import figure

import core
from pwsviz.export.files import Tables
from pwsviz.export.tables import DrawnRun, portrait_tables
from pwsviz.figures.linking import link_crossings
from pwsviz.figures.portrait import PortraitView
from pwsviz.figures.state import MOST_PANELS, StateView, panel_text, state_text
from pwsviz.figures.style import describe
from pwsviz.geometry.plane import Plane
from pwsviz.results.requests import ErrorInputs, run_inputs
from pwsviz.results.states import StateCurves
from pwsviz.scene.names import tally_of
from pwsviz.tabs.base import Tab
from pwsviz.tasks.cancellation import Cancel, Report
from pwsviz.text.math_names import variable_name
from pwsviz.text.words import JUMPS_MARKED, STEPS_MARKED, listed, whose_marks


class StatePicture(NamedTuple):
    """What the plot shows: the curves of each integrator, and the first one's run."""

    curves: list[StateCurves]
    first: core.Trajectory
    plane: Plane
    """Of the portrait, in which the crossing under the pointer is marked, too."""


class StateTab(Tab):
    """Each coordinate against time."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.view = StateView()
        self._panels = pn.Column(margin=0, sizing_mode="stretch_width")
        self._portrait: PortraitView | None = None

    def link(self, portrait: PortraitView) -> None:
        """Let the panels follow the player, and crossings under the pointer be marked in all figures."""
        self._portrait = portrait

    def inputs(self) -> ErrorInputs:
        """Return one run for each integrator."""
        return ErrorInputs(run_inputs(self.scene), self.scene.axes)

    def compute(self, inputs: ErrorInputs, cancel: Cancel, report: Report) -> StatePicture:
        """Reduce the runs to the resolution of a screen."""
        curves = [self.results.states(one, cancel) for one in inputs.runs]
        plane = self.results.plane(inputs.runs[0].problem.declaration, inputs.axes, cancel)
        return StatePicture(curves, self.results.run(inputs.runs[0], cancel), plane)

    def build(self) -> list[Any]:
        """Make place for the panels, which depend on the system."""
        return [self._panels]

    def draw(self, outcome: StatePicture) -> str:
        """Draw the runs, and return the ranges of the coordinates in words."""
        names = list(map(variable_name, outcome.first.system.variables))
        self.view.show(outcome.curves, names, outcome.first, outcome.plane.points(outcome.first.crossings.x))
        for panel in self.view.panels[len(self.plots) :]:
            self.plot(panel.figure)
            if self._portrait is not None:
                link_crossings(self._portrait, panel, self.view.shared.instants)
        self._panels.objects = self.plots[: len(names)]
        return self.which_start() + state_text(names, outcome.curves, len(outcome.first.crossings))

    def _describe(self, words: str) -> None:
        """Describe each panel by its own coordinate."""
        if self.outcome is not None:
            names, curves = self.outcome.first.system.variables, self.outcome.curves
            for k, pane in enumerate(self._panels.objects):
                describe(pane.object, panel_text(variable_name(names[k]), curves, k))

    def heading(self, outcome: StatePicture) -> str:
        """Return which variables are drawn over time."""
        names = list(map(variable_name, outcome.first.system.variables))
        return f"Time evolution of {listed(names[:MOST_PANELS])}"

    def meaning(self, outcome: StatePicture) -> str:
        """Return what dots are, and whose crossings are marked, for captions."""
        dots = STEPS_MARKED * any(len(curve.steps[0]) for curve in outcome.curves)
        marks = whose_marks([curve.method for curve in outcome.curves], len(outcome.first.crossings))
        jumps = JUMPS_MARKED * (tally_of(outcome.first).jumps > 0)
        return " ".join(filter(None, [dots, marks, jumps]))

    def pictures(self) -> list[figure]:
        """Return all panels."""
        return [pane.object for pane in self._panels.objects]

    def tables(self) -> Tables:
        """Return the states of every integrator at its own steps, and its crossings."""
        inputs, start = self.shown, self.scene.selected + 1
        if not isinstance(inputs, ErrorInputs):
            return {}
        return portrait_tables(lambda: [DrawnRun(start, self.results.run(one)) for one in inputs.runs])
