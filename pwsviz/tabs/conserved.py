"""The tab of the conserved quantity."""

from __future__ import annotations

from typing import Any, NamedTuple

import core
from pwsviz.export.tables import Table, run_table
from pwsviz.figures.conserved import ConservedView, conserved_text
from pwsviz.figures.linking import link_crossings
from pwsviz.figures.portrait import PortraitView
from pwsviz.geometry.projection import conserved_note
from pwsviz.results.animation import Landmarks
from pwsviz.results.requests import ErrorInputs, run_inputs
from pwsviz.results.results import ErrorCurve
from pwsviz.tabs.base import Tab
from pwsviz.tasks.cancellation import Cancel, Report


class ErrorPicture(NamedTuple):
    """All that the plot shows."""

    system: core.PiecewiseSystem
    curves: list[ErrorCurve]
    marks: Landmarks


class ConservedTab(Tab):
    """How far each integrator has let ψ drift."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.view = ConservedView()  # made at once: the portrait's player and crossings are linked to it
        self.now = self.view.now

    def link(self, portrait: PortraitView) -> None:
        """Mark a crossing that is pointed at in the portrait here, and the other way round."""
        link_crossings(portrait, self.view)

    def inputs(self) -> ErrorInputs:
        """One run for each integrator."""
        return ErrorInputs(run_inputs(self.scene), self.scene.axes)

    def compute(self, inputs: ErrorInputs, cancel: Cancel, report: Report) -> ErrorPicture:
        """Reduce the errors of the runs to what a screen can show."""
        curves = self.results.error_curves(inputs.runs, cancel)
        marks = self.results.landmarks(inputs.runs[0], inputs.axes, cancel)
        return ErrorPicture(inputs.runs[0].ground.declaration, curves, marks)

    def build(self) -> list[Any]:
        """One figure."""
        return [self.plot(self.view.figure)]

    def draw(self, outcome: ErrorPicture) -> str:
        """Draw the change of ψ, where there is a ψ; and say what there is to know about it."""
        system = outcome.system
        there = bool(system.psi_minus or system.psi_plus)
        self.plots[0].visible = there
        if there:
            self.view.show(outcome.curves, outcome.marks)
        said = conserved_text(outcome.curves) if there else ""
        return f"{said} {conserved_note(system)}".strip()

    def table(self) -> Table | None:
        """Return the first integrator's run at its own steps."""
        return run_table(self.results.run(self.inputs().runs[0])) if self.outcome is not None else None
