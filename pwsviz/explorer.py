"""The page: controls on the left, the portrait in the middle, one more view beside it."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import panel as pn
import panel_material_ui as pmui
import param
from panel_material_ui.template.base import Page

import core
from pwsviz.inputs import run_inputs, study_inputs
from pwsviz.panes import fade, plot_pane, text_pane
from pwsviz.plane import Window
from pwsviz.projection import conserved_note, portrait_note
from pwsviz.results import ErrorCurve, Pictures, Results
from pwsviz.scene import VIEWS, Scene
from pwsviz.sidebar import Sidebar
from pwsviz.study import StudyView
from pwsviz.text import as_text, complaint, run_lines
from pwsviz.views.conserved import ConservedView
from pwsviz.views.order import state_rows, time_rows
from pwsviz.views.portrait import PortraitView
from pwsviz.worker import Job, Lane

RESULTS = Results()
"""Shared by all sessions of the server: a second visitor finds the first picture ready."""

GRID_CSS = """
:host { display: grid !important; grid-template-columns: repeat(auto-fit, minmax(min(100%, 430px), 1fr)); gap: 8px 20px;
        grid-auto-rows: max-content; align-items: start; height: auto !important; max-height: none !important; }
"""


NARROW = 600
"""Pixels; on a screen less wide the controls would cover the picture, and start hidden."""

PAGE_SX = {
    ".MuiAppBar-root": {
        "backgroundColor": "background.paper", "color": "text.primary", "boxShadow": "none",
        "borderBottom": "1px solid", "borderColor": "divider", "backgroundImage": "none",
    },
    ".MuiAppBar-root .title": {"color": "text.primary", "fontSize": "1.35rem", "letterSpacing": "0.01em"},
    ".MuiToolbar-root": {"minHeight": "48px !important"},
}  # fmt: skip


TABS_SX = {".MuiTab-root": {"textTransform": "none", "minWidth": 0, "paddingX": "12px"}}
"""All three titles fit on a narrow screen."""

STACK_CSS = ":host { height: auto !important; max-height: none !important; } :host > * { flex: none !important; }"


class Screen(pn.custom.JSComponent):
    """Invisible; knows whether the browser's window is narrow."""

    narrow = param.Boolean(default=False)

    _esm = f"export function render({{ model }}) {{ model.narrow = window.innerWidth < {NARROW} }}"


class Explorer(pn.viewable.Viewer):
    """One person's page: follows a scene, and computes what is visible of it off the event loop.

    Parameters
    ----------
    scene : Scene, optional
        The settings to start from.
    results : Results, optional
        Where arrays come from.
    """

    def __init__(self, scene: Scene | None = None, results: Results | None = None) -> None:
        super().__init__()
        self.scene = scene or Scene()
        self.results = results or RESULTS
        self.document = pn.state.curdoc
        self.sidebar = Sidebar(self.scene)
        self.portrait = PortraitView(self._look_at, self._start_at)
        self.portrait_pane, self.portrait_note = plot_pane(self.portrait.figure), text_pane("")
        self.conserved = ConservedView()
        self.conserved_pane, self.conserved_note = plot_pane(self.conserved.figure), text_pane("")
        self.studies = {
            "order": StudyView(self.scene, "state error", state_rows),
            "time": StudyView(self.scene, "crossing time error", time_rows),
        }
        self.status = text_pane("Computing the first trajectory …")
        self.trouble = text_pane("")
        self.progress = pmui.LinearProgress(
            variant="indeterminate", visible=False, sizing_mode="stretch_width", margin=0
        )
        self._runs, self._ground, self._study = Lane(patience=0.1), Lane(patience=0.1), Lane(quiet=0.15)
        self._closed = False
        self._asked: dict[str, object] = {}
        self._visible: Window | None = None
        self._shown: Pictures | None = None
        self.tabs = self._make_tabs()
        self.scene.param.watch(lambda *_: self.refresh(), list(self.scene.param))
        self.refresh()

    def _make_tabs(self) -> Any:
        conserved = pn.Column(self.conserved_pane, self.conserved_note, margin=0, sizing_mode="stretch_width")
        content = {"conserved": conserved} | self.studies
        tabs = pmui.Tabs(
            *((title, content[key]) for key, title in VIEWS.items()),
            dynamic=False, active=list(VIEWS).index(self.scene.view), sizing_mode="stretch_width", margin=0, sx=TABS_SX,
        )  # fmt: skip
        tabs.param.watch(lambda event: self.scene.param.update(view=list(VIEWS)[event.new]), "active")
        return tabs

    def refresh(self) -> None:
        """Ask for whatever the visible views lack."""
        wanted = run_inputs(self.scene), self.scene.view == "conserved"
        if self._ask(self._runs, "runs", wanted, partial(self.results.pictures, *wanted), self._show_runs):
            self._promise(wanted)
        if self.scene.view in self.studies:
            self.studies[self.scene.view].reveal()
            study = study_inputs(self.scene)
            asked = self._ask(self._study, "study", study, partial(self.results.study, study), self._show_study)
            for view in self.studies.values():
                view.busy = view.busy or asked

    def _promise(self, wanted: object) -> None:
        """Show that something is on its way, if it has not come by the time a person begins to wonder."""

        def remind() -> None:
            self.progress.visible = self._runs.busy and self._asked.get("runs") == wanted
            if self.progress.visible and self._shown and self._shown.inputs[0].ground.system != self.scene.system:
                self._await_system()

        if self.document is not None:
            self.document.add_timeout_callback(remind, 300)

    def _await_system(self) -> None:
        """Fade what is shown: it is another system's."""
        name = core.CATALOGUE[self.scene.system].name
        words = f"{name}: preparing its integrators. That takes some seconds the first time."
        self.status.object, self.portrait_note.object, self.conserved_note.object = as_text(words), "", ""
        self._fade(past=True)

    def _fade(self, past: bool) -> None:
        for pane in (self.portrait_pane, self.conserved_pane):
            fade(pane, past)

    def _ask(
        self, lane: Lane, what: str, inputs: object, compute: Callable[..., Any], show: Callable[[Any], None]
    ) -> bool:
        if self._asked.get(what) == inputs:
            return False
        self._asked[what] = inputs
        lane.submit(Job(compute, partial(self._deliver, show)))
        return True

    def _deliver(self, show: Callable[[Any], None], outcome: object) -> None:
        """Hand an outcome from a thread to the event loop of this page."""
        if self.document is None:
            show(outcome)
        elif not self._closed:
            self.document.add_next_tick_callback(partial(self._apply, show, outcome))

    def _apply(self, show: Callable[[Any], None], outcome: object) -> None:
        """Send all changes in one message: the browser then paints each figure once."""
        with pn.io.hold(self.document):
            show(outcome)

    def _show_runs(self, outcome: Pictures | Exception) -> None:
        self.progress.visible = False
        if isinstance(outcome, Exception):
            self.trouble.object = complaint(outcome)
            return
        self.trouble.object = ""
        self._fade(past=False)
        system = core.CATALOGUE[outcome.inputs[0].ground.system]
        before = self.portrait.frame
        frame = self.portrait.show_orbits(system, outcome.orbits)
        if frame != before:
            self._visible = None
        self.portrait_note.object = as_text(portrait_note(system), "about")
        if outcome.errors is not None:
            self._show_errors(system, outcome.errors)
        self.status.object = run_lines(outcome.summaries)
        self._shown = outcome
        self._cover()

    def _show_errors(self, system: core.PiecewiseSystem, errors: list[ErrorCurve]) -> None:
        """Draw the change of ψ, where there is a ψ; and say what there is to know about it."""
        self.conserved.show(errors)
        self.conserved_pane.visible = bool(system.psi_minus or system.psi_plus)
        self.conserved_note.object = as_text(conserved_note(system), "about")

    def _look_at(self, window: Window) -> None:
        self._visible = window
        self._cover()

    def _cover(self) -> None:
        """Ask for a backdrop that suits the visible part of the plane."""
        if self._shown is None or self.portrait.frame is None:
            return
        visible = self._visible or self.portrait.frame
        window = self.portrait.covered
        if window is None or not window.shows_well(visible):
            window = visible.scaled(1.3 if self._visible else 2.0)
        ground = self._shown.inputs[0].ground
        levels = self._shown.orbits[0].levels  # it speaks for all: one that drifts has a new level each turn
        self._ask(
            self._ground,
            "ground",
            (ground.system, ground.values, window, levels),
            lambda _cancel: self.results.backdrop(ground, window, levels),
            self._show_ground,
        )

    def _show_ground(self, outcome: Any) -> None:
        if isinstance(outcome, Exception):
            self.trouble.object = complaint(outcome)
        else:
            self.portrait.show_backdrop(outcome)

    def _show_study(self, outcome: core.OrderStudy | Exception) -> None:
        for view in self.studies.values():
            view.busy = False
            if isinstance(outcome, Exception):
                view.show_trouble(complaint(outcome))
            else:
                view.show_study(outcome)

    def _start_at(self, x: float, y: float) -> None:
        """Start from the point the person clicked, to the digits a screen can tell."""
        view = self._visible or self.portrait.frame
        assert view is not None  # noqa: S101  (a click needs a picture)
        try:
            self.scene.accept("x0", place(x, y, view, self.scene.x0))
        except ValueError as reason:
            self.trouble.object = complaint(reason)

    def settle(self, timeout: float) -> bool:
        """Wait until nothing is left to compute; return whether that came true in time. For use without a server."""
        return all(lane.join(timeout) for lane in (self._runs, self._study, self._ground))

    def close(self) -> None:
        """Give up all work: the person has left."""
        self._closed = True
        for lane in (self._runs, self._ground, self._study):
            lane.cancel()

    def __panel__(self) -> pn.viewable.Viewable:
        """Portrait and tabs side by side, one below the other where the screen is narrow."""
        under = (self.portrait_note, self.trouble, self.status)
        left = pn.Column(
            pn.Column(self.progress, height=4, margin=0, sizing_mode="stretch_width"),
            self.portrait_pane,
            *under,
            margin=0,
            sizing_mode="stretch_width",
        )
        right = pn.Column(self.tabs, margin=0, sizing_mode="stretch_width")
        views = pn.Column(left, right, stylesheets=[GRID_CSS], margin=0, sizing_mode="stretch_width")
        return pn.Column(views, stylesheets=[STACK_CSS], margin=(8, 16), sizing_mode="stretch_width")

    def page(self) -> Any:
        """Return the whole page, which gives up its work when the visitor leaves."""
        pn.state.on_session_destroyed(lambda _context: self.close())
        page = Page(title="pwsviz", sidebar=[self.sidebar], main=[self], sidebar_width=300, sx=PAGE_SX)
        screen = Screen(sizing_mode="fixed", width=0, height=0, margin=0)
        screen.jscallback({"page": page}, narrow="page.data.sidebar_open = !cb_obj.narrow")
        page.main.append(screen)
        return page


def place(x: float, y: float, view: Window, x0: tuple[float, ...]) -> tuple[float, ...]:
    """Return the state at a point of the plane, rounded to about a pixel; further coordinates stay."""
    digits = 3 - math.floor(math.log10(max(view.width, view.height)))
    return (round(x, digits), round(y, digits), *x0[2:])
