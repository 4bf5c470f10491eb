"""What the page draws and says where no state can be."""

import numpy as np
import pytest

import core
from pwsviz.geometry.phase_plane import backdrop
from pwsviz.geometry.walls import bare_name
from pwsviz.geometry.window import Window
from tests.pwsviz.own_systems import OWN_SYSTEMS, WALL

BALL = core.CATALOGUE["bouncing_ball"]
WINDOW = Window(-2.0, 2.0, -2.0, 2.0)


def test_the_rest_of_the_plane_is_named_by_what_it_lacks():
    assert bare_name(WALL, {0}) == "beyond the wall", "no law is declared there, and no run arrives"
    assert bare_name(core.CATALOGUE["two_walls"], {0}) == "beyond the wall"
    assert bare_name(core.CATALOGUE["diode_bridge"], {0, 1, 2}) == "no law"
    assert bare_name(BALL, {1}) == "beyond the wall"
    assert bare_name(BALL, {0, 1}) == ""
    assert bare_name(OWN_SYSTEMS["Relay"], {0, 1}) == "", "regions with names leave no rest"


def rows_left_of(lines, edge):
    return np.count_nonzero(lines[:, 0] < edge)


def test_beyond_a_wall_are_neither_arrows_nor_level_sets_nor_a_tint():
    ground = backdrop(BALL, WINDOW, {1: (9.8,)})
    half_an_arrow = 0.1
    for part, edge in ((ground.arrows, -half_an_arrow), (ground.levels, -1e-9), (ground.orbit_levels, -1e-9)):
        assert sum(rows_left_of(part[shade], edge) for shade in (-1, 1)) == 0
        assert np.isfinite(part[1]).any()
    assert ground.minus_outer == []
    (ring,) = ground.bare_outer
    assert (ring.min(axis=0), ring.max(axis=0)) == (pytest.approx([-2, -2]), pytest.approx([0, 2]))
    assert [region[1] for region in ground.formulas["regions"]] == ["g > 0"]


def test_where_a_run_is_beyond_a_wall_there_are_arrows_and_level_sets():
    ground = backdrop(BALL, WINDOW, {0: (-9.8,)})
    assert all(np.isfinite(part[-1]).any() for part in (ground.arrows, ground.levels, ground.orbit_levels))
    assert ground.minus_outer
    assert not ground.bare_outer


def test_beyond_a_moving_wall_the_browser_has_nothing_to_paint():
    fall, jump = ("v", "-1"), ("sin(t)", "2*cos(t) - v")
    table = core.PiecewiseSystem("table", ("y", "v"), fall, fall, "y - sin(t)", jump=jump, x0=(1.0, 0.0))
    ground = backdrop(table, WINDOW, {})
    assert set(ground.whole) == {1}
    assert ground.formulas["bare"] == "beyond the wall"


def test_a_line_of_the_grid_on_which_two_surfaces_meet_is_no_region():
    """In a window of this size x = −1 and x = 1 are lines of the grid, on which the height of every region is 0."""
    chua = core.CATALOGUE["chua"]
    assert backdrop(chua, Window(-4.0, 4.0, -4.0, 4.0), {}).bare_outer == []
