"""Captions tell what is drawn, and why something is not."""

import pytest

from pwsviz.export.caption import caption
from pwsviz.figures.order import lower_end, studied, time_rows
from pwsviz.page.pieces import symbols_text


def told_of(explorer, **settings):
    """Return the captions of the portrait and of the view, in full."""
    explorer.scene.load(settings)
    assert explorer.settle(60)
    return [f"{caption(explorer.scene, one.title, **one.origin)} {one.meaning}".strip() for one in explorer._pieces()]


@pytest.mark.parametrize(("system", "slides"), [("harmonic_oscillator", False), ("stick_slip", True)])
def test_captions_speak_of_sliding_where_a_run_slides(explorer, system, slides):
    explorer.scene.load({"system": system, "methods": ["rk2"], "view": "state"})
    explorer.settle(60)
    for piece in explorer._pieces():
        told = caption(explorer.scene, piece.title, **piece.origin)
        assert ("sliding solution is followed" in told) == slides


def test_the_caption_of_the_drift_says_which_psi_is_shown_and_that_what_perturbed_crossings_change_is_counted(explorer):
    for settings, told in (
        (
            {"system": "rigid_body", "methods": ["dmm2"]},
            "The larger |Δψ| of the two conserved quantities is drawn at each time.",
        ),
        ({"perturbation_order": 1}, "Crossings lie off the surface here"),
    ):
        explorer.scene.load({**settings, "view": "conserved"})
        assert explorer.settle(60)
        assert told in explorer._pieces()[1].meaning


def test_a_caption_does_not_say_that_all_crossings_are_marked_of_which_the_legend_says_some(explorer):
    for methods, whose in ((["dmm2", "rk2"], 1), (["rk2"], 0)):
        portrait, _ = told_of(explorer, methods=methods, view="state")
        assert portrait.count("The marks of crossings belong to all integrators.") == whose
        assert "are marked" not in portrait


@pytest.mark.parametrize(
    ("system", "joined"),
    [("vibrating_table", True), ("bouncing_ball", False), ("henon_heiles", False), ("elliptic_curve", False)],
)
def test_lines_of_jumps_are_told_of_where_jumps_move_what_is_drawn(explorer, system, joined):
    portrait, _ = told_of(explorer, system=system, view="state")
    assert ("Dash-dotted lines join the states before and after jumps." in portrait) == joined


def test_a_projection_says_what_it_leaves_out_and_nothing_of_controls(explorer):
    portrait, _ = told_of(explorer, system="gene_ring", view="state")
    assert "Projection onto the plane of x, y, in which the field and the surface z − θ = 0" in portrait
    assert "selects" not in portrait


def test_a_section_that_ends_early_says_when_and_a_single_start_has_no_number(explorer):
    _, section = told_of(explorer, system="two_walls", view="section")
    assert ". 348 points on all surfaces, " in section
    assert "The run has ended with 348 points by t = 1036.3" in section
    assert "The encircled number marks the first point." in section


def test_successful_step_sizes_are_explained_where_they_are_drawn(explorer):
    _, without = told_of(explorer, system="stick_slip", view="stability")
    assert "is successful if" not in without
    _, drawn = told_of(explorer, system="elliptic_curve", view="stability", methods=["dmm2"])
    assert "ends as it does and, for a conservative integrator, |Δψ| is at most" in drawn
    assert "crossings and the end of the reference, with |Δψ|" in explorer.view.key(explorer.view.outcome)
    assert len(explorer.view.key(explorer.view.outcome)) < 180, "two lines of a picture of 85 mm"
    assert drawn.count("The diamond is for ") == 1
    assert "refers only to runs from the chosen start" not in drawn, "that is told by the first sentence"


def test_an_order_study_counts_jumps_and_tells_of_errors_that_are_zero(explorer):
    _, order = told_of(explorer, system="vibrating_table", view="order", methods=["dmm2"])
    assert "; jumps count as crossings." in order
    assert "The errors before the first crossing are 0 and are not drawn." in order


def test_captions_say_what_dots_on_curves_are_and_how_errors_of_0_are_drawn(explorer):
    dots = "Small dots are the ends of steps, between which the integrators interpolate."
    for tau in (0.01, 0.2, 0.8):
        told = told_of(explorer, view="state", methods=["rk4"], tau=tau)
        curve, portrait = explorer.view.outcome.curves[0], explorer.portrait_panel.portrait
        marked = [len(portrait.steps.data["x"]) > 0, len(curve.steps[0]) > 0]
        assert [dots in one for one in told] == marked
        assert marked == [True, True] or tau < 0.8
    _, times = told_of(explorer, system="stick_slip", view="time", methods=["rk4"])
    (study,) = explorer.view.outcome
    low = "Errors of 0 or below the plot’s range are drawn as downward triangles" in times
    assert low == bool((study.time_error < lower_end(studied([study], time_rows))).any())


def test_symbols_of_integrators_that_are_dots_are_told_from_the_ends_of_steps():
    assert symbols_text(["dmm2", "rk2"], True) == (
        "Other symbols on a curve, larger dots among them, tell its integrator."
    )
    for methods, steps in ((["dmm2", "rk2"], False), (["rk2", "rk4"], True)):
        assert symbols_text(methods, steps) == "Other symbols on a curve tell its integrator."
    assert symbols_text(["dmm2"], True) == ""


@pytest.mark.parametrize(("system", "drawn"), [("elliptic_curve", True), ("relay_feedback", False)])
def test_the_line_of_round_off_is_told_of_where_it_is_drawn(explorer, system, drawn):
    _, told = told_of(explorer, system=system, methods=["rk2"], view="conserved")
    assert explorer.view.view.draws_round_off == drawn
    assert ("round-off line" in told) == drawn


def test_where_crossings_are_not_located_the_words_on_psi_say_so(explorer):
    for locate in (True, False):
        explorer.scene.load({"methods": ["dmm2"], "view": "conserved", "locate": locate})
        assert explorer.settle(60)
        assert ("Crossings are not located" in explorer.views["conserved"].words.object) is not locate


def test_where_nothing_but_jumps_is_met_they_are_compared_by_their_name_and_do_not_count_as_crossings(explorer):
    for system in ("bouncing_ball", "coulomb_friction"):
        _, drawn = told_of(explorer, system=system, view="stability", methods=["dmm2"])
        assert "Jumps count as crossings." not in drawn
        assert ("crossing" in drawn) == (system == "coulomb_friction")
        told_of(explorer, system=system, view="cost", methods=["dmm2"])
        assert "Jumps count as crossings." not in explorer.view.words.object
        assert ("crossing" in explorer.view.words.object) == (system == "coulomb_friction")
