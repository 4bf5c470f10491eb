"""The tab of the conserved quantity."""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import core
from pwsviz.export.files import Tables
from pwsviz.export.tables import DrawnRun, conserved_tables
from pwsviz.figures.conserved import ConservedView, conserved_text
from pwsviz.figures.linking import link_crossings
from pwsviz.figures.portrait import PortraitView
from pwsviz.geometry.projection import conserved_note
from pwsviz.results.animation import Landmarks
from pwsviz.results.error_curve import ErrorCurve
from pwsviz.results.requests import ErrorInputs, run_inputs
from pwsviz.tabs.base import Tab
from pwsviz.tasks.cancellation import Cancel, Report


class ErrorPicture(NamedTuple):
    """What the plot shows."""

    system: core.PiecewiseSystem
    curves: list[ErrorCurve]
    marks: Landmarks


class ConservedTab(Tab):
    """The change of ψ that each integrator has made, against time."""

    @cached_property
    def view(self) -> ConservedView:
        """The figure."""
        return ConservedView()

    def link(self, portrait: PortraitView) -> None:
        """Let the plot follow the player, and crossings under the pointer be marked in all figures."""
        link_crossings(portrait, self.view, self.view.instants)

    def inputs(self) -> ErrorInputs:
        """Return one run for each integrator."""
        return ErrorInputs(run_inputs(self.scene), self.scene.axes)

    def compute(self, inputs: ErrorInputs, cancel: Cancel, report: Report) -> ErrorPicture:
        """Reduce the errors of the runs to the resolution of a screen."""
        curves = self.results.error_curves(inputs.runs, cancel)
        system = inputs.runs[0].problem.declaration
        axes = self.results.plane(system, inputs.axes, cancel)
        return ErrorPicture(system, curves, self.results.landmarks(inputs.runs[0], axes, cancel))

    def build(self) -> list[Any]:
        """One figure."""
        return [self.plot(self.view.figure)]

    def draw(self, outcome: ErrorPicture) -> str:
        """Draw the change of ψ, if any ψ is known, and return it in words."""
        system = outcome.system
        there = system.laws.most_conserved > 0
        self.plots[0].visible = there
        if there:
            self.view.show(outcome.curves, outcome.marks)
        said = conserved_text(outcome.curves) if there else ""
        return f"{said} {conserved_note(system)}".strip()

    def tables(self) -> Tables:
        """Return the drift of every integrator at its own steps, and its crossings."""
        inputs, start = self.shown, self.scene.selected + 1
        if not isinstance(inputs, ErrorInputs):
            return {}
        return conserved_tables(lambda: [DrawnRun(start, self.results.run(one)) for one in inputs.runs])
