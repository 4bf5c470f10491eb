"""The reference integrator's own estimate of its error."""

import numpy as np
import pytest

import core
from core.reference.taylor import TaylorSolution


@pytest.mark.parametrize(("t0", "least"), [(0.0, 1e-16), (1e6, 1e-10)])
def test_an_error_is_no_less_than_the_rounding_of_time_and_state(t0, least):
    """Late, a unit in the last place of t is a large part of any error, and both runs have it alike."""
    system = core.CATALOGUE["pendulum"]
    solution = TaylorSolution(system, np.array(system.x0), t0)
    t, _ = solution.crossing(1)
    assert solution.error > least
    assert solution.error >= np.spacing(t)
    later = TaylorSolution(system, np.array(system.x0), t0)
    assert later.error < least
    later.state(t0 + 3.0)
    assert later.error > least


def test_the_error_is_no_less_than_what_is_lost_where_coarse_steps_pass_a_peak_of_the_field():
    """A spiral passes the peak exp(-(b x)²) in the middle of steps, after which no coefficient tells of it."""
    bumped = "2*x + a*y + c*exp(-(b*x)**2)"
    spiral = core.PiecewiseSystem(
        "spiral", ("x", "y"), ("a*x - 2*y", bumped), ("a*x - 2*y - 0.2", bumped), "x - 0.3",
        parameters={"a": 0.53, "b": 1.21, "c": 0.74}, x0=(1.0, 0.0),
    )  # fmt: skip
    for a, b, c, end in ((0.53, 1.21, 0.74, 7.04), (0.48, 1.22, 0.47, 11.96), (0.45, 1.11, 0.47, 9.54)):
        system = spiral.with_parameters(a=a, b=b, c=c)
        by_short_steps = core.integrate(system, (0.0, end), tau=5e-4, method="rk8").x[-1]
        solution = TaylorSolution(system, np.array(system.x0), 0.0)
        apart = np.abs(solution.state(end) - by_short_steps).max()
        assert apart <= solution.error + 1e-10 * np.abs(by_short_steps).max()
