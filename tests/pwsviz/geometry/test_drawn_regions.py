"""Tint, arrows and level sets lie in the regions that they belong to. The oracle is numpy: no law is asked."""

import numpy as np
import pytest

import core
from pwsviz.geometry.phase_plane import GRID, ROWS, backdrop
from pwsviz.geometry.shades import regions_of, shades_of
from pwsviz.geometry.window import ARROWS, Window
from tests.pwsviz.own_systems import GATE, STRIPS, WALL, WEDGE

WINDOW = Window(-3.0, 3.1, -2.0, 2.05)
CELL = WINDOW.height / GRID
SPEED = 1.5

#: A field everywhere in the window, on one side.
PLAIN = core.PiecewiseSystem("plain", ("x", "y"), ("1", "0"), ("1", "0"), "x + 10")

#: For each region height (positive inside), field and ψ at points (x, y); all of them are regions of a plane.
STRIPS_BY_HAND = {
    "--": (lambda x, y: -1 - x, lambda x, y: (1 + 0 * x, 2 + 0 * x), lambda x, y: 2 * x - y),
    "+-": (lambda x, y: np.minimum(x + 1, 1 - x), lambda x, y: (SPEED + 0 * x, 0 * x), lambda x, y: y),
    "++": (lambda x, y: x - 1, lambda x, y: (y, 2 - x), lambda x, y: (x - 2) ** 2 + y**2),
}
WEDGE_BY_HAND = {
    "--": (lambda x, y: np.minimum(y - x, -x - y), lambda x, y: (2 + 0 * x, -1 + 0 * x), lambda x, y: x + 2 * y),
    "-+": (lambda x, y: np.minimum(y - x, x + y), lambda x, y: (1 + 0 * x, -0.25 + 0 * x), lambda x, y: x + 4 * y),
    "++": (lambda x, y: np.minimum(x - y, x + y), lambda x, y: (1 + 0 * x, 0.5 + 0 * x), lambda x, y: x - 2 * y),
}
WALL_BY_HAND = {"+": (lambda x, v: x, lambda x, v: (v, -1 + 0 * x), lambda x, v: v * v / 2 + x)}

by_hand = pytest.mark.parametrize(
    ("system", "hand"),
    [(STRIPS, STRIPS_BY_HAND), (WEDGE, WEDGE_BY_HAND), (WALL, WALL_BY_HAND)],
    ids=["strips", "wedge", "wall"],
)


def finite(lines):
    return lines[np.isfinite(lines).all(axis=1)]


def lines_of(points):
    """The pieces of a curve between its gaps."""
    gaps = np.flatnonzero(np.isnan(points).any(axis=1))
    return [finite(part) for part in np.split(points, gaps) if len(finite(part))]


def is_inside(rings, points):
    """Whether each point lies within an odd number of closed rings."""
    x, y = points.T
    odd = np.zeros(len(points), dtype=bool)
    for ring in rings:
        (ax, ay), (bx, by) = ring[:-1].T[:, :, None], ring[1:].T[:, :, None]
        with np.errstate(all="ignore"):
            met = ((ay > y) != (by > y)) & (x < ax + (y - ay) / (by - ay) * (bx - ax))
        odd ^= met.sum(axis=0) % 2 == 1
    return odd


def shafts(rows):
    """Tails and tips of arrows."""
    return [rows[: len(rows) // ROWS * ROWS].reshape(-1, ROWS, 2)[:, k] for k in (0, 1)]


def middles(rows):
    return np.add(*shafts(rows)) / 2


def names_of(system, shade):
    return [list(system.regions)[k] for k in regions_of(system, shade)]


def highest(hand, names, x, y):
    """Height above the boundary of the region that a point lies in; negative beyond all of these regions."""
    return np.max([hand[name][0](x, y) for name in names], axis=0) if names else np.full(np.shape(x), -np.inf)


@by_hand
def test_the_tint_covers_the_regions_of_the_first_shade_and_nothing_else(system, hand):
    ground = backdrop(system, WINDOW, {})
    rings = [*ground.minus_outer, *(ring for holes in ground.minus_holes for ring in holes)]
    rng = np.random.default_rng(2)
    points = rng.uniform([WINDOW.x_low, WINDOW.y_low], [WINDOW.x_high, WINDOW.y_high], (4000, 2))
    height = highest(hand, names_of(system, -1), *points.T)
    clear = np.abs(height) > CELL
    assert np.array_equal(is_inside(rings, points[clear]), height[clear] > 0)


@by_hand
def test_where_no_law_is_declared_and_only_there_the_plane_is_bare(system, hand):
    ground = backdrop(system, WINDOW, {})
    rings = [*ground.bare_outer, *(ring for holes in ground.bare_holes for ring in holes)]
    points = np.random.default_rng(5).uniform(WINDOW[::2], WINDOW[1::2], (4000, 2))
    height = highest(hand, list(hand), *points.T)
    clear = np.abs(height) > CELL
    assert np.array_equal(is_inside(rings, points[clear]), height[clear] < 0)


def test_the_backdrop_of_a_view_depends_on_its_place_and_size_alone():
    rng = np.random.default_rng(6)
    for _ in range(200):
        x, y, width, height = rng.uniform(-5, 5, 4)
        view = Window(x, x + np.exp(width), y, y + np.exp(height))
        covered = view.surroundings()
        assert covered.shows_well(view)
        assert 1.3 * view.longest <= covered.longest * (1 + 1e-9) <= 2.7 * view.longest
        nearby = Window(*(np.array(view) + 0.3 * view.longest))
        assert covered.longest == pytest.approx(nearby.surroundings().longest), "after a pan arrows are as dense"
        cell = covered.longest / ARROWS
        shift = (covered.x_low - nearby.surroundings().x_low) / cell
        assert shift == pytest.approx(round(shift), abs=1e-6), "and stand where they stood"
        assert not covered.shows_well(view.scaled(0.4)), "a view of another size has a backdrop of its own"


@by_hand
def test_each_arrow_has_the_direction_of_the_field_of_its_region_and_each_region_its_arrows(system, hand):
    ground, everywhere = backdrop(system, WINDOW, {}), middles(backdrop(PLAIN, WINDOW, {}).arrows[1])
    for shade in (-1, 1):
        names = names_of(system, shade)
        middle, along = middles(ground.arrows[shade]), np.subtract(*shafts(ground.arrows[shade])[::-1])
        told = np.zeros(len(middle), dtype=int)
        for name in names:
            height, field, _ = hand[name]
            there = height(*middle.T) > 0
            told += there
            wanted = np.column_stack(field(*middle[there].T))
            wanted /= np.linalg.norm(wanted, axis=1, keepdims=True)
            unit = along[there] / np.linalg.norm(along[there], axis=1, keepdims=True)
            assert np.abs(unit - wanted).max() < 1e-12
            assert middle[there] == pytest.approx(everywhere[height(*everywhere.T) > 0], abs=1e-12)
        assert (told == 1).all(), "each lies in one region of its shade"


@by_hand
def test_level_sets_have_the_value_of_psi_of_the_region_in_which_they_lie(system, hand):
    points = np.random.default_rng(3).uniform(WINDOW[::2], WINDOW[1::2], (200, 2)).T
    given = {
        k: tuple(hand[name][2](*points)[hand[name][0](*points) > 0.2][:2].tolist())
        for k, name in enumerate(system.regions)
    }
    ground = backdrop(system, WINDOW, given)
    for shade in (-1, 1):
        names = names_of(system, shade)
        for drawn in (ground.levels[shade], ground.orbit_levels[shade]):
            for line in lines_of(drawn):
                x, y, value = line.T
                homes = [name for name in names if (hand[name][0](x, y) > -0.1 * CELL).all()]
                assert homes, "a level set does not leave its region"
                errors = [np.abs(hand[name][2](x, y) - value).max() for name in homes]
                assert min(errors) < 5e-3
            assert all(
                any((hand[name][0](*line.T[:2]) > -0.1 * CELL).all() for line in lines_of(drawn)) for name in names
            ), "each region has some"


def test_straight_level_sets_lead_from_one_surface_to_the_other():
    ground = backdrop(STRIPS, WINDOW, {1: (0.25,)})
    for lines in (ground.levels[-1], ground.orbit_levels[-1]):
        for line in lines_of(lines):
            assert (line[:, 0].min(), line[:, 0].max()) == (pytest.approx(-1.0, abs=1e-9), pytest.approx(1.0, abs=1e-9))
            assert np.abs(line[:, 1] - line[:, 2]).max() < 1e-12
    assert len(lines_of(ground.levels[-1])) == 7
    assert len(lines_of(ground.orbit_levels[-1])) == 1


def test_a_straight_level_set_that_enters_a_disc_and_leaves_it_is_drawn_inside():
    disc = core.PiecewiseSystem("disc", ("x", "y"), ("1", "0"), ("0", "1"), "x**2 + y**2 - 1", ("y",), ("x",))
    (line,) = lines_of(backdrop(disc, WINDOW, {0: (0.5,)}).orbit_levels[-1])
    assert line[:, 0].min() == pytest.approx(-np.sqrt(0.75), abs=1e-3)
    assert line[:, 0].max() == pytest.approx(np.sqrt(0.75), abs=1e-3)


def test_levels_of_orbits_belong_to_the_region_of_their_number():
    ground = backdrop(STRIPS, WINDOW, {2: (0.5,)})
    assert not np.isfinite(ground.orbit_levels[-1]).any()
    (line,) = lines_of(ground.orbit_levels[shades_of(STRIPS, np.array([2]))[0]])
    assert np.abs(np.hypot(line[:, 0] - 2, line[:, 1]) - np.sqrt(0.5)).max() < 1e-2


def test_usual_level_sets_divide_each_region_by_itself():
    points = np.random.default_rng(4).uniform(WINDOW[::2], WINDOW[1::2], (20_000, 2))
    ground = backdrop(STRIPS, WINDOW, {})
    for name, (height, _, psi) in STRIPS_BY_HAND.items():
        shade = int(shades_of(STRIPS, np.array([list(STRIPS.regions).index(name)]))[0])
        lines = [line for line in lines_of(ground.levels[shade]) if (height(*line.T[:2]) > -0.1 * CELL).all()]
        values = np.unique(np.concatenate([line[:, 2] for line in lines]))
        inside = psi(*points[height(*points.T) > 0].T)
        shares = np.diff([0.0, *((inside < value).mean() for value in values), 1.0])
        assert shares == pytest.approx([0.5 / 7, *[1 / 7] * 6, 0.5 / 7], abs=0.02)


def test_of_moving_surfaces_only_tint_and_curves_are_drawn():
    ground = backdrop(GATE, WINDOW, {})
    assert ground.minus_outer
    assert np.isfinite(ground.surface).any()
    assert ground.whole == {}
    assert not any(np.isfinite(part[shade]).any() for part in (ground.arrows, ground.levels) for shade in (-1, 1))


def test_a_level_set_that_meets_the_surface_at_a_line_of_the_grid_ends_there():
    for window in (Window(-2.0, 2.0, -2.0, 2.0), Window(-1.0, 3.0, -2.0, 2.0), Window(-4.0, 1.0, -2.0, 2.0)):
        (line,) = lines_of(backdrop(STRIPS, window, {1: (0.25,)}).orbit_levels[-1])
        assert (line[:, 0].min(), line[:, 0].max()) == (-1.0, 1.0)
    halves = core.PiecewiseSystem("halves", ("x", "y"), ("1", "0"), ("2", "0"), "x", ("y",), ("2*y",))
    ground = backdrop(halves, Window(-2.0, 2.0, -2.0, 2.0), {})
    for side in (-1, 1):
        assert len(lines_of(ground.levels[side])) == 7
        for line in lines_of(ground.levels[side]):
            assert sorted(line[:, 0] * side) == [0.0, 2.0]
