"""In which direction a section counts crossings unless told otherwise, by the declaration alone."""

import pytest

import core
from pwsviz.geometry.section_crossings import chosen_direction, has_reset, is_one_way, usual_direction


@pytest.mark.parametrize(
    ("key", "direction"),
    [
        ("chua", 1), ("pendulum", 1), ("harmonic_oscillator", 1), ("gene_ring", 1),
        ("bouncing_ball", 0), ("two_walls", 0), ("thermostat", 0), ("stick_slip", 0), ("relay_feedback", 0),
        ("type_upward", 0), ("type_downward", 0),
    ],
)  # fmt: skip
def test_crossings_are_counted_where_g_rises_unless_the_surface_may_be_met_in_one_direction_only(key, direction):
    assert usual_direction(core.CATALOGUE[key], "", slides=True) == direction


def test_without_sliding_and_on_other_surfaces_crossings_are_counted_where_the_function_rises():
    assert usual_direction(core.CATALOGUE["stick_slip"], "", slides=False) == 1
    assert usual_direction(core.CATALOGUE["two_walls"], "v", slides=True) == 1


def test_a_reset_map_acts_at_its_own_surface_alone():
    walls = core.CATALOGUE["two_walls"]
    assert [has_reset(walls, of) for of in ("", "x - 1", "2*x + 2", "v")] == [True, True, True, False]
    assert is_one_way(core.CATALOGUE["thermostat"], "")
    assert not is_one_way(core.CATALOGUE["chua"], "")


@pytest.mark.parametrize(
    ("key", "of", "counted"), [("bouncing_ball", "", 0), ("bouncing_ball", "v", 1), ("chua", "", 1)]
)
def test_no_direction_is_chosen_at_a_wall(key, of, counted):
    assert chosen_direction(core.CATALOGUE[key], of, 1) == counted


def test_of_a_wall_and_a_surface_that_is_crossed_a_direction_is_chosen_unless_the_wall_alone_is_meant():
    regions = {name: core.Region(("v", "-1")) for name in ("+-", "++")}
    mixed = core.PiecewiseSystem(
        "mixed", ("x", "v"), surfaces=("x", "x - 1"), regions=regions, jumps={0: ("x", "-v")}, x0=(0.5, 0.0)
    )
    assert [is_one_way(mixed, of) for of in ("", "x", "x - 1")] == [False, True, False]
    assert [chosen_direction(mixed, of, -1) for of in ("", "x", "x - 1")] == [-1, 0, -1]
    assert usual_direction(mixed, "", slides=True) == 0, "else the wall would have no points"
