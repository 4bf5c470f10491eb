"""Dry friction: turning points nearer by 2μ at multiples of π, until the block sticks."""

import math

import numpy as np
import pytest

import core
from core import Status

FRICTION = core.CATALOGUE["coulomb_friction"]
EPS = np.finfo(float).eps
TURNS = [-2.2, 1.4, -0.6, -0.2]


@pytest.mark.parametrize("tau", [1e-2, 1e-1])
def test_turning_points_are_exact_whatever_the_step_size(tau):
    run = core.integrate(FRICTION, (0.0, 50.0), tau=tau)
    assert run.crossings.x[:, 0] == pytest.approx(TURNS, abs=16 * EPS)  # of numbers up to 3, four times
    assert run.crossings.kind.tolist() == ["transversal"] * 3 + ["sliding"]


def test_the_block_sticks_at_four_pi():
    run = core.integrate(FRICTION, (0.0, 50.0), tau=1e-3, method="rk4")
    assert run.status is Status.SLIDING
    assert "slides along" in run.message
    assert run.crossings.t == pytest.approx(np.pi * np.arange(1, 5), abs=1e-12)  # tau**4
    assert run.t[-1] == run.crossings.t[-1]
    assert run.x[-1] == pytest.approx((-0.2, 0.0), abs=1e-12)


@pytest.mark.parametrize("mu", [0.05, 0.3, 0.7, 1.1])
def test_every_turning_point_is_nearer_by_twice_the_friction_until_it_is_within_it(mu):
    run = core.integrate(FRICTION.with_parameters(mu=mu), (0.0, 200.0))
    y = np.abs([3.0, *run.crossings.x[:, 0]])
    inside = 3.0 % (2 * mu)
    assert len(run.crossings) == math.ceil((3.0 - mu) / (2 * mu))
    assert y[1:-1] == pytest.approx(3.0 - 2 * mu * np.arange(1, len(y) - 1), abs=64 * EPS)
    assert y[-1] == pytest.approx(min(inside, 2 * mu - inside), abs=64 * EPS)
    assert run.status is Status.SLIDING


@pytest.mark.parametrize(("y", "status"), [(0.3, Status.SLIDING), (-0.3, Status.SLIDING), (0.5, Status.COMPLETED)])
def test_a_block_at_rest_moves_only_if_the_spring_is_stronger_than_the_friction(y, status):
    run = core.integrate(FRICTION, (0.0, 1.0), x0=(y, 0.0))
    assert run.status is status
    assert (run.steps > 0) == (status is Status.COMPLETED)
    if run.steps:
        assert (run.side == -np.sign(y)).all()  # at rest it lies on the surface; the spring decides
