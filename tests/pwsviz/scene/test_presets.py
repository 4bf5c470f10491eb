"""Presets: the page takes them as they are, the paper's are the paper's, and what they promise comes true."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

import core
from pwsviz.scene.presets import FIRST_LOOK, PRESETS, shown_example
from pwsviz.scene.scene import Scene
from pwsviz.scene.validation import MAX_STEPS

FIGURES = {
    "fig:vftypes": 4, "fig:portraits": 2, "fig:harmonic_timeError": 1, "fig:harmonic_transition": 3,
    "fig:CQ_harmonic": 1, "fig:elliptic_time": 1, "fig:elliptic_transition": 3, "fig:CQ_elliptic": 1,
}  # fmt: skip
TAUS = tuple(2.0**-k for k in range(8, 14))
COARSE = tuple(2.0**-k for k in range(4, 9))


def scene(key: str) -> Scene:
    return Scene(**PRESETS[key].settings)


def runs(key: str, **changes: Any) -> dict[tuple[str, tuple[float, ...]], core.Trajectory]:
    """Every run of a preset, by method and start."""
    chosen = Scene(**{**PRESETS[key].settings, **changes})
    return {
        (method, start): core.integrate(
            chosen.build(), (0.0, chosen.t_end), start, chosen.tau, method,
            tolerance=chosen.tolerance if core.METHODS[method].adaptive else None,
            sliding="continue" if chosen.slides else "stop",
        )
        for method in chosen.methods
        for start in chosen.starts
    }  # fmt: skip


def worst(run: core.Trajectory) -> float:
    """The largest drift, as the page shows it: since the start of the run."""
    return float(np.nanmax(np.abs(run.change_of_psi())))


def by_method(key: str, **changes: Any) -> dict[str, core.Trajectory]:
    return {method: run for (method, _), run in runs(key, **changes).items()}


def study(key: str, taus: tuple[float, ...] = TAUS, **changes: Any) -> core.OrderStudy:
    chosen = Scene(**{**PRESETS[key].settings, **changes})
    return core.order_study(
        chosen.build(), taus, chosen.x0, chosen.study_method, perturbation_order=chosen.perturbation_order,
        perturbation_scale=chosen.perturbation_scale, transition="mannshardt" if chosen.locate else "none",
    )  # fmt: skip


def test_every_figure_of_the_paper_has_its_presets() -> None:
    figures = [preset.figure for preset in PRESETS.values()]
    assert {figure: figures.count(figure) for figure in FIGURES} == FIGURES
    assert set(figures) == {*FIGURES, ""}
    last_of_paper = max(k for k, figure in enumerate(figures) if figure)
    assert next(iter(PRESETS)) == FIRST_LOOK
    assert "" not in figures[1:last_of_paper]


@pytest.mark.parametrize("key", PRESETS)
def test_the_page_takes_a_preset_as_it_is(key: str) -> None:
    preset, chosen = PRESETS[key], scene(key)
    assert preset.key == key
    assert all(1 <= len(words) <= 130 and words.endswith(".") for words in (preset.look, preset.try_))
    for name, value in preset.settings.items():
        assert getattr(chosen, name) == value
    assert chosen.used == chosen.methods
    assert chosen.t_end / chosen.tau <= MAX_STEPS
    for name in ("tau", "t_end", "starts", "methods"):
        chosen.accept(name, getattr(chosen, name))


@pytest.mark.parametrize("key", PRESETS)
def test_a_preset_cannot_be_changed(key: str) -> None:
    with pytest.raises(TypeError):
        PRESETS[key].settings["tau"] = 1.0  # type: ignore[index]
    assert isinstance(PRESETS, Mapping)


@pytest.mark.parametrize(("key", "start"), [("cq_harmonic", (1.0, 1.0)), ("cq_elliptic", (-1.0, -1.0))])
def test_conserved_quantities_start_and_step_as_in_the_paper(key: str, start: tuple[float, ...]) -> None:
    chosen = scene(key)
    assert chosen.starts == (start,)
    assert chosen.tau == 1e-3
    assert set(chosen.methods) == {"dmm2", "rk2"}


def test_systems_of_the_paper_have_its_parameters() -> None:
    for key, preset in PRESETS.items():
        if preset.settings["system"] == "harmonic_oscillator":
            assert scene(key).values == {"omega2_minus": 3.0, "omega2_plus": 1.0}
        if preset.settings["system"] == "elliptic_curve":
            assert scene(key).values == {"a_minus": -3.0, "a_plus": -2.0, "radius": 1.0}


@pytest.mark.parametrize(
    ("key", "status", "crossings"),
    [
        ("vf_upward", core.Status.COMPLETED, 1),
        ("vf_downward", core.Status.COMPLETED, 1),
        ("vf_repelling", core.Status.COMPLETED, 0),
        ("vf_sliding", core.Status.SLIDING, 1),
    ],
)
def test_the_four_kinds_of_field_do_what_they_are_named_for(key: str, status: core.Status, crossings: int) -> None:
    for run in runs(key).values():
        assert (run.status, run.crossing_count) == (status, crossings)
        if status is core.Status.SLIDING:
            assert run.t[-1] == pytest.approx(20.0, abs=1e-9)


def test_an_unstable_surface_stops_a_run_that_starts_on_it() -> None:
    (run, *_) = runs("vf_repelling", starts=((0.0, 0.0),)).values()
    assert run.status is core.Status.REPELLING


def test_portraits_are_closed_curves_but_for_the_one_to_try() -> None:
    for key in ("portrait_harmonic", "portrait_elliptic"):
        assert all(run.status is core.Status.COMPLETED for run in runs(key).values())
    (run, *_) = runs("portrait_elliptic", starts=((1.5, 2.0),)).values()
    assert run.status is core.Status.ESCAPED


@pytest.mark.parametrize("key", ["harmonic_time", "elliptic_time"])
def test_crossing_times_err_by_the_square_of_the_step(key: str) -> None:
    found = study(key)
    assert found.crossings == (10, 20, 30)
    assert found.time_slope == pytest.approx([2, 2, 2], abs=0.1)


def test_what_to_try_with_crossing_times_comes_true() -> None:
    fourth = study("harmonic_time", COARSE, methods=["dmm4"], study_method="dmm4")
    assert fourth.time_slope == pytest.approx([4] * 3, abs=0.2)
    assert study("elliptic_time", methods=["rk2"], study_method="rk2").time_slope == pytest.approx([2] * 3, abs=0.2)
    # At the step sizes of the page: errors scatter from one to the next, and so all of them enter the fit.
    taus = tuple(2.0 ** -np.arange(3.0, 13.5, 0.5))
    assert study("harmonic_time", taus, locate=False).time_slope == pytest.approx([0.8] * 3, abs=0.2)
    for name in ("harmonic", "elliptic"):
        slopes = study(f"{name}_transition_15", taus, locate=False).state_slope
        assert slopes[1:] == pytest.approx([1] * 3, abs=0.4), name


@pytest.mark.parametrize("name", ["harmonic", "elliptic"])
@pytest.mark.parametrize(("p", "after"), [(1, 1), (2, 2), (15, 2)])
def test_the_order_after_crossings_is_the_smaller_of_p_and_two(name: str, p: int, after: int) -> None:
    key = f"{name}_transition_{p}"
    assert PRESETS[key].settings["perturbation_order"] == p
    assert study(key).state_slope == pytest.approx([2, after, after, after], abs=0.2)


@pytest.mark.parametrize(
    ("key", "crossings", "low", "high"), [("cq_harmonic", 41, 2e-7, 3e-7), ("cq_elliptic", 105, 3e-6, 4e-6)]
)
def test_the_multiplier_method_keeps_what_the_midpoint_rule_loses(
    key: str, crossings: int, low: float, high: float
) -> None:
    found = by_method(key)
    assert worst(found["dmm2"]) < 2e-15
    assert low < worst(found["rk2"]) < high
    assert {run.crossing_count for run in found.values()} == {crossings}


def test_rk8_conserves_nothing_though_its_drift_is_round_off_at_a_small_step() -> None:
    fine, coarse = (by_method("cq_elliptic", methods=["dmm2", "rk8"], tau=tau) for tau in (1e-3, 0.05))
    assert worst(fine["rk8"]) < 4e-15  # rounding of 100,000 steps, which nothing takes back
    assert worst(coarse["rk8"]) > 1e-11
    assert worst(coarse["dmm2"]) < 2e-15


def test_the_error_of_the_midpoint_rule_grows_a_thousandfold_with_a_step_ten_times_as_long() -> None:
    coarse, fine = by_method("cq_harmonic", tau=1e-2), by_method("cq_harmonic")
    assert worst(coarse["rk2"]) / worst(fine["rk2"]) == pytest.approx(1000, rel=0.05)
    assert worst(coarse["dmm2"]) < 2e-15


def test_one_swing_misses_one_crosses_and_one_touches() -> None:
    found = list(runs("grazing").values())
    assert [run.status for run in found] == [core.Status.COMPLETED, core.Status.COMPLETED, core.Status.GRAZING]
    assert found[0].crossing_count == 0
    assert found[1].crossing_count > 4
    assert found[2].x[-1] == pytest.approx((0.5, 0.0), abs=1e-6)


@pytest.mark.parametrize("key", PRESETS)
def test_an_example_that_speaks_of_a_start_opens_with_that_start_selected(key: str) -> None:
    opened, words = Scene(), f"{PRESETS[key].look} {PRESETS[key].try_}"
    opened.load(PRESETS[key].settings)
    named = {int(number) for number in re.findall(r"\b[Ss]tart (\d+)\b", words)}
    assert named <= {opened.selected + 1}
    assert opened.selected < len(opened.starts)


def test_the_example_of_a_touch_speaks_of_a_start() -> None:
    assert "start 3" in PRESETS["grazing"].try_


@pytest.mark.parametrize("restitution", [0.5, 0.8])
def test_bounces_accumulate_when_they_should(restitution: float) -> None:
    found = by_method("zeno", values={"gravity": 9.8, "restitution": restitution})["dmm2"]
    assert found.status is core.Status.ZENO
    fall = math.sqrt(2 / 9.8)
    assert found.t[-1] == pytest.approx(fall * (1 + restitution) / (1 - restitution), rel=1e-9)
    if restitution == 0.5:
        assert f"{found.t[-1]:.4f}" in PRESETS["zeno"].look


def test_the_block_sticks_at_its_fourth_turning_point() -> None:
    found = by_method("sticking")["dmm2"]
    assert found.status is core.Status.COMPLETED
    assert found.crossings.kind[-1] == "sliding"
    assert found.crossings.x[:, 0] == pytest.approx([-2.2, 1.4, -0.6, -0.2], abs=1e-12)
    assert by_method("sticking", values={"mu": 2.0})["dmm2"].crossing_count == 1


def test_four_integrators_lose_what_they_are_said_to_lose() -> None:
    found, halved = (
        {method: worst(run) for method, run in by_method("side_by_side", **changes).items()}
        for changes in ({}, {"tau": 0.005})
    )
    assert 1e-3 < found["rk2"] < 2e-3
    assert 1e-7 < found["rk4"] < 2e-7
    assert max(found["dmm2"], found["prk8"]) < 2e-15
    assert found["rk2"] / halved["rk2"] == pytest.approx(8, abs=0.5)
    assert found["rk4"] / halved["rk4"] == pytest.approx(30, abs=1)


def test_energy_and_angular_momentum_of_the_planet_are_kept() -> None:
    found = by_method("kepler")
    assert worst(found["prk8"]) < 3e-15
    assert worst(found["rk4"]) > 1e-9
    assert found["prk8"].crossing_count > 40


def test_a_taylor_series_takes_few_steps_and_fewer_at_a_coarser_tolerance() -> None:
    fine, coarse = (by_method("taylor", tolerance=tolerance)["taylor"] for tolerance in (1e-12, 1e-6))
    assert fine.crossing_count == 63
    assert 200 < fine.steps < 300
    assert coarse.steps < fine.steps
    assert max(worst(fine), worst(coarse)) < 2e-15


def test_higher_order_costs_a_tenth() -> None:
    """Crossing times against those of a Taylor series at the last digits."""
    chosen = scene("cost")
    exact = core.integrate(chosen.build(), (0, 60), chosen.x0, 0.1, "taylor", tolerance=1e-15, record="crossings")
    error, cost = {}, {}
    for method, tau in (("dmm2", 1e-3), ("prk8", 0.05)):
        run = core.integrate(chosen.build(), (0, 60), chosen.x0, tau, method, record="crossings")
        error[method], cost[method] = np.abs(run.crossings.t - exact.crossings.t).max(), run.evaluations
    assert error["prk8"] < error["dmm2"] / 100
    assert cost["prk8"] < cost["dmm2"] / 9.5


def test_labels_are_those_of_figures() -> None:
    assert all(re.fullmatch(r"(fig:\w+)?", preset.figure) for preset in PRESETS.values())


def test_the_impacts_of_two_walls_take_a_twentieth_and_nothing_else_does() -> None:
    found = by_method("walls")
    kept, lost = found["dmm2"], found["rk2"]
    speed = np.abs(kept.crossings.rate_after / kept.crossings.rate_before)
    assert np.allclose(speed, 0.95, rtol=1e-9)
    assert np.fmax.reduce(kept.change_of_psi()) < 4e-16
    assert np.fmax.reduce(lost.change_of_psi()) > 9e-6


def test_two_integrators_part_on_the_double_scroll_when_they_are_said_to() -> None:
    def apart(tau: float) -> float:
        coarse = core.integrate("chua", (0.0, 60.0), method="rk4", tau=tau)
        fine = core.integrate("chua", (0.0, 60.0), method="taylor", t_eval=coarse.t)
        far = np.abs(coarse.x - fine.at(coarse.t)).max(axis=1) > 0.1
        return float(coarse.t[np.argmax(far)])

    assert apart(0.02) == pytest.approx(44.1, abs=0.5)
    assert apart(0.02) + 3.0 < apart(0.01) < 60.0


def section_of(key: str, points: int, **values: float) -> tuple[core.Section, Scene]:
    """The section of a preset, with other values of parameters."""
    chosen = scene(key)
    system = core.CATALOGUE[chosen.system].with_parameters(**{**chosen.values, **values})
    settings = {"method": "taylor", "tau": chosen.tau, "tolerance": chosen.tolerance}
    return core.section(system, (0.0, 1e9), chosen.starts, points=points, **settings), chosen


def test_orbits_of_henon_and_heiles_have_one_energy_and_are_islands_or_fill_the_sea() -> None:
    found, _ = section_of("henon_heiles_section", 1500)
    x, y, u, v = found.ensemble.crossings.x_after.T
    assert (u**2 + v**2 + x**2 + y**2) / 2 + x**2 * y - y**3 / 3 == pytest.approx(1 / 8, abs=1e-12)
    cells = [len({*zip(*(np.floor(40 * w[found.member == k]) for w in (y, v)), strict=True)}) for k in range(7)]
    assert max(cells[k] for k in (1, 2, 3, 5)) < 100 < 400 < min(cells[k] for k in (0, 4, 6))


def test_bands_of_the_table_join_and_its_islands_attract_when_they_are_said_to() -> None:
    def speeds(**values: float) -> np.ndarray:
        found, _ = section_of("vibrating_table", 3000, **values)
        speed = found.ensemble.crossings.x_after[:, 2]
        return np.array([speed[found.member == k][-1000:] for k in range(9) if (found.member == k).sum() == 3000])

    assert speeds()[0].max() < 4.5 < 5.0 < speeds(a=0.4)[0].max()
    lossy = speeds(restitution=0.97)
    assert len(lossy) == 5  # the other four are at rest
    assert np.abs(lossy - math.pi).max() < 1e-6


def test_loops_of_the_circuit_double_and_reach_the_other_scroll_where_the_example_says() -> None:
    chosen = scene("chua_sweep")

    def points(alpha: float) -> np.ndarray:
        settings = {"points": 64, "discard": 400, "direction": 1, "method": "taylor"}
        return core.sweep("chua", (0.0, 4000.0), "alpha", [alpha], "y", chosen.x0, **settings).points

    def distinct(alpha: float) -> int:
        return len(np.unique(points(alpha).round(3)))

    assert [distinct(alpha) for alpha in (8.1, 8.2, 8.37, 8.41)] == [1, 2, 2, 4]
    assert points(8.7).max() < 0.3 < 0.35 < points(8.9).max()


def test_the_first_look_is_what_it_says() -> None:
    system, worst = core.CATALOGUE["elliptic_curve"], {}
    for name, tau in (("dmm2", 0.08), ("rk2", 0.08), ("rk2", 0.04)):
        run = core.integrate(system, (0.0, 20.0), tau=tau, method=name)
        worst[name, tau] = float(np.abs(run.accumulated_error()).max())
    assert worst["dmm2", 0.08] < 8 * np.finfo(float).eps
    assert 8.0 < worst["rk2", 0.08] / worst["rk2", 0.04] < 10.0
    radius = [np.hypot(*(core.integrate(system, (0.0, t), tau=0.08, method="rk2").x.T)).max() for t in (4.0, 20.0)]
    assert radius[1] > 1.05 * radius[0], "outwards"


@pytest.mark.parametrize("key", PRESETS)
def test_an_example_is_known_by_its_settings_until_one_is_changed(key: str) -> None:
    chosen = scene(key)
    assert shown_example(chosen) == PRESETS[key].title
    chosen.accept("tau", "0.00123")
    assert shown_example(chosen) == "" or "tau" not in PRESETS[key].settings
