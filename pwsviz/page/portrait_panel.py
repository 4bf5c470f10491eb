"""The portrait with its player, its notes and the figures of its runs."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import partial
from time import monotonic
from typing import Any

import panel as pn

import core
from core.interface import being_compiled
from pwsviz.figures.portrait import PortraitView
from pwsviz.figures.portrait_text import (
    SUMMARY,
    figures_of,
    law_markup,
    parted_words,
    perturbed_words,
    portrait_note,
    scale_note,
    which_start,
)
from pwsviz.figures.style import describe
from pwsviz.figures.summaries import run_lines, run_warnings, run_words
from pwsviz.geometry.phase_plane import Backdrop
from pwsviz.geometry.plane import Plane
from pwsviz.geometry.projection import PLANE
from pwsviz.geometry.window import Window
from pwsviz.page.player import Player
from pwsviz.page.sight import Sight
from pwsviz.page.starts_by_hand import StartsByHand
from pwsviz.results.orbits import Levels
from pwsviz.results.requests import InitialValueProblem, RunInputs, run_inputs
from pwsviz.results.results import Pictures, PortraitInputs, Results
from pwsviz.scene.checks import Start
from pwsviz.scene.scene import Scene
from pwsviz.tasks.cancellation import Cancel
from pwsviz.tasks.scheduler import Scheduler
from pwsviz.text.advice import without_advice
from pwsviz.text.words import as_text, complaint, failure
from pwsviz.widgets.disclosure import Disclosure
from pwsviz.widgets.panes import fade, plot_pane, text_pane
from pwsviz.widgets.progress import bar_pane
from pwsviz.widgets.widths import NARROW

REST = 1.5
"""Seconds without a change of a run until it is examined whether its steps are too long."""

REMIND = 300
"""Milliseconds of computing after which a progress bar appears."""

ROOM = 1.6
"""Half the width of the plane shown before the first trajectory, relative to the largest coordinate of a start."""

BESIDE = 0.01
"""Seconds of quiet before field and surface are computed: any at all, so that they do not take turns with what waits
for compilation."""

FIRST_WAIT = "Compiling {}, once on this machine: {} s so far."
"""What is said while the first trajectory waits for compilation."""

LONGEST_WAIT = "It takes half a minute where nothing else is at work."
"""What is added of what is not of one integrator: the loop that serves all of them."""

LONG_WAIT = 1000
"""Milliseconds until that is said, and between two words on it."""

DEFECT = "The portrait could not be drawn, by a defect of this page ({!r}). Undo, or change a setting."
"""What is said where it is not that of the present scene, and no other will come."""

WARNS = 'class="stopped"'
"""Part of the markup of words about runs that says of one that it may not be trusted; it stays by the portrait."""

DOUBTS = re.compile("stops? early|warning")
"""What of the words on other starts is no less than a warning."""

FEW = 3
"""Most runs whose figures stay there, too."""

NARROW_CSS = f"""
@media (width < {NARROW}px) {{ :host {{ display: contents !important; }} .aside {{ order: 2; }} }}
"""
NARROW_RUN_CSS = f"@media (width < {NARROW}px) {{ .run {{ font-size: 0.75rem; }} }}"
ASIDE = ["aside"]
"""On a narrow screen notes of this class come after the view below the portrait: its tabs are then in sight, too."""


class PortraitPanel(pn.viewable.Viewer):
    """The phase portrait of a scene, always visible.

    Parameters
    ----------
    scene, results, scheduler
        The settings, the source of arrays, and what runs the computations.
    on_wait : callable
        Called with a text while the integrators of the first, or of another, system are compiled.
    on_show : callable
        Called when other trajectories have been drawn.
    on_end : callable
        Called with words about the runs when these have ended, or could not be computed.
    on_hold : callable
        Called with whether a start is being dragged.
    """

    def __init__(
        self,
        scene: Scene,
        results: Results,
        scheduler: Scheduler,
        on_wait: Callable[[str], None],
        on_show: Callable[[], None],
        on_end: Callable[[str], None],
        on_hold: Callable[[bool], None],
    ) -> None:
        super().__init__()
        self.scene, self.results, self.scheduler = scene, results, scheduler
        self._on_wait, self._on_show, self._on_end, self._on_hold = on_wait, on_show, on_end, on_hold
        self.starts = StartsByHand(scene, self._place, self._refuse)
        self.portrait = PortraitView(
            on_window=lambda seen: self.sight.look_at(seen),
            on_place=self.starts.place,
            on_move=self._drag,
            on_drop=lambda: on_hold(False),
            on_remove=self.starts.remove,
            on_select=self.starts.select,
            on_zoom=lambda seen: self.sight.keep(seen),
            on_fit=lambda: self.sight.fit(),
            on_double_click=self._fit_instead,
        )
        self.pane, self.note = plot_pane(self.portrait.figure), text_pane("")
        self.sight = Sight(scene, self.portrait, self._cover)
        self.player = Player(self.portrait)
        self.readout = pn.pane.Bokeh(
            self.portrait.ground.readout, margin=(0, 4), align="center", sizing_mode="stretch_width"
        )
        self.player.param.watch(lambda *_: self._submit_frames(), "open")
        self.status = text_pane("Computing the first trajectory …")
        self.note.css_classes = self.status.css_classes = ASIDE
        self.status.stylesheets = [*self.status.stylesheets, NARROW_RUN_CSS]
        self.trouble = text_pane("")
        self.progress = bar_pane("the phase portrait", margin=0)
        self.shown: Pictures | None = None
        self._begun = monotonic()
        self._warnings: tuple[Any, tuple[str, ...]] = (None, ())  # runs, and what is said against their steps

    def refresh(self) -> None:
        """Submit the computation of the portrait of the present scene."""
        wanted = PortraitInputs.of(self.scene)
        window = self.sight.covering() if self.sight.keeps(wanted) else None
        if self.scheduler.submit(
            "runs", wanted, lambda cancel, _: self._compute(wanted, window, cancel), self._show, patience=0.1
        ):
            if self.shown is not None and self.shown.inputs.declaration != wanted.declaration:
                fade(self.pane, past=True)  # it stays that of another system until the new one is computed
            self.scheduler.call_later(REMIND, self._remind, partial(self.scheduler.busy, "runs", wanted))
        elif self.shown is not None and self.shown.inputs == wanted:
            self._mark_starts()

    def _compute(self, wanted: PortraitInputs, window: Window | None, cancel: Cancel) -> Pictures:
        """Return the curves, after computing what lies under them on a window, so that both are painted together."""
        pictures = self.results.pictures(wanted, cancel)
        if window is not None:
            self.results.backdrop(*_ground_of(pictures, window))
        return pictures

    def _remind(self) -> None:
        """Show a progress bar: the portrait has not come yet."""
        self.progress.visible = self.scheduler.busy("runs")
        if self.progress.visible and self.shown is None:
            self._submit_ground()
            self.scheduler.call_later(LONG_WAIT, self._explain_wait, lambda: self.shown is None)
        if self.progress.visible and self.shown and self.shown.inputs.declaration != self.scene.declaration:
            name = self.scene.declaration.name
            words = f"{name}: compiling its integrators, which takes a few seconds the first time."
            self.status.object, self.note.object = as_text(words), ""
            describe(self.portrait.figure, f"{SUMMARY} of another system, as long as this one is not ready. {words}")
            self._on_wait(words)

    def _submit_ground(self) -> None:
        """Submit the field and the surface about the starts, which need no compilation: the first trajectory does."""
        scene, system, starts = self.scene, self.scene.declaration, self.scene.starts
        if system.dimension != PLANE:  # the plane in which it is looked at follows from a trajectory
            return
        window = Window(*scene.window) if scene.window is not None else around(starts)
        problem = run_inputs(scene)[0].problem

        def show(outcome: Backdrop | Exception) -> None:
            wanted = self.shown is None and scene.declaration == system
            if wanted and not isinstance(outcome, Exception):  # of an exception the trajectories tell
                self.portrait.show_ground(system, outcome, window, starts)
                fade(self.pane, past=False)

        self.scheduler.submit(
            "ground", problem, lambda *_: self.results.backdrop(problem, window.surroundings(), ()), show, quiet=BESIDE
        )

    def _explain_wait(self) -> None:
        """Say what is being compiled while the first trajectory waits for it."""
        if self.shown is not None:
            return
        if what := being_compiled():
            own = what in core.METHODS
            name = f"{what} for {self.scene.declaration.name}" if own else what
            words = FIRST_WAIT.format(name, round(monotonic() - self._begun))
            self.status.object = as_text(words if own else f"{words} {LONGEST_WAIT}")
            self._on_wait("This view comes with the first trajectory, whose integrators are being compiled.")
        self.scheduler.call_later(LONG_WAIT, self._explain_wait, lambda: self.shown is None)

    def _show(self, outcome: Pictures | Exception) -> None:
        self.progress.visible = False
        if isinstance(outcome, Exception):
            self.trouble.object = complaint(outcome)
            self._on_end(failure(outcome))
            return
        if outcome.inputs.declaration != self.scene.declaration:  # another system has been chosen since
            return
        try:
            self._draw(outcome)
        except Exception as defect:  # of this page: what stands there may be of two systems
            fade(self.pane, past=True)
            self.status.object, self.trouble.object = "", as_text(DEFECT.format(defect), "error")
            raise

    def _draw(self, outcome: Pictures) -> None:
        self.trouble.object = ""
        fade(self.pane, past=False)
        system, axes = outcome.inputs.declaration, outcome.plane.axes
        self.shown = outcome
        self._mark_starts()
        self.sight.show(outcome)
        scaled, left_out = scale_note(system, outcome.plane), portrait_note(system, axes)
        self.note.object = as_text(scaled, "about") + law_markup(system) + as_text(left_out, "about")
        self._tell(outcome)
        self._cover()
        self._submit_frames()
        self._on_show()
        self._on_end(f"{which_start(outcome)} {run_words(outcome.summaries)}".strip())
        runs = (*outcome.inputs.selected, *outcome.inputs.others)
        self.scheduler.submit(
            "warnings",
            runs,
            lambda cancel, _: self.results.warnings(runs, cancel),
            partial(self._show_warnings, runs),
            quiet=REST,
        )

    def _show_warnings(self, runs: tuple[RunInputs, ...], outcome: Any) -> None:
        if isinstance(outcome, Exception):
            self.trouble.object = complaint(outcome)
            return
        self._warnings = runs, outcome
        if self.shown is not None:
            self._tell(self.shown)

    def _tell(self, shown: Pictures) -> None:
        """Write the warnings, if these are known, below the portrait, where they are in sight, and then the figures."""
        warnings = self._warnings_of(shown)
        words = "".join(
            [
                run_warnings(shown.summaries, warnings),
                as_text(parted_words(shown), "stopped"),
                as_text(figures := figures_of(shown, warnings), "stopped" if DOUBTS.search(figures) else "which"),
                as_text(perturbed_words(shown.inputs.selected[0])),
                run_lines(shown.summaries, warnings),
            ]
        )
        beside = WARNS in words or len(shown.summaries) <= FEW
        self.status.param.update(object=words, css_classes=[] if beside else ASIDE)

    def _warnings_of(self, shown: Pictures) -> tuple[str, ...]:
        """What is said against the steps of the runs shown; () as long as that is not known."""
        (runs, found), inputs = self._warnings, shown.inputs
        return found if runs == (*inputs.selected, *inputs.others) else ()

    @property
    def warned(self) -> str:
        """What is said against the steps of the runs from the selected start, in sentences, as far as it is known."""
        if self.shown is None:
            return ""
        pairs = zip(self.shown.summaries, self._warnings_of(self.shown), strict=False)
        return " ".join(f"{one.method}: {without_advice(words)}" for one, words in pairs if words)

    def _mark_starts(self) -> None:
        """Draw the present curves, with the starts of the scene."""
        assert self.shown is not None  # noqa: S101  (called only after the first portrait)
        starts = list(map(self.shown.plane.place, self.scene.starts))
        self.portrait.show_orbits(self.shown.inputs.declaration, self.shown, starts, self.scene.selected)

    def _submit_frames(self) -> None:
        """Submit the computation of the frames of the player, while it is open; once closed it has none."""
        if not self.player.wanted:
            self.scheduler.forget("frames")
        elif self.shown is not None:
            shown = self.shown.inputs
            inputs = (*shown.selected, *shown.others), self.shown.plane
            self.scheduler.submit(
                "frames",
                inputs,
                lambda cancel, _: self.results.frames(*inputs, cancel),
                partial(self._show_frames, shown),
                patience=0.1,
            )

    def _show_frames(self, shown: PortraitInputs, outcome: Any) -> None:
        if isinstance(outcome, Exception):
            self.trouble.object = complaint(outcome)
        else:
            several = shown.start_count > 1 or len(shown.selected) > 1
            start = f"start {shown.index + 1}, " if shown.start_count > 1 else ""
            whose = f" ({start}{shown.selected[0].scheme.method})" if several else ""
            self.player.show(outcome, len(shown.selected), whose)

    def _cover(self) -> None:
        """Show a backdrop for the visible part of the plane if it has been computed, or submit its computation."""
        window = self.sight.covering()
        if self.shown is None or window is None:
            return
        wanted = _ground_of(self.shown, window)
        if there := self.results.found_backdrop(*wanted):
            self.scheduler.forget("backdrop")
            self._show_backdrop(there)
        else:
            self.scheduler.submit(
                "backdrop",
                wanted,
                lambda _cancel, _report: self.results.backdrop(*wanted),
                self._show_backdrop,
                patience=0.1,
            )

    def _show_backdrop(self, outcome: Any) -> None:
        if isinstance(outcome, Exception):
            self.trouble.object = complaint(outcome)
        else:
            self.sight.covered = outcome.window
            self.portrait.show_backdrop(outcome)

    # What the user does in the portrait ------------------------------------------------------------------------------

    def _place(self) -> tuple[Window, Plane]:
        """Return what is visible, and the variables that span it with their units."""
        assert self.sight.visible is not None  # noqa: S101  (a click needs a picture)
        return self.sight.visible, self.sight.plane

    def _refuse(self, reason: ValueError) -> None:
        """Say why nothing can start there, and put back a star that was dropped there."""
        self.trouble.object = complaint(reason)
        if self.shown is not None:
            self._mark_starts()

    def _fit_instead(self) -> None:
        """Take back what the first click of two has placed, and show the trajectories there were."""
        if self.starts.take_back():
            self.trouble.object = ""
        self.sight.fit()

    def _drag(self, index: int, x: float, y: float) -> None:
        self._on_hold(True)
        self.starts.move(index, x, y)

    def __panel__(self) -> pn.viewable.Viewable:
        """Return portrait, player and notes in a column."""
        limits = self.sight.limits
        row = pn.Row(
            self.player.button, limits.button, self.readout, Disclosure(limits.button, limits.box),
            margin=0, sizing_mode="stretch_width",
        )  # fmt: skip
        return pn.Column(
            pn.Column(self.progress, height=4, margin=0, sizing_mode="stretch_width"),
            self.pane, row, self.player, limits, self.trouble, self.status, self.note,
            margin=0, sizing_mode="stretch_width", stylesheets=[NARROW_CSS],
        )  # fmt: skip


def around(starts: Sequence[Start]) -> Window:
    """Return a square about the origin with room for all starts of a system of two variables."""
    half = ROOM * max((abs(x) for start in starts for x in start), default=0.0) or 1.0
    return Window(-half, half, -half, half)


def _ground_of(shown: Pictures, window: Window) -> tuple[InitialValueProblem, Window, Levels, Plane]:
    """Return the arguments of `Results.backdrop` for these curves."""
    levels = shown.orbits[0].levels  # of one integrator only: one that drifts has a new level each turn
    met = {mode for orbit in shown.others for mode, _ in orbit.levels} - dict(levels).keys()
    return shown.inputs.selected[0].problem, window, (*levels, *((mode, ()) for mode in sorted(met))), shown.plane
