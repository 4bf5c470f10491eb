"""Kepler with a shell, against Kepler's equation inside and outside."""

import math

import numpy as np

import core

KEPLER = core.CATALOGUE["kepler"]
EPS = np.finfo(float).eps
MU_INSIDE, MU_OUTSIDE, RADIUS = 3.0, 4.0, 1.0
START, SPEED = 1.2, 1.55  # across
MOMENTUM = START * SPEED
ENERGY_OUTSIDE = SPEED**2 / 2 - MU_OUTSIDE / START
ENERGY_INSIDE = ENERGY_OUTSIDE + (MU_OUTSIDE - MU_INSIDE) / RADIUS
RADIAL_SPEED = math.sqrt(2 * (ENERGY_OUTSIDE + MU_OUTSIDE / RADIUS) - (MOMENTUM / RADIUS) ** 2)


def from_perihelion(mu, energy):
    """Time and angle from the perihelion to the shell, and from the perihelion to the aphelion."""
    axis, eccentricity = -mu / (2 * energy), math.sqrt(1 + 2 * energy * MOMENTUM**2 / mu**2)
    anomaly = math.acos((1 - RADIUS / axis) / eccentricity)
    angle = math.acos((MOMENTUM**2 / (mu * RADIUS) - 1) / eccentricity)
    slow = math.sqrt(axis**3 / mu)
    return slow * (anomaly - eccentricity * math.sin(anomaly)), angle, slow * math.pi


def exact_crossings(count):
    """Times and polar angles: from the aphelion in, through, and round outside."""
    time_in, angle_in, _ = from_perihelion(MU_INSIDE, ENERGY_INSIDE)
    time_out, angle_out, half = from_perihelion(MU_OUTSIDE, ENERGY_OUTSIDE)
    outside = (half - time_out, math.pi - angle_out)
    visits = [(2 * time_in, 2 * angle_in), (2 * outside[0], 2 * outside[1])] * count
    return np.cumsum([outside, *visits], axis=0)[:count].T


def test_the_planet_meets_the_shell_when_and_where_keplers_equation_says():
    run = core.integrate(KEPLER, (0.0, 50.0), tau=1e-3, method="rk4", record="crossings")
    t, angle = exact_crossings(41)
    assert len(run.crossings) == 41
    assert np.abs(run.crossings.t - t).max() < 2e-10  # tau**4 times a factor of 200: there are twelve turns
    assert np.abs(run.crossings.x[:, 0] - RADIUS * np.cos(angle)).max() < 2e-10
    assert np.abs(run.crossings.x[:, 1] - RADIUS * np.sin(angle)).max() < 2e-10


def test_energy_and_momentum_fix_the_velocity_at_the_shell_whatever_the_step_size():
    # Two invariants in four dimensions leave time and angle to err, and nothing else.
    for tau in (1e-2, 5e-2):
        x, y, u, v = core.integrate(KEPLER, (0.0, 50.0), tau=tau, record="crossings").crossings.x.T
        radial = (x * u + y * v) / RADIUS
        bound = 16 * EPS * 4  # levels have terms up to 4
        assert np.abs(np.abs(radial) - RADIAL_SPEED).max() <= bound
        assert np.abs((x * v - y * u) - MOMENTUM).max() <= bound
