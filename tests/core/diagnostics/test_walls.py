"""Where a state can be: beyond a wall, at which every run bounces, none is, though a law is declared there."""

import pytest

import core
from core.diagnostics import inhabited

BALL = core.CATALOGUE["bouncing_ball"]


def impacts(jump, f_plus=("v", "-1"), f_minus=("v", "-1"), g="y", x0=(1.0, 0.0)):
    return core.PiecewiseSystem("impacts", ("y", "v"), f_minus, f_plus, g, parameters={"r": 0.5}, jump=jump, x0=x0)


@pytest.mark.parametrize("key", core.CATALOGUE)
def test_a_region_of_the_catalogue_is_beyond_a_wall_if_and_only_if_no_run_enters_it(key):
    system, there = core.CATALOGUE[key], inhabited(core.CATALOGUE[key])
    run = core.integrate(system, (0.0, 20.0), tau=0.01, method="rk4", max_crossings=200)
    met = {mode for mode in run.mode.tolist() if mode < len(system.regions)}
    assert met <= there
    walled = {"bouncing_ball": {0}, "vibrating_table": {0}, "henon_heiles": {0}}
    assert set(range(len(system.regions))) - there == walled.get(key, set())


def test_a_reset_map_that_lets_runs_through_or_may_do_so_makes_no_wall():
    assert inhabited(impacts(("0", "-r*v"))) == {1}
    assert inhabited(impacts(("0", "r*v"))) == {0, 1}, "the speed keeps its sign"
    assert inhabited(impacts(("0", "1 - v"))) == {0, 1}, "slow ones come back, fast ones do not"
    assert inhabited(impacts(("-1", "-r*v"))) == {0, 1}, "it leads beyond"


def test_what_is_beyond_a_wall_depends_on_the_parameters_and_on_where_runs_are():
    assert inhabited(impacts(("0", "-r*v")).with_parameters(r=-0.5)) == {0, 1}
    assert inhabited(BALL, met=(0,)) == {0, 1}
    assert inhabited(impacts(("0", "-r*v"), x0=(-1.0, 0.0))) == {0}


def test_a_start_at_a_wall_is_in_the_regions_on_both_sides():
    assert inhabited(impacts(("0", "-r*v"), x0=(0.0, 1.0))) == {0, 1}


def test_beside_a_wall_that_moves_a_late_start_is_judged_at_its_time():
    f = ("v", "-1")
    wall = core.PiecewiseSystem(
        "wall", ("x", "v"), f, f, "x - c*(t - T)", parameters={"T": 1000.0, "c": -0.2}, x0=(1.0, 0.0),
        jump=("x", "-(v - c) + c"),
    )  # fmt: skip
    for height, beyond in ((1.0, False), (-1.0, True)):
        run = core.integrate(wall, (1000.0, 1001.0), x0=(height, 0.0), method="rk4", tau=0.01)
        assert ("beyond a wall" in run.message) == beyond
