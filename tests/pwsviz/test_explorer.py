"""The page without a browser: what it computes when, and what it shows."""

import numpy as np
import pytest

import core
from pwsviz.explorer import Explorer, place
from pwsviz.plane import Window
from pwsviz.results import Results
from pwsviz.scene import VIEWS, Scene


@pytest.fixture
def explorer():
    page = Explorer(Scene(), Results())
    page.settle(20)
    yield page
    page.close()


def counts(explorer):
    return dict(explorer.results.computed)


def test_first_picture_computes_what_is_visible_and_no_more(explorer):
    assert counts(explorer) == {"run": 2, "orbit": 2, "error": 2, "summary": 2, "curve": 2, "backdrop": 1}


def test_hidden_views_compute_nothing(explorer):
    explorer.scene.view = "order"
    explorer.settle(20)
    explorer.scene.accept("tau", 5e-3)
    explorer.settle(20)
    assert counts(explorer)["curve"] == 2, "the conserved quantity is hidden"
    assert counts(explorer)["study"] == 1, "the study does not depend on the step size"
    assert counts(explorer)["run"] == 4, "the portrait is always there"


def test_going_round_the_tabs_computes_each_once(explorer):
    for _ in range(3):
        for view in VIEWS:
            explorer.scene.view = view
            explorer.settle(20)
    assert counts(explorer)["run"] == 2
    assert counts(explorer)["study"] == 1


def test_tab_and_scene_agree(explorer):
    explorer.tabs.active = 2
    assert explorer.scene.view == "time"


def test_a_change_repaints_by_data_not_by_new_figures(explorer):
    figures = [explorer.portrait.figure, explorer.conserved.figure]
    models = [figure.references() for figure in figures]
    before = explorer.portrait.orbits.data["xs"][0]
    explorer.scene.accept("tau", 0.05)
    explorer.scene.system = next(key for key in core.CATALOGUE if key != explorer.scene.system)
    explorer.settle(20)
    assert [figure.references() for figure in figures] == models
    assert explorer.portrait.orbits.data["xs"][0] is not before


def test_the_status_line_tells_each_run(explorer):
    assert "2,000 steps, 21 crossings" in explorer.status.object
    assert explorer.status.object.count("|Δψ| ≤") == 2


def test_the_view_holds_still_while_only_the_step_size_moves(explorer):
    frame = explorer.portrait.frame
    explorer.scene.accept("tau", 2e-2)
    explorer.settle(20)
    assert explorer.portrait.frame == frame


def test_bad_input_is_told_beside_the_field_and_the_picture_stays(explorer):
    shown = explorer.portrait.orbits.data
    field = explorer.sidebar.tau
    field.text.value = "minus one"
    explorer.settle(20)
    assert field.text.error_state
    assert "not a number" in field.text.helper_text
    assert explorer.portrait.orbits.data is shown
    field.text.value = "0.02"
    assert not field.text.error_state
    assert explorer.scene.tau == 0.02


def test_the_slider_and_the_entry_follow_each_other(explorer):
    field = explorer.sidebar.tau
    field.slider.value = -3.0
    assert explorer.scene.tau == 1e-3
    assert field.text.value == "0.001"
    field.text.value = "0.1"
    assert field.slider.value == pytest.approx(-1.0)


def test_no_integrator_chosen_is_refused_in_words(explorer):
    explorer.sidebar.methods.value = []
    assert "at least one" in explorer.sidebar.methods_message.object
    assert explorer.scene.methods == ["dmm2", "rk2"]


def test_another_system_brings_its_own_fields(explorer):
    explorer.scene.system = "harmonic_oscillator"
    names = [p.name for p in core.CATALOGUE["harmonic_oscillator"].parameters]
    assert list(explorer.sidebar.fields) == [*(f"values.{name}" for name in names), "x0.0", "x0.1"]


def test_a_click_moves_the_start_and_drops_an_older_complaint(explorer):
    coordinate = explorer.sidebar.fields["x0.0"]
    coordinate.text.value = "?"
    assert coordinate.text.error_state
    explorer._start_at(-0.123456, 0.654321)
    explorer.settle(20)
    assert explorer.scene.x0 == (-0.123, 0.654)
    assert not coordinate.text.error_state
    assert list(explorer.portrait.starts.data["x"]) == [-0.123]


def test_a_place_is_rounded_to_about_a_pixel():
    assert place(1.23456, 2.0, Window(0, 5000, 0, 10), (0.0, 0.0, 7.0)) == (1.0, 2.0, 7.0)


@pytest.mark.parametrize("system", list(core.CATALOGUE))
def test_every_system_can_be_chosen_and_shows_its_picture(explorer, system):
    explorer.scene.system = system
    explorer.settle(60)
    laws = core.CATALOGUE[system]
    portrait = explorer.portrait
    assert explorer.trouble.object == ""
    assert len(portrait.orbits.data["xs"]) == len(explorer.scene.used) > 0
    assert all(np.isfinite(x).sum() > 20 for x in portrait.orbits.data["xs"])
    assert list(portrait.starts.data["x"]) == [laws.x0[0]]
    assert (len(portrait.surface.data["x"]) > 1) == (system != "gene_switch")
    assert (len(portrait.arrows[1].data["x"]) > 0) == (laws.dimension == 2)
    assert explorer.conserved_pane.visible == bool(laws.psi_minus)
    assert explorer.conserved_pane.visible or "no conserved quantity" in explorer.conserved_note.object
    assert (portrait.figure.xaxis[0].axis_label == laws.variables[0]) == (laws.dimension == 2)


def test_a_system_without_conserved_quantities_offers_what_can_be_used(explorer):
    explorer.scene.system = "relay_feedback"
    explorer.settle(20)
    assert explorer.sidebar.methods.options == ["rk2", "rk4", "rk8", "taylor"]
    assert explorer.sidebar.methods.value == ["rk2"]
    assert "keep conserved quantities" in explorer.sidebar.methods_note.object
    explorer.scene.system = "elliptic_curve"
    assert explorer.sidebar.methods.options == list(core.METHODS)
    assert explorer.sidebar.methods.value == ["dmm2", "rk2"]
    assert explorer.sidebar.methods_note.object == ""


def test_the_tolerance_is_shown_with_an_integrator_that_has_one(explorer):
    field = explorer.sidebar.tolerance
    assert not field.text.visible
    explorer.sidebar.methods.value = ["dmm2", "taylor"]
    assert field.text.visible
    assert field.slider.visible
    field.slider.value = -9.0
    assert explorer.scene.tolerance == 1e-9
    explorer.sidebar.methods.value = ["dmm2"]
    assert not field.slider.visible


def test_a_study_of_few_crossings_says_so(explorer):
    explorer.scene.param.update(system="coulomb_friction", view="order")
    explorer.settle(20)
    words = explorer.studies["order"].words.object
    assert "after 1 crossing, slope" in words
    assert "ends too early" in words


def test_a_study_that_is_impossible_says_why(explorer):
    explorer.scene.accept("x0", (1.4, -1.4))  # runs off to infinity
    explorer.scene.view = "order"
    explorer.settle(20)
    assert 'class="error"' in explorer.studies["order"].words.object
    assert not explorer.studies["order"].busy


def test_one_integrator_that_blows_up_does_not_spoil_the_view_of_another(explorer):
    explorer.scene.param.update(system="harmonic_oscillator", tau=0.25, t_end=60_000.0)
    explorer.settle(20)
    assert "stopped" in explorer.status.object
    frame = explorer.portrait.frame
    assert max(frame.width, frame.height) < 10
    for x in explorer.portrait.orbits.data["xs"]:
        assert np.nanmax(np.abs(x)) < 100
    assert len(explorer.portrait.orbits.data["xs"][1]) > 100


def test_a_run_that_stops_early_says_why_and_shows_what_there_is(explorer):
    explorer.scene.accept("x0", (1.4, 1.4))
    explorer.settle(20)
    assert "stopped" in explorer.status.object
    frame = explorer.portrait.frame
    assert max(frame.width, frame.height) < 100
