"""The tab of stability: which step sizes and starts work, long runs, and runs near grazing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import panel as pn
from bokeh.plotting import figure

import core
from pwsviz.export.files import Tables
from pwsviz.export.script import stability_program
from pwsviz.figures.stability import StabilityView, stability_numbers, stability_tables, stability_text
from pwsviz.figures.stability_map import Shown
from pwsviz.figures.stability_text import has_limit, map_text, runs_drawn
from pwsviz.geometry.section_crossings import may_slide
from pwsviz.results.requests import StabilityInputs
from pwsviz.scene.names import STABILITY_PARTS, STABILITY_SHOWN, met_at_surfaces
from pwsviz.tabs.base import LongTab, about_crossings, counted
from pwsviz.tasks.cancellation import Cancel, Report
from pwsviz.text.math_names import variable_name
from pwsviz.text.tables import Numbers
from pwsviz.text.words import at_surface, complaint
from pwsviz.widgets.setting_buttons import choice

HEADINGS = {
    "map": "Outcomes of runs",
    "drift": "Error of ψ in long runs",
    "grazing": "Error of ψ and missed crossings near grazing",
}
"""What a caption says of each part, to be followed by “of the system”."""

MEANINGS = {
    "map": "A step size is successful if the run has the crossings of the reference{} ends as it does{}. The largest "
    "successful τ is the largest step size tried that is successful together with every smaller one tried.",
    "drift": "|Δψ| is the change of ψ since the start; drawn is the largest in each part of the time.",
    "grazing": "|Δψ| is the change of ψ since the start.",
}
"""Of what is drawn in each part, for captions."""

CONSERVES = (
    " and, for a conservative integrator, |Δψ| is at most 10⁻¹⁰ times the size of the terms of ψ (nothing is asked of "
    "the |Δψ| of others)"
)
"""What a successful run of some integrators does besides, where ψ is known."""


KEY = "Largest successful τ: up to it, each step size tried gives the crossings and the end of the reference{}."
CONSERVED = ", with |Δψ| at most 10⁻¹⁰ times the size of the terms of ψ"
"""The same in short, for a picture of the map."""


class StabilityTab(LongTab):
    """The map of outcomes, the drift in long runs, and runs that almost touch the surface."""

    settings = ("stability_shown", "study_method", "tau", "starts", "selected")

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.view: StabilityView | None = None

    def inputs(self) -> StabilityInputs:
        """Return all integrators and one part of the study."""
        return StabilityInputs.of(self.scene)

    def compute(self, inputs: StabilityInputs, cancel: Cancel, report: Report) -> core.StabilityStudy:
        """Compute one part of the study."""
        return self.results.stability(inputs, cancel, report)

    def build(self) -> list[Any]:
        """Make the choices, and the plot of the chosen part."""
        scene = self.scene
        self.view = StabilityView(self._go)
        self._part = choice(scene, "stability_part", lambda: {words: key for key, words in STABILITY_PARTS.items()})
        self._method = choice(scene, "study_method", lambda: {n: n for n in scene.used}, ("system", "own", "methods"))
        self._shown = choice(scene, "stability_shown", lambda: {words: key for key, words in STABILITY_SHOWN.items()})
        self._coordinate = choice(
            scene,
            "stability_coordinate",
            lambda: {variable_name(v): k for k, v in enumerate(scene.declaration.variables)},
            ("system", "own"),
        )
        self._place = pn.Column(margin=0, sizing_mode="stretch_width")
        controls = pn.FlexBox(
            self._part, self._coordinate, self._shown, self._method, margin=0, sizing_mode="stretch_width"
        )
        self._offer()
        return [controls, self.progress, self._place]

    def _offer(self) -> None:
        """Show the controls that affect this part, and its figure."""
        part = self.scene.stability_part
        self._method.visible = part == "map"
        self._shown.visible = part == "map" and self._knows_psi
        self._coordinate.visible = part != "drift"
        assert self.view is not None  # noqa: S101  (made before)
        plot = self.view.figure(part)
        pane = next((pane for pane in self.plots if pane.object is plot), None) or self.plot(plot)
        if self._place.objects != [pane]:
            self._place.objects = [pane]

    @property
    def _knows_psi(self) -> bool:
        """Whether a conserved quantity is known, so that there is a |Δψ| to colour a map by."""
        return self.scene.declaration.laws.most_conserved > 0

    def draw(self, outcome: core.StabilityStudy) -> str:
        """Draw the chosen part and return it in words; those of the map are details of its tables."""
        assert self.view is not None  # noqa: S101  (drawn after it was built)
        self._offer()
        scene = self.scene
        coloured: Shown = scene.stability_shown if self._knows_psi else "outcome"
        met = met_at_surfaces(scene.declaration)
        self.view.show(outcome, scene.stability_part, scene.selected_method, coloured, met)
        self.view.mark(scene.tau, scene.x0[outcome.coordinate])
        part = scene.stability_part
        return self.as_met(map_text(outcome) if part == "map" else stability_text(outcome, part))

    def remark(self, outcome: core.StabilityStudy) -> str:
        """Return what counts as a crossing, and what runs do at crossings, if that is unusual."""
        also = counted(self.scene) * (self.scene.stability_part != "drift")
        return f"{also} {about_crossings(self.scene)}".strip()

    def details(self, outcome: core.StabilityStudy) -> str:
        """Return in words what the map is made of."""
        return self.as_met(stability_text(outcome, "map")) if self.scene.stability_part == "map" else ""

    def numbers(self, outcome: core.StabilityStudy) -> Sequence[Numbers]:
        """Return the figures of the part shown."""
        tables = stability_numbers(outcome, self.scene.stability_part, self.scene.selected_method)
        return [one.worded(self.as_met) for one in tables]

    def _go(self, tau: float, value: float) -> None:
        """Take the step size and the start on which the user clicked, rounded to what a screen resolves."""
        try:
            self.scene.choose_on_map(float(f"{tau:.3g}"), float(f"{value:.4g}"))
        except ValueError as reason:
            self.redraw()  # without the last complaint
            self.words.object = f"{complaint(reason)}{self.words.object}"

    def tables(self) -> Tables:
        """Return the tables of the part shown."""
        return stability_tables(self.outcome, self.scene.stability_part) if self.outcome is not None else {}

    def heading(self, outcome: core.StabilityStudy) -> str:
        """Return what the part shown is about."""
        return self.as_met(HEADINGS[self.scene.stability_part])

    def free(self) -> str:
        """Return the coordinate that is another one in each run of a map, or beside a tangency."""
        scene = self.scene
        return "" if scene.stability_part == "drift" else scene.declaration.variables[scene.stability_coordinate]

    def meaning(self, outcome: core.StabilityStudy) -> str:
        """Return which runs are successful, for captions of the map, which names the largest, or what the error is."""
        part = self.scene.stability_part
        known = self._knows_psi and any(core.METHODS[name].conservative for name in outcome.methods)
        if part == "map" and not has_limit(outcome, self.scene.selected_method):
            return counted(self.scene)
        words = self.as_met(MEANINGS[part].format(*((",", CONSERVES) if known else (" and", ""))))
        return f"{words} {counted(self.scene)}".rstrip() if part == "map" else words

    def key(self, outcome: core.StabilityStudy) -> str:
        """Return which runs are successful, where the map names the largest."""
        if self.scene.stability_part != "map":
            return ""
        method = self.scene.selected_method
        conserves = self._knows_psi and core.METHODS[method].conservative
        key = self.as_met(KEY.format(CONSERVED * conserves)) * has_limit(outcome, method)
        return f"{key} {counted(self.scene)}".strip()

    def how(self, outcome: core.StabilityStudy) -> str:
        """Return which runs are drawn of the part shown, and how they were integrated."""
        system, part = self.scene.declaration, self.scene.stability_part
        crossings = at_surface(met_at_surfaces(system), self.scene.locate, self.scene.slides and may_slide(system))
        which = self.as_met(runs_drawn(outcome, part, self.scene.selected_method))
        words = self.as_met(stability_text(outcome, part, caption=True)) * (part != "drift")
        return f"{which}; {crossings}. {words}".rstrip(". ")

    def pictures(self) -> list[figure]:
        """Return the figure of the part shown, if it shows anything."""
        plot = self.view.figure(self.scene.stability_part) if self.view is not None else None
        return [plot] if plot is not None and self.tables() else []

    def program(self) -> str:
        """Return the lines that repeat the study."""
        drawn = self.outcome.map if self.outcome is not None and self.shown == self.inputs() else None
        return stability_program(self.scene, self.inputs(), drawn)
