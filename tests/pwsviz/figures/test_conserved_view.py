"""The plot of the conserved quantity draws what the arrays say, within what its axis can show."""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import core
from pwsviz.figures.conserved import FLOOR, NOWHERE, ConservedView, drawable
from pwsviz.figures.conserved_text import CEILING, MOST_BANDS, conserved_text, largest_of_each, meaning
from pwsviz.figures.marks import KIND_COLOURS, KIND_MARKERS
from pwsviz.geometry.numbers import MACHINE_EPSILON
from pwsviz.geometry.plane import XY
from pwsviz.results.animation import landmarks
from pwsviz.results.error_curve import ErrorCurve
from pwsviz.results.requests import run_inputs
from pwsviz.results.results import Results
from pwsviz.scene.scene import Scene


@cache
def computed(methods=("dmm2", "rk2"), **settings):
    results, scene = Results(), Scene(methods=list(methods), **settings)
    inputs = run_inputs(scene)
    return results.error_curves(inputs), results.run(inputs[0])


def shown(with_landmarks=True, **settings):
    view, (curves, run) = ConservedView(), computed(**settings)
    view.show(curves, landmarks(run, XY) if with_landmarks else None)
    return view, curves, run


def curve(error, method="dmm2", t_end=20.0, size=1.0, runs_off=False):
    error, t = np.asarray(error, dtype=float), np.linspace(0, t_end, len(error))
    size = np.broadcast_to(size, t.shape)
    keeps = core.METHODS[method].conservative
    level = np.asarray(size)
    return ErrorCurve(
        method, t, error, t_end, np.empty(0), np.array([-1]), psi_size=level, runs_off=runs_off, keeps=keeps,
        steps=1000,
    )  # fmt: skip


def test_zero_is_drawn_at_the_floor_and_overflow_not_at_all():
    drawn = drawable(np.array([0.0, 1e-10, 1e250, np.nan]))
    assert list(drawn[:3]) == [FLOOR, 1e-10, CEILING], "the curve leaves through the upper end of the axis"
    assert np.isnan(drawn[3:]).all()
    assert np.isnan(drawable(np.array([1e250, 1.0]))[1])


@pytest.mark.parametrize("side", [-1, 1])
def test_bands_are_the_visits_to_a_side(side):
    view, _, run = shown()
    middles = (np.array(view.segments[side].data["start"]) + np.array(view.segments[side].data["end"])) / 2
    assert len(middles) == np.sum(run.crossings.side == side) + (run.side[0] == side)
    assert all(run.side[np.searchsorted(run.t, t) - 1] == side for t in middles)
    assert view.entries[side].visible


def test_bands_of_both_sides_cover_the_run_once():
    view, _, run = shown()
    lengths = [np.subtract(source.data["end"], source.data["start"]).sum() for source in view.segments.values()]
    assert sum(lengths) == pytest.approx(run.t[-1])


def test_sides_are_those_of_the_run_where_it_comes_back_to_the_same():
    view, _, _ = shown(system="bouncing_ball")
    assert len(view.segments[-1].data["start"]) == 0, "the ball is never below the ground"
    assert not view.entries[-1].visible, "nor does the legend name it"
    assert len(view.segments[1].data["start"]) == 1, "where it bounces it stays on its side"
    assert len(view.instants.data["t"]) > 10


def test_a_run_with_very_many_crossings_has_no_bands():
    view, _, _ = shown(t_end=2000.0, tau=0.05)
    assert all(len(source.data["start"]) == 0 for source in view.segments.values())
    assert len(view.instants.data["t"]) == 0
    assert "are too dense to mark; the sides are not shaded." in view.figure.html_attributes["aria-description"]


@pytest.mark.parametrize(("system", "kind"), [("elliptic_curve", "transversal"), ("bouncing_ball", "jump")])
def test_ticks_tell_number_time_kind_and_integrator(system, kind):
    view, _, run = shown(system=system)
    ticks = view.instants.data
    assert np.array_equal(ticks["t"], run.crossings.t)
    assert list(ticks["number"]) == list(range(1, len(run.crossings) + 1))
    assert set(ticks["method"]) == {"dmm2"}
    assert (ticks["kind"][0], ticks["marker"][0], ticks["colour"][0]) == (kind, KIND_MARKERS[kind], KIND_COLOURS[kind])


def test_ticks_know_their_place_in_the_portrait():
    view, _, run = shown()
    assert np.array_equal(np.column_stack([view.instants.data["x"], view.instants.data["y"]]), run.crossings.x)


def test_without_landmarks_ticks_are_there_but_know_no_place():
    view, _, run = shown(with_landmarks=False)
    assert np.array_equal(view.instants.data["t"], run.crossings.t)
    assert np.isnan(view.instants.data["x"]).all()
    assert set(view.instants.data["kind"]) == {"crossing"}


def test_round_off_is_marked_and_machine_epsilon_where_it_can_be_told_from_it():
    view, (curves, run) = ConservedView(), computed()
    near = 2 * MACHINE_EPSILON
    for level, marked in ((1e-12, 1e-12), (near, near), (FLOOR / 2, NOWHERE), (0.0, NOWHERE)):
        size = np.full(len(curves[0].t), level / (2 * MACHINE_EPSILON))
        view.show([replace(curves[0], psi_size=size)], landmarks(run, XY))
        assert view.levels.ticker.ticks == pytest.approx(
            [NOWHERE if marked == near else MACHINE_EPSILON, FLOOR, marked]
        )
        assert len(view.round_off.data["t"]) == 0


def test_round_off_that_grows_with_psi_is_a_curve_and_what_stays_below_it_is_round_off():
    settings = {"starts": ((1.5, 2.0),), "t_end": 5.0}
    view, curves, run = shown(**settings)
    assert run.status is core.Status.ESCAPED
    assert curves[0].error[-1] > 1e-7
    assert re.fullmatch(
        r"dmm2 conserves ψ to round-off up to t = \S+, where the run stops: max \|Δψ\| = [\d.×]*10⁻. "
        r"\(relative: (below )?[\d.×]*10⁻¹.\)\. “Relative”: divided by .*\.",
        conserved_text(curves[:1]),
    )
    drawn = view.round_off.data
    assert np.array_equal(drawn["t"], curves[0].t)
    assert drawn["y"][0] < 1e-14 < 1e-7 < drawn["y"][-1]
    assert (curves[0].error <= drawn["y"]).all()
    assert view.levels.ticker.ticks[-1] == drawn["y"][-1]
    assert not view.levels.spans[-1].visible, "no line at the level of the end"
    view.show(computed()[0])
    assert view.levels.spans[-1].visible


def test_an_early_drift_is_no_round_off_though_psi_grows_large_later():
    sizes = np.array([1.0, 1.0, 1e9])
    assert conserved_text([curve([0.0, 1e-8, 1e-8], size=sizes, runs_off=True)]) == (
        "dmm2: max |Δψ| = 10⁻⁸ up to t = 20, where the run stops."
    )


def test_screen_readers_hear_the_same_sentence():
    view, curves, _ = shown()
    said = view.figure.html_attributes
    assert said["role"] == "application"
    assert conserved_text(curves) in said["aria-description"]


def test_a_caption_speaks_of_what_is_met_and_only_where_something_is():
    quiet, once = curve([0.0, 1e-16]), replace(curve([0.0, 1e-16]), crossings=np.array([3.0]), sides=np.array([1, 1]))
    assert "makes at jumps" in meaning([once], "jumps")
    assert "Marks near the lower edge are the times at which the run meets a surface." in meaning([once], "jumps")
    assert "jumps" not in meaning([quiet], "jumps")


def test_the_sentence_tells_round_off_from_drift():
    drifting = curve(np.linspace(0, 6.4e-7, 300), "rk2")
    noise = curve(1e-16 * np.arange(9))
    words = "dmm2 conserves ψ to round-off: max |Δψ| = 8×10⁻¹⁶; rk2 drifts: max |Δψ| = 6.4×10⁻⁷ up to t = 20."
    words += " Any shading refers to dmm2."
    assert conserved_text([noise, drifting]) == words


@pytest.mark.parametrize("errors", [1e-16 * np.arange(9), np.full(9, 2e-15), 1e-16 * np.arange(30)])
@pytest.mark.parametrize("method", ["rk2", "rk8", "gauss4"])
def test_only_methods_that_conserve_psi_are_said_to_do_so_however_small_the_error(method, errors):
    words = conserved_text([curve(errors, method)])
    assert ("conserves" in words) == core.METHODS[method].conservative
    assert "conserves ψ to" in conserved_text([curve(errors, "dmm2")])


@pytest.mark.parametrize(("last", "kind"), [(3e-16, "round-off"), (3.2e-15, "round-off")], ids=["of ψ", "of the steps"])
def test_an_error_of_round_off_size_is_said_to_be_so_of_any_method_even_where_it_rises(last, kind):
    errors, most = last * np.linspace(0, 1, 4), {3e-16: "3×10⁻¹⁶", 3.2e-15: "3.2×10⁻¹⁵"}[last]
    for method, does in (("rk8", "stays at the level of"), ("dmm2", "conserves ψ to")):
        assert conserved_text([curve(errors, method)]).startswith(f"{method} {does} {kind}: max |Δψ| = {most}.")


def test_round_off_adds_up_over_the_steps_that_there_are():
    few, many = (replace(curve([0.0, 4e-15, 4e-15], "rk8"), steps=steps) for steps in (100, 1000))
    assert conserved_text([few]) == "rk8 drifts: max |Δψ| = 4×10⁻¹⁵ up to t = 20."
    assert "level of round-off" in conserved_text([many])


def test_eps_is_not_named_where_its_name_would_overlap_that_of_the_lowest_level():
    view = ConservedView()
    for largest, named in ((1e-3, True), (1e8, False)):
        view.show([curve([0.0, largest], "rk2", size=1e5)])
        assert (view.levels.ticker.ticks[0] == MACHINE_EPSILON) == named
        assert view.levels.ticker.ticks[1] == FLOOR


def test_a_sentence_says_whose_marks_are_shown_only_where_there_are_some():
    many = replace(curve([0.0, 1e-16]), crossings=np.linspace(0, 20, MOST_BANDS + 1), sides=np.ones(MOST_BANDS + 2))
    met = replace(curve([0.0, 1e-16]), crossings=np.array([1.0]), sides=np.ones(2))
    whose, none = "Marks at surfaces and any shading refer to dmm2.", "crossings of dmm2 are too dense to mark"
    assert "Any shading refers to dmm2." in conserved_text([curve([0.0, 1e-16]), curve([0.0, 1e-7], "rk2")])
    for first, said, unsaid in ((met, whose, none), (many, none, whose)):
        words = conserved_text([first, curve([0.0, 1e-7], "rk2")])
        assert said in words
        assert unsaid not in words


def test_what_is_round_off_depends_on_the_size_of_psi():
    def words(errors, size):
        said, *what = conserved_text([curve(errors, size=size)]).split(" “Relative”: divided by ")
        assert bool(what) == ("relative:" in said)
        return said

    large, small = 4e-8 * np.arange(9), 1e-16 * np.arange(9)
    assert words(large, 1e9) == "dmm2 conserves ψ to round-off: max |Δψ| = 3.2×10⁻⁷ (relative: 3.2×10⁻¹⁶)."
    assert words(large / 1e8, 30.0).endswith("(relative: 1.1×10⁻¹⁶).")
    assert words([0.0, 7.5e-16], 13.4).endswith("= 7.5×10⁻¹⁶ (relative: 5.6×10⁻¹⁷).")
    assert words(large, 1.0) == "dmm2 drifts: max |Δψ| = 3.2×10⁻⁷ up to t = 20."
    told = "max |Δψ| = 8×10⁻¹⁶ (relative: 8×10⁻⁷) up to t = 20."
    assert words(small, 1e-9) == f"dmm2 drifts: {told}"


def test_no_bound_is_praised_where_less_than_a_digit_of_psi_is_right():
    lost = curve([0.0, 2.7e5, 2.7e5, 2.6e5], "rk2", size=6.5e5)
    assert conserved_text([lost]) == (
        "rk2 does not conserve ψ: max |Δψ| = 2.7×10⁵ (relative: 0.42). "
        "“Relative”: divided by the largest |ψ| + Σ |xᵢ ∂ψ/∂xᵢ| of the run."
    )


def test_a_method_that_destroys_psi_at_once_is_not_said_to_show_no_drift():
    """rk4 passes the centre of attraction too fast, and throws a bound planet out: ψ stays where it jumped to."""
    (thrown, *_), _ = computed(system="kepler", starts=((1.2, 0.0, 0.0, 0.2),), methods=("rk4",), tau=0.05, t_end=40.0)
    assert thrown.error[-1] > 100.0 * abs(thrown.psi_size[0])
    assert conserved_text([thrown]).startswith("rk4 does not conserve ψ: max |Δψ| = 690")
    assert "elative" not in conserved_text([thrown]), "the size of ψ’s terms is that of the error"


def test_a_drift_is_rounded_to_the_nearest_and_goes_to_the_end_of_the_run():
    drifting = replace(curve(np.linspace(0, 2.02e-8, 300), "rk4", t_end=99.92), t_end=100.0)
    assert conserved_text([drifting]) == "rk4 drifts: max |Δψ| = 2×10⁻⁸ up to t = 100."
    stops = replace(drifting, crossings=np.array([60.0]), sides=np.array([-1, 0]))
    assert conserved_text([stops]).startswith("rk4 drifts: max |Δψ| = 1.2×10⁻⁸ up to t = 60; rk4 changes g by")


def test_an_error_that_comes_and_goes_is_no_drift():
    waves = curve(1e-3 * np.sin(np.linspace(0, 60, 1000)) ** 2, "rk4")
    assert conserved_text([waves]) == "rk4 shows no visible drift up to t = 20: max |Δψ| = 10⁻³."


def test_a_caption_tells_how_large_the_error_of_each_integrator_becomes():
    curves = [curve(np.array([0.0, 2e-16, 1e-16])), curve(np.array([0.0, 3.14e-4, 1e-4]), "rk2")]
    assert largest_of_each(curves) == "Largest |Δψ|: 2×10⁻¹⁶ for dmm2 and 3.1×10⁻⁴ for rk2."
    assert largest_of_each([curve(np.array([0.0, np.inf]), "rk4")]) == "Largest |Δψ|: unbounded for rk4."
    assert largest_of_each([curve(np.full(3, np.nan))]) == "", "no ψ is known"


def test_a_drift_that_an_oscillation_hides_is_not_denied():
    """By rk2 ψ of a spring with a kink, and with a cubic force, drifts in proportion to time, by 10⁻⁶ in a unit."""
    springs = core.PiecewiseSystem(
        name="Springs", variables=("q", "p"), g="q - 0.3", parameters={"k": 2.0, "s": 0.5}, x0=(-1.0, 0.0),
        f_minus=("p", "-k*q**3"), psi_minus=("p**2/2 + k*q**4/4",),
        f_plus=("p", "-k*q**3 - s*(q - 0.3)"), psi_plus=("p**2/2 + k*q**4/4 + s*(q - 0.3)**2/2",),
    )  # fmt: skip
    told = []
    for t_end in (10.0, 20.0, 200.0):
        scene = Scene(methods=["rk2"])
        scene.use(springs)
        scene.accept_times(0.01, t_end)
        told.append(conserved_text(Results().error_curves(run_inputs(scene))))
    assert told[0].startswith("rk2: max |Δψ| =")
    assert told[1] == "rk2: max |Δψ| = 1.7×10⁻⁵ up to t = 20."
    assert told[2] == "rk2 drifts: max |Δψ| = 2.1×10⁻⁴ up to t = 200."


@pytest.mark.parametrize("rise", [0.3, 0.5, 0.9])
def test_of_an_error_that_rises_it_is_not_said_that_it_stays(rise):
    rising = curve(1e-3 * np.linspace(0, 1, 1000) ** rise, "rk4")
    assert conserved_text([rising]) in (f"rk4{word}: max |Δψ| = 10⁻³ up to t = 20." for word in ("", " drifts"))


def test_an_error_beyond_the_axis_is_marked_where_it_leaves_with_its_size():
    gone = curve([0.0, 1e-3, 1.0, 4.5e16, 1.0], "rk2", t_end=4.0)
    assert conserved_text([gone]) == "rk2 leaves the plot at t = 3: max |Δψ| = 4.5×10¹⁶."
    view = ConservedView()
    view.show([gone])
    assert (view.exits.data["t"], view.exits.data["y"]) == ([3.0], [CEILING])
    assert view.exits.data["words"] == ["rk2 leaves the plot: max |Δψ| = 4.5×10¹⁶"]
    assert view.curves.data["ys"][0][2] == CEILING
    assert view.corners.data["y"][1] >= CEILING
    endless = curve([0.0, 1.0, np.inf], t_end=2.0)
    assert conserved_text([endless]) == "dmm2 leaves the plot at t = 2: the numerical solution blows up."


def test_no_error_at_all_is_said_so():
    assert conserved_text([curve([0.0, 0.0, 0.0])]) == "dmm2 conserves ψ exactly."


def test_of_several_runs_that_slide_each_is_named():
    slides = [replace(curve([0.0, 0.0, 0.0], name), sides=np.zeros(1, dtype=int)) for name in ("dmm2", "rk2")]
    words = conserved_text(slides)
    assert words.startswith("dmm2 keeps g exactly while it slides; rk2 keeps g exactly while it slides.")


def test_where_no_conserved_quantity_is_known_nothing_is_said():
    assert conserved_text([curve([np.nan, np.nan])]) == ""


@pytest.mark.parametrize("order", [1, 2])
def test_a_change_of_psi_by_perturbed_crossings_is_not_blamed_on_a_method_that_keeps_psi_between_them(order):
    settings = {"system": "harmonic_oscillator", "methods": ("dmm2", "gauss4", "rk2"), "perturbation_order": order}
    curves, run = computed(**settings)
    assert np.abs(run.exit_error()).max() < 1e-14 < 1e-8 < curves[0].error.max()
    words = conserved_text(curves)
    for name in ("dmm2", "gauss4"):
        assert (
            f"{name} conserves ψ to round-off between crossings, but crossings off the surface change it: max |Δψ|"
            in words
        )
    assert re.search(r"rk2 drifts: max .*; between two crossings ψ changes by at most .*, and crossings off", words)
    unperturbed = conserved_text(computed(**settings | {"perturbation_order": None})[0])
    assert "off the surface" not in unperturbed
    assert "gauss4 conserves ψ to round-off: max |Δψ| =" in unperturbed, "it keeps every quadratic ψ"


def test_a_change_of_psi_where_crossings_are_not_located_is_not_blamed_on_the_method():
    words = conserved_text(computed(system="elliptic_curve", methods=("dmm2",), tau=0.08, locate=False)[0])
    assert "dmm2 conserves ψ to round-off between crossings, but crossings off the surface change it" in words


@pytest.mark.parametrize("settings", [{"perturbation_order": 1}, {"locate": False}])
def test_of_jumps_off_the_surface_it_is_said_that_they_lie_there_and_count_for_nothing(settings):
    curves, _ = computed(system="two_walls", methods=("dmm2",), **settings)
    assert "conserves ψ to round-off between jumps, which lie off the surface" in conserved_text(curves)
    assert "the change of ψ that this causes is not counted at jumps" in meaning(curves, "jumps")


def test_gauss4_is_said_to_conserve_only_what_it_keeps():
    (curve, *_), _ = computed(system="elliptic_curve", methods=("gauss4",))
    assert not curve.keeps
    assert "gauss4 shows no visible drift" in conserved_text([curve])
