"""What is drawn is true in the plane shown; what is left out is named."""

import numpy as np
import pytest

import core
from pwsviz.geometry.phase_plane import Window, backdrop, closed_surface
from pwsviz.geometry.projection import (
    axis_labels,
    conserved_note,
    in_plane,
    planes,
    portrait_note,
    shows_levels,
    shows_surface,
    surface_name,
)

WINDOW = Window(-2.0, 2.0, -2.0, 2.0)
XY = (0, 1)


@pytest.mark.parametrize("name", list(core.CATALOGUE))
def test_the_surface_drawn_is_where_g_vanishes_whatever_is_not_shown(name):
    system = core.CATALOGUE[name]
    ground = backdrop(system, WINDOW, {})
    points = ground.surface[np.isfinite(ground.surface).all(axis=1)]
    assert (len(points) > 1) == shows_surface(system, XY) == bool(ground.minus_outer)
    hidden = np.random.default_rng(1).uniform(-1, 1, (len(points), system.dimension - 2))
    g = system.switching(0.0, np.column_stack([points, hidden]))
    assert np.abs(g).max(initial=0.0) < 1e-2


@pytest.mark.parametrize("name", list(core.CATALOGUE))
def test_level_sets_and_arrows_are_drawn_in_the_plane_only(name):
    system = core.CATALOGUE[name]
    ground = backdrop(system, WINDOW, {})
    for side in (-1, 1):
        assert np.isfinite(ground.levels[side]).any() == (shows_levels(system) and bool(system.psi_minus))
        assert (len(ground.arrows[side]) > 0) == (system.dimension == 2)


def test_a_surface_that_is_no_curve_in_the_plane_is_left_out_and_named():
    gene = core.CATALOGUE["gene_switch"]
    assert not shows_surface(gene, XY)
    assert len(closed_surface(gene, WINDOW)) == 0
    assert "z - threshold" in portrait_note(gene, XY)
    assert axis_labels(gene, XY) == ("x (z not shown)", "y")


def test_a_surface_of_the_shown_variables_is_drawn_in_any_dimension():
    assert len(closed_surface(core.CATALOGUE["kepler"], WINDOW)) > 10
    assert axis_labels(core.CATALOGUE["kepler"], XY) == ("x (u, v not shown)", "y")


def test_any_two_variables_span_a_portrait():
    kepler = core.CATALOGUE["kepler"]
    assert planes(kepler) == [(0, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 3)]
    assert not shows_surface(kepler, (2, 3))
    assert shows_surface(kepler, (1, 0))
    assert axis_labels(kepler, (3, 1)) == ("v (x, u not shown)", "y")
    x = np.arange(8.0).reshape(2, 4)
    assert np.array_equal(in_plane(x, (1, 3)), x[:, [1, 3]])
    assert np.array_equal(in_plane(x, (3, 1)), x[:, [3, 1]])


def test_a_swapped_plane_is_the_mirror_image():
    system = core.CATALOGUE["elliptic_curve"]
    plain, swapped = backdrop(system, WINDOW, {}), backdrop(system, WINDOW, {}, (1, 0))
    for side in (-1, 1):
        there = plain.arrows[side][np.isfinite(plain.arrows[side]).all(axis=1)]
        mirrored = swapped.arrows[side][np.isfinite(swapped.arrows[side]).all(axis=1)][:, ::-1]
        assert len(there) == len(mirrored)
    assert np.abs(np.linalg.norm(swapped.surface[:-1], axis=1) - 1).max() < 1e-2


def test_what_changes_with_time_is_named():
    moving, damped = core.CATALOGUE["moving_interface"], core.CATALOGUE["damped_oscillator"]
    assert "t = 0" in surface_name(moving)
    assert "moves with time" in portrait_note(moving, XY)
    assert shows_levels(moving)
    assert not shows_levels(damped)
    assert "level sets move" in portrait_note(damped, XY)


def test_a_planar_system_at_rest_needs_no_words():
    for name in ("elliptic_curve", "type_repelling", "bouncing_ball"):
        assert portrait_note(core.CATALOGUE[name], XY) == conserved_note(core.CATALOGUE[name]) == ""


def test_the_conserved_view_says_what_is_not_known():
    assert "no conserved quantity" in conserved_note(core.CATALOGUE["relay_feedback"])
    assert "2 conserved quantities" in conserved_note(core.CATALOGUE["rigid_body"])
    half = core.PiecewiseSystem("half", ("x", "y"), ("y", "-x"), ("y", "-x - y"), "x", psi_minus=("x**2 + y**2",))
    assert "where g > 0" in conserved_note(half)
