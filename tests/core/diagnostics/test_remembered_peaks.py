"""An end is said to be spoilt by a peak before it where it is, and not where errors decay along with the state."""

from __future__ import annotations

import numpy as np
import pytest

import core

TOLD = "do not decay with it"


def smooth(variables, field, x0, **parameters):
    """A system that meets no surface."""
    return core.PiecewiseSystem(
        "Smooth", variables, field, field, f"{variables[0]} + 1e30", parameters=parameters, x0=x0
    )


def test_an_end_past_a_narrowly_missed_pole_is_told_where_it_is_wrong():
    rng, found = np.random.default_rng(1), []
    system = smooth(("x",), ("-2*k*(t - a)/((t - a)**2 + w)**2",), (1.0,), a=1.0, w=1e-12, k=1.0)
    for _ in range(16):
        a, k, w = rng.uniform(0.3, 1.7), 10.0 ** rng.uniform(-2, 2), 10.0 ** rng.uniform(-15, -6)
        start, end = (k / ((t - a) ** 2 + w) for t in (0.0, 2.5))
        run = core.integrate(system.with_parameters(a=a, w=w, k=k), (0.0, 2.5), x0=(start,), method="taylor")
        error = float(abs(run.x[-1, 0] - end) / end)
        if not 0.02 < error < 0.5:
            assert (TOLD in run.warning) is (error > 0.1), (a, k, w, error)
            found.append(error > 0.1)
    assert {True, False} == set(found)


@pytest.mark.parametrize(("size", "told"), [(1e9, True), (1e2, False)])
def test_an_end_after_a_peak_is_told_where_steps_of_fixed_size_do_not_return_from_it(size, told):
    # x = c (s - s⁴) up to s = 1, and then sin(s - 1).
    fields = ("c*(1 - 4*s**3)", "1"), ("cos(s - 1)", "1")
    system = core.PiecewiseSystem("Peak", ("x", "s"), *fields, "s - 1", parameters={"c": size}, x0=(0.0, 0.0))
    run = core.integrate(system, (0.0, 3.0), tau=0.01, method="rk2", record="end")
    spoilt = bool(abs(run.x[-1, 0] - np.sin(2.0)) > 0.1)
    assert (TOLD in run.warning, spoilt) == (told, told), (run.message, run.x[-1])


@pytest.mark.parametrize("method", ["rk2", "rk8", "taylor"])
def test_a_state_that_decays_from_its_peak_with_its_errors_is_not_told(method):
    tau = None if method == "taylor" else 0.01
    for field in (("-x", "x - y"), ("y - x", "-x - y"), ("-x + cos(t)", "-y**3")):
        run = core.integrate(smooth(("x", "y"), field, (1e6, 3.0)), (0.0, 20.0), tau=tau, method=method)
        assert TOLD not in run.warning
    slides = core.integrate("relay_feedback", (0.0, 50.0), tau=tau, method=method, sliding="continue")
    assert TOLD not in slides.warning


def test_a_narrow_peak_is_compared_in_other_tolerances():
    f = "-4*(t - 0.8)/((t - 0.8)**2 + w**2)**3"
    system = core.PiecewiseSystem("Peak", ("x",), (f,), (f,), "x + 1e20", parameters={"w": 1.4e-6})
    run = core.integrate(system, (0.0, 3.0), (0.8**-4,), method="taylor")
    assert abs(run.x[-1, 0] - 2.2**-4) > 1e6
    assert TOLD in run.warning
