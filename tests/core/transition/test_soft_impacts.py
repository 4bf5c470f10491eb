"""Impacts so soft that rounding hides whether the surface is reached, and impacts after which the state rests on it."""

from __future__ import annotations

import math

import numpy as np
import pytest

import core
from core import Region, Status

WALLS = core.CATALOGUE["two_walls"]
OSCILLATION, ENERGY = ("v", "-x"), ("(v**2 + x**2)/2",)
METHODS = ("dmm2", "rk4", "rk8", "prk8", "gauss4", "taylor")


def wall(jump: tuple[str, str], f: tuple[str, str] = OSCILLATION, psi: tuple[str, ...] = ENERGY) -> core.System:
    """A wall at x = 1, beyond which no law is declared."""
    regions = {"-": Region(f=f, psi=psi)}
    return core.PiecewiseSystem("Wall", ("x", "v"), surfaces=("x - 1",), regions=regions, jumps={0: jump}, x0=(0, 2))


def two_laws(jump: tuple[str, str]) -> core.System:
    """A surface at x = 1 at which the state jumps, between two equal laws."""
    return core.PiecewiseSystem(
        "Two laws", ("x", "v"), OSCILLATION, OSCILLATION, "x - 1", ENERGY, ENERGY, x0=(0, 2), jump=jump
    )


def is_soft(run: core.Trajectory) -> bool:
    """Whether a run goes on, or ends at an impact of which rounding of the place hides the speed."""
    grazes = run.status is Status.GRAZING and abs(run.x[-1][1]) < 1e-6  # v² is of the size of the rounding of x
    return run.status is Status.COMPLETED or grazes


def test_swings_that_just_reach_the_walls_do_not_slide_along_them():
    run = core.integrate(WALLS, (0.0, 1300.0), record="crossings")
    assert run.t[-1] > 1000.0
    assert is_soft(run), run.message


@pytest.mark.parametrize("method", METHODS)
def test_ever_softer_impacts_are_carried_on_or_end_as_a_touch_within_the_walls(method):
    rng = np.random.default_rng(1)
    for _ in range(20):
        restitution, stiffness = rng.uniform(0.3, 0.97), rng.uniform(0.3, 3.0)
        tau = None if method == "taylor" else float(10 ** rng.uniform(-2.5, -1.5))
        system = WALLS.with_parameters(restitution=restitution, stiffness=stiffness)
        speed = rng.uniform(1.5, 3.0) * math.sqrt(stiffness)
        end = 120.0 / (math.sqrt(stiffness) * (1.0 - restitution))
        run = core.integrate(system, (0.0, end), (0.0, speed), tau, method, record="crossings")
        assert is_soft(run), run.message
        assert (run.crossings.x_after[:-1, 0] * run.crossings.x_after[:-1, 1] < 0.0).all()


@pytest.mark.parametrize("method", METHODS)
def test_no_soft_impact_leads_beyond_a_surface_with_a_law_on_either_side(method):
    for restitution in (0.5, 0.7, 0.9):
        run = core.integrate(two_laws(("x", f"-{restitution}*v")), (0.0, 1100.0), method=method, tau=None)
        assert is_soft(run), run.message
        assert run.x[:, 0].max() < 1.0 + 1e-14


@pytest.mark.parametrize("system", [wall(("x", "0*v")), two_laws(("x", "0*v"))], ids=lambda s: s.name)
@pytest.mark.parametrize("method", ["dmm2", "rk4", "taylor"])
def test_a_state_at_rest_after_a_jump_leaves_where_the_field_curves_away(system, method):
    run = core.integrate(system, (0.0, 6.0), tau=None if method == "taylor" else 1e-3, method=method)
    assert run.status is Status.COMPLETED, run.message
    assert run.crossings.kind.tolist() == ["jump"]
    assert run.x[-1, 0] == pytest.approx(math.cos(6.0 - math.pi / 6.0), abs=1e-5)
    many = core.ensemble(
        system, (0.0, 6.0), np.array([(0.0, 2.0)] * 2), tau=None if method == "taylor" else 1e-3, method=method
    )
    assert (many.x == run.x[-1]).all()


def test_a_state_at_rest_after_a_jump_stays_where_the_field_presses_it_on():
    run = core.integrate(wall(("x", "0*v"), ("v", "1"), ("v**2/2 - x",)), (0.0, 6.0))
    assert (run.status, run.crossings.kind.tolist()) == (Status.SLIDING, ["sliding"])
    assert "the field does not lead away from the surface after the jump" in run.message
