"""What the views beside the portrait have in common."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any

import panel as pn
from bokeh.models.annotations import Span
from bokeh.plotting import figure

import core
from pwsviz.export.tables import Table
from pwsviz.figures.portrait import PortraitView
from pwsviz.figures.style import describe
from pwsviz.results.results import Results
from pwsviz.scene.scene import Scene
from pwsviz.tasks.cancellation import Cancel, Report
from pwsviz.text.words import as_text, complaint
from pwsviz.widgets.panes import fade, plot_pane, text_pane
from pwsviz.widgets.progress import Progress

Outcome = Any
"""What a tab computes; each has its own type."""


class Tab(pn.viewable.Viewer):
    """One view beside the portrait; nothing of it is made, computed or sent before it is first looked at.

    Parameters
    ----------
    scene : Scene
        The settings.
    results : Results
        Where arrays come from.

    Attributes
    ----------
    shown : hashable or None
        Inputs of what is drawn; None where it is a part, or of something past.
    settings : tuple of str
        Settings of the scene whose change alters what is drawn, though nothing is computed anew.
    now : Span or None
        The line that the player moves, where time runs across the view.
    quiet, patience : float
        As in `latest_wins.Job`.
    """

    settings: tuple[str, ...] = ()
    now: Span | None = None
    quiet, patience = 0.0, 0.1

    def __init__(self, scene: Scene, results: Results) -> None:
        super().__init__()
        self.scene, self.results = scene, results
        self.words = text_pane("")
        self.outcome: Outcome | None = None
        self._system: core.PiecewiseSystem | None = None
        self.shown: Hashable = None
        self.built = False
        self.plots: list[pn.pane.Bokeh] = []
        self._summaries: list[str] = []
        self._content = pn.Column(margin=0, sizing_mode="stretch_width")

    # For each tab to say ---------------------------------------------------------------------------------------------

    def inputs(self) -> Hashable:
        """Return exactly what the picture depends on."""
        raise NotImplementedError

    def compute(self, inputs: Any, cancel: Cancel, report: Report) -> Outcome:
        """Compute the picture's arrays, off the event loop."""
        raise NotImplementedError

    def build(self) -> list[Any]:
        """Make figures and controls."""
        raise NotImplementedError

    def draw(self, outcome: Outcome) -> str:
        """Show what was computed, whole or in part, and return it in words."""
        raise NotImplementedError

    def table(self) -> Table | None:
        """Return what is shown as columns to export; None while there is nothing."""
        raise NotImplementedError

    def program(self) -> str:
        """Return the lines of Python that repeat the study shown, after those of the runs; none by default."""
        return ""

    def link(self, portrait: PortraitView) -> None:
        """Mark in the portrait what is pointed at here, and here what is pointed at there; nothing by default."""

    # For the page ----------------------------------------------------------------------------------------------------

    def reveal(self) -> None:
        """Make what is in the tab, the first time it is looked at."""
        if not self.built:
            self._content.objects = [*self.build(), self.words]
            self.built = True

    def begin(self) -> None:
        """Say that something is being computed that is not there yet; for tabs that take long."""

    def advance(self, done: int, total: int, partial: Outcome) -> None:
        """Show the part of a study that is there."""
        self.shown = None
        self._say(self.draw(partial))
        self._fade(past=False)

    def present(self, inputs: Hashable, outcome: Outcome | Exception) -> None:
        """Show what was computed for these inputs, or say why it was not; what was drawn last then stays, faded."""
        if isinstance(outcome, Exception):
            self.shown = None
            self.words.object = complaint(outcome)
            self._fade(past=True)
            return
        self.outcome, self.shown = outcome, inputs
        self._say(self.draw(outcome))
        self._fade(past=False)

    def redraw(self) -> None:
        """Show the same outcome in another way."""
        if self.outcome is not None and self.built:
            self._say(self.draw(self.outcome))

    def expect(self, system: core.PiecewiseSystem) -> None:
        """Clear away the words, and fade the figures, of a system that is no longer the one at hand."""
        if self._system not in (None, system):
            self.await_system("")
        self._system = system

    def await_system(self, words: str) -> None:
        """Fade what is shown: it is another system's."""
        self.shown = self.outcome = None
        self.words.object = words
        self._fade(past=True)

    def plot(self, plot: figure) -> pn.pane.Bokeh:
        """Return a pane for one of the tab's figures."""
        pane = plot_pane(plot)
        self.plots.append(pane)
        self._summaries.append(plot.html_attributes["aria-label"])
        return pane

    def _say(self, words: str) -> None:
        """Say what is shown: beside the figure, and to those who cannot see it."""
        self.words.object = as_text(words)
        for pane, summary in zip(self.plots, self._summaries, strict=True):
            describe(pane.object, f"{summary}. {words}")

    def _fade(self, past: bool) -> None:
        for pane in self.plots:
            fade(pane, past)

    def __panel__(self) -> pn.viewable.Viewable:
        """Whatever `build` has made."""
        return self._content


class LongTab(Tab):
    """A view whose computation takes long: with a bar, a button to cancel it, and one to have it done again."""

    quiet, patience = 0.25, 0.0

    def __init__(self, scene: Scene, results: Results) -> None:
        super().__init__(scene, results)
        self.on_cancel: Callable[[], None] = lambda: None
        self.on_again: Callable[[], None] = lambda: None
        self.progress = Progress(lambda: self.on_cancel(), lambda: self.on_again())

    def begin(self) -> None:
        """Show that it is on its way."""
        self.progress.begin()

    def advance(self, done: int, total: int, partial: Outcome) -> None:
        """Show how far it has come, and what there is."""
        self.progress.advance(done, total)
        super().advance(done, total, partial)

    def present(self, inputs: Hashable, outcome: Outcome | Exception) -> None:
        """Show the whole."""
        self.progress.end()
        super().present(inputs, outcome)

    def stop(self) -> None:
        """Say that it was cancelled; what there is stays."""
        self.progress.stop()
