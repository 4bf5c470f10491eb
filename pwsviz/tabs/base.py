"""The base classes of the views beside the portrait."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from functools import cached_property
from typing import Any

import panel as pn
from bokeh.plotting import figure

import core
from pwsviz.export.files import Table, Tables
from pwsviz.figures.portrait import PortraitView
from pwsviz.figures.style import describe, described
from pwsviz.results.requests import run_inputs
from pwsviz.results.results import Results
from pwsviz.scene.names import as_met, met_at_surfaces
from pwsviz.scene.scene import Scene
from pwsviz.tasks.cancellation import Cancel, Report
from pwsviz.text.tables import Numbers, table_markup
from pwsviz.text.words import as_text, complaint
from pwsviz.widgets.fold import Fold
from pwsviz.widgets.panes import FADED, PLAIN, WHOLE_CSS, empty, fade, is_seen, leave_out, plot_pane, text_pane
from pwsviz.widgets.progress import Progress

_WAITING = "Computing …"
"""Words of a view that shows nothing yet: the browser has them before the view is first opened."""

_ABOUT = "About this figure"
"""Line that unfolds how a result was made."""

Outcome = Any
"""What a tab computes; its type differs from tab to tab."""


class Tab(pn.viewable.Viewer):
    """One view beside the portrait; its contents are made and computed when it is first opened.

    Parameters
    ----------
    scene : Scene
        The settings.
    results : Results
        Where arrays come from.

    Attributes
    ----------
    shown : hashable or None
        Inputs of what is drawn; None if that is partial or outdated.
    settings : tuple of str
        Settings of the scene that change what is drawn but not what is computed.
    quiet, patience : float
        Seconds, as in `latest_wins.Job`.
    every_start : bool
        Whether it shows runs from all starts, or from the selected one alone.
    """

    settings: tuple[str, ...] = ()
    quiet = 0.0
    patience = 0.1
    every_start = False

    def __init__(self, scene: Scene, results: Results) -> None:
        super().__init__()
        self.scene, self.results = scene, results
        self.words = text_pane(_WAITING, style=WHOLE_CSS)
        self.outcome: Outcome | None = None
        self._system: core.PiecewiseSystem | None = None
        self._drawn: core.PiecewiseSystem | None = None  # of which the figures show something
        self.shown: Hashable = None
        self.built = False
        self.plots: list[pn.pane.Bokeh] = []
        self._hidden: list[pn.pane.Bokeh] = []  # figures that show nothing, as the computation has failed
        self._summaries: list[str] = []
        self.about: Fold | None = None  # made when there is something to unfold
        self._content = pn.Column(self.words, margin=0, sizing_mode="stretch_width")

    # For each tab to define ------------------------------------------------------------------------------------------

    def inputs(self) -> Hashable:
        """Return exactly what the result depends on."""
        raise NotImplementedError

    def compute(self, inputs: Any, cancel: Cancel, report: Report) -> Outcome:
        """Compute the arrays that are drawn; runs in a thread."""
        raise NotImplementedError

    def further_inputs(self) -> Hashable | None:
        """Return what is still to be computed for a whole result that is drawn; None if there is nothing."""
        return None

    def compute_further(self, inputs: Any, cancel: Cancel, report: Report) -> Outcome:
        """Compute that; runs in a thread."""
        raise NotImplementedError

    def add_further(self, outcome: Outcome) -> None:
        """Draw that, too."""

    def build(self) -> list[Any]:
        """Make figures and controls."""
        raise NotImplementedError

    def draw(self, outcome: Outcome) -> str:
        """Draw a whole or a partial result, and return it in words."""
        raise NotImplementedError

    def remark(self, outcome: Outcome) -> str:
        """Return what is unusual, or what to know of the axes, for a paler paragraph; none by default."""
        return ""

    def details(self, outcome: Outcome) -> str:
        """Return in words how a result was made and what its terms mean, to be unfolded; none by default."""
        return ""

    def warnings(self, outcome: Outcome) -> Sequence[str]:
        """Return what is said against the step size of the runs; nothing by default."""
        return ()

    def numbers(self, outcome: Outcome) -> Sequence[Numbers]:
        """Return the figures of a whole or partial result as tables, shown below the plot; none by default."""
        return ()

    def table(self) -> Table | None:
        """Return what is drawn as columns to export; None while there is nothing."""
        return None

    def tables(self) -> Tables:
        """Return what is drawn as tables to export; by default the one of `table`."""
        table = self.table()
        return {} if table is None else {"": lambda: table}

    def how(self, outcome: Outcome) -> str:
        """Return how a study was made, for files and captions; empty if it shows the runs of the scene."""
        return ""

    @property
    def slid(self) -> bool:
        """Whether one of the runs from the selected start slides."""
        return any(bool(self.results.run(one).sliding.any()) for one in run_inputs(self.scene))

    def heading(self, outcome: Outcome) -> str:
        """Return what the figures show, to be followed by “of the system” in captions; empty if that is the title."""
        return ""

    def free(self) -> str:
        """Return the parameter, or the variable at the start, that has many values in the figures; empty if none."""
        return ""

    def meaning(self, outcome: Outcome) -> str:
        """Return what the axes and lines of the figures mean, for captions; empty if their names say it."""
        return ""

    def key(self, outcome: Outcome) -> str:
        """Return what of that a short caption cannot do without; nothing by default."""
        return ""

    def not_saved(self, outcome: Outcome) -> str:
        """Return what the export says of files that have less than may be expected; nothing by default."""
        return ""

    def pictures(self) -> list[figure]:
        """Return the figures on screen that are saved as one picture; the first by default, if it is there."""
        return [pane.object for pane in self.plots[:1] if pane.visible]

    def program(self) -> str:
        """Return the lines of Python that repeat the study, to follow those of the runs; none by default."""
        return ""

    def link(self, portrait: PortraitView) -> None:
        """Let the figures follow the player and mark crossings under the pointer, when made; nothing by default."""

    def as_met(self, words: str) -> str:
        """Return words on crossings, which are jumps where the runs of the scene meet nothing else."""
        return as_met(words, met_at_surfaces(self.scene.declaration))

    # For the page ----------------------------------------------------------------------------------------------------

    def reveal(self, portrait: PortraitView) -> None:
        """Make the contents of the tab, the first time it is opened, and link them to the portrait."""
        if not self.built:
            parts = [*self.build(), self.words]
            self.link(portrait)
            self._content.objects = parts
            self.built = True

    said = ""
    """What was said last of a result, in sentences."""

    def begin(self) -> None:
        """Show that a computation is running; for tabs that take long."""

    def advance(self, done: int, total: int, partial: Outcome) -> None:
        """Draw a partial result."""
        self.shown = None
        self._show(partial)
        self._fade(past=False)

    def present(self, inputs: Hashable, outcome: Outcome | Exception) -> None:
        """Draw the result for these inputs; or say why there is none, and fade what was drawn last."""
        if isinstance(outcome, Exception):
            self.shown = None
            self._say(complaint(outcome))
            self._fade(past=True)
            if self._drawn is not self._system:  # nothing will take the place of what they show of another system
                for pane in self.plots:
                    empty(pane)
            self._hide([pane for pane in self.plots if not is_seen(pane)])
            return
        self.outcome, self.shown = outcome, inputs
        self._show(outcome)
        self._fade(past=False)

    def which_start(self) -> str:
        """Return the start of which runs are told, before what is told of them; empty if there is but one."""
        count = len(self.scene.starts)
        return f"Start {self.scene.selected + 1} of {count}: " if count > 1 else ""

    def redraw(self) -> None:
        """Draw the same result again, after a change of `settings`."""
        if self.outcome is not None and self.built:
            self._show(self.outcome)

    def expect(self, system: core.PiecewiseSystem) -> None:
        """Clear the words and fade the figures if they belong to another system."""
        if self._system not in (None, system):
            self.await_system("")
        self._system = system

    def announce(self) -> None:
        """Say that the view is being computed, if it says nothing yet."""
        if self.outcome is None and not self.words.object:
            self._say(as_text(_WAITING))

    def await_first(self, words: str) -> None:
        """Show these words if the view shows nothing yet."""
        if self._waits():
            self._say(words)

    def await_system(self, words: str) -> None:
        """Fade the figures, which belong to another system, and show these words."""
        self.shown = self.outcome = None
        self._say(words)
        self._fade(past=True)

    def plot(self, plot: figure) -> pn.pane.Bokeh:
        """Return a pane for one of the tab's figures."""
        pane = plot_pane(plot)
        self.plots.append(pane)
        self._summaries.append(described(plot))
        return pane

    def _show(self, outcome: Outcome) -> None:
        """Draw a result, show it in figures and words below the plot, and give the words to screen readers."""
        self._drawn = self._system
        self._hide([])
        self.said = words = self.draw(outcome)
        remark, details = self.remark(outcome), self.details(outcome)
        tables, warnings = "".join(map(table_markup, self.numbers(outcome))), self.warnings(outcome)
        warned = "".join(as_text(one, "stopped") for one in warnings)
        self._say(tables + as_text(words) + warned + as_text(remark, "about"), as_text(details))
        self._describe(" ".join(filter(None, (words, *warnings, remark, details))))

    def _describe(self, words: str) -> None:
        """Give screen readers the summary of each figure, and the words below it."""
        for pane, summary in zip(self.plots, self._summaries, strict=True):
            describe(pane.object, f"{summary}. {words}")

    def _hide(self, empty_ones: Sequence[pn.pane.Bokeh]) -> None:
        """Let empty figures take no room, so that the reason stands where the figure would; and others again."""
        for pane in self._hidden:
            leave_out(pane, False)
        self._hidden = [pane for pane in empty_ones if pane.visible]
        for pane in self._hidden:
            leave_out(pane)

    def _waits(self) -> bool:
        return bool(self.words.object == as_text(_WAITING))

    def _say(self, markup: str, details: str = "") -> None:
        """Show words below the plot, and what is to be unfolded there."""
        self.words.param.update(object=markup, styles=PLAIN)
        if details and self.about is None:
            self.about = Fold(title=_ABOUT, markup=details, margin=0, sizing_mode="stretch_width")
            self._content.append(self.about)
        elif self.about is not None:
            self.about.param.update(markup=details, styles=PLAIN)

    def _fade(self, past: bool) -> None:
        for pane in self.plots:
            fade(pane, past)

    def __panel__(self) -> pn.viewable.Viewable:
        """Return what `build` has made."""
        return self._content


class LongTab(Tab):
    """A view whose computation takes long: with a progress bar, and buttons to cancel it and to run it again."""

    quiet = 0.25
    patience = 0.0

    def __init__(self, scene: Scene, results: Results) -> None:
        super().__init__(scene, results)
        self.on_cancel: Callable[[], None] = lambda: None
        self.on_again: Callable[[], None] = lambda: None

    @cached_property
    def progress(self) -> Progress:
        """The bar and the buttons; made with the rest of the tab."""
        return Progress(lambda: self.on_cancel(), lambda: self.on_again())

    def begin(self) -> None:
        """Show the progress bar, and fade figures and words: what they show is not what was asked for."""
        self.progress.begin(former=any(map(is_seen, self.plots)))
        if not self._waits():
            for pane in filter(None, (self.words, self.about)):
                pane.styles = FADED
        self._fade(past=True)

    def advance(self, done: int, total: int, partial: Outcome) -> None:
        """Show the progress and the partial result."""
        self.progress.advance(done, total)
        super().advance(done, total, partial)

    def present(self, inputs: Hashable, outcome: Outcome | Exception) -> None:
        """Hide the progress bar and draw the whole result."""
        self.progress.end()
        super().present(inputs, outcome)

    def stop(self) -> None:
        """Show that the computation was cancelled; the partial result stays."""
        self.progress.stop()
        if self._waits():
            self._say("")


def counted(scene: Scene) -> str:
    """Say what else counts as a crossing where sequences of crossings are compared; empty if nothing does."""
    return "Jumps count as crossings." if met_at_surfaces(scene.declaration) == "crossings and jumps" else ""


def about_crossings(scene: Scene, locates: bool = False) -> str:
    """Say what a view does at crossings if that is unusual, or other than in the portrait.

    Parameters
    ----------
    locates
        Whether it locates crossings even where the runs of the portrait do not.
    """
    words = ""
    if not scene.locate and locates:
        words = "Crossings are located here, although the runs of the portrait step over the surface."
    elif not scene.locate:
        words = "The integrators step over the surface: crossings are not located."
    elif scene.perturbation_order is not None:
        words = "Crossing times are not perturbed here, although those of the portrait are."
    return as_met(words, met_at_surfaces(scene.declaration))
