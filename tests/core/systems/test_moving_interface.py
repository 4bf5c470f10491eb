"""Moving interface, against rotations that meet y = a sin(wt)."""

import math

import numpy as np

import core
from tests.core.systems.arcs import crossings

MOVING = core.CATALOGUE["moving_interface"]
EPS = np.finfo(float).eps
OMEGA, A, W = {-1: math.sqrt(3.0), 1: 1.0}, 0.5, 0.7


def flow(side, s, state):
    x, y = state
    omega, angle = OMEGA[side], OMEGA[side] * s
    return np.array([
        x * math.cos(angle) + y / omega * math.sin(angle), y * math.cos(angle) - omega * x * math.sin(angle)
    ])  # fmt: skip


def height(t, state):
    return state[1] - A * math.sin(W * t)


def test_the_moving_line_is_met_when_and_where_rotations_say():
    run = core.integrate(MOVING, (0.0, 50.0), tau=1e-3, method="rk4", record="crossings")
    t, x = crossings(flow, height, MOVING.x0, 1, 21)
    assert len(run.crossings) == 21
    assert np.abs(run.crossings.t - t).max() < 1e-11  # tau**4 times a factor of 10
    assert np.abs(run.crossings.x - x).max() < 1e-11


def test_crossings_of_dmm2_lie_on_the_line_where_it_then_is():
    run = core.integrate(MOVING, (0.0, 50.0), tau=1e-2, record="crossings")
    line = A * np.sin(W * run.crossings.t)
    assert np.abs(run.crossings.x[:, 1] - line).max() <= 32 * EPS  # an ulp of t, up to 50, moves the line by 0.35


def test_energy_changes_at_crossings_and_stays_in_bounds_for_a_long_time():
    run = core.integrate(MOVING, (0.0, 2000.0), tau=1e-2, record="crossings")
    entered = run.system.conserved(1, run.crossings.t, run.crossings.x)[run.crossings.side == 1, 0]
    assert run.status is core.Status.COMPLETED
    assert np.ptp(entered) > 0.1
    assert 1.0 < entered.min() <= entered.max() < 2.5
    assert (run.crossings.rate_before * run.crossings.rate_after > 1.0).all()
