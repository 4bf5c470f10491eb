"""The page: controls on the left, the portrait in the middle, another view beside it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from functools import cached_property, partial
from typing import Any

import panel as pn
import panel_material_ui as pmui

import core
from pwsviz.editor.form import SystemEditor
from pwsviz.figures.linking import link_portrait
from pwsviz.page.cover import Cover
from pwsviz.page.export_dialog import ExportDialog, Piece
from pwsviz.page.frame import THE_PAGE, make_frame
from pwsviz.page.header import footer, header
from pwsviz.page.headline import Headline
from pwsviz.page.help import Help
from pwsviz.page.look import GRID_CSS, STACK_CSS, tabs_sx
from pwsviz.page.pieces import pieces_of
from pwsviz.page.portrait_panel import NARROW_CSS, PortraitPanel
from pwsviz.page.shown_example import ShownExample
from pwsviz.page.sidebar import Sidebar
from pwsviz.results.requests import run_inputs
from pwsviz.results.results import Results
from pwsviz.scene.examples import example_of
from pwsviz.scene.history import History
from pwsviz.scene.names import named_settings
from pwsviz.scene.permalink import adopt, query
from pwsviz.scene.presets import FIRST_LOOK, PRESETS, Preset
from pwsviz.scene.scene import Scene
from pwsviz.scene.views import VIEWS
from pwsviz.tabs import LongTab, Tab, make_tab
from pwsviz.tasks.cancellation import Cancel
from pwsviz.tasks.scheduler import Scheduler
from pwsviz.text.numbers import printed
from pwsviz.text.words import as_text, failure
from pwsviz.widgets.announcer import Announcer
from pwsviz.widgets.browser import CRAMPED, REMEMBER_DARK, Browser
from pwsviz.widgets.dialog import dialog
from pwsviz.widgets.lecture import Lecture
from pwsviz.widgets.panes import text_pane

RESULTS = Results()
"""Shared by all sessions of the process, so that a second visitor finds the first picture computed."""

COVER = Cover(RESULTS)
"""Seen on every page until it is built."""

FIRST = 0.15
"""Seconds that a page waits for its first pictures: most often they are there already, or need some milliseconds."""

ADDRESS_RESTS = 1100
"""Milliseconds without a change of the scene after which the address bar is updated: not at each move of a slider."""

WINDOW_RESTS = 300
"""The same where nothing but the window of the portrait has changed: a pan or zoom costs the server little else."""

LOOKS = {"view", "window"}
"""Settings that say how a scene is looked at: a complaint about its link stays when they change."""

SOON = 200
"""Milliseconds after which a study is shown to be running; a cached one is delivered before."""

AHEAD = 0.05
"""Seconds after a successful check of a user's own system until it is compiled, in case the user applies it."""


class Explorer(pn.viewable.Viewer):
    """The page of one session: follows a scene, and computes what is visible of it off the event loop.

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
        self.notice = text_pane("")
        opened: Preset | None = None
        if scene is None and pn.state.location is not None:
            opened = self._begin(pn.state.location.search)  # before anything is computed
        self.example = ShownExample(self.scene, opened)
        self.scheduler, self.history = Scheduler(), History(self.scene)
        self.headline = Headline(self.scene, self.example)
        self.announcer = Announcer(sizing_mode="fixed", width=0, height=0, margin=0)
        self.views = {key: make_tab(key, self.scene, self.results) for key in VIEWS}
        self.portrait_panel = PortraitPanel(
            self.scene, self.results, self.scheduler, self._await_system, self._refresh_export,
            self._end_portrait, self.history.hold,
        )  # fmt: skip
        link_portrait(self.portrait_panel.portrait)
        self.editor: SystemEditor | None = None  # two dozen widgets that few visitors need
        self._controls = pn.Column(margin=0, sizing_mode="stretch_width")
        self._views = pn.Column(margin=0, sizing_mode="stretch_width")
        self.browser = Browser(sizing_mode="fixed", width=0, height=0, margin=0)
        self.lecture = Lecture(sizing_mode="fixed", width=0, height=0, margin=0)
        self._look = ""  # what an example shows, to be told with its results
        self._changes = 0
        self._changed_settings: set[str] = set()
        self._with_pictures: list[Callable[[], None]] = []
        self.tabs = self._make_tabs()
        for tab in self.views.values():
            if isinstance(tab, LongTab):
                tab.on_cancel, tab.on_again = self._cancel, partial(self.scheduler.call_soon, self._again)
        player = self.portrait_panel.player
        self.scene.param.watch(lambda *_: player.param.update(open=False), ["system", "own"])
        player.param.watch(lambda event: self.lecture.param.update(plays=event.new), "open")
        self.lecture.param.watch(lambda event: player.param.update(open=event.new), "plays")
        self.scene.param.watch(self._follow, [name for name in self.scene.param if name != "name"])
        self.portrait_panel.refresh()

    def _take_preset(self, preset: Preset) -> None:
        self.portrait_panel.player.open = False
        self._look = preset.look

    def _make_tabs(self) -> Any:
        tabs = pmui.Tabs(
            *((view.title, self.views[key]) for key, view in VIEWS.items()),
            dynamic=False, active=list(VIEWS).index(self.scene.view), sizing_mode="stretch_width", margin=0,
            sx=tabs_sx([view.subject for view in VIEWS.values()]),
        )  # fmt: skip
        tabs.param.watch(lambda event: self.scene.param.update(view=list(VIEWS)[event.new]), "active")
        self.scene.param.watch(lambda event: tabs.param.update(active=list(VIEWS).index(event.new)), "view")
        return tabs

    @cached_property
    def sidebar(self) -> Sidebar:
        """The controls."""
        sidebar = Sidebar(self.scene, self.edit, self._call_with_pictures, self._take_preset, self.example)
        sidebar.presets.jscallback(value=f"if (cb_obj.value != '' && {CRAMPED}) {THE_PAGE}.sidebar_open = false")
        return sidebar

    @cached_property
    def editing(self) -> Any:
        """The dialog that holds the editor."""
        return dialog("A system of your own")

    @cached_property
    def export(self) -> ExportDialog:
        """The dialog behind “Export & share”."""
        return ExportDialog(self.scene, self._pieces, lambda: self.view.program())

    @cached_property
    def help(self) -> Help:
        """The dialog behind “?”."""
        return Help(self.lecture.turn)

    @property
    def view(self) -> Tab:
        """The view beside the portrait."""
        return self.views[self.scene.view]

    def _follow(self, *events: Any) -> None:
        waiting, changed = bool(self._changed_settings), {event.name for event in events}
        self._changed_settings |= changed
        if changed - LOOKS:  # the scene is no longer that of the link
            self.notice.object = ""
        if not waiting:
            self.scheduler.call_soon(self._catch_up)

    def _catch_up(self) -> None:
        """Bring the page up to date with the scene."""
        changed, self._changed_settings = self._changed_settings, set()
        self.refresh()
        if changed & set(self.view.settings):
            self.view.redraw()
        callbacks, self._with_pictures = self._with_pictures, []
        for callback in callbacks:
            self.scheduler.call_together(callback)
        self._changes += 1
        changes = self._changes
        rests = WINDOW_RESTS if changed == {"window"} else ADDRESS_RESTS
        self.scheduler.call_later(rests, self._write_address, lambda: changes == self._changes)

    def _call_with_pictures(self, callback: Callable[[], None]) -> None:
        """Call back when the pictures of the last change come, or soon if they do not: one message tells all."""
        if not self._changed_settings:  # they have been submitted
            self.scheduler.call_together(callback)
        elif callback not in self._with_pictures:
            self._with_pictures.append(callback)

    def refresh(self) -> None:
        """Submit the computations that the visible views need and do not show yet."""
        self.portrait_panel.refresh()
        self._refresh_view()

    def _refresh_view(self) -> None:
        view = self.view
        view.reveal(self.portrait_panel.portrait)
        wanted = view.inputs()
        if wanted == view.shown:
            self.scheduler.cancel("view")
            self.scheduler.forget("view")
            self._add_further(view)
            return
        self.scheduler.cancel("further")
        system = self.scene.declaration
        show, advance = partial(self._show, view, system, wanted), partial(self._advance, view, system, wanted)
        view.expect(system)
        view.announce()
        submitted = self.scheduler.submit(
            "view", (self.scene.view, wanted), partial(view.compute, wanted), show, advance, view.quiet, view.patience
        )
        if submitted:
            self._stop_others(view)
            if isinstance(view, LongTab):
                under_way = partial(self.scheduler.busy, "view", (self.scene.view, wanted))
                self.scheduler.call_later(SOON, partial(self._begin_study, view), under_way)

    def _begin_study(self, view: LongTab) -> None:
        """Show that a computation takes its time, and tell screen readers: they may have kept the words of the last."""
        view.begin()
        self._tell("computing.")

    def _stop_others(self, view: Tab) -> None:
        for other in self.views.values():
            if other is not view and other.built and isinstance(other, LongTab):
                other.progress.end()

    def _is_overtaken(self, view: Tab, system: core.PiecewiseSystem, wanted: Any) -> bool:
        """Whether these inputs are no longer those of the scene, such that it lacks what would be drawn of them.

        Under a dragged slider a view that takes no time shows one result after the other, each a little late. A study
        may be of integrators that are not chosen any more.
        """
        if view.inputs() == wanted:
            return False
        return isinstance(view, LongTab) or bool(self._changed_settings) or system != self.scene.declaration

    def _advance(self, view: Tab, system: core.PiecewiseSystem, wanted: Any, done: int, total: int, part: Any) -> None:
        if view is self.view and not self._is_overtaken(view, system, wanted):
            view.advance(done, total, part)

    def _show(self, view: Tab, system: core.PiecewiseSystem, wanted: Any, outcome: Any) -> None:
        if self._is_overtaken(view, system, wanted):
            if self._changed_settings:  # they may be wanted again by the time these are looked at
                self.scheduler.forget("view")
            return
        view.present(wanted, outcome)
        if isinstance(outcome, Exception):
            self._tell(failure(outcome))
        elif isinstance(view, LongTab):
            first = view.said.partition(". ")[0].rstrip(".")
            self._tell(printed(f"finished.{f' {first}.' * bool(first)}"))
        self._refresh_export()
        self._add_further(view)

    def _add_further(self, view: Tab) -> None:
        """Submit what a view computes once its result is drawn."""
        wanted = view.further_inputs()
        if wanted is None:
            self.scheduler.cancel("further")
            self.scheduler.forget("further")
            return

        def show(outcome: Any) -> None:
            if view is self.view and view.further_inputs() == wanted and not isinstance(outcome, Exception):
                view.add_further(outcome)

        self.scheduler.submit("further", wanted, partial(view.compute_further, wanted), show, quiet=view.quiet)

    def _end_portrait(self, words: str) -> None:
        """Tell the browser that what has been chosen is shown, and screen readers how the runs ended."""
        self.browser.choosing = False
        self.announcer.tell_of_portrait(f"{self._look} {words}".strip())
        self._look = ""

    def _tell(self, words: str) -> None:
        """Tell screen readers how the computation of the view has ended."""
        self.announcer.tell_of_view(f"{VIEWS[self.scene.view].title}: {words}")

    def _undo(self) -> None:
        if changed := self.history.undo():
            self.announcer.tell_of_page(f"Undone: {named_settings(changed)}.")

    def _redo(self) -> None:
        if changed := self.history.redo():
            self.announcer.tell_of_page(f"Redone: {named_settings(changed)}.")

    def _refresh_export(self) -> None:
        if "export" in vars(self):  # made with the rest of the page
            self.export.refresh()

    def _cancel(self) -> None:
        """Cancel the running study; its partial result stays on screen."""
        if self.scheduler.cancel("view") and isinstance(self.view, LongTab):
            self.view.stop()
            self._tell("cancelled.")

    def _again(self) -> None:
        """Run the study again."""
        self.scheduler.forget("view")
        self.refresh()

    def _await_system(self, words: str) -> None:
        if self.portrait_panel.shown is None:
            self.view.await_first(as_text(words))
        else:
            self.view.await_system(as_text(words))

    # Own system, link, export ----------------------------------------------------------------------------------------

    def edit(self) -> None:
        """Open the editor with the system on the page, or with what was typed there before."""
        core.compile_beside()
        if self.editor is None:
            self.editor = SystemEditor(self._use, current=self.scene.build, on_ready=self._prepare)
            self.editing.objects = [self.editor]
        self.editor.resume()
        self.editing.open = True

    def _prepare(self, system: core.PiecewiseSystem) -> None:
        """Compute the first runs of a typed system in advance: compiling takes some seconds."""
        ahead = Scene()
        ahead.restore(self.scene.settings())
        try:
            ahead.use(system)
        except ValueError:  # reported when the user applies the system
            return
        runs = run_inputs(ahead)

        def compute(cancel: Cancel, _: Any) -> None:
            for one in runs:
                self.results.run(one, cancel)

        self.scheduler.submit("ahead", runs, compute, lambda _: None, quiet=AHEAD)

    def _use(self, system: core.PiecewiseSystem) -> None:
        self.scene.use(system)
        self.editing.open = False

    def _begin(self, search: str) -> Preset | None:
        """Show the scene of a link, or without one the first example; return the example that it is."""
        if search not in ("", "?"):
            self.adopt(search)
            return example_of(self.scene)
        self.scene.load(PRESETS[FIRST_LOOK].settings)
        return PRESETS[FIRST_LOOK]

    def adopt(self, search: str) -> None:
        """Set the scene to what a link describes, and show the complaints about the link."""
        complaints = adopt(self.scene, search.removeprefix("?")) if search not in ("", "?") else []
        self.notice.object = "".join(as_text(words, "error") for words in complaints)

    def _give_lecture(self, begun: bool) -> None:
        self.headline.give_lecture(begun)
        self.lecture.told = begun
        self.portrait_panel.sight.limits.close()

    def _write_address(self) -> None:
        """Update the address bar; a scene too large for a link empties it."""
        self._name_page()
        try:
            self.browser.query = query(self.scene)
        except ValueError:  # the export dialog says why there is no link
            self.browser.query = ""

    def _name_page(self) -> None:
        """Name the page, as a list of windows shows it."""
        self.browser.title = f"{self.scene.declaration.name}: {VIEWS[self.scene.view].title} – pwsviz"

    def _pieces(self) -> list[Piece]:
        """Return what can be exported now."""
        return pieces_of(self.scene, self.results, self.portrait_panel, self.view)

    def settle(self, timeout: float) -> bool:
        """Wait at most `timeout` seconds; return whether all computations are done. For use without a server."""
        return self.scheduler.settle(timeout)

    def close(self) -> None:
        """Cancel all computations: the session has ended."""
        self.scheduler.close()
        if self.editor is not None:
            self.editor.close()

    def __panel__(self) -> pn.viewable.Viewable:
        """Portrait and tabs side by side, one below the other where the screen is narrow."""
        left = pn.Column(
            self.portrait_panel, css_classes=["portrait"], margin=0, sizing_mode="stretch_width",
            stylesheets=[NARROW_CSS],
        )  # fmt: skip
        both = pn.Column(left, self._views, stylesheets=[GRID_CSS], margin=0, sizing_mode="stretch_width")
        return pn.Column(
            self.notice, self.headline.greeting, both, footer(),
            stylesheets=[STACK_CSS], margin=(8, 16), sizing_mode="stretch_width",
        )  # fmt: skip

    def page(self) -> Any:
        """Return the page, whose computations are cancelled when the session ends."""
        pn.state.on_session_destroyed(lambda _context: self.close())
        self._refresh_view()
        if self.notice.object:  # the address still says what was refused
            self._write_address()
        self.scheduler.draw_first(FIRST)
        self._name_page()
        page = make_frame("pwsviz", self._header(), [self._controls], [self], COVER)
        self.browser.jscallback(narrow=f"{THE_PAGE}.sidebar_open = !cb_obj.narrow")
        self.browser.jscallback(dark=f"if (cb_obj.dark) {THE_PAGE}.dark_theme = true")
        page.jscallback(dark_theme=REMEMBER_DARK)
        keys = {
            "undo": self._undo,
            "redo": self._redo,
            "help": lambda: self.help.open(self.lecture.large),
        }
        self.browser.on_msg(lambda event: keys[event.data]())
        self.lecture.jscallback(large=f"{THE_PAGE}.sidebar_open = !cb_obj.large && !{CRAMPED}")
        self.lecture.param.watch(lambda event: self._give_lecture(event.new), "large")
        page.main.extend([self.browser, self.lecture, self.announcer])
        pn.state.onload(self._furnish)
        return page

    def _furnish(self) -> None:
        """Add what can wait until the portrait is on screen: controls, tabs, and dialogs that open at a click."""
        document = pn.state.curdoc
        with document.models.freeze() if document is not None else nullcontext():  # else it looks for them twice
            self._controls.objects = [self.sidebar]
            self._views.objects = [self.tabs, self.editing, self.export, self.help]

    def _header(self) -> list[Any]:
        return header(
            self.history,
            self.headline.tagline,
            undo=self._undo,
            redo=self._redo,
            export=lambda: self.export.open(self._page_address()),
            lecture=self.lecture.turn,
            ask=lambda: self.help.open(self.lecture.large),
        )

    @staticmethod
    def _page_address() -> str:
        location = pn.state.location
        return (location.href or "").partition("?")[0] if location is not None else ""
