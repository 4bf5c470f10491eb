"""Damped oscillator, against its closed form: each half-swing takes π/ω, and loses speed by exp(-γπ/2mω)."""

import math

import numpy as np

import core

DAMPED = core.CATALOGUE["damped_oscillator"]
EPS = np.finfo(float).eps
GAMMA = {-1: 0.05, 1: 0.2}
OMEGA = {side: math.sqrt(2.0 - gamma**2 / 4) for side, gamma in GAMMA.items()}


def exact_crossings(count):
    """Times and speeds, from rest at x = 1."""
    t = (math.pi - math.atan(2 * OMEGA[1] / GAMMA[1])) / OMEGA[1]
    v = -math.sqrt(2.0) * math.exp(-GAMMA[1] * t / 2)  # psi: m v²/2 exp(γt/m) = k/2 at x = 0
    found = []
    for k in range(count):
        found.append((t, v))
        side = -1 if k % 2 == 0 else 1
        t += math.pi / OMEGA[side]
        v *= -math.exp(-GAMMA[side] * math.pi / (2 * OMEGA[side]))
    return np.array(found).T


def test_damped_oscillator_crosses_at_the_exact_times_and_speeds():
    run = core.integrate(DAMPED, (0.0, 50.0), tau=1e-3, method="rk4", record="crossings")
    t, v = exact_crossings(22)
    assert len(run.crossings) == 22
    assert np.abs(run.crossings.t - t).max() < 2e-11  # tau**4 times a factor of 20
    assert np.abs(run.crossings.x[:, 1] - v).max() < 2e-12


def test_dmm2_crosses_at_order_two_where_psi_names_time():
    # With t in psi the speed at x = 0 follows from the time of the crossing, and is no better than that.
    t, v = exact_crossings(22)
    runs = [core.integrate(DAMPED, (0.0, 50.0), tau=tau, record="crossings").crossings for tau in (2e-2, 1e-2)]
    coarse, fine = (max(np.abs(k.t - t).max(), np.abs(k.x[:, 1] - v).max()) for k in runs)
    assert 3.8 < coarse / fine < 4.2


def test_each_visit_keeps_the_level_it_starts_on_though_energy_is_lost():
    run = core.integrate(DAMPED, (0.0, 50.0), tau=1e-2)
    # exp(γt/m) grows to exp(10); the energy falls from 2 by exp(-6.25), at the mean of both γ: a level of 2 exp(3.75).
    assert np.nanmax(np.abs(run.conserved_error())) <= 16 * EPS * 2 * math.exp(3.75)
    speed = np.abs(run.crossings.x[:, 1])
    assert (np.diff(speed) < 0).all()
