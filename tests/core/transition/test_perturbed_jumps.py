"""Jumps at a surface that the run has not landed on: at a perturbed time, or without a transition."""

from __future__ import annotations

import numpy as np
import pytest

import core
from core import Status


def wall(rng: np.random.Generator, moves: bool, one_sided: bool) -> core.PiecewiseSystem:
    """A ball that bounces at a floor, which may move, below which the same law or none is declared."""
    e, a = round(rng.uniform(0.6, 1.2), 2), round(rng.uniform(0.05, 0.15), 3) if moves else 0.0
    k, law = round(rng.uniform(0.0, 0.5), 2), "-1 - {k}*x"
    g, jump = f"x - {a}*sin(t)", ("x", f"{a}*cos(t) - {e}*(v - {a}*cos(t))")
    field = ("v", law.format(k=k))
    if one_sided:
        region = {"+": core.Region(field)}
        return core.PiecewiseSystem("wall", ("x", "v"), surfaces=(g,), regions=region, jumps={0: jump}, x0=(1.0, 0.0))
    return core.PiecewiseSystem("wall", ("x", "v"), field, field, g, jump=jump, x0=(1.0, 0.0))


@pytest.mark.parametrize("one_sided", [True, False])
@pytest.mark.parametrize("moves", [True, False])
def test_a_bounce_at_a_perturbed_time_costs_as_much_before_as_behind_the_wall(draws, moves, one_sided):
    for rng in draws(3):
        system, end = wall(rng, moves, one_sided), 4.0
        exact = core.integrate(system, (0.0, end), method="rk8", tau=0.005)
        for order in (1, 2):
            errors = []
            for scale in (1.0, -1.0):
                run = core.integrate(
                    system, (0.0, end), method="rk8", tau=0.005, perturbation_order=order, perturbation_scale=scale
                )
                assert run.status is Status.COMPLETED, run.message
                assert len(run.crossings) == len(exact.crossings)
                errors.append(run.x[-1] - exact.x[-1])
            displaced = 0.005**order
            assert 0.05 * displaced < np.abs(errors).max() < 50.0 * displaced
            np.testing.assert_allclose(errors[0], -errors[1], atol=0.2 * np.abs(errors).max())


@pytest.mark.parametrize("one_sided", [True, False])
def test_a_bounce_that_is_stepped_over_is_one_bounce_of_first_order(draws, one_sided):
    for rng in draws(3):
        system, end = wall(rng, False, one_sided), 4.0
        exact = core.integrate(system, (0.0, end), method="rk8", tau=0.005)
        for tau in (0.01, 0.002):
            run = core.integrate(system, (0.0, end), method="rk4", tau=tau, transition="none")
            assert run.status is Status.COMPLETED, run.message
            assert len(run.crossings) == len(exact.crossings)
            assert np.abs(run.x[-1] - exact.x[-1]).max() < 20.0 * tau


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("tau", [0.02, 0.001])
def test_bounces_that_are_nearer_than_the_perturbation_moves_them_end_the_run_and_it_says_so(order, tau):
    region = {"+": core.Region(("v", "-1"))}
    ball = core.PiecewiseSystem(
        "ball", ("x", "v"), surfaces=("x",), regions=region, jumps={0: ("x", "-v/2")}, x0=(1.0, 0.0)
    )
    for scale, status in ((-1.0, Status.ZENO), (1.0, Status.NO_CONVERGENCE)):
        run = core.integrate(
            ball, (0.0, 20.0), tau=tau, method="rk4", perturbation_order=order, perturbation_scale=scale
        )
        assert run.status is status, run.message
        assert len(run.crossings) < 200
        assert abs(run.t[-1] - 3.0 * np.sqrt(2.0)) < 60.0 * tau**order + tau, "where the bounces accumulate"
    assert "a perturbed crossing has moved the state" in run.message
