"""The curves of the state go through the solution, and show its jumps."""

import numpy as np
import pytest

import core
from pwsviz.results.states import FEW_STEPS, OUTLIERS, SAMPLES, state_curves


@pytest.mark.parametrize(("method", "how"), [("taylor", {"tau": 10.0}), ("dmm8", {"tau": 0.5}), ("rk4", {"tau": 0.01})])
def test_curves_follow_the_exact_oscillation_between_steps_as_well(method, how):
    run = core.integrate(core.CATALOGUE["harmonic_oscillator"], (0.0, 20.0), method=method, **how)
    t, x = state_curves(run).curves[0]
    assert len(t) >= SAMPLES
    np.testing.assert_allclose(x, run.at(t)[:, 0], rtol=0, atol=1e-12)


def test_a_long_run_is_reduced_to_the_screen():
    run = core.integrate(core.CATALOGUE["elliptic_curve"], (0.0, 20.0), tau=1e-4)
    curves = state_curves(run)
    assert all(len(t) <= 2 * SAMPLES for t, _ in curves.curves)
    assert len(curves.steps[0]) == 0
    np.testing.assert_allclose(curves.bounds, np.stack([run.x.min(axis=0), run.x.max(axis=0)], axis=1), atol=1e-3)


def test_a_jump_leaves_a_gap_between_its_two_ends():
    run = core.integrate(core.CATALOGUE["bouncing_ball"], (0.0, 3.0), method="taylor", tau=1.0)
    assert len(run.crossings) >= 2
    _, v = state_curves(run).curves[1]
    for crossing in run.crossings:
        (place,) = np.flatnonzero(np.isnan(v) & (np.roll(v, 1) == crossing.x[1]))
        assert v[place + 1] == crossing.x_after[1] > 0 > v[place - 1]


def test_few_steps_are_marked():
    run = core.integrate(core.CATALOGUE["harmonic_oscillator"], (0.0, 5.0), tau=0.1)
    t, x = state_curves(run).steps
    assert len(t) == len(run.t) <= FEW_STEPS
    np.testing.assert_array_equal(x, run.x)


def test_bounds_leave_out_the_last_moments_of_a_run_that_blows_up():
    system = core.PiecewiseSystem("Blow-up", ("x", "y"), ("x**2", "0"), ("x**2", "0"), "y - 10", x0=(1.0, 0.0))
    run = core.integrate(system, (0.0, 2.0), tau=1e-3, method="rk4")
    assert run.status is not core.Status.COMPLETED
    assert run.x[:, 0].max() > 1e3
    bounds = state_curves(run).bounds[0]
    assert bounds[0] <= 1.0 + 10 * OUTLIERS
    assert bounds[1] < 200
