"""Warnings of steps do not contradict the reason for which a run ended, and are not lost to it."""

from __future__ import annotations

import math

import numpy as np
import pytest

import core
from core import Status

PENDULUM = core.CATALOGUE["pendulum"]


@pytest.mark.parametrize("tau", [0.003, 0.01, 0.03])
def test_of_a_run_that_ends_at_a_touch_the_last_step_is_not_called_too_long(tau):
    run = core.integrate(PENDULUM, (0.0, 60.0), (-0.5, 0.0), tau, "dmm2")
    assert run.status is Status.GRAZING
    assert run.warning == ""


@pytest.mark.parametrize("method", ["dmm2", "rk4", "rk8", "prk8", "taylor"])
def test_an_oscillator_that_just_reaches_a_surface_is_told_one_thing_only(method):
    rng, touches = np.random.default_rng(2), 0
    f, psi = (("v", "-x"), ("v", "-2*x")), (("(x**2 + v**2)/2",), ("x**2 + v**2/2",))
    system = core.PiecewiseSystem("Just", ("x", "v"), *f, "x - a", *psi, parameters=(core.Parameter("a", 1.0),))
    for _ in range(12):
        a, tau = float(rng.uniform(0.5, 2.0)), None if method == "taylor" else float(10 ** rng.uniform(-3, -1))
        run = core.integrate(system.with_parameters(a=a), (0.0, 2.0), (0.0, a), tau=tau, method=method)
        if run.status is Status.GRAZING:
            touches += 1
            assert run.warning == "", run.message
    assert touches or method == "rk4"  # which loses energy, so that the surface is not reached


@pytest.mark.parametrize("g", ["sin(x) - 0.5", "cos(x) - 0.3", "x - 3", "sin(3*x*y)"])
@pytest.mark.parametrize("method", ["rk2", "rk4", "rk8", "gauss4"])
def test_of_a_solution_that_blows_up_it_is_not_said_that_smaller_steps_help(method, g):
    for tau in np.geomspace(5e-4, 0.03, 7).tolist():
        system = core.PiecewiseSystem("Pole", ("x", "y"), ("x**2", "-y"), ("x**2", "-y"), g, x0=(1.0, 0.5))
        run = core.integrate(system, (0.0, 5.0), tau=tau, method=method)
        if run.status in (Status.ESCAPED, Status.UNSTABLE):
            assert run.warning == "", run.message


@pytest.mark.parametrize("method", ["rk4", "rk8", "gauss4"])
def test_a_surface_leapt_over_long_before_a_solution_blows_up_is_told(method):
    system = core.PiecewiseSystem(
        "Early", ("x", "y"), ("x**2", "1"), ("x**2", "1"), "(y - 0.305)**2 - 1e-6", x0=(1.0, 0.0)
    )
    run = core.integrate(system, (0.0, 5.0), tau=0.01, method=method)
    assert run.status in (Status.ESCAPED, Status.UNSTABLE)
    assert len(run.crossings) == 2 or "crossings may have been missed" in run.warning, run.message


def test_a_surface_leapt_over_long_before_a_touch_is_told():
    # Narrow dips of the switching function, of width 1/50 of a step, long before the touch at t = π/2.
    g = "0.5*(x - 1) + 0.6*exp(-((x - 0.5)/1e-3)**2)"
    system = core.PiecewiseSystem("Dip", ("x", "v"), ("v", "-x"), ("v", "-x"), g, x0=(0.0, 1.0))
    run = core.integrate(system, (0.0, 2.0), tau=0.1, method="rk8")
    assert len(run.crossings) > 2 or "crossings may have been missed" in run.warning, run.message
    assert math.isfinite(run.t[-1])


@pytest.mark.parametrize("radius", [1.56, 1.57368])
def test_an_orbit_that_passes_at_a_distance_is_not_said_to_touch_however_its_phase_errs(radius):
    """Of y² − x³ − a·x = ψ, the farthest point of the closed branch is 0.01 or more in g from the circle."""
    system = core.CATALOGUE["elliptic_curve"].with_parameters(radius=radius)
    a, (x0, y0) = system.values["a_minus"], system.x0
    x = np.linspace(-3.0, 0.0, 300_001)
    square = y0**2 - x0**3 - a * x0 + x**3 + a * x
    inside = (square >= 0.0) & (x > -2.0)
    assert (x**2 + square)[inside].max() < radius**2 - 0.01
    run = core.integrate(system, (0.0, 19.2), tau=0.08, method="dmm2", sliding="continue")
    assert (len(run.crossings), run.warning) == (0, "")
