"""The tab of run time against error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import panel as pn

import core
from pwsviz.export.files import Table
from pwsviz.export.script import cost_program
from pwsviz.figures.cost import (
    MEANING,
    CostView,
    compared_with,
    cost_details,
    cost_numbers,
    cost_rows,
    cost_text,
    timed_how,
)
from pwsviz.figures.cost_text import lies_below, missing_text, settings_text, shows_round_off
from pwsviz.results.requests import CostInputs
from pwsviz.scene.names import COST_ACROSS, COST_UP, EXTERNAL_SOLVERS, LABELS, counted_as, met_at_surfaces
from pwsviz.tabs.base import LongTab, about_crossings, counted
from pwsviz.tasks.cancellation import Cancel, Report
from pwsviz.text.tables import Numbers
from pwsviz.text.words import at_surface, listed
from pwsviz.widgets.choices import SEEN_NAME, Choices
from pwsviz.widgets.setting_buttons import choice

ROUND_OFF = {
    "state": "The round-off line is at 2⁻⁴⁸ times the size of the state, or at the error of the reference if larger.",
    "time": "The round-off line is at 2⁻⁴⁸ times the end time, or at the error of the reference if larger.",
    "invariant": "The round-off line is at 2⁻⁴⁸ times the size of the terms of ψ.",
}
"""What the line of each error is, for captions."""


class CostTab(LongTab):
    """What an error costs, by integrator."""

    settings = ("cost_across", "cost_up")

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.view: CostView | None = None

    def inputs(self) -> CostInputs:
        """Return all integrators and the chosen external solvers."""
        return CostInputs.of(self.scene)

    def compute(self, inputs: CostInputs, cancel: Cancel, report: Report) -> core.WorkPrecision:
        """Measure run times and errors."""
        return self.results.cost(inputs, cancel, report)

    def build(self) -> list[Any]:
        """Make the choices of the axes and of the external solvers, and the plot."""
        self.view = CostView()
        across = choice(self.scene, "cost_across", lambda: {words: key for key, words in COST_ACROSS.items()})
        up = choice(self.scene, "cost_up", self._errors, ("system", "own"))
        peers = Choices(
            label=LABELS["peers"], options=list(EXTERNAL_SOLVERS.values()), value=self._peers(), margin=(4, 0),
            stylesheets=[SEEN_NAME],
        )  # fmt: skip
        chosen = {words: key for key, words in EXTERNAL_SOLVERS.items()}
        peers.param.watch(lambda event: self.scene.accept("peers", [chosen[words] for words in event.new]), "value")
        self.scene.param.watch(lambda _: peers.param.update(value=self._peers()), "peers")
        controls = pn.FlexBox(across, up, peers, margin=0, sizing_mode="stretch_width")
        return [controls, self.progress, self.plot(self.view.figure)]

    def _errors(self) -> dict[str, str]:
        return {self.as_met(words): key for key, words in COST_UP.items()}

    def _peers(self) -> list[str]:
        return [EXTERNAL_SOLVERS[key] for key in self.scene.peers]

    def draw(self, outcome: core.WorkPrecision) -> str:
        """Draw the curves and return in words what they are."""
        assert self.view is not None  # noqa: S101  (drawn after it was built)
        across, up = self.scene.cost_across, self.scene.cost_up
        outcome = self._counted(outcome)
        self.view.show(outcome, across, up, met_at_surfaces(self.scene.declaration))
        return self.as_met(cost_text(outcome, across, up))

    def _counted(self, outcome: core.WorkPrecision) -> core.WorkPrecision:
        """Return the study with what the solution meets counted as the page does."""
        return replace(outcome, met=counted_as(outcome.met, met_at_surfaces(self.scene.declaration)))

    def remark(self, outcome: core.WorkPrecision) -> str:
        """Return what counts as a crossing, and what runs do at crossings, if that is unusual."""
        return f"{counted(self.scene)} {self._about_crossings(outcome)}".strip()

    def details(self, outcome: core.WorkPrecision) -> str:
        """Return what is measured and how."""
        return self.as_met(cost_details(self._counted(outcome), self.scene.cost_across, self.scene.cost_up))

    def _about_crossings(self, outcome: core.WorkPrecision) -> str:
        """Say what integrators and external solvers do at crossings, if that is unusual."""
        stops = not self.scene.locate and any(curve.peer for curve in outcome.curves)
        return about_crossings(self.scene) + (" External solvers stop on it all the same." if stops else "")

    def numbers(self, outcome: core.WorkPrecision) -> Sequence[Numbers]:
        """Return the cheapest integrators."""
        return [cost_numbers(outcome, self.scene.cost_across, self.scene.cost_up).worded(self.as_met)]

    def how(self, outcome: core.WorkPrecision) -> str:
        """Return what the runs do at crossings, what they are compared with, and how they are timed."""
        scene = self.scene
        slides = scene.slides and outcome.met.slides > 0
        met = met_at_surfaces(scene.declaration)
        crossings = at_surface(met, scene.locate, slides) if any(outcome.met) else ""
        integrators = listed([curve.title for curve in outcome.curves])
        by = f"integrated by {integrators} {compared_with(self._counted(outcome))}"
        peers = [curve.title for curve in outcome.curves if curve.peer]
        verbs = ("locates", "restarts") if len(peers) == 1 else ("locate", "restart")
        crossings += f"; {listed(peers)} {verbs[0]} {met} as events and {verbs[1]} at each" * bool(peers and crossings)
        runs = "; ".join(filter(None, [by, f"{settings_text(outcome)}{missing_text(outcome)}", crossings]))
        return self.as_met(f"{runs}. {timed_how(outcome)}")

    def heading(self, outcome: core.WorkPrecision) -> str:
        """Return what diagram it is."""
        return "Work–precision diagram"

    def meaning(self, outcome: core.WorkPrecision) -> str:
        """Return what the errors, the line and open symbols are, for captions."""
        wrong = any((~curve.correct_sequence & np.isfinite(curve.seconds)).any() for curve in outcome.curves)
        hollow = " Open symbols: runs whose sequence of crossings differs from that of the reference." * wrong
        hollow += f" {counted(self.scene)}".rstrip() * bool(hollow)
        below = " Downward triangles: errors of 0, or below the plotted range." * lies_below(
            outcome, self.scene.cost_up
        )
        level = f" {ROUND_OFF[self.scene.cost_up]}" * shows_round_off(outcome, self.scene.cost_up)
        return self.as_met(f"{MEANING[self.scene.cost_up]}{level}{below}{hollow}")

    def table(self) -> Table | None:
        """Return a row for each integrator and setting."""
        return cost_rows(self.outcome) if self.outcome is not None else None

    def program(self) -> str:
        """Return the lines that repeat the study."""
        return cost_program(self.scene, self.inputs())
