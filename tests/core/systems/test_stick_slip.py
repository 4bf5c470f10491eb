"""Stick-slip: the block sticks until the spring pulls with the static friction, and slips as SciPy says."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import core
from core import Status

BELT = core.CATALOGUE["stick_slip"]


def test_the_block_is_carried_until_the_spring_pulls_with_the_static_friction():
    run = core.integrate(BELT, (0.0, 60.0), tau=1e-2, method="rk8", sliding="continue")
    assert run.status is Status.COMPLETED
    assert run.crossings.kind.tolist()[:4] == ["sliding", "leaving", "sliding", "leaving"]
    left = run.crossings[run.crossings.kind == "leaving"]
    assert len(left) >= 5
    assert left.x == pytest.approx(np.tile([1.0, 0.3], (len(left), 1)), abs=1e-14)
    carried = run.mode == 2
    assert run.x[carried, 1] == pytest.approx(0.3, abs=1e-14)


def test_the_period_is_that_of_the_slip_and_the_ride_back():
    run = core.integrate(BELT, (0.0, 60.0), method="taylor", sliding="continue")
    left, caught = (run.crossings[run.crossings.kind == kind] for kind in ("leaving", "sliding"))

    def slip(_, x):
        return [x[1], -x[0] + 0.4 + 0.6 * np.exp((x[1] - 0.3) / 0.5)]

    def catches(t, x):
        return x[1] - 0.3 if t > 0.1 else -1.0

    catches.terminal, catches.direction = True, 1
    found = solve_ivp(slip, (0.0, 20.0), [1.0, 0.3], events=catches, rtol=1e-12, atol=1e-13, max_step=0.05)
    slipping, end = found.t[-1], found.y[0, -1]
    assert caught.t[1] - left.t[0] == pytest.approx(slipping, abs=1e-8)
    assert caught.x[1, 0] == pytest.approx(end, abs=1e-8)
    assert np.diff(left.t) == pytest.approx(slipping + (1.0 - end) / 0.3, abs=1e-8)
