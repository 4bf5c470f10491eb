"""A run whose errors decide on which side it passes a saddle says so, though one in half steps takes the same side."""

import numpy as np
import pytest

import core

SLOW = "nearly comes to rest"


def _pendulum():
    """Energy cos(0) is the separatrix: with less of it |x| stays below π, and with more it comes to 4.5."""
    return core.PiecewiseSystem(
        "Over or not", ("x", "v"), ("v", "-sin(x)"), ("v", "-sin(x) - v/10"), "x**2 - 4.5**2", x0=(1.0, 0.0)
    )  # fmt: skip


#: Method, tau, end, start; of each a run in half steps takes the wrong side, too.
WRONG = [
    ("rk4", 0.4, 30.0, (1.1601652759870635, 1.6728339298991055)),
    ("gauss4", 0.4, 60.0, (0.050220547864090914, 1.9993693647791069)),
    ("rk2", 0.05, 60.0, (-0.12199235134378883, -1.9962813749399342)),
]


@pytest.mark.parametrize(("method", "tau", "end", "start"), WRONG)
def test_a_pendulum_that_errors_carry_to_the_other_side_of_its_upper_rest_is_told(method, tau, end, start):
    energy = start[1] ** 2 / 2 - np.cos(start[0]) - 1.0  # above that of the upper rest
    run = core.integrate(_pendulum(), (0.0, end), start, tau=tau, method=method)
    assert (run.crossing_count > 0) != (energy > 0.0), "it takes the wrong side"
    assert SLOW in run.warning, run.warning


@pytest.mark.parametrize("part", [-1e-2, 1e-2])
@pytest.mark.parametrize(("method", "tau"), [("rk2", 0.01), ("rk4", 0.1), ("gauss4", 0.1)])
def test_one_that_passes_its_rest_farther_away_than_its_errors_is_not(method, tau, part):
    run = core.integrate(_pendulum(), (0.0, 12.0), (0.0, float(np.sqrt(4.0 + 2.0 * part))), tau=tau, method=method)
    assert (run.crossing_count > 0) == (part > 0.0), "it takes the right side"
    assert run.warning == ""


@pytest.mark.parametrize("method", ["rk2", "rk4"])
def test_a_slow_pass_that_leads_on_along_one_way_only_is_not(method):
    """x' = ε + x² is slow near 0, and every solution goes on through it; a swing that dies out is slow for ever."""
    for field, x0 in ((("1/1000 + x**2", "-y"), (-1.0, 1.0)), (("y", "-x - y/5"), (1.0, 0.0))):
        system = core.PiecewiseSystem("Slow", ("x", "y"), field, field, "x - 3", x0=x0)
        run = core.integrate(system, (0.0, 90.0), tau=0.02, method=method)
        assert SLOW not in run.warning, run.warning
