"""The first look at a system: the plane where its run is not flat, and no room where its laws do not hold."""

import numpy as np
import pytest

import core
from pwsviz.geometry.first_view import first_plane, with_room
from pwsviz.geometry.window import Window

TURN = np.linspace(0.0, 20.0, 500)


def in_space(g):
    return core.PiecewiseSystem(
        name="space", variables=("x", "y", "z"), f_minus=("1", "0", "0"), f_plus=("1", "0", "0"), g=g,
        x0=(1.0, 0.0, 0.0),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("sizes", "g", "plane"),
    [
        ((1.0, 0.5, 1.0), "x", (0, 1)),  # not flat: the first two variables, though others are rounder
        ((1.0, 0.1, 0.9), "x", (0, 2)),
        ((1.0, 0.1, 0.09), "x", (1, 2)),  # where it is least flat, and no other is round
        ((0.1, 1.0, 0.6), "x", (1, 2)),
        ((1.0, 0.5, 1.0), "z", (0, 2)),  # of the first two variables no surface would be seen
        ((1.0, 0.5, 0.01), "z", (0, 1)),
        ((1.0, 0.0, 0.0), "x", (0, 1)),  # along a line: nowhere round
    ],
)
def test_a_run_is_first_looked_at_in_a_plane_where_it_is_not_flat(sizes, g, plane):
    states = np.column_stack([size * np.cos(TURN + k) for k, size in enumerate(sizes)])
    assert first_plane(in_space(g), states) == plane
    assert first_plane(in_space(g), np.vstack([states, [[np.nan] * 3, [np.inf] * 3]])) == plane


def test_of_round_planes_the_one_that_shows_the_surface_is_first():
    states = np.column_stack([np.cos(TURN), 0.01 * np.cos(TURN), 0.5 * np.sin(TURN), 0.4 * np.sin(TURN)])
    system = core.PiecewiseSystem(
        name="space", variables=("x", "y", "z", "w"), f_minus=("1", "0", "0", "0"), f_plus=("1", "0", "0", "0"),
        g="x + w", x0=(1.0, 0.0, 0.0, 0.0),
    )  # fmt: skip
    assert first_plane(system, states) == (0, 3)


def test_room_is_left_where_the_laws_hold():
    prey = core.CATALOGUE["predator_prey"]  # ψ has log x and log y
    assert with_room(prey, Window(0.0, 4.0, 0.0, 2.0)) == Window(0.0, 4.0, 0.0, 4.0)
    assert with_room(prey, Window(0.0, 1.0, 0.0, 3.0)) == Window(0.0, 3.0, 0.0, 3.0)
    oscillator = core.CATALOGUE["harmonic_oscillator"]
    wide = Window(0.0, 4.0, 0.0, 2.0)
    assert with_room(oscillator, wide) == wide  # the browser adds room on both sides
    assert with_room(core.CATALOGUE["kepler"], wide) == wide


def test_room_avoids_regions_without_a_law():
    beside = core.PiecewiseSystem(
        name="beside", variables=("x", "y"), surfaces=("y", "y - 10"),
        regions={"+-": core.Region(f=("1", "0")), "++": core.Region(f=("1", "0"))}, x0=(0.0, 1.0),
    )  # fmt: skip
    assert with_room(beside, Window(0.0, 4.0, 0.5, 1.5)) == Window(0.0, 4.0, 0.5, 4.5)


def test_room_avoids_what_lies_beyond_a_wall():
    ball = core.CATALOGUE["bouncing_ball"]  # y > 0, with a law beyond the wall, too
    assert with_room(ball, Window(-0.5, 1.5, -4.0, 3.0)) == Window(-0.5, 6.5, -4.0, 3.0)
