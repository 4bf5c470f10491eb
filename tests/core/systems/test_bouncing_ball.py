"""Bouncing ball: free fall, speeds that halve, and the time at which infinitely many bounces are over."""

import math

import numpy as np
import pytest

import core
from core import Status

BALL = core.CATALOGUE["bouncing_ball"]
EPS = np.finfo(float).eps
FALL, SPEED = math.sqrt(2 / 9.8), math.sqrt(2 * 9.8)  # from the height 1


def test_the_ball_stops_where_its_bounces_accumulate():
    run = core.integrate(BALL, (0.0, 50.0), tau=1e-2)
    assert run.status is Status.ZENO
    assert run.t[-1] == pytest.approx(1.3552618543578767, abs=4 * EPS)
    assert np.abs(run.x[-1]).max() < SPEED / 2**48  # the bounces that were left take less than an ulp of the time


def test_every_bounce_comes_when_and_as_fast_as_free_fall_says():
    run = core.integrate(BALL, (0.0, 50.0), tau=1e-2)
    n = np.arange(30)
    # The flight after bounce n takes 2 FALL / 2**n; free fall is quadratic, so dmm2 makes no error but round-off.
    assert run.crossings.t[:30] == pytest.approx(FALL * (3 - 4 * 0.5 ** (n + 1)), abs=64 * EPS)
    assert run.crossings.x[:30, 1] == pytest.approx(-SPEED * 0.5**n, abs=16 * EPS * SPEED)
    assert run.crossings.x_after[:30, 1] == pytest.approx(SPEED * 0.5 ** (n + 1), abs=16 * EPS * SPEED)
    assert set(run.crossings.kind) == {"jump"}
    assert (run.side == 1).all()


def test_a_perfect_ball_bounces_for_ever_at_the_height_it_came_from():
    run = core.integrate(BALL.with_parameters(restitution=1.0), (0.0, 50.0), tau=1e-2)
    assert run.status is Status.COMPLETED
    # Each bounce starts from the last: their round-off, of times up to 50, adds up.
    exact = FALL * (2 * np.arange(len(run.crossings)) + 1)
    assert len(exact) == 55
    assert np.abs(run.crossings.t - exact).max() <= 55 * 50 * EPS
    energy = run.system.conserved(1, run.t, run.x)[:, 0]
    assert np.abs(energy - 9.8).max() <= 55 * 9.8 * EPS
