"""Diode circuit, against its closed form: on each side the charge turns about that of the biased capacitor."""

import math

import numpy as np
import pytest

import core

CIRCUIT = core.CATALOGUE["diode_circuit"]
EPS = np.finfo(float).eps
CAPACITANCE, INDUCTANCE, BIAS, CHARGE = {-1: 0.2, 1: 2.0}, 0.5, 0.2, 1.5
#: At every crossing, by the energy of the start at rest.
CURRENT = math.sqrt(2 / INDUCTANCE * (CHARGE**2 / (2 * CAPACITANCE[1]) - BIAS * CHARGE))


def visit(side):
    """How long a side is occupied: q = EC (1 - cos ωs) ± (i/ω) sin ωs vanishes at tan(ωs/2) = ∓ i/(ωEC)."""
    omega = 1 / math.sqrt(INDUCTANCE * CAPACITANCE[side])
    return 2 / omega * math.atan2(CURRENT / omega, -side * BIAS * CAPACITANCE[side])


def test_the_diode_switches_at_the_exact_times():
    run = core.integrate(CIRCUIT, (0.0, 50.0), tau=1e-3, method="rk4", record="crossings")
    resting = BIAS * CAPACITANCE[1]
    first = math.acos(-resting / (CHARGE - resting)) * math.sqrt(INDUCTANCE * CAPACITANCE[1])
    exact = np.cumsum([first, *([visit(-1), visit(1)] * 10)])
    assert len(run.crossings) == 21
    assert np.abs(run.crossings.t - exact).max() < 2e-11  # tau**4 times a factor of 20


@pytest.mark.parametrize("tau", [1e-2, 1e-1])
def test_the_current_is_the_same_at_every_crossing_whatever_the_step_size(tau):
    # psi fixes the orbit, so dmm2 errs in time only. The bound: 16 eps of terms of size 1.
    x = core.integrate(CIRCUIT, (0.0, 50.0), tau=tau, record="crossings").crossings.x
    assert np.abs(x[:, 0]).max() <= EPS
    assert np.abs(np.abs(x[:, 1]) - CURRENT).max() <= 16 * EPS
