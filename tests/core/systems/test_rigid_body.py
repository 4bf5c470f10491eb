"""Rigid body, against the Jacobi functions: y = (r sn, r cn, w dn)(ws | m r²/w²)."""

import math

import numpy as np
import pytest
from scipy.special import ellipk, ellipkinc

import core

BODY = core.CATALOGUE["rigid_body"]
EPS = np.finfo(float).eps
PLANE, RADIUS, M_MINUS, M_PLUS = 0.6, 1.0, 0.51, 0.9
#: y₃ at every crossing, by the second invariant from y₀ = (0, 1, 1).
HEIGHT = math.sqrt(1.0 - M_MINUS * PLANE**2)


def quarter_and_part(m):
    """Times from y₁ = 0 to its greatest value, and to the plane."""
    w2 = m * PLANE**2 + HEIGHT**2
    modulus = m * RADIUS**2 / w2
    return ellipk(modulus) / math.sqrt(w2), ellipkinc(math.asin(PLANE / RADIUS), modulus) / math.sqrt(w2)


def test_rigid_body_crosses_when_the_elliptic_integrals_say():
    run = core.integrate(BODY, (0.0, 50.0), tau=1e-3, method="rk4", record="crossings")
    (quarter, part), (quarter_up, part_up) = quarter_and_part(M_MINUS), quarter_and_part(M_PLUS)
    visits = [2 * (quarter_up - part_up), 2 * (quarter + part)]
    exact = np.cumsum([part, *(visits * 12)])[:13]
    assert len(run.crossings) == 13
    assert np.abs(run.crossings.t - exact).max() < 2e-11  # tau**4 times a factor of 20


@pytest.mark.parametrize("tau", [1e-2, 1e-1])
def test_rigid_body_meets_the_plane_in_the_same_two_points_whatever_the_step_size(tau):
    # Two invariants fix the orbit, so dmm2 errs in time only. The bound: 16 eps of levels of size 4.
    x = core.integrate(BODY, (0.0, 50.0), tau=tau, record="crossings").crossings.x
    spin = math.sqrt(RADIUS**2 - PLANE**2)
    expected = [(PLANE, spin if k % 2 == 0 else -spin, HEIGHT) for k in range(len(x))]
    assert np.abs(x - expected).max() <= 16 * EPS * 4


def test_rigid_body_of_one_inertia_reaches_the_state_of_detest_b5():
    one = BODY.with_parameters(m_plus=M_MINUS)
    run = core.integrate(one, (0.0, 20.0), x0=(0.0, 1.0, 1.0), tau=1e-3, method="rk4", record="end")
    exact = (-0.9396570798729202, -0.3421177754000749, 0.7414126596199953)  # (sn, cn, dn)(20 | 0.51)
    assert np.abs(run.x[-1] - exact).max() < 1e-10
