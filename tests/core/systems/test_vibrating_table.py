"""A ball on a vibrating table: bounces are those of parabolas that SciPy intersects with the table, and periodic ones
are where the impact law says.
"""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import core
from core import Status

TABLE = core.CATALOGUE["vibrating_table"]
LOSSY = TABLE.with_parameters(a=0.6, restitution=0.9)


def bounces(system, phi, v, count):
    """Phase and speed after each bounce, from just after one: flights are parabolas, omega = 1."""
    p = system.values
    found = []
    for _ in range(count):
        y = p["a"] * math.sin(phi)

        def gap(t, phi=phi, v=v, y=y):
            return y + v * t - p["gravity"] * t * t / 2 - p["a"] * math.sin(phi + t)

        low = high = 1e-2  # the ball has left the table by then, and is not back yet
        assert gap(low) > 0
        while gap(high) > 0:
            high += 1e-2
        t = brentq(gap, low, high, xtol=1e-15, rtol=1e-15)
        phi, v = phi + t, v - p["gravity"] * t
        v = (1 + p["restitution"]) * p["a"] * math.cos(phi) - p["restitution"] * v
        found.append((phi, v))
    return np.array(found)


@pytest.mark.parametrize("system", [TABLE, LOSSY], ids=["elastic", "lossy"])
def test_every_bounce_is_where_a_parabola_meets_the_table(system):
    start = (0.3, system.values["a"] * math.sin(0.3), 2.5)
    wanted = bounces(system, start[0], start[2], 12)
    found = core.section(system, (0.0, 1e6), start, points=12, method="taylor", tolerance=1e-13, tau=1.0)
    after = found.ensemble.crossings.x_after
    assert after[:, [0, 2]] == pytest.approx(wanted, abs=1e-9)
    assert after[:, 1] == pytest.approx(system.values["a"] * np.sin(after[:, 0]), abs=1e-14)


@pytest.mark.parametrize("turns", [1, 2])
def test_a_stable_periodic_bounce_attracts(turns):
    """One bounce in a whole number of turns n leaves with v = n*pi*gravity, and v = (1 + e)*a*cos(phi) + e*v."""
    e, a = LOSSY.values["restitution"], LOSSY.values["a"]
    v = turns * math.pi
    phi = math.acos(v * (1 - e) / ((1 + e) * a))
    start = (phi + 0.05, a * math.sin(phi + 0.05), v)
    found = core.section(LOSSY, (0.0, 1e6), start, points=3, discard=500, method="dmm2", tau=0.02)
    after = found.ensemble.crossings.x_after
    assert after[:, 2] == pytest.approx(v, abs=1e-9)
    assert np.mod(after[:, 0], 2 * math.pi) == pytest.approx(phi, abs=1e-9)


def test_regular_and_chaotic_orbits_lie_side_by_side():
    near = (math.pi / 2, 0.25, math.pi + 0.1)  # an island
    x0 = [near, (0.0, 3.0, 0.0)]
    found = core.section(TABLE, (0.0, 1e9), x0, points=3000, method="taylor", tolerance=1e-10, tau=1.0)
    speed, member = found.ensemble.crossings.x_after[:, 2], found.member
    assert np.abs(speed[member == 0] - math.pi).max() < 0.2
    assert np.ptp(speed[member == 1]) > 2.0
    assert found.ensemble.outcomes == {Status.CROSSING_LIMIT: 2}


@pytest.mark.parametrize("method", ["taylor", "rk4", "dmm2"])
@pytest.mark.parametrize("restitution", [0.3, 0.5, 0.7])
def test_a_ball_that_comes_to_rest_on_the_table_bounced_and_never_touched_it(restitution, method):
    """Where the last flights are lost in rounding a jump and a touch look alike."""
    run = core.integrate(TABLE.with_parameters(restitution=restitution), (0.0, 60.0), method=method)
    assert run.status is Status.ZENO
    assert set(run.crossings.kind) == {"jump"}
