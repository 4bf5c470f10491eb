"""How a solution grows: by steps of the method itself, against closed forms."""

import math

import numpy as np
import pytest

import core
from core.integrate import checked_settings
from core.integration.failure import Growth
from core.integration.runner import Runner

METHODS = ["rk2", "rk8", "gauss4", "taylor"]


def follow(f, method, x0, t_end, step=0.1):
    """Follow x' = f(x) from x0 > 0, with a surface that is never met."""
    system = core.PiecewiseSystem("one law", ("x",), f_minus=(f,), f_plus=(f,), g="x + 1e9", x0=(x0,))
    chosen = core.METHODS[method]
    runner = Runner(system, chosen, 0.0, (x0,), checked_settings(chosen, None if chosen.adaptive else step))
    runner.advance(1e-3 * t_end)
    return runner.follow(0.0, np.array([x0]), t_end, math.copysign(step, t_end), x0)


@pytest.mark.parametrize("method", METHODS)
def test_a_solution_with_a_pole_grows_and_one_that_ends_before_it_does_not(method):
    assert follow("x**2", method, 1.0, 2.0) is Growth.LARGE  # x = 1/(1 − t)
    assert follow("x**2", method, 1.0, 0.9) is Growth.BOUNDED
    assert follow("x**2", method, 1.0, -50.0) is Growth.BOUNDED


@pytest.mark.parametrize("method", METHODS)
def test_an_exponential_grows_by_a_million_after_fourteen_units_of_time(method):
    assert follow("x", method, 1.0, 13.0) is Growth.BOUNDED  # e¹³ = 4e5
    assert follow("x", method, 1.0, 15.0) is Growth.LARGE  # e¹⁵ = 3e6
    assert follow("x", method, 1.0, math.log(1e6)) is None  # too near to tell


def test_a_field_that_ends_and_a_stiff_one_are_left_to_the_implicit_method():
    assert follow("-1/x", "rk8", 1.0, 1.0) is None  # x = √(1 − 2t) ends at t = 1/2
    assert follow("-1e9*(x - 1)", "rk8", 2.0, 1e4) is None


@pytest.mark.parametrize("tolerance", [1e-9, 1e-12, 1e-15])
@pytest.mark.parametrize("growth", [0.1, 0.2, 0.35])
def test_a_solution_that_grows_from_crossing_to_crossing_is_not_taken_for_steps_too_long(growth, tolerance):
    """Between two crossings it turns within bounds, but it has grown to 1e150 before, whatever the tolerance is."""
    growing = core.PiecewiseSystem(
        "Growing", ("x", "y"), ("y", "-x + b*y"), ("y", "-2*x + b*y"), "x", parameters={"b": growth}, x0=(1.0, 0.0)
    )
    run = core.integrate(growing, (0.0, 8000.0), method="taylor", tolerance=tolerance, record="crossings")
    assert run.status is core.Status.ESCAPED
    assert np.abs(run.x[-1]).max() > 1e148


def test_a_run_beyond_bounds_tells_a_pole_from_an_exponential():
    for f, x0, t_end, word in (("x**2", 1.0, 2.0, "beyond bounds"), ("x", 1.0, 400.0, "no pole was found")):
        system = core.PiecewiseSystem("one law", ("x",), f_minus=(f,), f_plus=(f,), g="x + 1e9", x0=(x0,))
        run = core.integrate(system, (0.0, t_end), tau=0.05, method="rk8", record="end")
        assert run.status is core.Status.ESCAPED
        assert word in run.message
