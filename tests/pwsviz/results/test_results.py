"""Only what is visible is computed, nothing twice, and the arrays are what they say."""

import numpy as np
import pytest

import core
from pwsviz.geometry.plane import Plane
from pwsviz.geometry.polyline_reduction import RESOLUTION
from pwsviz.geometry.window import Window
from pwsviz.results.orbits import orbit_of
from pwsviz.results.requests import CostInputs, Scheme, StabilityInputs, run_inputs, study_inputs
from pwsviz.results.results import PortraitInputs, Results
from pwsviz.scene.scene import Scene
from pwsviz.tasks.cancellation import Cancelled
from tests.levels import deep_but


@pytest.fixture
def results():
    return Results()


def portrait(scene):
    return PortraitInputs.of(scene)


def test_portrait_alone_draws_no_error_curve(results):
    results.pictures(portrait(Scene()))
    assert results.computed["run"] == 2
    assert results.computed["curve"] == results.computed["study"] == results.computed["backdrop"] == 0


def test_portrait_and_error_share_one_run_for_each_method(results):
    for _ in range(2):
        results.pictures(portrait(Scene()))
        results.error_curves(run_inputs(Scene()))
    assert dict(results.computed) == {"run": 2, "orbit": 2, "error": 2, "curve": 2, "summary": 2, "plane": 1}


def test_one_more_method_costs_one_more_run(results):
    scene = Scene()
    results.pictures(portrait(scene))
    scene.accept("methods", ["dmm2", "rk2", "rk4"])
    results.pictures(portrait(scene))
    assert results.computed["run"] == 3


def test_one_more_trajectory_costs_one_more_run_for_each_integrator(results):
    scene = Scene()
    results.pictures(portrait(scene))
    scene.place((-0.5, 0.25))
    pictures = results.pictures(portrait(scene))
    assert results.computed["run"] == 4
    assert [orbit.start for orbit in pictures.orbits] == [(-0.5, 0.25)] * 2
    assert [orbit.start for orbit in pictures.others] == [(-1.0, -1.0)] * 2
    scene.selected = 0
    results.pictures(portrait(scene))
    assert results.computed["run"] == 4


def test_another_projection_costs_no_run(results):
    scene = Scene(system="kepler", methods=["rk2"])
    flat = results.pictures(portrait(scene)).orbits[0]
    scene.accept("axes", (2, 3))
    tilted = results.pictures(portrait(scene)).orbits[0]
    assert results.computed["run"] == 1
    run = results.run(run_inputs(scene)[0])
    assert np.array_equal(flat.path[0], run.x[0, :2])
    assert np.array_equal(tilted.path[0], run.x[0, 2:])
    assert np.array_equal(tilted.crossings[0], run.crossings.x[0, 2:])


@pytest.mark.parametrize(
    ("inputs", "name"),
    [(CostInputs, "work_precision"), (StabilityInputs, "stability_study")],
    ids=["cost", "stability"],
)
def test_cost_and_stability_step_over_the_surface_where_the_page_does(inputs, name, monkeypatch):
    asked = []
    monkeypatch.setattr(core, name, lambda *_, transition, **__: asked.append(transition))
    for locate in (True, False):
        getattr(Results(), {"work_precision": "cost", "stability_study": "stability"}[name])(
            inputs.of(Scene(locate=locate, stability_part="drift"))
        )
    assert asked == ["mannshardt", "none"]


def test_the_order_study_does_not_depend_on_step_size_and_end_time():
    scene, results = Scene(), Results()
    before = study_inputs(scene)
    scene.param.update(tau=5e-3)
    assert study_inputs(scene) == before
    study = results.study(*before)
    scene.param.update(t_end=3.0)
    assert results.study(*study_inputs(scene)) is study
    scene.accept("x0.0", -0.9)
    assert study_inputs(scene) != before


def test_settings_without_effect_do_not_make_another_run():
    scene = Scene()
    before = run_inputs(scene)
    scene.accept("perturbation_scale", 3.0)
    assert run_inputs(scene) == before
    scene.perturbation_order = 2
    assert run_inputs(scene) != before
    scene.locate = False
    assert run_inputs(scene)[0].scheme == Scheme("dmm2", locate=False)


def test_a_run_given_up_is_not_taken_for_a_result(results):
    inputs = run_inputs(Scene())[0]
    with pytest.raises(Cancelled):
        results.run(inputs, cancel=lambda: True)
    assert results.run(inputs).status is core.Status.COMPLETED


#: In two dimensions and in three, without ψ, with ψ that names time, with jumps, sliding, between walls, with names.
QUICK = (
    "elliptic_curve", "rigid_body", "gene_switch", "damped_oscillator", "bouncing_ball", "coulomb_friction",
    "two_walls", "thermostat",
)  # fmt: skip


@pytest.mark.parametrize("system", deep_but(QUICK, core.CATALOGUE))
@pytest.mark.parametrize("tau", [1e-4, 1e-2])
def test_a_portrait_has_few_vertices_and_its_kinks_on_the_surface(results, system, tau):
    scene = Scene(system=system, tau=tau)
    inputs = run_inputs(scene)[0]
    run, orbit = results.run(inputs), results.orbit(inputs)
    assert len(orbit.path) <= 4000
    pixel = np.ptp(orbit.path[np.isfinite(orbit.path).all(axis=1)], axis=0).max() / RESOLUTION
    for crossing in orbit.crossings:
        a, b = orbit.path[:-1], orbit.path[1:]
        share = ((crossing - a) * (b - a)).sum(axis=1) / np.maximum(((b - a) ** 2).sum(axis=1), 1e-300)
        away = a + share.clip(0.0, 1.0)[:, None] * (b - a) - crossing
        assert np.nanmin(np.linalg.norm(away, axis=1)) <= 3 * pixel
    assert (len(orbit.crossings) > 0) == (len(run.crossings.passed) > 0)
    assert (orbit.end is None) == (run.status is core.Status.COMPLETED)
    met = {tuple(x[:2]): (t, x) for t, x in zip(run.crossings.t, run.crossings.x, strict=True)}
    laws, p = scene.build().laws, scene.build().parameter_array
    for crossing in orbit.crossings:
        t, x = met[tuple(crossing)]
        assert np.abs(laws.evaluate("all surfaces", laws.surfaces, t, x, p)).min() < 1e-12


def test_a_jump_is_a_gap_in_the_path_and_a_line_of_its_own(results):
    inputs = run_inputs(Scene(system="bouncing_ball"))[0]
    run, orbit = results.run(inputs), results.orbit(inputs)
    assert set(orbit.kinds) == {"jump"}
    assert len(orbit.jumps) == 0, "they lead along the surface, which is drawn"
    ends = np.isnan(orbit.path[:, 0]).nonzero()[0]
    assert np.array_equal(orbit.path[ends[0] - 1], run.crossings.x[0])
    assert np.array_equal(orbit.path[ends[0] + 1], run.crossings.x_after[0])
    inputs = run_inputs(Scene(system="vibrating_table"))[0]
    run = results.run(inputs)
    orbit = orbit_of(inputs, run, None, Plane((1, 2)))
    assert np.array_equal(orbit.jumps[0::3], orbit.crossings)
    assert np.array_equal(orbit.jumps[1], run.crossings.x_after[0][1:])


def test_a_run_that_ends_where_it_slides_is_shown_whole(results):
    inputs = run_inputs(Scene(system="coulomb_friction", slide=False))[0]
    run, orbit = results.run(inputs), results.orbit(inputs)
    assert orbit.end.status is core.Status.SLIDING
    assert orbit.end.place == tuple(run.crossings.x[-1])
    assert np.array_equal(orbit.path[[0, -1]], run.x[[0, -1]])
    assert results.summary(inputs).met == (len(run.crossings) - 1, 0, 0, 0), "where it stops it does not cross"


@pytest.mark.parametrize(
    ("system", "start", "settings", "course"),
    [
        ("coulomb_friction", (0.1, 0.0), {}, "at rest on the surface from t = 0 on"),
        ("coulomb_friction", (0.1, 0.0), {"slide": False}, "0 crossings"),
        ("type_sliding", (0.3, 0.0), {}, "slides from t = 0 on"),
        ("stick_slip", (0.0, 0.3), {"t_end": 5.0, "methods": ["rk2"]}, "slides from t = 0 to t = 3.333"),
    ],
)
def test_of_a_run_that_slides_or_rests_from_its_start_this_is_said(results, system, start, settings, course):
    inputs = run_inputs(Scene(system=system, starts=(start,), **settings))[0]
    assert results.summary(inputs).course == course


def test_a_tolerance_matters_to_methods_that_choose_their_steps_and_to_no_other(results):
    scene = Scene(methods=["dmm2", "taylor"], tau=1.0)
    steady, free = run_inputs(scene)
    scene.accept("tolerance", 1e-4)
    assert run_inputs(scene)[0] == steady
    coarse, fine = results.run(run_inputs(scene)[1]), results.run(free)
    assert coarse.evaluations < fine.evaluations
    assert 1e-8 < np.abs(coarse.x[-1] - fine.x[-1]).max() < 1e-1


def test_crossing_times_of_a_method_without_a_step_size_are_not_disturbed(results):
    scene = Scene(methods=["taylor"], perturbation_order=2)
    assert results.run(run_inputs(scene)[0]).status is core.Status.COMPLETED


def test_error_curves_have_no_more_points_than_pixels(results):
    curve = results.error_curve(run_inputs(Scene(tau=2e-5))[0])
    assert len(curve.t) == len(curve.error) <= 2400


@pytest.mark.parametrize("system", ["harmonic_oscillator", "elliptic_curve"])
def test_accumulated_error_is_the_distance_from_the_exact_levels(results, system):
    """Both systems of the paper return to the same level on each side, so the sum over visits telescopes."""
    scene = Scene(system=system, methods=["rk2"])
    run = results.run(run_inputs(scene)[0])
    error = run.change_of_psi()
    assert error[0] == 0.0
    first = run.side == run.side[0]
    psi = run.system.conserved(int(run.side[0]), 0.0, run.x)[:, 0]
    drift = np.abs(psi - psi[0])
    inner = first & (run.segment >= 4)
    ratio = error[inner] / drift[inner]
    assert 0.1 < np.median(ratio) < 10
    assert error.max() > 1e-6


def test_the_conservative_method_stays_at_round_off(results):
    for key, system in core.CATALOGUE.items():
        if any(region.psi for region in system.regions.values()):
            assert results.summary(run_inputs(Scene(system=key, methods=["dmm2"]))[0]).worst_error < 1e-13


def test_the_backdrop_is_kept_for_another_start_on_the_same_levels(results):
    scene, window = Scene(), Window(-2.0, 2.0, -2.0, 2.0)
    problem = run_inputs(scene)[0].problem
    levels = results.orbit(run_inputs(scene)[0]).levels
    first = results.backdrop(problem, window, levels)
    scene.accept("tau", 5e-3)
    assert results.orbit(run_inputs(scene)[0]).levels == levels
    assert results.backdrop(problem, window, levels) is first
    g = scene.build().switching(0.0, first.surface[np.isfinite(first.surface).all(axis=1)])
    assert np.abs(g).max() < 1e-2


def test_level_sets_stay_on_their_side(results):
    scene = Scene()
    levels = results.orbit(run_inputs(scene)[0]).levels
    drawn = results.backdrop(run_inputs(scene)[0].problem, Window(-2.0, 2.0, -2.0, 2.0), levels)
    for side in (-1, 1):
        for lines in (drawn.levels[side], drawn.orbit_levels[side]):
            points = lines[np.isfinite(lines).all(axis=1), :2]
            assert len(points) > 10
            assert (side * scene.build().switching(0.0, points) > -0.02).all()
        tails, tips = (drawn.arrows[side][k : len(drawn.arrows[side]) // 6 * 6 : 6] for k in (0, 1))
        assert len(tails) > 10
        assert (side * scene.build().switching(0.0, (tails + tips) / 2) > 0).all()


def test_the_study_measures_slope_two(results):
    study = results.study(*study_inputs(Scene()))
    assert np.abs(study.state_slope - 2).max() < 0.1
    assert results.study(*study_inputs(Scene(tau=1e-3))) is study


@pytest.mark.parametrize(
    ("how", "least", "most"),
    [
        ({}, 0.0, 4e-15),
        ({"perturbation_order": 1}, 0.05, 5.0),
        ({"transition": "none"}, 0.02, 2.0),
        ({"method": "rk2"}, 1e-4, 1e-2),
    ],
)
def test_what_is_lost_at_crossings_counts_as_much_as_what_is_lost_between(how, least, most):
    # Against the exact levels (psi = 0 outside, 2 cos(4 pi/7) inside): round-off, 0.42, 0.18 and 6e-4.
    run = core.integrate(core.CATALOGUE["elliptic_curve"], (0.0, 20.0), tau=1e-2, **how)
    assert least <= run.change_of_psi().max() <= most


@pytest.mark.parametrize(
    ("system", "crossings"),
    [("elliptic_curve", (10, 20, 30)), ("coulomb_friction", (1, 2, 3)), ("relay_feedback", (3, 5, 7))],
)
def test_a_study_looks_at_the_crossings_there_are(results, system, crossings):
    study = results.study(*study_inputs(Scene(system=system)))
    assert study.crossings == crossings
    assert np.isfinite(study.state_error).mean() > 0.8


def of_law_in_time(system, **settings):
    scene = Scene()
    scene.use(system)
    for name, value in settings.items():
        scene.accept(name, value)
    return scene


PUSHED = core.PiecewiseSystem("Pushed from t = 3 on", ("x", "v"), ("v", "-x"), ("v", "1 - x"), "t - 3", x0=(1.0, 0.0))


@pytest.mark.parametrize(("t_end", "crossings"), [(7.0, (1,)), (2.0, ())])
def test_with_less_than_two_crossings_states_are_compared_at_the_end_time(results, t_end, crossings):
    """Against the solution in closed form: cos t up to t = 3, and cos t − cos(t − 3) + 1 from then on."""
    scene = of_law_in_time(PUSHED, methods=["rk4"], t_end=t_end)
    study = results.study(*study_inputs(scene))
    assert (study.crossings, study.until) == (crossings, t_end)
    assert study.times.tolist() == ([1.5, 7.0] if crossings else [2.0])
    assert study.state_slope == pytest.approx([4.0] * len(study.times), abs=0.1)
    run = core.integrate(PUSHED, (0.0, t_end), tau=float(study.taus[0]), method="rk4")
    exact = np.cos(t_end) + (1 - np.cos(t_end - 3)) * (t_end > 3), -np.sin(t_end) + np.sin(t_end - 3) * (t_end > 3)
    assert study.state_error[-1, 0] == pytest.approx(np.linalg.norm(run.x[-1] - exact), rel=1e-3)


@pytest.mark.parametrize(("system", "crossings"), [("type_upward", (1,)), ("type_repelling", ())])
def test_a_system_with_one_crossing_or_none_has_an_order(results, system, crossings):
    study = results.study(*study_inputs(Scene(system=system)))
    assert study.crossings == crossings
    assert np.isfinite(study.state_error).mean() > 0.8


def test_what_stops_at_once_has_no_order(results):
    held = core.PiecewiseSystem("Held", ("x", "y"), ("1", "0"), ("-1", "0"), "x", x0=(0.0, 1.0))
    scene = of_law_in_time(held, slide=False)
    with pytest.raises(ValueError, match=r"stops at once: .*There is no order to study"):
        results.study(*study_inputs(scene))


@pytest.mark.parametrize("system", deep_but(QUICK, core.CATALOGUE))
def test_errors_of_every_system_are_known_where_it_has_a_conserved_quantity(results, system):
    scene = Scene(system=system, methods=["dmm2", "rk2"])
    known = all(region.psi for region in scene.build().regions.values())
    for inputs in run_inputs(scene):
        curve = results.error_curve(inputs)
        assert np.isfinite(curve.error).all() == known
        assert len(curve.sides) == 1 + len(curve.crossings)
        assert known or np.isnan(results.summary(inputs).worst_error)


def test_the_first_short_run_of_a_system_and_a_method_is_made_again_when_warm(results, monkeypatch):
    calls = []
    original = core.integrate

    def counted(*arguments, **keywords):
        run = original(*arguments, **keywords)
        calls.append(run.method)
        return run

    monkeypatch.setattr(core, "integrate", counted)
    for tau in (0.01, 0.02, 0.03):
        results.run(run_inputs(Scene(methods=["dmm2"], tau=tau, t_end=1.0))[0])
    assert calls == ["dmm2"] * 4, "the first call brings the code into memory: its time is not that of the run"
    results.run(run_inputs(Scene(methods=["rk2"], tau=0.02, t_end=1.0))[0])
    assert calls[4:] == ["rk2"] * 2


def test_what_a_run_reaches_is_told_beyond_what_is_drawn(results):
    pictures = results.pictures(portrait(Scene(starts=((0.507, 1.501),), tau=0.08, t_end=19.2, methods=["rk2"])))
    run = core.integrate("elliptic_curve", (0.0, 19.2), (0.507, 1.501), tau=0.08, method="rk2")
    finite = run.x[np.isfinite(run.x).all(axis=1)]
    assert pictures.orbits[0].reach[1].tolist() == finite.max(axis=0).tolist()
    assert np.nanmax(pictures.orbits[0].path) < finite.max(), "it leaves what is drawn"
