"""The tab of an order plot: which integrator, the plot, and the slopes in words."""

from __future__ import annotations

from collections.abc import Callable

import panel as pn
import panel_material_ui as pmui

import core
from pwsviz.panes import fade, plot_pane, text_pane
from pwsviz.scene import Scene
from pwsviz.text import study_text
from pwsviz.views.order import OrderView, Row


class StudyView(pn.viewable.Viewer):
    """One order plot with its controls; nothing of it is made or sent before it is first looked at.

    Parameters
    ----------
    scene : Scene
        Has the choice of the integrator.
    error : str
        Which error is plotted, in words.
    rows : callable
        Picks the curves of this plot from a study.
    """

    def __init__(self, scene: Scene, error: str, rows: Callable[[core.OrderStudy], list[Row]]) -> None:
        super().__init__()
        self.scene = scene
        self.error = error
        self.plot: OrderView | None = None
        self.words = text_pane("")
        self._rows = rows
        self._study: core.OrderStudy | None = None
        self._progress = pmui.LinearProgress(
            variant="indeterminate", visible=False, sizing_mode="stretch_width", margin=0
        )
        self._content = pn.Column(margin=0, sizing_mode="stretch_width")

    @property
    def busy(self) -> bool:
        """Whether a study is on its way; shown as a moving bar."""
        return bool(self._progress.visible)

    @busy.setter
    def busy(self, value: bool) -> None:
        self._progress.visible = value

    def reveal(self) -> None:
        """Make what is in the tab, the first time it is looked at."""
        if self.plot is not None:
            return
        self.plot = OrderView(self.error)
        method = pmui.RadioButtonGroup.from_param(
            self.scene.param.study_method, label="", description="", size="small", margin=(6, 0)
        )
        self._pane = plot_pane(self.plot.figure)
        self._draw()
        self._content.objects = [method, self._progress, self._pane, self.words]

    def show_study(self, study: core.OrderStudy) -> None:
        """Draw a study and say its slopes."""
        self._study = study
        self._draw()

    def _draw(self) -> None:
        study = self._study
        if study is None or self.plot is None:
            return
        rows, order = self._rows(study), core.METHODS[study.method].order
        assert order is not None  # noqa: S101  (a study needs one)
        self.plot.show(study.taus, rows, float(study.floor), order)
        self.words.object = study_text(study, rows)
        fade(self._pane, past=False)

    def show_trouble(self, markup: str) -> None:
        """Say why there is no study; what was drawn last stays, faded."""
        self.words.object = markup
        if self.plot is not None:
            fade(self._pane, past=True)

    def __panel__(self) -> pn.viewable.Viewable:
        """Choice, progress, plot, words; empty before it is revealed."""
        return self._content
