"""How runs of a method that chooses its steps end where these get ever shorter towards a pole."""

import re

import numpy as np
import pytest
import scipy

import core
from core import Status


def growing(field, g="y + 5", f_minus="1", x0=1.0):
    """One coordinate, which grows where g is positive."""
    return core.PiecewiseSystem("Growing", ("y",), (f_minus,), (field,), g, x0=(x0,))


@pytest.mark.parametrize(
    ("field", "pace"),
    [
        ("y**2 + sin(y)", lambda y: y**2 + np.sin(y)),
        ("y**2 + sin(y**2)", lambda y: y**2 + np.sin(y**2)),
    ],
)
def test_a_field_that_varies_ever_faster_towards_a_pole_ends_the_run_soon_and_tells_when_the_pole_is(field, pace):
    run = core.integrate(growing(field), (0.0, 6.0), method="taylor")
    assert run.status is Status.ESCAPED
    assert run.steps < 300_000
    told = float(re.search(r"a pole at about t = ([\d.]+),", run.message)[1])
    parts = [scipy.integrate.quad(lambda y: 1.0 / pace(y), a, a + 1.0, limit=500)[0] for a in range(1, 100)]
    assert told == pytest.approx(sum(parts) + 0.01, abs=2e-4)


def test_backward_in_time_it_does_so_too():
    system = growing("-(y**2 + sin(y))", f_minus="-1")
    back, forth = (
        core.integrate(s, (0.0, t), method="taylor") for s, t in ((system, -6.0), (growing("y**2 + sin(y)"), 6.0))
    )
    assert (back.status, back.steps) == (forth.status, forth.steps)
    assert back.reason == forth.reason.replace("t = ", "t = -")


def test_a_surface_before_the_pole_is_met():
    """The run is within some hundred thousand steps of the surface when the solution beyond it has a pole."""
    system = growing("y**2 + sin(y)", "3e6 - y", "-1")
    run = core.integrate(system, (0.0, 6.0), method="taylor", sliding="stop")
    assert run.status is Status.SLIDING
    assert run.x[-1, 0] == pytest.approx(3e6)


def test_a_limit_of_steps_that_no_higher_one_mends_says_so():
    run = core.integrate(growing("y**2*(1 + sin(y)/2)"), (0.0, 6.0), method="taylor", max_steps=20_000)
    assert run.status is Status.STEP_LIMIT
    assert re.search(r"Steps have become so short that \de\d+ more would lead to the end time", run.message)
    assert "raise the limit" not in run.message


def test_a_limit_of_steps_that_a_higher_one_mends_says_that():
    run = core.integrate("harmonic_oscillator", (0.0, 1000.0), method="taylor", max_steps=300)
    assert run.status is Status.STEP_LIMIT
    assert "raise the limit" in run.message


@pytest.mark.parametrize("t_end", [8.0, -8.0])
def test_so_does_one_whose_pole_only_its_own_growth_tells(t_end):
    way = "" if t_end > 0 else "-"
    fields = (
        f"{way}(1.6*y + 0.06*(2 + sin(y))**1.7 + x*(x**2 + y**2 - 1)/10)",
        f"{way}(-1.6*x + 3*y*(x**2 + y**2 - 1)/20)",
    )
    system = core.PiecewiseSystem("Far", ("x", "y"), fields, fields, "x + 1e6", x0=(0.96, 0.99))
    run = core.integrate(system, (0.0, t_end), method="taylor")
    assert run.status is Status.ESCAPED, run.message
    assert run.steps < 1_000_000
    told = float(re.search(r"a pole at about t = (-?[\d.]+),", run.message)[1])

    def paced(_, y):  # t and x over a time in which a pole is never reached
        x, r2 = y[1:], y[1] ** 2 + y[2] ** 2 - 1
        f = 1.6 * x[1] + 0.06 * (2 + np.sin(x[1])) ** 1.7 + x[0] * r2 / 10, -1.6 * x[0] + 3 * x[1] * r2 / 20
        return np.array([1.0, *f]) / (2.0 + r2)

    oracle = scipy.integrate.solve_ivp(paced, (0.0, 60.0), (0.0, 0.96, 0.99), method="DOP853", rtol=1e-8, atol=1e-8)
    assert np.abs(oracle.y[1:, -1]).max() > 100, "what is left of the time is of the order of its inverse square"
    assert abs(told) == pytest.approx(oracle.y[0, -1], abs=1e-3)


@pytest.mark.parametrize("field", ["y**2 + sin(y)", "y**2 + sin(y**2)", "y**1.5 + sin(y**2)", "y**2 + cos(y)*y"])
def test_members_of_an_ensemble_end_soon_before_such_a_pole_as_single_runs_do(field):
    x0 = np.random.default_rng(0).uniform(0.5, 2.0, (3, 1))
    found = core.ensemble(growing(field), (0.0, 6.0), x0=x0, method="taylor", max_steps=600_000)
    for k, x in enumerate(x0):
        run = core.integrate(growing(field), (0.0, 6.0), tuple(x), method="taylor", record="end", max_steps=600_000)
        assert Status(int(found.status[k])) is run.status is Status.ESCAPED
        assert (found.t[k], *found.x[k]) == (run.t[-1], *run.x[-1])
