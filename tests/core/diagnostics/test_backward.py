"""Backward in time jumps are made as forward: a run says so where that does not undo them."""

from __future__ import annotations

import pytest

import core

FALLS = ("v", "-1")


def ball(jump: tuple[str, str]) -> core.PiecewiseSystem:
    return core.PiecewiseSystem("Ball", ("x", "v"), FALLS, FALLS, "x", jump=jump, x0=(1.0, 0.0))


@pytest.mark.parametrize("record", ["steps", "end"])
def test_a_jump_that_is_not_its_own_inverse_is_told_backward_in_time_alone(record):
    # From (1, 0) the ball is at (0.49117, 0.54558) at t = 2; back from there it is not at (1, 0).
    system = ball(("x", "-0.8*v"))
    assert core.integrate(system, (0.0, 2.0), tau=0.01, record=record).warning == ""
    back = core.integrate(system, (2.0, 0.0), (0.49117, 0.54558), tau=0.01, record=record)
    assert "the jump at x = 0 is made as it is forward in time, not undone" in back.warning


def test_an_elastic_impact_undoes_itself():
    system = ball(("x", "-v"))
    there = core.integrate(system, (0.0, 2.0), tau=0.01)
    back = core.integrate(system, (2.0, 0.0), tuple(there.x[-1].tolist()), tau=0.01)
    assert (back.warning, back.x[-1].tolist()) == ("", pytest.approx([1.0, 0.0], abs=1e-12))


def test_a_jump_off_its_surface_is_told_though_it_is_never_met():
    reset = core.PiecewiseSystem("Reset", ("x", "y"), ("1", "-y"), ("1", "-y"), "1 - x", jump=("x - 0.7", "2*y + 1"))
    back = core.integrate(reset, (1.9, 0.0), (0.5, 1.0), tau=0.01, method="rk4")
    assert back.crossing_count == 0
    assert "not undone" in back.warning


def test_hysteresis_is_not_undone():
    back = core.integrate(core.CATALOGUE["thermostat"], (2.0, 0.0), tau=0.01, method="rk4")
    assert "the transition at" in back.message
