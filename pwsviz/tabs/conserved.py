"""The tab of the conserved quantity."""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

import core
from pwsviz.export.files import Tables
from pwsviz.export.tables import DrawnRun, conserved_tables
from pwsviz.figures.conserved import ConservedView
from pwsviz.figures.conserved_text import conserved_text, excluded, largest_of_each, meaning
from pwsviz.figures.linking import link_crossings
from pwsviz.figures.portrait import PortraitView
from pwsviz.geometry.projection import conserved_note, has_bare
from pwsviz.results.animation import Landmarks
from pwsviz.results.error_curve import ErrorCurve
from pwsviz.results.requests import ErrorInputs, run_inputs
from pwsviz.scene.names import met_at_surfaces
from pwsviz.tabs.base import Tab
from pwsviz.tasks.cancellation import Cancel, Report
from pwsviz.widgets.panes import leave_out


class ErrorPicture(NamedTuple):
    """What the plot shows."""

    system: core.PiecewiseSystem
    curves: list[ErrorCurve]
    marks: Landmarks
    unmoved: str = ""
    """Why no step was made, where none was."""


DEFINED = "|Δψ| is the change of ψ since the start{apart}. It does not show errors in time along the orbit (of phase)."
"""What the axis shows, in a line; captions say more."""


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
        plane = self.results.plane(system, inputs.axes, cancel)
        marks = self.results.landmarks(inputs.runs[0], plane, cancel)
        moved = any(curve.t_end > curve.t[0] for curve in curves)
        return ErrorPicture(
            system, curves, marks, "" if moved else self.results.summary(inputs.runs[0], cancel).message
        )

    def build(self) -> list[Any]:
        """One figure."""
        return [self.plot(self.view.figure)]

    def draw(self, outcome: ErrorPicture) -> str:
        """Draw the change of ψ, if any ψ is known, and return it in words."""
        system = outcome.system
        drawn = system.laws.most_conserved > 0
        slides = any(np.isfinite(curve.error[curve.sliding]).any() for curve in outcome.curves)
        there = not outcome.unmoved and (drawn or slides)
        leave_out(self.plots[0], not there)
        if there:
            self.view.show(outcome.curves, outcome.marks)
        said = f"{self.which_start()}{conserved_text(outcome.curves)}" if there else ""
        if outcome.unmoved:
            said = f"No step was made, so there is no |Δψ| to show. The run ended at once, at {outcome.unmoved}"
        elif slides and not drawn:
            return f"{said} Shown is |Δg| while sliding, as no conserved quantity is known.".strip()
        note = "Crossings are not located: a step may lead across the surface." * (there and not self.scene.locate)
        return " ".join(filter(None, [said, note, conserved_note(system)]))

    def remark(self, outcome: ErrorPicture) -> str:
        """Return what the axis shows."""
        there = outcome.system.laws.most_conserved > 0 and not outcome.unmoved
        crosses = any(len(curve.crossings) for curve in outcome.curves)
        met = met_at_surfaces(outcome.system) * crosses
        return DEFINED.format(apart=excluded(outcome.curves, met, has_bare(outcome.system))) * there

    def heading(self, outcome: ErrorPicture) -> str:
        """Return whether the figure shows the error of ψ, or that of g while sliding."""
        known = outcome.system.laws.most_conserved
        largest = "Largest error" if known > 1 else "Error"
        quantities = "quantities" if known > 1 else "quantity"
        return f"{largest} |Δψ| of the conserved {quantities}" if known else "Error of g along the sliding motion"

    def meaning(self, outcome: ErrorPicture) -> str:
        """Return how large the error becomes, and what the axis and the lines show, for captions."""
        system = outcome.system
        note = conserved_note(system) * (system.laws.most_conserved > 0)
        shown = meaning(outcome.curves, met_at_surfaces(system), has_bare(system), self.view.draws_round_off)
        return " ".join(filter(None, [self.key(outcome), shown, note]))

    def key(self, outcome: ErrorPicture) -> str:
        """Return how large the error becomes."""
        return largest_of_each(outcome.curves)

    def tables(self) -> Tables:
        """Return the drift of every integrator at its own steps, and its crossings."""
        inputs, start = self.shown, self.scene.selected + 1
        if not isinstance(inputs, ErrorInputs):
            return {}
        return conserved_tables(lambda: [DrawnRun(start, self.results.run(one)) for one in inputs.runs])
