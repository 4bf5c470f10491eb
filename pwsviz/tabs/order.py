"""The tabs of the order: of states, and of crossing times."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import core
from pwsviz.export.files import Tables
from pwsviz.export.script import order_program
from pwsviz.figures.order import STATE_ERROR, TIME_ERROR, OrderView, Row, order_tables, state_rows, time_rows
from pwsviz.figures.summaries import study_text
from pwsviz.results.requests import StudyInputs, study_inputs
from pwsviz.tabs.base import LongTab
from pwsviz.tasks.cancellation import Cancel, Report
from pwsviz.widgets.setting_buttons import choice


class OrderTab(LongTab):
    """An error against the step size, with fitted slopes.

    Parameters
    ----------
    error : (str, str)
        Which error is plotted, in words and in symbols.
    rows : callable
        Returns the curves of this plot from a study.
    """

    def __init__(self, *given: Any, error: tuple[str, str], rows: Callable[[core.OrderStudy], list[Row]]) -> None:
        super().__init__(*given)
        self.error, self._rows = error, rows
        self.view: OrderView | None = None

    def inputs(self) -> StudyInputs:
        """Return the system and one integrator."""
        return study_inputs(self.scene)

    def compute(self, inputs: StudyInputs, cancel: Cancel, report: Report) -> core.OrderStudy:
        """Measure the order."""
        return self.results.study(inputs, cancel, report)

    def build(self) -> list[Any]:
        """Make the choice of the integrator, and the plot."""
        self.view = OrderView(*self.error)
        methods = choice(
            self.scene, "study_method", lambda: {name: name for name in self.scene.fixed_step}, ("system", "methods")
        )
        return [methods, self.progress, self.plot(self.view.figure)]

    def draw(self, outcome: core.OrderStudy) -> str:
        """Draw a study and return its slopes in words."""
        assert self.view is not None  # noqa: S101  (drawn after it was built)
        rows, order = self._rows(outcome), core.METHODS[outcome.method].order
        assert order is not None  # noqa: S101  (a study needs one)
        self.view.show(outcome.taus, rows, float(outcome.floor), order)
        words = study_text(outcome, rows)
        chosen = self.scene.selected_method
        if chosen != outcome.method and core.METHODS[chosen].adaptive:
            words += f" {chosen} chooses its own steps and has no order; {outcome.method} is shown in its place."
        return words

    def tables(self) -> Tables:
        """Return the errors over the step sizes, and the fits."""
        return order_tables(self.outcome, self._rows(self.outcome)) if self.outcome is not None else {}

    def how(self, outcome: core.OrderStudy) -> str:
        """Return the integrator and what it is compared with."""
        taus = f"{len(outcome.taus)} step sizes from {outcome.taus.min():.2g} to {outcome.taus.max():.3g}"
        return f"integrated by {outcome.method} with {taus}; compared with: {outcome.reference}"

    def program(self) -> str:
        """Return the lines that repeat the study."""
        return order_program(self.scene, self.inputs())


state_order_tab = partial(OrderTab, error=STATE_ERROR, rows=state_rows)
time_order_tab = partial(OrderTab, error=TIME_ERROR, rows=time_rows)
