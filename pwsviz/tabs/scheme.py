"""The tab of the equations, the scheme derived from them, and the constants of the theory for a run."""

from __future__ import annotations

from typing import Any

import core
from pwsviz.figures.scheme import SCHEME_STYLE, scheme_markup
from pwsviz.results.requests import RunInputs, run_inputs
from pwsviz.tabs.base import Tab
from pwsviz.tasks.cancellation import Cancel, Report
from pwsviz.widgets.panes import markup_pane
from pwsviz.widgets.setting_buttons import choice


class SchemeTab(Tab):
    """One integrator's scheme for the system."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.mathematics = markup_pane(SCHEME_STYLE)

    def inputs(self) -> RunInputs:
        """Return the run of the selected integrator."""
        return next(one for one in run_inputs(self.scene) if one.scheme.method == self.scene.selected_method)

    def compute(self, inputs: RunInputs, cancel: Cancel, report: Report) -> str:
        """Derive and typeset the scheme, and evaluate the constants along the run."""
        if not self.results.has_run(inputs):  # compilation may take long, and no formula waits for it
            report(0, 1, _markup(inputs, None, None))
        return _markup(inputs, self.results.diagnosis(inputs, cancel), self.results.run(inputs, cancel))

    def build(self) -> list[Any]:
        """Make the choice of the integrator, and the pane of the mathematics."""
        methods = choice(
            self.scene, "study_method", lambda: {name: name for name in self.scene.used}, ("system", "own", "methods")
        )
        return [methods, self.mathematics]

    def draw(self, outcome: str) -> str:
        """Show the mathematics, which needs no further words."""
        self.mathematics.object = outcome
        return ""

    def await_system(self, words: str) -> None:
        """Clear the pane, which belongs to another system, and show these words."""
        super().await_system(words)
        self.mathematics.object = ""

    def present(self, inputs: Any, outcome: Any) -> None:
        """Show the mathematics, or clear it and say why there is none: that of another scheme would mislead."""
        if isinstance(outcome, Exception):
            self.mathematics.object = ""
        super().present(inputs, outcome)


def _markup(inputs: RunInputs, diagnosis: core.Diagnosis | None, run: core.Trajectory | None) -> str:
    scheme = inputs.scheme
    return scheme_markup(
        inputs.problem.build(), scheme.method, diagnosis, run, locate=scheme.locate,
        perturbation_order=scheme.perturbation_order, perturbation_scale=scheme.perturbation_scale,
    )  # fmt: skip
