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
