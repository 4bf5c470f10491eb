"""Hénon–Heiles with a wall: bounces conserve the energy; without the wall the orbit is SciPy's."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import core
from core import Status

WALLED = core.CATALOGUE["henon_heiles"]
EPS = 2.0**-52


@pytest.mark.parametrize("method", ["dmm2", "prk8", "taylor"])
def test_energy_is_conserved_through_every_bounce(method):
    run = core.integrate(WALLED, (0.0, 200.0), tau=0.05, method=method)
    assert run.status is Status.COMPLETED
    assert set(run.crossings.kind) == {"jump"}
    assert len(run.crossings) > 30
    assert (run.side == 1).all()
    assert run.crossings.x_after[:, 2] == pytest.approx(-run.crossings.x[:, 2])
    x, y, u, v = run.x.T
    energy = (u**2 + v**2 + x**2 + y**2) / 2 + x**2 * y - y**3 / 3
    # The energy is some 0.09, of terms up to 0.1; each bounce rounds it once more.
    assert np.abs(energy - energy[0]).max() < 0.2 * EPS * (4 + len(run.crossings) / 2)


def test_far_from_the_wall_the_orbit_is_that_of_scipy():
    start = (0.3, 0.1, 0.2, 0.1)
    run = core.integrate(WALLED.with_parameters(wall=0.6), (0.0, 20.0), start, tau=0.02, method="rk8")
    assert run.crossing_count == 0

    def field(_, s):
        x, y, u, v = s
        return [u, v, -x - 2 * x * y, -y - x * x + y * y]

    found = solve_ivp(field, (0.0, 20.0), start, method="DOP853", rtol=1e-13, atol=1e-14)
    assert run.x[-1] == pytest.approx(found.y[:, -1], abs=1e-9)
