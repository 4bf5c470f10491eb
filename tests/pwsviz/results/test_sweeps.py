"""A bifurcation diagram comes coarse to fine, is that of core.sweep, and agrees with closed forms."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import core
from core import Status
from pwsviz.export.tables import sweep_tables
from pwsviz.figures.sweep_text import examined_words, period_of, sweep_details, sweep_numbers, sweep_text
from pwsviz.results.requests import SweepInputs
from pwsviz.results.results import Results
from pwsviz.results.sweeps import (
    NO_CROSSING,
    NO_START,
    coarse_to_fine,
    of_one_value,
    sweep_arguments,
    swept,
    swept_values,
    with_discard,
)
from pwsviz.scene.presets import PRESETS
from pwsviz.scene.scene import Scene
from pwsviz.tasks.cancellation import Cancelled

#: Friction that drives: each half-turn about x = ±1 shrinks the distance by q = exp(−πζ/√(1 − ζ²)), so that the limit
#: cycle turns at x = ±(1 + q)/(1 − q).
DRIVEN = core.PiecewiseSystem(
    "Driven by friction", ("x", "v"), g="v", f_minus=("v", "-x - 1 - 2*zeta*v"), f_plus=("v", "-x + 1 - 2*zeta*v"),
    parameters={"zeta": core.Parameter("zeta", 0.2, (0.05, 0.5))}, x0=(3.0, 0.5),
)  # fmt: skip


def scene_of(system, **settings):
    scene = Scene()
    scene.use(system)
    scene.accept("methods", ["taylor"])
    for name, value in {"tau": 0.5, **settings}.items():
        scene.accept(name, value)
    return scene


def diagram(scene, report=lambda *_: None, cancel=lambda: False):
    with ThreadPoolExecutor(1) as pool:
        return swept(SweepInputs.of_scene(scene), pool, cancel, report)


@pytest.mark.parametrize("count", [2, 3, 16, 400, 1000])
def test_any_first_part_of_the_values_covers_the_range_evenly(count):
    order = coarse_to_fine(count)
    assert sorted(order.tolist()) == list(range(count))
    for part in (count // 16, count // 5, count // 2):
        gaps = np.diff(np.concatenate([[-1], np.sort(order[:part]), [count]]))
        assert part == 0 or gaps.max() <= 2.5 * count / part


def test_the_points_are_those_of_the_limit_cycle_in_closed_form():
    found = diagram(scene_of(DRIVEN, sweep_values=40, sweep_discard=200, sweep_points=20))
    value, x = found.sorted_points()
    assert found.whole.all()
    q = np.exp(-np.pi * value / np.sqrt(1 - value**2))
    assert np.abs(x) == pytest.approx((1 + q) / (1 - q), abs=1e-10)
    assert (x[1:] * x[:-1] < 0)[np.diff(value) == 0].all(), "it turns left and right in turn"


@pytest.mark.parametrize(
    ("key", "discarded"),
    [("coulomb_friction", 0), ("relay_feedback", 0), ("bouncing_ball", 0), ("type_upward", 0), ("elliptic_curve", 100),
     ("stick_slip", 100), ("type_repelling", 100)],
)  # fmt: skip
def test_a_transient_is_discarded_unless_most_runs_end_within_it(key, discarded):
    scene = Scene(system=key, methods=["dmm2"], sweep_values=16, sweep_points=20)
    inputs = SweepInputs.of_scene(scene)
    with ThreadPoolExecutor(1) as pool:
        found = swept(inputs, pool, lambda: False, lambda *_: None)
    assert (found.inputs.discard, found.sparse) == (discarded, not discarded)
    if not discarded:
        assert (found.counts > 0).sum() >= 8, "most runs have points to show"
        assert "No transient is discarded" in sweep_details(found)


def test_a_number_of_discarded_points_that_was_chosen_stays():
    inputs = SweepInputs.of_scene(Scene(system="coulomb_friction", methods=["dmm2"], sweep_discard=100))
    with ThreadPoolExecutor(1) as pool:
        assert with_discard(inputs, pool, lambda: False) is inputs


def test_the_bounces_of_the_example_double_where_theory_says():
    """Period one: speed π; it doubles at a² = (π(1 − ε)/(1 + ε))² + (2(1 + ε²)/(1 + ε)²)², the trace of the map."""
    scene = Scene()
    scene.load(PRESETS["vibrating_table_sweep"].settings)
    scene.accept("sweep_values", 41)
    scene.accept("sweep_discard", 1500)
    scene.accept("sweep_end", 1e5)
    found = diagram(scene)
    doubling = np.hypot(np.pi / 3, 2.5 / 2.25)
    once = (found.values > 1.12) & (found.values < doubling - 0.02)
    twice = (found.values > doubling + 0.02) & (found.values < 1.65)
    assert found.whole[once | twice].all()
    for a in found.values[once]:
        assert found.points_at(a) == pytest.approx(np.pi, abs=1e-8)
    for a in found.values[twice]:
        v = found.points_at(a)
        assert np.abs(v[2:] - v[:-2]).max() < 1e-8
        assert np.abs(v[1:] - v[:-1]).min() > 0.01
    below = found.values < np.pi / 3  # the table never moves fast enough
    assert set(found.outcomes[below].tolist()) == {Status.ZENO}


@pytest.mark.parametrize("continuation", ["none", "up", "down"])
def test_portions_have_the_points_of_one_sweep(continuation, monkeypatch):
    monkeypatch.setattr("pwsviz.results.sweeps.PORTION", 1e-9)  # as many portions as there can be
    scene = scene_of(DRIVEN, sweep_values=50, sweep_discard=2, sweep_points=5, sweep_continuation=continuation)
    heard = []
    found = diagram(scene, lambda done, total, part: heard.append((done, total, part)))
    inputs = SweepInputs.of_scene(scene)
    whole = core.sweep(
        DRIVEN, (0.0, inputs.t_end), "zeta", swept_values(inputs), "x", DRIVEN.x0, **sweep_arguments(inputs)
    )
    value, x = found.sorted_points()
    order = np.argsort(whole.value, kind="stable")
    assert np.array_equal(value, whole.value[order])
    assert np.array_equal(x, whole.points[order])
    assert found.outcomes.tolist() == [*whole.statuses]
    parts = [part for _, _, part in heard if len(part.portions)]
    assert len({len(part.portions) for part in parts}) >= 4
    assert all(one is other for one, other in zip(parts[0].portions, found.portions, strict=False))
    assert [done for done, _, _ in heard] == sorted(done for done, _, _ in heard)
    assert heard[-1][:2] == (50, 50)


#: The first wall moves with the parameter; beyond it no law is declared.
WALL = core.PiecewiseSystem(
    "A wall", ("x", "v"), surfaces=("x - place",), regions={"+": core.Region(f=("v", "-x"))}, jumps={0: ("x", "-v")},
    parameters={"place": core.Parameter("place", -0.5, (-2.0, 1.0))}, x0=(0.5, 0.0),
)  # fmt: skip


@pytest.mark.parametrize("continuation", ["none", "up", "down"])
def test_values_at_which_no_run_begins_are_told_and_the_others_drawn(continuation):
    """From x = 0.5 the swing meets the wall at x = p for |p| < 0.5, with v² = 0.25 − p²; beyond 0.5 nothing begins."""
    settings = {"sweep_values": 31, "sweep_points": 10, "sweep_discard": 0, "sweep_coordinate": "v"}
    found = diagram(scene_of(WALL, **settings, sweep_continuation=continuation))
    inside = np.abs(found.values) < 0.49
    assert found.whole.tolist() == inside.tolist()
    assert (found.outcomes[found.values > 0.51] == NO_START).all()
    assert (found.outcomes[found.values < -0.51] == NO_CROSSING).all()
    assert "member" not in found.refusal
    assert found.refusal
    value, v = found.sorted_points()
    there = np.abs(value) < 0.49
    assert v[there] == pytest.approx(np.sqrt(0.25 - value[there] ** 2), abs=1e-9), "after the reset map"


def test_what_makes_no_sense_at_all_is_refused():
    scene = scene_of(WALL, sweep_range=(0.6, 0.9), sweep_values=5)
    with pytest.raises(ValueError, match=r"region|start|law"):
        diagram(scene)
    laws = {"f_minus": ("y", "-x"), "f_plus": ("y", "-2*x"), "g": "y", "x0": (1.0, 1.0)}
    with pytest.raises(ValueError, match="no parameter"):
        diagram(scene_of(core.PiecewiseSystem("plain", ("x", "y"), **laws)))


def test_a_diagram_that_is_not_wanted_any_more_stops():
    heard = []
    with pytest.raises(Cancelled):
        diagram(scene_of(DRIVEN, sweep_values=400), lambda *news: heard.append(news), lambda: len(heard) > 0)
    assert 0 < max(done for done, _, _ in heard) < 400


def test_the_present_value_of_the_parameter_changes_nothing():
    scene, results = scene_of(DRIVEN, sweep_values=20, sweep_points=3, sweep_discard=0), Results()
    first = results.sweep(SweepInputs.of_scene(scene))
    scene.accept("values.zeta", 0.4)
    assert results.sweep(SweepInputs.of_scene(scene)) is first
    assert results.computed["sweep"] == 1


def chua(t, x, alpha):
    slope, corner = (-5 / 7, np.sign(x[0])) if abs(x[0]) > 1 else (-8 / 7, 0.0)
    diode = slope * x[0] + corner * (-8 / 7 + 5 / 7)
    return [alpha * (x[1] - x[0] - diode), x[0] - x[1] + x[2], -100 / 7 * x[1]]


def rises_through_the_surface(t, x, alpha):
    """Where the loop about the right equilibrium begins."""
    return x[0] - 1


rises_through_the_surface.direction = 1


@pytest.mark.parametrize(("alpha", "period"), [(8.1, 1), (8.3, 2)])
def test_loops_of_the_circuit_double_as_an_external_solver_finds_them(alpha, period):
    run = solve_ivp(
        chua, (0.0, 300.0), (0.1, 0.1, 0.0), "DOP853", args=(alpha,), events=rises_through_the_surface, rtol=1e-9,
        atol=1e-11,
    )  # fmt: skip
    expected = run.y_events[0][-period:, 1]
    scene = Scene()
    scene.load(PRESETS["chua_sweep"].settings)
    for name, value in {"sweep_range": (alpha, 9.2), "sweep_values": 2, "sweep_points": 2 * period}.items():
        scene.accept(name, value)
    points = diagram(scene).points_at(alpha)
    assert period_of(points, 1.0) == period
    assert np.sort(points[:period]) == pytest.approx(np.sort(expected), abs=1e-4)


def test_an_angle_loses_full_turns_so_that_a_periodic_bounce_has_one_phase():
    scene = Scene()
    scene.load(PRESETS["vibrating_table_sweep"].settings)
    for name, value in {"sweep_coordinate": "phi", "sweep_range": (1.2, 1.3), "sweep_values": 2}.items():
        scene.accept(name, value)
    phases = diagram(scene).points_at(1.3)
    assert len(phases) > 1
    assert 0.0 <= phases.min() <= phases.max() < 2 * np.pi
    assert period_of(phases, 1.0) == 1


@pytest.mark.parametrize("continuation", ["none", "up"])
def test_steps_that_are_too_long_are_told_with_the_value_of_the_parameter(continuation):
    for tau, told in ((0.2, True), (0.002, False)):
        scene = Scene(
            tau=tau, sweep_range=(0.5, 1.3), sweep_values=12, sweep_continuation=continuation, sweep_end=100.0
        )
        found = diagram(scene)
        warning = " ".join(found.warnings)
        assert (len(found.warned) > 0) is bool(warning) is told
        assert np.isin(found.warned, found.examined).all()
        assert np.isin(found.examined, found.values).all()
        assert not told or any(warning.startswith(f"r = {value:.6g}: ") for value in found.warned)
        assert ("too long for this field" in warning) is told, warning


def test_runs_that_meet_no_surface_are_told_from_those_that_meet_it_too_seldom():
    """Of the elliptic curve with start (−1, −1), against SciPy's DOP853 inside the circle."""
    found = diagram(Scene(sweep_range=(1.45, 3.0), sweep_values=12, sweep_end=40.0, sweep_discard=3, tau=0.01))
    orbit = solve_ivp(
        lambda _, x: (2 * x[1], 3 * x[0] ** 2 - 3), (0.0, 40.0), (-1.0, -1.0), "DOP853", rtol=1e-10, max_step=0.05
    )
    farthest = np.hypot(*orbit.y).max()
    assert ((found.outcomes == NO_CROSSING) == (found.values > farthest)).all()
    assert 0 < (found.outcomes == NO_CROSSING).sum() < 12
    never = replace(found, outcomes=np.where(found.counts == 0, NO_CROSSING, found.outcomes))
    assert "discard fewer" not in sweep_text(never, 1.0)
    assert ("no crossing by t = 40", f"{(never.outcomes == NO_CROSSING).sum()}") in {
        row[:2] for row in sweep_numbers(never).rows
    }


def test_a_stretch_in_which_orbits_touch_the_surface_is_marked_and_no_period_is_told_there():
    """From r = 1.43 to 1.554 orbits slide to an end of an arc of S that repels, where rounding decides what follows."""
    settings = {"sweep_range": (1.4, 1.6), "sweep_values": 41, "sweep_end": 100.0, "tau": 0.01}
    found = diagram(Scene(**settings))
    touch = (found.examined > 1.44) & (found.examined < 1.55)
    assert touch.sum() > 3
    assert np.isin(found.examined[touch], found.warned).all()
    assert not (found.warned > 1.56).any(), "these orbits stay inside the circle"
    first, last = np.searchsorted(found.values, [found.warned.min(), found.warned.max()])
    assert np.isin(found.values[[first - 1, last + 1]], found.examined).all(), "so that where the stretch ends is known"
    assert f"at r = {found.warned.min():.6g} to {found.warned.max():.6g}." in examined_words(found)
    assert sweep_text(found, 1.5) == "At r = 1.5 no period is stated: the run is in doubt."
    between = next(value for value in found.values if 1.46 < value < 1.54 and value not in found.examined)
    assert "no period is stated: the nearest runs examined, at 1." in sweep_text(found, between)


def test_chaos_is_not_in_doubt_but_said_to_let_small_errors_grow():
    """Of Chua’s circuit: a limit cycle at α = 8.1, a strange attractor at 8.7."""
    scene = Scene()
    scene.load(PRESETS["chua_sweep"].settings)
    for name, value in {"sweep_range": (8.1, 8.7), "sweep_values": 3, "sweep_points": 40}.items():
        scene.accept(name, value)
    found = diagram(scene)
    assert (found.sensitive.tolist(), len(found.warned), found.warnings) == ([8.7], 0, ())
    assert "Small errors grow in all that were examined at α = 8.7." in examined_words(found)
    assert "no period up to 20 was found, and small errors grow" in sweep_text(found, 8.7)
    assert "grow" not in sweep_text(found, 8.1)
    _, values = sweep_tables(found).values()
    assert values()["doubt"].tolist() == ["examined", "examined", "small errors grow"]


def test_the_points_of_one_value_are_those_that_it_has_in_a_diagram():
    found = diagram(scene_of(DRIVEN, sweep_values=3, sweep_discard=50, sweep_points=5))
    value = float(found.values[1])
    with ThreadPoolExecutor(1) as pool:
        alone = swept(of_one_value(found.inputs, value), pool, lambda: False, lambda *_: None)
    assert alone.values.tolist() == [value]
    assert alone.points_at(value) == pytest.approx(found.points_at(value), abs=1e-12)
