"""The page without a browser: what it computes when, and what it shows."""

import gc
import weakref
from threading import Event
from types import SimpleNamespace

import numpy as np
import panel as pn
import pytest
from bokeh.core.validation.check import check_integrity
from bokeh.document import Document
from bokeh.models import Plot
from panel.io.document import _cleanup_doc
from panel.io.state import set_curdoc

import core
from pwsviz.geometry.projection import shows_field, shows_surface
from pwsviz.geometry.window import Window
from pwsviz.page.explorer import ADDRESS_RESTS, WINDOW_RESTS, Explorer
from pwsviz.page.export_dialog import NOT_YET
from pwsviz.page.portrait_panel import at_point
from pwsviz.results.results import Results
from pwsviz.scene.permalink import query, read
from pwsviz.scene.scene import Scene
from pwsviz.scene.views import VIEWS, View
from pwsviz.tabs import Tab
from pwsviz.tasks.scheduler import Scheduler
from pwsviz.widgets.panes import FADED, PLAIN
from tests.levels import deep_but


def counts(explorer):
    return dict(explorer.results.computed)


def test_first_picture_computes_what_is_visible_and_no_more(explorer):
    once = {"backdrop": 1, "landmarks": 1}
    assert counts(explorer) == {"run": 2, "orbit": 2, "error": 2, "summary": 2, "curve": 2, "warning": 2, **once}


def test_a_link_shows_the_level_sets_and_arrows_that_its_reader_saw_before(explorer):
    panel = explorer.portrait_panel
    for window in (Window(-3.0, 1.0, -2.0, 2.0), Window(-2.6, 1.4, -1.8, 2.2), Window(-1.9, 2.1, -1.7, 2.3)):
        panel._look_at(window)  # as the browser tells of a pan, and then of its end
        panel._keep_window(window)
        explorer.settle(20)
    opened = Explorer(Scene(), Results())
    opened.scene.restore(read(query(explorer.scene))[0])
    opened.refresh()
    opened.settle(20)
    ground, other = panel.portrait.ground, opened.portrait_panel.portrait.ground
    for one, same in ((ground.levels, other.levels), (ground.arrows, other.arrows)):
        for side in (-1, 1):
            np.testing.assert_array_equal(one[side].data["x"], same[side].data["x"])
    opened.close()


@pytest.mark.parametrize("key", [key for key in VIEWS if key != "conserved"])
def test_a_view_says_that_it_is_computed_before_it_is_made(explorer, key):
    view = explorer.views[key]
    assert not view.built
    assert view._content.objects == [view.words], "the browser has the words before anybody asks for the view"
    assert "Computing …" in view.words.object
    assert explorer.scene.view == "conserved"


def test_a_view_without_a_result_says_so_until_it_has_one(explorer):
    view = explorer.views["scheme"]
    explorer.scene.accept("view", "scheme")
    assert explorer.settle(20)
    assert "Computing" not in view.words.object
    explorer.scene.accept("system", "coulomb_friction")
    explorer.refresh()
    assert view.mathematics.object == ""
    assert "Computing …" in view.words.object
    assert explorer.settle(60)
    assert view.mathematics.object
    assert "Computing" not in view.words.object


def test_curves_of_a_moved_slider_bring_the_backdrop_on_which_they_lie(explorer):
    scheduler, panel, submitted = explorer.scheduler, explorer.portrait_panel, []
    scheduler.submit = lambda lane, *rest, **options: (
        submitted.append(lane) or Scheduler.submit(scheduler, lane, *rest, **options)
    )
    before = panel.portrait.ground.levels[-1].data
    explorer.scene.accept("values.a_minus", -2.6)
    explorer.settle(20)
    assert set(submitted) == {"runs", "view", "warnings"}, "what follows waits until the slider rests"
    assert counts(explorer)["backdrop"] == 2
    assert panel.portrait.ground.levels[-1].data is not before
    explorer.scene.accept("values.a_minus", -2.5)
    explorer.settle(20)
    assert counts(explorer)["backdrop"] == 3


def test_a_player_that_is_opened_again_has_its_frames(explorer):
    player = explorer.portrait_panel.player
    for is_open in (True, False, True):
        player.open = is_open
        explorer.settle(20)
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


@pytest.mark.parametrize("view", ["order", "time", "cost", "section", "stability", "sweep", "conserved"])
def test_a_result_that_comes_when_others_are_under_way_is_drawn_only_of_what_the_scene_still_has(explorer, view):
    """As one whose computation had just ended when another system, or another integrator, was chosen."""
    explorer.scene.param.update(t_end=2.0, peers=[], view=view)
    assert explorer.settle(60)
    tab = explorer.view
    former, system, inputs = tab.outcome, explorer.scene.declaration, tab.shown
    for setting, value in (("methods", ["rk4"]), ("system", "henon_heiles")):
        explorer.scene.accept(setting, value)
        assert explorer.settle(60)
        shown, wanted = tab.shown, tab.inputs()
        explorer._show(tab, system, inputs, former)
        explorer._advance(tab, system, inputs, 1, 2, former)
        if setting == "system" or view != "conserved":  # its pictures follow a slider, each a little late
            assert tab.shown == shown
        assert explorer.settle(60)
        assert tab.inputs() == wanted


def test_hidden_views_compute_nothing(explorer):
    explorer.scene.view = "order"
    explorer.settle(20)
    explorer.scene.accept("tau", 5e-3)
    explorer.settle(20)
    assert counts(explorer)["curve"] == 2, "the conserved quantity is hidden"
    assert counts(explorer)["study"] == 1, "the study does not depend on the step size"
    assert counts(explorer)["run"] == 4, "the portrait is always there"


@pytest.mark.deep
def test_going_round_the_tabs_twice_computes_each_view_once(explorer):
    explorer.scene.param.update(t_end=5.0, peers=[])
    assert explorer.settle(120)
    before = counts(explorer)
    for _ in range(2):
        for view in VIEWS:
            explorer.scene.view = view
            explorer.settle(60)
    made = {kind: count - before.get(kind, 0) for kind, count in counts(explorer).items()}
    assert {kind: count for kind, count in made.items() if count} == {
        "states": 2, "study": 1, "cost": 1, "section": 1, "stability": 1, "limits": 1, "sweep": 1,
        "diagnosis": 1,
    }  # fmt: skip


def test_a_view_not_yet_looked_at_is_not_even_made(explorer):
    assert [key for key, view in explorer.views.items() if view.built] == ["conserved"]
    explorer.scene.view = "scheme"
    assert [key for key, view in explorer.views.items() if view.built] == ["conserved", "scheme"]


def test_leaving_a_long_study_gives_it_up(explorer):
    explorer.scene.view = "stability"
    explorer.scene.view = "conserved"
    assert explorer.settle(20)
    assert explorer.views["stability"].outcome is None
    explorer.scene.param.update(t_end=2.0, methods=["dmm2"], stability_part="drift")
    explorer.scene.view = "stability"
    assert explorer.settle(60)
    assert explorer.views["stability"].outcome is not None


def test_of_stability_the_part_shown_is_offered_as_a_picture_and_none_without_a_tangency(explorer):
    explorer.scene.use(core.CATALOGUE["damped_oscillator"])
    explorer.scene.param.update(t_end=2.0, methods=["rk4"], stability_part="drift", view="stability")
    assert explorer.settle(60)
    tab = explorer.views["stability"]
    assert explorer._pieces()[1].figures == [tab.view.figure("drift")]
    explorer.scene.stability_part = "grazing"
    assert explorer.settle(60)
    piece = explorer._pieces()[1]
    assert (piece.figures, piece.tables, piece.lack) == ([], {}, "this view has no figure.")


def test_a_long_study_can_be_cancelled_and_begun_again(explorer):
    explorer.scene.param.update(peers=[], t_end=5.0)
    explorer.scene.view = "cost"
    view = explorer.views["cost"]
    view.progress.begin()
    view.on_cancel()
    assert explorer.settle(20)
    assert view.outcome is None
    assert view.progress._again.visible
    assert explorer.announcer.view[0] == "Cost: cancelled."
    view.on_again()
    assert explorer.settle(60)
    assert view.outcome is not None
    assert explorer.announcer.view[0] == "Cost: finished."
    assert not view.progress.busy


def test_what_only_looks_different_is_not_computed_anew(explorer):
    explorer.scene.param.update(peers=[], t_end=5.0, view="cost")
    assert explorer.settle(60)
    label = explorer.views["cost"].view.figure.yaxis[0].axis_label
    explorer.scene.cost_up = "invariant"
    assert explorer.settle(20)
    assert counts(explorer)["cost"] == 1
    assert explorer.views["cost"].view.figure.yaxis[0].axis_label != label


def test_tab_and_scene_agree(explorer):
    explorer.tabs.active = list(VIEWS).index("time")
    assert explorer.scene.view == "time"


def test_a_change_repaints_by_data_not_by_new_figures(explorer):
    figures = [explorer.portrait_panel.portrait.figure, explorer.views["conserved"].view.figure]
    models = [figure.references() for figure in figures]
    before = explorer.portrait_panel.portrait.orbits.data["xs"][0]
    explorer.scene.accept("tau", 0.05)
    explorer.scene.system = next(key for key in core.CATALOGUE if key != explorer.scene.system)
    explorer.settle(20)
    assert [figure.references() for figure in figures] == models
    assert explorer.portrait_panel.portrait.orbits.data["xs"][0] is not before


def test_the_status_line_tells_each_run(explorer):
    assert "2,000 steps, 21 crossings" in explorer.portrait_panel.status.object
    assert explorer.portrait_panel.status.object.count("max |Δψ| = ") == 2


def test_a_run_that_reaches_the_end_by_too_long_steps_is_warned_of_below_the_portrait(explorer):
    explorer.scene.tau = 0.12
    explorer.settle(20)
    words = explorer.portrait_panel.status.object
    assert "dmm2: The step of 0.12 at t = " in words
    assert "take a smaller τ" in words
    explorer.scene.place((-0.9, -1.1))
    explorer.scene.selected = 0
    explorer.settle(20)
    words = explorer.portrait_panel.status.object
    assert "is too long for this field" in words, "the run is the same"
    assert "There is a warning of start 2: select it to read it." in words
    explorer.scene.tau = 0.01
    explorer.settle(20)
    assert "too long" not in explorer.portrait_panel.status.object


def test_the_view_holds_still_while_only_the_step_size_moves(explorer):
    frame = explorer.portrait_panel.portrait.frame
    explorer.scene.accept("tau", 2e-2)
    explorer.settle(20)
    assert explorer.portrait_panel.portrait.frame == frame


def test_bad_input_is_told_beside_the_field_and_the_picture_stays(explorer):
    shown = explorer.portrait_panel.portrait.orbits.data
    field = explorer.sidebar.tau
    field.type("minus one")
    explorer.settle(20)
    assert field.entry.complaint
    assert "not a number" in field.entry.complaint
    assert explorer.portrait_panel.portrait.orbits.data is shown
    field.type("0.02")
    assert not field.entry.complaint
    assert explorer.scene.tau == 0.02


def test_the_slider_and_the_entry_follow_each_other(explorer):
    field = explorer.sidebar.tau
    field.entry.place = -3.0
    assert explorer.scene.tau == 1e-3
    assert field.entry.text == "0.001"
    field.type("0.1")
    assert field.entry.place == pytest.approx(-1.0)


def test_no_integrator_chosen_is_refused_in_words(explorer):
    explorer.sidebar.methods.value = []
    assert "at least one" in explorer.sidebar.methods_message.object
    assert explorer.scene.methods == ["dmm2", "rk2"]


def test_another_system_brings_its_own_fields(explorer):
    explorer.scene.system = "harmonic_oscillator"
    names = [p.name for p in core.CATALOGUE["harmonic_oscillator"].parameters]
    assert list(explorer.sidebar.fields) == [*(f"values.{name}" for name in names), "x0.0", "x0.1"]


def test_the_fields_of_one_system_become_those_of_the_next(explorer):
    sidebar = explorer.sidebar
    before = dict(sidebar.fields)
    complained = before["values.a_plus"]
    complained.type("?")
    explorer.scene.system = "pendulum"
    assert list(sidebar.fields.values()) == list(before.values())  # three parameters and two coordinates, as before
    assert not complained.entry.complaint
    field = sidebar.fields["values.k_plus"]
    assert (field.entry.label, field.entry.text) == ("k₊", "9.8")
    assert (*field.entry.ends, field.entry.place) == (0.1, 30.0, 9.8)
    field.entry.place = 4.0
    assert explorer.scene.values["k_plus"] == 4.0
    explorer.scene.system = "gene_switch"
    assert sidebar.fields["x0.2"].entry.label == "z at start"
    explorer.scene.system = "elliptic_curve"
    assert list(sidebar.fields.values()) == list(before.values())
    assert explorer.scene.values == core.CATALOGUE["elliptic_curve"].values


def test_the_address_follows_a_zoom_sooner_than_a_slider(explorer, monkeypatch):
    delays = []
    monkeypatch.setattr(explorer.scheduler, "call_later", lambda delay, call, _: delays.append((delay, call)))
    explorer.scene.tau = 2e-3
    explorer.scene.window = (-1.0, 1.0, -1.0, 1.0)
    written = [delay for delay, call in delays if call == explorer._write_address]
    assert written == [ADDRESS_RESTS, WINDOW_RESTS]


def test_a_click_places_one_more_trajectory(explorer):
    explorer.portrait_panel.place(-0.123456, 0.654321)
    explorer.settle(20)
    assert explorer.scene.starts == ((-1.0, -1.0), (-0.123, 0.654))
    assert explorer.scene.selected == 1
    assert list(explorer.portrait_panel.portrait.starts.data["x"]) == [-1.0, -0.123]
    assert len(explorer.portrait_panel.portrait.others.data["xs"]) == 2
    assert explorer.sidebar.fields["x0.0"].entry.text == "-0.123"


def test_a_dragged_start_moves_and_an_older_complaint_goes(explorer):
    coordinate = explorer.sidebar.fields["x0.0"]
    coordinate.type("?")
    assert coordinate.entry.complaint
    explorer.portrait_panel.move(0, -0.8, 0.5)
    explorer.settle(20)
    assert explorer.scene.starts == ((-0.8, 0.5),)
    assert not coordinate.entry.complaint


def test_the_last_trajectory_cannot_be_removed_and_that_is_said(explorer):
    explorer.portrait_panel.place(-0.5, 0.5)
    explorer.portrait_panel.remove(0)
    assert explorer.scene.starts == ((-0.5, 0.5),)
    explorer.settle(20)
    explorer.portrait_panel.remove(0)
    assert "has to stay" in explorer.portrait_panel.trouble.object


def test_looking_into_another_trajectory_computes_no_run(explorer):
    explorer.portrait_panel.place(-0.5, 0.5)
    explorer.settle(20)
    runs = counts(explorer)["run"]
    explorer.scene.selected = 0
    explorer.settle(20)
    assert counts(explorer)["run"] == runs


def test_undo_of_a_zoom_brings_back_the_view_before_it_and_fit_fits_anew(explorer):
    panel, scene = explorer.portrait_panel, explorer.scene
    explorer.settle(20)
    before = panel.portrait.frame
    scene.place((3.0, 0.0))
    explorer.settle(20)
    panel._keep_window(Window(-1.0, 1.0, -1.0, 1.0))
    for _ in range(2):
        explorer.history.undo()
        explorer.settle(20)
        assert (scene.window, panel.portrait.frame) == (None, before)
    assert len(scene.starts) == 1
    scene.place((3.0, 0.0))
    explorer.settle(20)
    panel.fit()
    assert panel.portrait.frame.x_high > before.x_high


def test_undo_brings_back_what_was_there(explorer):
    before = explorer.scene.settings()
    explorer.portrait_panel.place(-0.5, 0.5)
    explorer.history.undo()
    explorer.settle(20)
    assert explorer.scene.settings() == before
    assert list(explorer.portrait_panel.portrait.starts.data["x"]) == [-1.0]


@pytest.mark.parametrize("wait", [0, 20])
def test_a_double_click_fits_the_view_and_takes_back_what_its_first_click_placed(explorer, monkeypatch, wait):
    panel, scene, later = explorer.portrait_panel, explorer.scene, []
    frame, before = panel.portrait.frame, scene.settings()
    scene.window = (-9.0, 9.0, -9.0, 9.0)
    panel.place(-1.5, 0.5)
    explorer.settle(wait)  # the second click may come before or after the first one's trajectory
    monkeypatch.setattr(explorer.scheduler, "call_soon", later.append)  # as where there is a server
    panel.portrait.hand.data = {"act": ["fit"], "index": [0], "x": [0.0], "y": [0.0], "count": [1]}
    for call in later:
        call()
    explorer.settle(20)
    assert scene.settings() == before
    assert panel.portrait.frame == frame
    monkeypatch.undo()
    panel.place(-0.5, 0.5)
    explorer.settle(20)
    assert panel.portrait.frame == frame, "the next start does not move it"


def test_a_place_is_rounded_to_about_a_pixel_and_what_is_not_shown_stays():
    window = Window(0, 5000, 0, 10)
    assert at_point(1.23456, 2.0, window, (0.0, 0.0, 7.0)) == (1.0, 2.0, 7.0)
    assert at_point(1.23456, 2.0, window, (5.0, 6.0, 7.0), (2, 0)) == (2.0, 6.0, 1.0)


def test_another_projection_shows_other_variables(explorer):
    explorer.scene.load({"system": "kepler", "methods": ["rk4"]})
    explorer.settle(60)
    explorer.sidebar.plane.value = (2, 3)
    explorer.settle(20)
    names = core.CATALOGUE["kepler"].variables
    figure = explorer.portrait_panel.portrait.figure
    assert figure.xaxis[0].axis_label.startswith(names[2])
    assert figure.yaxis[0].axis_label == names[3]
    start = core.CATALOGUE["kepler"].x0
    assert list(explorer.portrait_panel.portrait.starts.data["y"]) == [start[3]]


def test_the_player_gets_its_steps_once_it_is_open_and_not_before(explorer):
    assert "frames" not in counts(explorer)
    explorer.portrait_panel.player.open = True
    explorer.settle(20)
    assert counts(explorer)["frames"] == 2
    assert len(explorer.portrait_panel.player.bar.ways) == 2


def test_a_preset_is_loaded_and_says_what_to_look_at(explorer):
    explorer.sidebar.presets.value = "vf_sliding"
    assert explorer.settle(60)
    assert explorer.scene.system == "type_sliding"
    assert "every run reaches" in explorer.sidebar.preset_note.object


def test_a_system_of_ones_own_is_used_like_any_other(explorer):
    own = core.PiecewiseSystem(
        "<b>mine</b>", ("u", "v"), ("v", "-k*u"), ("v", "-u"), "v", parameters={"k": 3.0}, x0=(1.0, 1.0)
    )
    explorer._use(own)
    assert explorer.settle(60)
    assert explorer.portrait_panel.trouble.object == ""
    assert "<b>mine</b> (yours)" in explorer.sidebar.system.options
    explorer.sidebar.fields["values.k"].type("2")
    for view in VIEWS:
        explorer.scene.param.update(view=view, t_end=5.0, peers=[])
        assert explorer.settle(60)
        assert 'class="error"' not in explorer.view.words.object or view in ("order", "time")
    assert "<b>mine" not in explorer.portrait_panel.note.object + explorer.view.mathematics.object


def test_a_typed_system_is_computed_before_it_is_wanted(explorer):
    explorer.settle(20)
    explorer.edit()
    explorer.editor.texts["g"].value_input = "x + 0.125"
    assert explorer.editor.settle(20)
    assert explorer.settle(60)
    computed = explorer.results.computed["run"]
    assert explorer.scene.system == "elliptic_curve"
    explorer.editor.use.clicks += 1
    assert explorer.settle(20)
    assert explorer.scene.declaration.g == "x + 0.125"
    assert "crossings" in explorer.portrait_panel.status.object
    assert explorer.results.computed["run"] == computed


def test_a_link_is_adopted_and_what_is_wrong_with_it_is_told(explorer):
    explorer.adopt("?v=1&system=pendulum&tau=0.125&t_end=never&<script>=1")
    assert (explorer.scene.system, explorer.scene.tau) == ("pendulum", 0.125)
    assert "never" in explorer.notice.object
    assert "<script>" not in explorer.notice.object
    assert explorer.settle(60)


def test_the_first_hint_fits_mouse_and_finger(explorer):
    assert "click or tap in the portrait" in explorer.sidebar.preset_note.object


def test_a_complaint_about_a_link_goes_with_the_first_change_of_its_scene(explorer):
    explorer.adopt("?v=2&tau=2")
    assert "Step size" in explorer.notice.object
    explorer.scene.view = "order"
    explorer.scene.window = (-2.0, 2.0, -2.0, 2.0)
    assert "Step size" in explorer.notice.object
    explorer.scene.t_end = 5.0
    assert explorer.notice.object == ""


def test_what_is_taken_away_is_what_is_shown(explorer):
    explorer.scene.view = "order"
    explorer.settle(20)
    portrait, order = explorer._pieces()
    assert len(portrait.tables["curves"]()["t"]) == 2 * 2001
    assert portrait.figures == [explorer.portrait_panel.portrait.figure]
    for name in ("ψ = ψ(trajectory)", "S attracts", "S repels"):
        assert f"“{name}”" in portrait.meaning
    assert len(order.tables["errors"]()["error"]) > 20
    explorer.export.open("http://here/app")
    assert explorer.export.link.value.startswith("http://here/app?v=2")
    assert "core.integrate" in explorer.export.program.object


def test_the_order_says_when_states_are_compared_and_what_it_counts(explorer):
    explorer.scene.load({"system": "stick_slip", "methods": ["rk2"], "view": "order"})
    assert explorer.settle(60)
    last = explorer.view.outcome[0].times[-1]
    told = explorer.view.words.object
    assert last > explorer.scene.t_end
    assert f" and {last:.4g}, halfway from crossings 10, 20 and 30 to the next (“after”)" in told
    assert "The end time has no effect here." in told
    assert "page" not in explorer.view.how(explorer.view.outcome)
    assert "the beginning and the end of sliding count as crossings" in told
    assert "Euclidean norm" in explorer.view.how(explorer.view.outcome)


def test_where_no_step_is_made_the_view_says_why(explorer):
    explorer.scene.load({"system": "type_repelling", "starts": ((0.0, 0.0),), "view": "conserved"})
    explorer.settle(20)
    assert "No step was made" in explorer.view.words.object
    assert not explorer.view.plots[0].visible
    explorer.scene.load({"view": "conserved"})
    explorer.settle(20)
    assert explorer.view.plots[0].visible, "the figure comes back with the next run"
    assert explorer.view.plots[0].object.visible


def test_sliding_is_drawn_apart_and_named_also_where_no_psi_is_known(explorer):
    explorer.scene.load({"system": "coulomb_friction", "view": "conserved"})
    explorer.settle(20)
    view = explorer.view.view
    assert view.figure.yaxis[0].axis_label == "error of ψ, |Δψ|; of g while sliding, |Δg|"
    for xs, ys, curve in zip(view.curves.data["xs"], view.curves.data["ys"], explorer.view.outcome.curves, strict=True):
        changes = np.count_nonzero(np.diff(curve.sliding[1:]))
        assert changes
        assert len(xs) == len(ys) == len(curve.t) - 1 + changes
    assert "round-off is at 2 × 2⁻⁵² times the largest |ψ| + Σ" in explorer._pieces()[1].meaning
    explorer.scene.load({"system": "stick_slip", "view": "conserved"})
    explorer.scene.view = "conserved"
    explorer.settle(20)
    assert explorer.view.plots[0].visible
    assert view.figure.yaxis[0].axis_label == "error of g while sliding, |Δg|"
    assert "Shown is |Δg|" in explorer.view.words.object


def test_the_export_says_that_a_view_is_not_computed_and_offers_its_files_when_it_is(explorer):
    explorer.scene.view = "order"
    explorer.scheduler.cancel("view")
    explorer.export.open("")
    _, row, _ = explorer.export.numbers
    assert [part.object for part in row] == ["Order", NOT_YET]
    explorer._again()
    assert explorer.settle(60)
    _, row, _ = explorer.export.numbers
    assert [part.label for part in row[1:]][:2] == ["CSV errors", "CSV fits"]
    explorer.scene.accept("values.a_minus", -2.5)  # of which nothing is computed: what is drawn is of other values
    assert explorer._pieces()[1].tables == {}


def test_all_panels_of_the_state_are_saved_as_one_picture(explorer):
    explorer.scene.accept("system", "relay_feedback")
    explorer.settle(20)
    assert explorer.scene.view == "state"
    _, state = explorer._pieces()
    assert [plot.yaxis.axis_label for plot in state.figures] == ["x", "v"]
    said = [plot.html_attributes["aria-label"] for plot in state.figures]
    assert [words.partition(" against time. ")[0] for words in said] == ["Coordinate x", "Coordinate v"]
    assert "v from" not in said[0], "each panel tells of its own coordinate"
    assert "x from" not in said[1]


def test_of_a_view_that_has_no_figure_no_picture_is_offered(explorer):
    explorer.scene.accept("system", "relay_feedback")
    explorer.scene.param.update(view="conserved", slide=False)  # it has no ψ, and no |Δg| of sliding
    assert explorer.settle(20)
    _, conserved = explorer._pieces()
    assert list(conserved.figures) == []


def test_no_figure_of_another_system_stays_where_a_study_is_refused(explorer):
    explorer.scene.view = "order"
    assert explorer.settle(60)
    assert all(pane.styles["visibility"] == "inherit" for pane in explorer.view.plots)
    explorer.scene.accept("system", "type_upward")  # which crosses once
    assert explorer.settle(60)
    assert "at least two crossings" in explorer.view.words.object
    assert all(pane.styles["visibility"] == "hidden" for pane in explorer.view.plots)
    assert not any(pane.visible for pane in explorer.view.plots), "the reason stands where the figure would"
    explorer.scene.accept("system", "pendulum")
    assert explorer.settle(60)
    assert all(pane.visible and pane.styles["visibility"] == "inherit" for pane in explorer.view.plots)


def test_where_all_errors_are_0_the_order_has_words_and_no_empty_figure(explorer):
    explorer.scene.load({"system": "bouncing_ball", "methods": ["dmm2"], "view": "time"})
    assert explorer.settle(60)
    assert "No slope is fitted, as all errors are near round-off" in explorer.view.words.object
    assert explorer._pieces()[1].figures == []
    explorer.scene.accept("system", "elliptic_curve")
    assert explorer.settle(60)
    assert len(explorer._pieces()[1].figures) == 1


#: In two dimensions, in three, without ψ, with jumps, with two surfaces.
QUICK = ("elliptic_curve", "rigid_body", "gene_switch", "bouncing_ball", "two_walls")


@pytest.mark.parametrize("system", deep_but(QUICK, core.CATALOGUE))
def test_every_system_can_be_chosen_and_shows_its_picture(explorer, system):
    explorer.scene.system = system
    explorer.settle(60)
    laws = core.CATALOGUE[system]
    portrait = explorer.portrait_panel.portrait
    assert explorer.portrait_panel.trouble.object == ""
    assert len(portrait.orbits.data["xs"]) == len(explorer.scene.used) > 0
    assert all(np.isfinite(x).sum() > 5 for x in portrait.orbits.data["xs"])  # a ring of genes turns six corners
    axes = explorer.results.plane(explorer.scene.declaration, explorer.scene.axes)
    assert list(portrait.starts.data["x"]) == [laws.x0[axes[0]]]
    assert (len(portrait.ground.surface.data["x"]) > 1) == shows_surface(laws, axes)
    drawn = [np.isfinite(source.data["x"]).any() for source in portrait.ground.arrows.values()]
    assert any(drawn) == shows_field(laws)
    assert explorer.scene.view == ("conserved" if laws.laws.most_conserved else "state")
    assert explorer.view.words.object
    assert all(plot.visible for plot in explorer.view.plots)
    assert (portrait.figure.xaxis[0].axis_label == laws.variables[axes[0]]) == (laws.dimension == 2)


def test_a_system_without_conserved_quantities_offers_what_can_be_used(explorer):
    explorer.scene.system = "relay_feedback"
    explorer.settle(20)
    assert explorer.sidebar.methods.options == ["rk2", "rk4", "rk8", "gauss4", "taylor"]
    assert explorer.sidebar.methods.value == ["rk2"]
    assert "need a conserved quantity" in explorer.sidebar.methods_note.object
    explorer.scene.system = "elliptic_curve"
    assert explorer.sidebar.methods.options == list(core.METHODS)
    assert explorer.sidebar.methods.value == ["dmm2", "rk2"]
    assert "need a conserved quantity" not in explorer.sidebar.methods_note.object


def test_the_tolerance_is_shown_with_an_integrator_that_has_one(explorer):
    field = explorer.sidebar.tolerance
    assert not field.entry.visible
    explorer.sidebar.methods.value = ["dmm2", "taylor"]
    assert field.entry.visible
    assert field.entry.ends is not None
    field.entry.place = -9.0
    assert explorer.scene.tolerance == 1e-9
    explorer.sidebar.methods.value = ["dmm2"]
    assert not field.entry.visible


def test_a_study_of_few_crossings_says_so(explorer):
    explorer.scene.param.update(system="coulomb_friction", view="order")
    explorer.settle(20)
    words = explorer.views["order"].words.object
    assert "after 1 crossing, slope" in words
    assert "fewer crossings than the usual" in words


def test_a_study_that_is_impossible_says_why(explorer):
    explorer.scene.accept("x0", (1.4, -1.4))  # runs off to infinity
    explorer.scene.view = "order"
    explorer.settle(20)
    assert 'class="error"' in explorer.views["order"].words.object
    assert not explorer.views["order"].progress.busy


def test_one_integrator_that_blows_up_does_not_spoil_the_view_of_another(explorer):
    explorer.scene.param.update(system="harmonic_oscillator", tau=0.25, t_end=60_000.0)
    explorer.settle(20)
    assert "stopped" in explorer.portrait_panel.status.object
    frame = explorer.portrait_panel.portrait.frame
    assert max(frame.width, frame.height) < 10
    for x in explorer.portrait_panel.portrait.orbits.data["xs"]:
        assert np.nanmax(np.abs(x)) < 100
    assert len(explorer.portrait_panel.portrait.orbits.data["xs"][1]) > 100


def test_a_run_that_stops_early_says_why_and_shows_what_there_is(explorer):
    explorer.scene.accept("x0", (1.4, 1.4))
    explorer.settle(20)
    assert "stopped" in explorer.portrait_panel.status.object
    frame = explorer.portrait_panel.portrait.frame
    assert max(frame.width, frame.height) < 100


def visit_and_leave():
    document = Document()
    with set_curdoc(document):
        explorer = Explorer(Scene(), Results())
        explorer.page().server_doc(document)
        explorer.settle(20)
    for callback in document.session_destroyed_callbacks:
        callback(SimpleNamespace(id="one", _document=document))
    _cleanup_doc(document)
    return weakref.ref(explorer)


def test_a_page_that_is_left_is_let_go():
    left = visit_and_leave()
    gc.collect()
    assert left() is None


def test_a_page_begins_with_the_portrait_alone(monkeypatch):
    furnish = []
    monkeypatch.setattr(type(pn.state), "onload", lambda _state, callback, **_options: furnish.append(callback))
    explorer = Explorer(Scene(), Results())
    document = Document()
    document.add_root(explorer.page().get_root(document))
    explorer.settle(20)
    assert list(document.select({"type": Plot})) == [explorer.portrait_panel.portrait.figure]
    for callback in furnish:
        callback()
    assert len(list(document.select({"type": Plot}))) == 2


def test_the_page_passes_the_checks_of_bokeh_that_the_server_leaves_out():
    explorer = Explorer(Scene(), Results())
    explorer.settle(20)
    document = Document()
    document.add_root(explorer.page().get_root(document))
    assert check_integrity(document.models).error == []


class StepSizeTab(Tab):
    """A view of one number, as somebody else might add it."""

    def inputs(self):
        """The step size is all that it shows."""
        return self.scene.tau

    def compute(self, inputs, cancel, report):
        """Nothing is left to compute."""
        return inputs

    def build(self):
        """No figure."""
        return []

    def draw(self, outcome):
        """Say it."""
        return f"The step size is {outcome:g}."

    def table(self):
        """One number."""
        return {"tau": [self.outcome]}

    def program(self):
        """Print it."""
        return f"print('tau', {self.scene.tau})"


def test_a_view_added_from_outside_is_in_the_page_in_links_and_in_the_export(monkeypatch):
    monkeypatch.setitem(VIEWS, "step", View("Step size", f"{__name__}:StepSizeTab"))
    explorer = Explorer(Scene(t_end=1.0), Results())
    explorer.tabs.active = list(VIEWS).index("step")
    assert explorer.settle(20)
    assert "The step size is 0.01." in explorer.view.words.object
    assert read(query(explorer.scene)) == (explorer.scene.settings(), [])
    assert "Scheme, Step" in "".join(read("view=nonsense")[1])
    explorer.export.open("")
    assert "print(&#x27;tau&#x27;, 0.01)" in explorer.export.program.object
    assert [row[0].object for row in explorer.export.numbers] == ["Phase portrait", "Step size", "Equations"]
    explorer.close()


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
    page.settle(20)
    assert {pane.object.styles["visibility"] for pane in (panel.pane, *page.view.plots)} == {"inherit"}
    assert not panel.progress.visible
    page.scene.view = "cost"
    page.view.begin()
    assert page.view.plots[0].object.styles["visibility"] == "hidden"
    page.close()


def test_a_map_of_a_system_without_psi_offers_no_colours_by_its_error(explorer):
    for system, known in (("gene_switch", False), ("elliptic_curve", True)):
        chosen = {"methods": ["rk4"], "view": "stability", "stability_shown": "error"}
        explorer.scene.param.update(system=system, t_end=1.0, **chosen)
        assert explorer.settle(30)
        tab = explorer.views["stability"]
        assert tab._shown.visible == known
        headers = [table.header for table in tab.numbers(tab.outcome)]
        assert any("|Δψ| at most" in header for header in headers) == known
        assert explorer.scene.stability_shown == "error", "it is kept for the next system"


@pytest.mark.parametrize("view", ["order", "cost", "stability", "section"])
def test_what_a_study_does_at_crossings_stands_in_its_caption(explorer, view):
    explorer.scene.param.update(t_end=1.0, peers=[], perturbation_order=1, perturbation_scale=2.0, view=view)
    assert explorer.settle(60)
    how = explorer._pieces()[1].how
    assert "crossings located by Mannshardt’s transition scheme" in how
    assert ("sliding solution is followed" in how) == (view in ("stability", "section")), "no run of the others slides"
    assert ("their times perturbed by 2·τ" in how) == (view == "order"), "others do not perturb"


def test_the_order_says_that_crossing_times_are_perturbed(explorer):
    explorer.scene.load({"view": "order", "perturbation_order": 1, "methods": ["dmm2"]})
    assert explorer.settle(60)
    assert "Crossing times are perturbed by τ." in explorer.view.words.object
