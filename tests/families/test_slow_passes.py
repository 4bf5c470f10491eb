"""Swings that come near to an upper rest: a run that its errors lead over it, or not, against the energy, says so.

The oracle is the energy of the start: with less than at the rest the swing turns back, and with more it goes over. The
methods are of order 2: of order 4, errors of two steps, one half the other, are alike in one of some hundred draws.
"""

import numpy as np
import pytest
from scipy.integrate import quad

import core

PENDULUM = ("-sin(x)", lambda x: -np.cos(x), np.pi)
WELLS = ("x - x**3", lambda x: x**4 / 4 - x**2 / 2, 0.0)


def _time(potential, energy, x, top):
    """Time from x to beyond the top."""
    return quad(lambda q: 1 / np.sqrt(2 * (energy - potential(q))), x, top + 0.5, points=[top], limit=500)[0]


@pytest.mark.parametrize(("force", "potential", "top"), [PENDULUM, WELLS])
def test_a_run_that_takes_the_wrong_side_of_a_saddle_is_told(draws, force, potential, top):
    wrong = 0
    for rng in draws(60):
        above = float(10 ** rng.uniform(-7, -3) * rng.choice([1, -1]))
        x = top + float(rng.uniform(-1.3, -0.7) if top == 0.0 else rng.uniform(-4.0, -2.0))
        v = np.sqrt(2 * (potential(top) + above - potential(x)))
        law = ("v", force)
        system = core.PiecewiseSystem("Over or not", ("x", "v"), law, law, f"x - {top + 0.5!r}", x0=(x, float(v)))
        tau, end = float(rng.choice([0.02, 0.05, 0.1])), float(rng.choice([15, 30, 60]))
        run = core.integrate(system, (0.0, end), tau=tau, method="rk2")
        over = above > 0 and _time(potential, potential(top) + above, x, top) < end - 1
        if (above < 0 and run.crossing_count) or (over and not run.crossing_count):
            wrong += 1
            assert run.warning, (x, above, tau, end)
    assert wrong, "some draws are within the error"
