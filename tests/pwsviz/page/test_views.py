"""The views beside the portrait: made when looked at, computed when wanted, and spoken of in words."""

import re

import numpy as np
import pytest
from bokeh.models import LegendItem

import core
from pwsviz.export.script import snippet
from pwsviz.scene.views import VIEWS
from tests.levels import deep_but
from tests.pwsviz.own_systems import KICKED


def counts(explorer):
    return dict(explorer.results.computed)


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
    assert explorer.settle(60)
    assert "Computing" not in view.words.object
    explorer.scene.accept("system", "coulomb_friction")
    explorer.refresh()
    assert view.mathematics.object == ""
    assert "Computing …" in view.words.object
    assert explorer.settle(60)
    assert view.mathematics.object
    assert "Computing" not in view.words.object


@pytest.mark.parametrize(
    "view", deep_but(["order", "conserved"], ["order", "time", "cost", "section", "stability", "sweep", "conserved"])
)
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
    explorer.settle(60)
    explorer.scene.accept("tau", 5e-3)
    explorer.settle(60)
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
    assert explorer.settle(60)
    assert explorer.views["stability"].outcome is None
    explorer.scene.param.update(t_end=2.0, methods=["dmm2"], stability_part="drift")
    explorer.scene.view = "stability"
    assert explorer.settle(60)
    assert explorer.views["stability"].outcome is not None


def test_a_long_study_can_be_cancelled_and_begun_again(explorer):
    explorer.scene.param.update(peers=[], t_end=5.0)
    explorer.scene.view = "cost"
    view = explorer.views["cost"]
    view.progress.begin()
    view.on_cancel()
    assert explorer.settle(60)
    assert view.outcome is None
    assert view.progress._again.visible
    assert explorer.announcer.view[0] == "Cost: cancelled."
    view.on_again()
    assert explorer.settle(60)
    assert view.outcome is not None
    assert explorer.announcer.view[0].startswith("Cost: finished.")
    assert not view.progress.busy


def test_the_order_says_when_states_are_compared_and_what_it_counts(explorer):
    explorer.scene.load({"system": "stick_slip", "methods": ["rk2"], "view": "order"})
    assert explorer.settle(60)
    last = explorer.view.outcome[0].times[-1]
    told = explorer.view.about.markup
    assert last > explorer.scene.t_end
    assert f" and {last:.4g}, halfway from crossings 10, 20 and 30 to the next (“after”)" in told
    assert "The end time has no effect here." in explorer.view.words.object
    assert "page" not in explorer.view.how(explorer.view.outcome)
    assert "the beginning and the end of sliding count as crossings" in told
    assert "Euclidean distance" in explorer.view.how(explorer.view.outcome)


def test_where_no_step_is_made_the_view_says_why(explorer):
    explorer.scene.load({"system": "type_repelling", "starts": ((0.0, 0.0),), "view": "conserved"})
    explorer.settle(60)
    assert "No step was made" in explorer.view.words.object
    assert not explorer.view.plots[0].visible
    explorer.scene.load({"view": "conserved"})
    explorer.settle(60)
    assert explorer.view.plots[0].visible, "the figure comes back with the next run"
    assert explorer.view.plots[0].object.visible


def test_sliding_is_drawn_apart_and_named_also_where_no_psi_is_known(explorer):
    explorer.scene.load({"system": "coulomb_friction", "view": "conserved"})
    explorer.settle(60)
    view = explorer.view.view
    assert view.figure.yaxis[0].axis_label == "error of ψ, |Δψ|; of g while sliding, |Δg|"
    for xs, ys, curve in zip(view.curves.data["xs"], view.curves.data["ys"], explorer.view.outcome.curves, strict=True):
        changes = np.count_nonzero(np.diff(curve.sliding[1:]))
        assert changes
        assert len(xs) == len(ys) == len(curve.t) - 1 + changes
    assert "round-off line is 2⁻⁵¹ times the largest |ψ| + Σ" in explorer._pieces()[1].meaning
    explorer.scene.load({"system": "stick_slip", "view": "conserved"})
    explorer.scene.view = "conserved"
    explorer.settle(60)
    assert explorer.view.plots[0].visible
    assert view.figure.yaxis[0].axis_label == "error of g while sliding, |Δg|"
    assert ">|Δg|</span> while sliding" in explorer.view.words.object


def test_no_figure_of_another_system_stays_where_a_study_is_refused(explorer):
    explorer.scene.view = "order"
    assert explorer.settle(60)
    assert all(pane.styles["visibility"] == "inherit" for pane in explorer.view.plots)
    explorer.scene.load({"system": "type_repelling", "view": "time"})  # which does not cross
    assert explorer.settle(60)
    assert "so there is no crossing time to study" in explorer.view.words.object
    assert all(pane.styles["visibility"] == "hidden" for pane in explorer.view.plots)
    assert not any(pane.visible for pane in explorer.view.plots), "the reason stands where the figure would"
    explorer.scene.accept("system", "pendulum")
    assert explorer.settle(60)
    assert all(pane.visible and pane.styles["visibility"] == "inherit" for pane in explorer.view.plots)


def test_where_all_errors_are_0_the_order_has_words_and_no_empty_figure(explorer):
    explorer.scene.load({"system": "bouncing_ball", "methods": ["dmm2"], "view": "time"})
    assert explorer.settle(60)
    assert "dmm2 is exact to round-off for every τ: no error to draw." in explorer.view.words.object
    assert explorer._pieces()[1].figures == []
    explorer.scene.accept("system", "elliptic_curve")
    assert explorer.settle(60)
    assert len(explorer._pieces()[1].figures) == 1


def test_where_all_errors_are_round_off_the_order_tells_of_nothing_that_is_not_painted(explorer):
    explorer.scene.load({"system": "bouncing_ball", "methods": ["dmm2"], "view": "order"})
    assert explorer.settle(60)
    assert "dmm2 is exact to round-off here: no slope to fit." in explorer.view.words.object
    told = explorer.view.how(explorer.view.outcome)
    assert "compared with the exact solution (linear flow) before" in told
    assert ("downward triangles" in told) == ("inverted_triangle" in explorer.view.view.points.data["marker"])
    assert "The errors before the first crossing are 0 and are not drawn" in told


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        (
            {"methods": ["dmm2", "rk2"]},
            ["As in the figure, dmm2 only; there, “all chosen integrators” adds the others."],
        ),
        ({"methods": ["dmm2", "rk2"], "order_all": True}, []),
        ({"methods": ["dmm2"]}, []),
    ],
)
def test_the_dialog_of_the_export_says_that_one_of_several_integrators_is_saved(explorer, settings, told):
    explorer.scene.load({"view": "order", **settings})
    assert explorer.settle(60)
    row = explorer.export._row(explorer._pieces()[1])
    words = [getattr(part, "object", "") for part in row]
    assert [one for one in words if "only" in one] == told


def test_a_study_of_few_crossings_says_so(explorer):
    explorer.scene.param.update(system="coulomb_friction", view="order")
    explorer.settle(60)
    words = explorer.views["order"].words.object
    assert "before the first crossing and after 1, 2 and 3 crossings" in words
    assert "too few crossings for the usual ones" in words


def test_a_study_of_one_crossing_ends_with_the_runs_and_says_so(explorer):
    explorer.scene.param.update(system="type_upward", view="order")
    assert explorer.settle(60)
    view, end = explorer.view, f"{explorer.scene.t_end:.4g}"
    assert "before the first crossing and after 1 crossing" in view.words.object
    assert f"The last states are compared at t = {end}." in view.words.object
    assert f"at t = {end}, after the only crossing up to then" in view._times(view.outcome)
    assert "The end time has no effect" not in view.words.object
    explorer.scene.param.update(view="time")
    assert explorer.settle(60)
    assert "for crossing 1 of runs to t" in explorer.view._times(explorer.view.outcome)
    explorer.scene.param.update(system="type_repelling", view="order")
    assert explorer.settle(60)
    assert "up to which there is no crossing" in explorer.view._times(explorer.view.outcome)


def test_a_study_that_is_impossible_says_why(explorer):
    explorer.scene.use(core.PiecewiseSystem("Held", ("x", "y"), ("1", "0"), ("-1", "0"), "x", x0=(0.0, 1.0)))
    explorer.scene.param.update(slide=False, view="order")
    explorer.settle(60)
    assert 'class="error"' in explorer.views["order"].words.object
    assert not explorer.views["order"].progress.busy


def test_one_integrator_that_blows_up_does_not_spoil_the_view_of_another(explorer):
    explorer.scene.param.update(system="harmonic_oscillator", tau=0.25, t_end=60_000.0)
    explorer.settle(60)
    assert "stopped" in explorer.portrait_panel.status.object
    frame = explorer.portrait_panel.portrait.frame
    assert max(frame.width, frame.height) < 10
    for x in explorer.portrait_panel.portrait.orbits.data["xs"]:
        assert np.nanmax(np.abs(x)) < 100
    assert len(explorer.portrait_panel.portrait.orbits.data["xs"][1]) > 100


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


def test_the_order_says_that_crossing_times_are_perturbed(explorer):
    explorer.scene.load({"view": "order", "perturbation_order": 1, "methods": ["dmm2"]})
    assert explorer.settle(60)
    assert "Crossing times are perturbed by τ." in explorer.view.words.object


@pytest.mark.parametrize(("view", "part"), [("cost", "map"), ("stability", "map"), ("stability", "grazing")])
def test_stability_cost_and_the_program_say_jumps_of_a_system_that_is_kicked_as_the_portrait_does(explorer, view, part):
    scene = explorer.scene
    scene.use(KICKED)
    scene.param.update(t_end=3.5, tau=0.05, peers=[], methods=["rk4"], stability_part=part, view=view)
    assert explorer.settle(120)
    tab = explorer.view
    said = [tab.words.object, tab.details(tab.outcome), tab.how(tab.outcome), tab.meaning(tab.outcome)]
    said += [tab.heading(tab.outcome), str([item.label for one in tab.plots for item in one.object.select(LegendItem)])]
    assert "jump" in " ".join(said)
    assert not re.findall("[^.]*crossing[^.]*", " ".join(said))
    printed = [line for line in snippet(scene, tab.program()).splitlines() if "print" in line or line.startswith("#")]
    assert not [line for line in printed if re.search(r"(?<!\.)\bcrossing", line)]
