"""Pendulum, against elliptic functions: sin(q/2) = k sn(ωs | k²) from the bottom, ω² = gravity over length."""

import math

import numpy as np
from scipy.special import ellipj, ellipk, ellipkinc

import core

PENDULUM = core.CATALOGUE["pendulum"]
EPS = np.finfo(float).eps
K_MINUS, K_PLUS, ANGLE, START = 3.7, 9.8, 0.5, -1.57
ENERGY = -K_MINUS * math.cos(START)
SPEED = math.sqrt(2 * (ENERGY + K_MINUS * math.cos(ANGLE)))  # at every crossing, up and down


def quarter_and_part(k, energy):
    """Times from the bottom to the turning point, and to the angle where gravity changes."""
    m = (energy / k + 1) / 2
    return ellipk(m) / math.sqrt(k), ellipkinc(math.asin(math.sin(ANGLE / 2) / math.sqrt(m)), m) / math.sqrt(k)


def exact_times(count):
    quarter, part = quarter_and_part(K_MINUS, ENERGY)
    quarter_up, part_up = quarter_and_part(K_PLUS, SPEED**2 / 2 - K_PLUS * math.cos(ANGLE))
    visits = [2 * (quarter_up - part_up), 2 * (quarter + part)]
    return np.cumsum([quarter + part, *(visits * count)])[:count]


def test_pendulum_crosses_when_the_elliptic_integrals_say():
    run = core.integrate(PENDULUM, (0.0, 50.0), tau=1e-3, method="rk4", record="crossings")
    assert len(run.crossings) == 33
    assert np.abs(run.crossings.t - exact_times(33)).max() < 2e-11  # tau**4 times a factor of 20


def test_pendulum_passes_the_angle_at_one_speed_whatever_the_step_size():
    # psi fixes the orbit, so dmm2 errs in time only. The bound: 16 eps of a level of size 4, as in test_catalogue.
    for tau in (1e-2, 1e-1):
        x = core.integrate(PENDULUM, (0.0, 50.0), tau=tau, record="crossings").crossings.x
        assert np.abs(x[:, 0] - ANGLE).max() <= 2 * EPS
        assert np.abs(np.abs(x[:, 1]) - SPEED).max() <= 16 * EPS * 4


def test_pendulum_under_one_gravity_follows_the_jacobi_functions():
    one = PENDULUM.with_parameters(k_minus=4.0, k_plus=4.0)
    run = core.integrate(one, (0.0, 20.0), tau=1e-3, method="rk4", record="end")
    modulus = math.sin(START / 2)
    _, cn, dn, _ = ellipj(2 * 20.0, modulus**2)
    q = 2 * math.asin(modulus * cn / dn)  # from rest: sn, a quarter of a period on
    assert abs(run.x[-1, 0] - q) < 1e-10
