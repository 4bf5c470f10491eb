"""Three bodies: energy, both momenta and the angular momentum are conserved, through collisions too."""

import numpy as np
import pytest

import core
from core import Status
from tests.levels import deep_but

BODIES = core.CATALOGUE["three_bodies"]
EPS = 2.0**-52


def invariants(x):
    """Energy, momenta and angular momentum of states (n, 12), written out anew."""
    r, p = x[:, :6].reshape(-1, 3, 2), x[:, 6:].reshape(-1, 3, 2)
    energy = 0.5 * (p**2).sum(axis=(1, 2))
    for i, j in ((0, 1), (0, 2), (1, 2)):
        energy -= 1 / np.sqrt(((r[:, i] - r[:, j]) ** 2).sum(axis=1) + 0.25)
    turning = (r[:, :, 0] * p[:, :, 1] - r[:, :, 1] * p[:, :, 0]).sum(axis=1)
    return np.column_stack([energy, p.sum(axis=1), turning])


@pytest.mark.parametrize("method", deep_but(["dmm2", "taylor"], ["dmm2", "prk8", "taylor"]))
def test_what_is_conserved_stays_through_collisions(method):
    run = core.integrate(BODIES, (0.0, 40.0), tau=0.02, method=method)
    assert run.status is Status.COMPLETED
    assert len(run.crossings) >= 3
    assert set(run.crossings.kind) == {"jump"}
    apart = np.hypot(*(run.x[:, :2] - run.x[:, 2:4]).T)
    assert apart.min() > 0.6 - 1e-12, "hard discs do not overlap"
    values = invariants(run.x)
    # Sums of nine terms up to 2 in size, evaluated in doubles here; each collision rounds the velocities once more.
    assert np.abs(values - values[0]).max() < 32 * EPS * (1 + len(run.crossings))


def test_a_collision_exchanges_the_velocities_along_the_line_of_centres():
    run = core.integrate(BODIES, (0.0, 40.0), tau=0.02, method="prk8")
    for met in run.crossings:
        line = (met.x[:2] - met.x[2:4]) / 0.6
        before, after = (x[6:].reshape(3, 2) for x in (met.x, met.x_after))
        assert after[0] @ line == pytest.approx(before[1] @ line, abs=1e-13)
        assert after[1] @ line == pytest.approx(before[0] @ line, abs=1e-13)
        assert np.array_equal(after[2], before[2])
