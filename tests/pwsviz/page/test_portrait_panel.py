"""The portrait of a page: its curves, what lies under them, its window, and the words below it."""

import re
from threading import Event
from time import monotonic, sleep

import numpy as np
import pytest

import core
from core.interface import compiling
from pwsviz.geometry.projection import shows_field, shows_surface
from pwsviz.geometry.window import Window
from pwsviz.page.explorer import Explorer
from pwsviz.results.results import Results
from pwsviz.scene.permalink import query, read
from pwsviz.scene.scene import Scene
from pwsviz.tasks.scheduler import Scheduler
from pwsviz.widgets.panes import FADED, PLAIN
from tests.levels import deep_but

QUICK = ("elliptic_curve", "rigid_body", "gene_switch", "bouncing_ball", "two_walls")


def counts(explorer):
    return dict(explorer.results.computed)


def test_a_link_shows_the_level_sets_and_arrows_that_its_reader_saw_before(explorer):
    panel = explorer.portrait_panel
    for window in (Window(-3.0, 1.0, -2.0, 2.0), Window(-2.6, 1.4, -1.8, 2.2), Window(-1.9, 2.1, -1.7, 2.3)):
        panel.sight.look_at(window)  # as the browser tells of a pan, and then of its end
        panel.sight.keep(window)
        explorer.settle(60)
    opened = Explorer(Scene(), Results())
    opened.scene.restore(read(query(explorer.scene))[0])
    opened.refresh()
    opened.settle(60)
    ground, other = panel.portrait.ground, opened.portrait_panel.portrait.ground
    for one, same in ((ground.levels, other.levels), (ground.arrows, other.arrows)):
        for side in (-1, 1):
            np.testing.assert_array_equal(one[side].data["x"], same[side].data["x"])
    opened.close()


def test_curves_of_a_moved_slider_bring_the_backdrop_on_which_they_lie(explorer):
    scheduler, panel, submitted = explorer.scheduler, explorer.portrait_panel, []
    scheduler.submit = lambda lane, *rest, **options: (
        submitted.append(lane) or Scheduler.submit(scheduler, lane, *rest, **options)
    )
    before = panel.portrait.ground.levels[-1].data
    explorer.scene.accept("values.a_minus", -2.6)
    explorer.settle(60)
    assert set(submitted) == {"runs", "view", "warnings"}, "what follows waits until the slider rests"
    assert counts(explorer)["backdrop"] == 2
    assert panel.portrait.ground.levels[-1].data is not before
    explorer.scene.accept("values.a_minus", -2.5)
    explorer.settle(60)
    assert counts(explorer)["backdrop"] == 3


def test_a_player_that_is_opened_again_has_its_frames(explorer):
    player = explorer.portrait_panel.player
    for is_open in (True, False, True):
        player.open = is_open
        explorer.settle(60)
        assert len(player.bar.ways) == 2 * is_open


def test_a_result_that_comes_after_a_change_of_system_and_before_its_computation_is_not_drawn(explorer, monkeypatch):
    explorer.scene.accept("view", "section")
    assert explorer.settle(60)
    view, later = explorer.view, []
    former, system, inputs = view.outcome, explorer.scene.declaration, view.shown
    with monkeypatch.context() as patch:
        patch.setattr(explorer.scheduler, "call_soon", later.append)
        explorer.scene.accept("system", "henon_heiles")
        explorer._show(view, system, inputs, former)
        explorer._advance(view, system, inputs, 1, 2, former)
    for callback in later:
        callback()
    assert explorer.settle(60)
    assert view.shown == view.inputs() != inputs


def test_the_status_line_tells_each_run(explorer):
    assert "2,000 steps, 21 crossings" in explorer.portrait_panel.status.object
    assert explorer.portrait_panel.status.object.count("max |Δψ| = ") == 2


def test_a_run_that_reaches_the_end_by_too_long_steps_is_warned_of_below_the_portrait(explorer):
    explorer.scene.tau = 0.12
    explorer.settle(60)
    words = explorer.portrait_panel.status.object
    assert "dmm2: The step of 0.12 at t = " in words
    assert "take a smaller τ" in words
    assert words.index("The step of 0.12") < words.index("crossings"), "before all figures, where it is in sight"
    explorer.scene.place((-0.9, -1.1))
    explorer.scene.selected = 0
    explorer.settle(60)
    words = explorer.portrait_panel.status.object
    assert "is too long for this field" in words, "the run is the same"
    assert "There is a warning for start 2: select it to read it." in words
    explorer.scene.tau = 0.01
    explorer.settle(60)
    assert "too long" not in explorer.portrait_panel.status.object


def test_the_view_holds_still_while_only_the_step_size_moves(explorer):
    frame = explorer.portrait_panel.portrait.frame
    explorer.scene.accept("tau", 2e-2)
    explorer.settle(60)
    assert explorer.portrait_panel.portrait.frame == frame


def test_undo_of_a_zoom_brings_back_the_view_before_it_and_fit_fits_anew(explorer):
    panel, scene = explorer.portrait_panel, explorer.scene
    explorer.settle(60)
    before = panel.portrait.frame
    scene.place((3.0, 0.0))
    explorer.settle(60)
    panel.sight.keep(Window(-1.0, 1.0, -1.0, 1.0))
    for _ in range(2):
        explorer.history.undo()
        explorer.settle(60)
        assert (scene.window, panel.portrait.frame) == (None, before)
    assert len(scene.starts) == 1
    scene.place((3.0, 0.0))
    explorer.settle(60)
    panel.sight.fit()
    assert panel.portrait.frame.x_high > before.x_high


@pytest.mark.parametrize("by", ["fit", "undo"])
def test_the_ground_of_a_view_that_was_left_is_not_shown_until_the_browser_tells_of_the_new_one(explorer, by):
    panel = explorer.portrait_panel
    explorer.settle(60)
    panel.sight.keep(Window(-40.0, 40.0, -40.0, 40.0))
    explorer.settle(60)
    {"fit": panel.sight.fit, "undo": explorer.history.undo}[by]()
    explorer.settle(60)
    assert panel.sight.covered == panel.portrait.frame.surroundings()


def test_another_projection_shows_other_variables(explorer):
    explorer.scene.load({"system": "kepler", "methods": ["rk4"]})
    explorer.settle(60)
    explorer.sidebar.plane.value = (2, 3)
    explorer.settle(60)
    names = core.CATALOGUE["kepler"].variables
    figure = explorer.portrait_panel.portrait.figure
    assert figure.xaxis[0].axis_label.startswith(names[2])
    assert figure.yaxis[0].axis_label == names[3]
    start = core.CATALOGUE["kepler"].x0
    assert list(explorer.portrait_panel.portrait.starts.data["y"]) == [start[3]]


def test_the_player_gets_its_steps_once_it_is_open_and_not_before(explorer):
    assert "frames" not in counts(explorer)
    explorer.portrait_panel.player.open = True
    explorer.settle(60)
    assert counts(explorer)["frames"] == 2
    assert len(explorer.portrait_panel.player.bar.ways) == 2


@pytest.mark.parametrize("system", deep_but(QUICK, core.CATALOGUE))
def test_every_system_can_be_chosen_and_shows_its_picture(explorer, system):
    explorer.scene.system = system
    explorer.settle(60)
    laws = core.CATALOGUE[system]
    portrait = explorer.portrait_panel.portrait
    assert explorer.portrait_panel.trouble.object == ""
    assert len(portrait.orbits.data["xs"]) == len(explorer.scene.used) > 0
    assert all(np.isfinite(x).sum() > 5 for x in portrait.orbits.data["xs"])  # a ring of genes turns six corners
    axes = explorer.results.plane(explorer.scene.declaration, explorer.scene.axes).axes
    assert list(portrait.starts.data["x"]) == [laws.x0[axes[0]]]
    assert (len(portrait.ground.surface.data["x"]) > 1) == shows_surface(laws, axes)
    drawn = [np.isfinite(source.data["x"]).any() for source in portrait.ground.arrows.values()]
    assert any(drawn) == shows_field(laws)
    assert explorer.scene.view == ("conserved" if laws.laws.most_conserved else "state")
    assert explorer.view.words.object
    assert all(plot.visible for plot in explorer.view.plots)
    assert (portrait.figure.xaxis[0].axis_label == laws.variables[axes[0]]) == (laws.dimension == 2)


def test_a_run_that_stops_early_says_why_and_shows_what_there_is(explorer):
    explorer.scene.accept("x0", (1.4, 1.4))
    explorer.settle(60)
    assert "stopped" in explorer.portrait_panel.status.object
    frame = explorer.portrait_panel.portrait.frame
    assert max(frame.width, frame.height) < 100


def test_while_the_first_integrators_are_compiled_the_portrait_shows_field_surface_and_starts():
    compiled = Event()

    class Compiling(Results):
        def pictures(self, *given):
            compiled.wait(60)
            return super().pictures(*given)

    page = Explorer(Scene(), Compiling())
    panel = page.portrait_panel
    panel._submit_ground()  # as a page does that still waits after `REMIND`
    assert page.scheduler._lanes["ground"].join(30)
    drawn = panel.portrait
    assert drawn.ground.surface.data["x"].size > 50
    assert drawn.starts.data["x"] == [-1.0]
    assert not len(drawn.orbits.data["xs"])
    assert panel.pane.styles["visibility"] == "inherit"
    compiled.set()
    assert page.settle(60)
    assert len(drawn.orbits.data["xs"]) == 2
    page.close()


def test_what_is_being_compiled_for_the_first_trajectory_is_said_with_the_time_it_takes():
    begun, compiled = Event(), Event()

    class Compiling(Results):
        def pictures(self, *given):
            with compiling("the time loop"):
                begun.set()
                compiled.wait(60)
            return super().pictures(*given)

    page = Explorer(Scene(), Compiling())
    panel = page.portrait_panel
    begun.wait(60)
    panel._explain_wait()  # as a page does that still waits after `LONG_WAIT`
    assert re.search(r"Compiling the time loop, once on this machine: \d+ s so far\.", panel.status.object)
    with compiling("rk2"):
        compiled.set()
        assert page.settle(60)
    assert "Compiling" not in panel.status.object
    page.close()


def test_a_view_says_that_it_waits_for_what_is_compiled_but_keeps_formulas_that_need_nothing_compiled():
    go = Event()

    class Compiling(Results):
        def run(self, *given):
            go.wait(60)
            return super().run(*given)

    page = Explorer(Scene(view="scheme"), Compiling())
    page._refresh_view()
    wait_for(lambda: "The scheme: dmm2" in page.view.mathematics.object)
    page._await_system("Compiling.")
    assert "The scheme: dmm2" in page.view.mathematics.object
    page.scene.view = "conserved"
    page._refresh_view()
    page._await_system("Compiling.")
    assert "Compiling." in page.view.words.object
    go.set()
    assert page.settle(60)
    assert "Compiling." not in page.view.words.object
    page.close()


def wait_for(condition):
    deadline = monotonic() + 30
    while not condition():
        assert monotonic() < deadline
        sleep(0.01)


def test_the_picture_of_another_system_is_faded_at_once_and_gets_no_star_of_the_new_one(explorer):
    panel, late = explorer.portrait_panel, explorer.portrait_panel.shown
    explorer.scene.param.update(system="pendulum")
    assert panel.pane.styles["opacity"] == FADED["opacity"] or panel.shown is not late
    assert explorer.settle(60)
    assert panel.pane.styles["opacity"] == PLAIN["opacity"]
    stars = dict(panel.portrait.starts.data)
    panel._show(late)  # as it may come if another system is chosen meanwhile
    assert panel.shown is not late
    assert dict(panel.portrait.starts.data) == stars


def test_nothing_is_seen_of_a_figure_before_there_is_something_in_it():
    results, go = Results(), Event()

    def slow(*args):
        go.wait(20)
        return Results.pictures(results, *args)

    results.pictures = slow
    page = Explorer(Scene(), results)
    panel = page.portrait_panel
    assert panel.portrait.figure.styles["visibility"] == "hidden"
    assert panel.progress.visible
    assert 'aria-label="Progress of the phase portrait"' in panel.progress.object
    go.set()
    page.refresh()
    page.settle(60)
    assert {pane.object.styles["visibility"] for pane in (panel.pane, *page.view.plots)} == {"inherit"}
    assert not panel.progress.visible
    page.scene.view = "cost"
    page.view.begin()
    assert page.view.plots[0].object.styles["visibility"] == "hidden"
    page.close()


def test_a_picture_that_cannot_be_drawn_is_no_mixture_of_two_systems_unsaid(explorer, monkeypatch):
    panel = explorer.portrait_panel

    def fail(*_):
        raise KeyError("a mark")

    monkeypatch.setattr(panel.portrait, "_label_marks", fail)
    monkeypatch.setattr(panel.portrait, "show_starts", fail)
    explorer.scene.accept("system", "kepler")
    with pytest.raises(KeyError, match="a mark"):
        explorer.settle(60)
    assert "could not be drawn, by a defect of this page" in panel.trouble.object
    assert panel.pane.styles["opacity"] == FADED["opacity"]
    assert panel.status.object == ""
    monkeypatch.undo()
    explorer.scene.accept("system", "pendulum")
    assert explorer.settle(60)
    assert panel.trouble.object == ""
    assert panel.pane.styles["opacity"] == PLAIN["opacity"]
    assert "dmm2" in panel.status.object


@pytest.mark.deep
def test_a_run_at_the_limit_of_crossings_is_drawn_and_says_so(explorer):
    """A converter whose step is longer than its surface allows switches millions of times."""
    law = {"parameters": {"L": 0.02, "C": 47e-6, "R": 22.0, "E": 24.0, "V": 12.0}, "x0": (0.0, 0.0)}
    fields = ("(i - v/R)/C", "(E - v)/L"), ("(i - v/R)/C", "-v/L")
    explorer.scene.use(core.PiecewiseSystem("Buck", ("v", "i"), *fields, "v - V", **law))
    explorer.scene.accept_times(0.01, 20.0)
    assert explorer.settle(240)
    assert "the limit of crossings is reached" in explorer.portrait_panel.status.object
    assert explorer.portrait_panel.portrait.ends.data["label"] == ["end: crossing limit"]
