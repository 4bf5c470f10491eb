"""A step is said to lose its order only where its error does not fall as the order says."""

from __future__ import annotations

import math

import pytest

import core


@pytest.mark.parametrize("record", ["steps", "end"])
def test_a_step_beside_a_root_is_said_to_lose_its_order_whatever_is_recorded(record):
    # v ≈ 1 at x = 0: the error of the first step behind is some √τ³, whatever the order.
    system = core.PiecewiseSystem("Root", ("x",), ("1",), ("1 + sqrt(x + 1e-9)",), "x", x0=(-1.0,))
    run = core.integrate(system, (0.0, 2.0), tau=0.01, method="rk8", record=record)
    assert "too long for rk8 to keep its order" in run.warning
    assert "falls as tau^1.5, not as tau^8" in run.warning


def test_a_step_that_does_not_resolve_a_pulse_is_told_and_half_of_it_is_not():
    # By a pulse narrower than the step the error is 0.05; with half the step it is 200 times smaller, not 16.
    field = ("y", "-x + 0.0647/(0.0007 + (t - 0.9557)**2)")
    system = core.PiecewiseSystem("Pulse", ("x", "y"), field, field, "x + 1000", x0=(0.787, 0.874))
    for tau, told in ((0.04227292254941118, True), (0.02113646127470559, False)):
        run = core.integrate(system, (0.0, 2.67), tau=tau, method="gauss4")
        assert ("too long for gauss4 to keep its order" in run.warning) is told, run.message


@pytest.mark.parametrize(("key", "method"), [("pendulum", "rk4"), ("predator_prey", "rk4"), ("kepler", "dmm4")])
def test_steps_with_large_errors_of_the_right_order_are_not_said_to_lose_it(key, method):
    # Each has a step whose error is more than ten times the median, and 1e-5 of the longest step.
    run = core.integrate(core.CATALOGUE[key], (0.0, 20.0), tau=0.1, method=method)
    assert "order" not in run.warning


@pytest.mark.parametrize(("method", "tau"), [("rk4", 0.004), ("rk4", 0.002), ("rk8", 0.01)])
def test_a_step_to_a_surface_on_which_the_field_has_no_value_is_told(method, tau):
    system = core.PiecewiseSystem("Pulled", ("x", "v"), ("v", "0.459 - x"), ("v", "-0.459/sqrt(x) - x"), "x")
    run = core.integrate(system, (0.0, 3.0), (1.346, -0.565), tau=tau, method=method)
    exact = -math.sqrt(0.565**2 + 1.346**2 + 4 * 0.459 * math.sqrt(1.346))  # speed at the surface, of the energy
    assert abs(run.crossings.x[0, 1] - exact) > 1e-4
    assert "too long" in run.warning
