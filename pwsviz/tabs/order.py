"""The tabs of the order: of states, and of crossing times."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
import panel as pn
import panel_material_ui as pmui

import core
from pwsviz.export.files import Tables
from pwsviz.export.script import order_program
from pwsviz.figures.order import (
    STATE_ERROR,
    TIME_ERROR,
    OrderView,
    Rows,
    compared_with,
    exact_text,
    order_numbers,
    order_tables,
    state_rows,
    studied,
    time_rows,
)
from pwsviz.figures.summaries import (
    all_fitted,
    all_slopes_text,
    fit_rule,
    numbered_crossings,
    slopes_text,
    study_text,
    study_times,
)
from pwsviz.results.requests import StudyInputs, study_inputs
from pwsviz.results.studies import STUDY_CROSSINGS
from pwsviz.scene.names import met_at_surfaces
from pwsviz.tabs.base import LongTab
from pwsviz.tasks.cancellation import Cancel, Report
from pwsviz.text.tables import Numbers
from pwsviz.text.words import at_surface, listed, perturbation
from pwsviz.widgets.panes import leave_out
from pwsviz.widgets.setting_buttons import choice

FITS = "Broad lines: the fits."
"""What captions say of them."""

EVERY = "all chosen integrators"
"""Label of the box for more than one of them."""

Studies = tuple[core.OrderStudy, ...]
"""One of each integrator."""


class OrderTab(LongTab):
    """An error against the step size, with fitted slopes.

    Parameters
    ----------
    error : (str, str)
        Which error is plotted, in words and in symbols.
    rows : callable
        Returns the curves of this plot from a study.
    """

    def __init__(self, *given: Any, error: tuple[str, str], rows: Rows) -> None:
        super().__init__(*given)
        self.error, self._rows = error, rows
        self.view: OrderView | None = None

    def inputs(self) -> tuple[StudyInputs, ...]:
        """Return the system and one integrator, or each of the chosen ones."""
        return study_inputs(self.scene)

    def compute(self, inputs: tuple[StudyInputs, ...], cancel: Cancel, report: Report) -> Studies:
        """Measure the order; ValueError if it is that of crossing times, and there is no crossing."""
        if self._rows is time_rows and not any(self.results.compared(one, cancel).crossings for one in inputs):
            until = self.results.compared(inputs[0], cancel).until
            raise ValueError(f"There is no crossing up to t = {until:.6g}, so there is no crossing time to study.")
        return self.results.studies(inputs, cancel, report)

    def build(self) -> list[Any]:
        """Make the choices of the integrators, and the plot."""
        self.view, scene = OrderView(*self.error), self.scene
        one = choice(
            scene, "study_method", lambda: {name: name for name in scene.fixed_step}, ("system", "own", "methods")
        )
        every = pmui.Checkbox(label=EVERY, value=scene.order_all, size="small", margin=(6, 0))
        every.param.watch(lambda event: scene.accept("order_all", bool(event.new)), "value")

        def offer(*_: Any) -> None:
            every.param.update(value=scene.order_all, visible=len(scene.fixed_step) > 1)
            one.visible = not scene.order_all

        offer()
        scene.param.watch(offer, ["order_all", "system", "own", "methods"])
        controls = pn.FlexBox(one, every, margin=0, sizing_mode="stretch_width")
        return [controls, self.progress, self.plot(self.view.figure)]

    def draw(self, outcome: Studies) -> str:
        """Draw studies and return their slopes in words."""
        assert self.view is not None  # noqa: S101  (drawn after it was built)
        shown = studied(outcome, self._rows)
        self.view.show(shown)
        errors = [row.error for one in shown for row in one.rows]
        zero = any(np.isfinite(error).any() for error in errors) and not any((error > 0).any() for error in errors)
        leave_out(self.plots[0], zero)  # zeros have no place on its axis
        slopes = "" if shown[0].is_exact else slopes_text(shown)  # of several it is empty
        return " ".join(filter(None, [exact_text(shown, not zero), slopes, *self._left_out(outcome)]))

    def remark(self, outcome: Studies) -> str:
        """Return whether crossing times are perturbed, that runs have ends of their own, and what was not fitted."""
        scene, moved = self.scene, ""
        if scene.locate and scene.perturbation_order is not None:
            moved = (
                f"Crossing times are perturbed by {perturbation(scene.perturbation_order, scene.perturbation_scale)}."
            )
        free = self._end(outcome) * bool(self._times(outcome))
        return " ".join(filter(None, (moved, free, self._made(outcome) * self._is_unusual(outcome))))

    def details(self, outcome: Studies) -> str:
        """Return what is compared, with what and when, and what is fitted, if all could be."""
        made = self._made(outcome) * (not self._is_unusual(outcome))
        return f"{self._times(outcome)} {made}".strip()

    def _made(self, outcome: Studies) -> str:
        return study_text(studied(outcome, self._rows), self._is_early(outcome))

    def _is_unusual(self, outcome: Studies) -> bool:
        """Whether there is a reason to read how the study was made."""
        other = [one for one in studied(outcome, self._rows) if not one.is_exact]
        off = any(row.is_off for one in other for row in one.rows)
        return self._is_early(outcome) or off or not all_fitted(other)

    @staticmethod
    def _is_early(outcome: Studies) -> bool:
        """Whether a trajectory has too few crossings for those that are usually looked at."""
        return any(one.crossings != STUDY_CROSSINGS for one in outcome)

    def _end(self, outcome: Studies) -> str:
        """Return what the end time has to do with the study."""
        if (until := outcome[0].until) is None:
            return "The end time has no effect here."
        return f"The last states are compared at t = {until:.4g}." * (self._rows is state_rows)

    def _times(self, outcome: Studies) -> str:
        return study_times(outcome[0], self._rows is state_rows, self.slid, met_at_surfaces(self.scene.declaration))

    def _left_out(self, outcome: Studies) -> Iterator[str]:
        """Say which integrators are not shown, and why."""
        there, wanted = [one.method for one in outcome], self.scene.order_methods
        missing = [] if self.progress.busy else [name for name in wanted if name not in there]
        if missing:
            yield f"Not shown, as their trajectories have too few crossings: {listed(missing)}."
        chosen = self.scene.selected_method
        if chosen not in there and core.METHODS[chosen].adaptive:
            yield f"{chosen} chooses its own steps and has no order; {listed(there)} is shown in its place."

    def numbers(self, outcome: Studies) -> Sequence[Numbers]:
        """Return the slopes of several integrators."""
        return order_numbers(studied(outcome, self._rows))

    def tables(self) -> Tables:
        """Return the errors over the step sizes, and the fits."""
        return order_tables(studied(self.outcome, self._rows)) if self.outcome is not None else {}

    def heading(self, outcome: Studies) -> str:
        """Return which error converges."""
        return "Convergence of the state" if self._rows is state_rows else "Convergence of the crossing times"

    def meaning(self, outcome: Studies) -> str:
        """Return what the broad lines are, and the slopes that no legend tells, for captions."""
        shown = studied(outcome, self._rows)
        rows = [row for one in shown for row in one.rows if np.isfinite(row.slope)]
        drawn = any(not row.is_off for row in rows)
        return " ".join(filter(None, [FITS * drawn, all_slopes_text(shown) if rows else ""]))

    def key(self, outcome: Studies) -> str:
        """Return what the broad lines are, and when states are compared."""
        when = "“Before”: halfway to the first crossing; “after k”: halfway from crossing k to the next."
        if (until := outcome[0].until) is not None:
            when = f"“Before”: halfway to the crossing; “after 1”: at t = {until:.6g}." * bool(outcome[0].crossings)
        fitted = FITS in self.meaning(outcome)
        return " ".join(filter(None, [when * (self._rows is state_rows), FITS * fitted]))

    def not_saved(self, outcome: Studies) -> str:
        """Return that one integrator is shown of several that might be, and how to have all."""
        if self.scene.order_all or len(self.scene.fixed_step) < 2:
            return ""
        return f"As in the figure, {outcome[0].method} only; there, “{EVERY}” adds the others."

    def how(self, outcome: Studies) -> str:
        """Return the integrators, what they do at crossings, and what they are compared with."""
        first, scene = outcome[0], self.scene
        met = met_at_surfaces(scene.declaration)
        crossings = at_surface(
            met, scene.locate, scene.slides and self.slid, scene.perturbation_order, scene.perturbation_scale
        )
        taus = f"{len(first.taus)} step sizes from {first.taus.min():.3g} to {first.taus.max():.3g}"
        methods = listed([one.method for one in outcome])
        at = f"{'before the first crossing and after' if self._rows is state_rows else 'at'} {{}}"
        at = at.format(numbered_crossings(first.crossings)) if first.crossings else f"at t = {first.until:.6g}"
        taus += f", compared with {compared_with(first.reference)} {at}"
        rule = f"{self._times(outcome)} {fit_rule(studied(outcome, self._rows))}".lstrip()
        return f"integrated by {methods} with {taus}; {crossings}. {rule}"

    def program(self) -> str:
        """Return the lines that repeat the study."""
        return order_program(self.scene, self.inputs())


state_order_tab = partial(OrderTab, error=STATE_ERROR, rows=state_rows)
time_order_tab = partial(OrderTab, error=TIME_ERROR, rows=time_rows)
