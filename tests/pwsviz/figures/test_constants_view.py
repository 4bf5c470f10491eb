"""The table of the theory's constants: the worst of a run, and bounds that its step exceeds."""

from __future__ import annotations

import re

import pytest

import core
from pwsviz.figures.constants import constants_markup
from pwsviz.figures.scheme import scheme_markup


def diagnosed(tau: float, method: str = "dmm2") -> tuple[core.Trajectory, core.Diagnosis]:
    run = core.integrate(core.CATALOGUE["elliptic_curve"], (0.0, 10.0), tau=tau, method=method)
    return run, core.diagnose(run)


def test_constants_of_a_run_are_the_worst_over_its_crossings() -> None:
    run, diagnosis = diagnosed(0.01)
    text = constants_markup("dmm2", diagnosis, run)
    for value in (
        diagnosis.alpha_S2, diagnosis.alpha_hat_S2, diagnosis.M.max(), diagnosis.M_hat.max(),
        diagnosis.tau_minus.min(), diagnosis.tau_plus.min(), diagnosis.window.min(), diagnosis.window_hat.min(),
    ):  # fmt: skip
        assert f'<span class="number">{value:.3g}</span>' in text
    assert "τ satisfies all bounds" in text
    assert 'role="alert"' not in text


def test_a_step_beyond_a_bound_is_warned_of_in_words() -> None:
    run, diagnosis = diagnosed(0.6)
    assert diagnosis.warnings
    text = constants_markup("dmm2", diagnosis, run)
    assert 'role="alert"' in text
    assert "&lt; τ" in text
    assert text.count("<li>") == len(diagnosis.warnings)
    items = "".join(re.findall("<li>.*?</li>", text))
    assert "α²/M" in items
    assert not re.search("tau|alpha", items)


@pytest.mark.parametrize("name", ["harmonic_oscillator", "damped_oscillator", "bouncing_ball"])
def test_windows_speak_of_a_step_alone_as_the_surface_is_met_again_later(name: str) -> None:
    run = core.integrate(core.CATALOGUE[name], (0.0, 20.0), max_crossings=5)
    assert run.crossing_count == 5
    text = constants_markup("dmm2", core.diagnose(run), run)
    assert text.count("does not meet the surface again within a step") == 2
    assert "∞" not in text


def test_a_step_too_long_for_the_field_is_warned_of_though_it_keeps_the_bounds() -> None:
    run, found = diagnosed(0.12)
    assert not found.warnings
    text = constants_markup("dmm2", found, run)
    assert "too long for this field" in text
    assert "satisfies" not in text


def test_without_a_transversal_crossing_no_bound_is_satisfied() -> None:
    run = core.integrate(core.CATALOGUE["type_sliding"], (0.0, 30.0), sliding="continue")
    found = core.diagnose(run)
    text = constants_markup("dmm2", found, run)
    assert "The run has no transversal crossing, but 1 slide" in text
    assert "do not apply" in text
    assert "satisfies" not in text + found.summary


def test_bounds_that_are_satisfied_are_those_at_transversal_crossings() -> None:
    run = core.integrate(core.CATALOGUE["coulomb_friction"], (0.0, 20.0), sliding="continue")
    text = constants_markup("dmm2", core.diagnose(run), run)
    assert "The worst values over 3 crossings, 1 slide of dmm2" in text
    assert "τ satisfies all bounds. Where the surface is not crossed transversally they do not apply." in text


def test_a_run_without_crossings_says_so() -> None:
    system = core.CATALOGUE["elliptic_curve"]
    run = core.integrate(system, (0.0, 1e-2), tau=1e-3)
    assert "No crossings." in constants_markup("dmm2", core.diagnose(run), run)


def test_accumulating_crossings_are_no_warning_against_the_step() -> None:
    ball = core.CATALOGUE["bouncing_ball"]
    run = core.integrate(ball, (0.0, 5.0))
    assert run.status is core.Status.ZENO
    text = constants_markup("dmm2", core.diagnose(run), run)
    assert "accumulate" in text
    assert f"The worst values over {run.tally.jumps} jumps of" in text
    assert 'role="alert"' not in text


def test_the_table_stands_in_the_scheme() -> None:
    run, diagnosis = diagnosed(0.01)
    assert constants_markup("dmm2", diagnosis, run) in scheme_markup(run.system, "dmm2", diagnosis, run)


def test_without_a_run_there_is_no_table() -> None:
    assert "there is none yet" in constants_markup("dmm2", None, None)


def test_bounds_on_a_fixed_step_give_no_verdict_on_steps_that_a_method_chooses() -> None:
    run, diagnosis = diagnosed(0.6, "taylor")
    text = constants_markup("taylor", diagnosis, run)
    assert "taylor chooses its own steps" in text
    assert f"at τ ≤ {run.tau:.3g}" in text
    for verdict in ("satisfies", "exceeded", "alert"):
        assert verdict not in text
    assert "no bound" in diagnosis.summary


def test_a_verdict_by_constants_of_another_step_says_that_they_are_estimates() -> None:
    run, diagnosis = diagnosed(0.01, "prk8")
    assert "τ satisfies all bounds, as estimated below." in constants_markup("prk8", diagnosis, run)


@pytest.mark.parametrize(("method", "stands_in"), [("dmm2", ""), ("dmm4", "dmm2"), ("prk8", "classical Runge–Kutta")])
def test_it_is_said_of_which_step_the_constants_are(method: str, stands_in: str) -> None:
    run, diagnosis = diagnosed(0.01, method)
    assert (stands_in in constants_markup(method, diagnosis, run).rpartition("</table>")[2]) is True


def test_a_root_at_the_surface_leaves_no_window_and_exceeds_none():
    law = ("1 + sqrt(-x)/500",), ("1 + sqrt(x)/500",)  # so small that no step loses its order
    run = core.integrate(
        core.PiecewiseSystem("Root", ("x",), *law, "x", x0=(-1.0,)), (0.0, 2.0), method="rk4", tau=0.01
    )
    shown = constants_markup("rk4", core.diagnose(run), run)
    assert "τ satisfies all bounds that exist. The second derivative of g is not bounded at a crossing." in shown
    assert "exceeded" not in shown
    assert run.warning == ""
