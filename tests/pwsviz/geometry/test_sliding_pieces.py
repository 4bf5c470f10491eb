"""The pieces of the surface along which states slide, and those that repel."""

import numpy as np
import pytest

import core
from pwsviz.geometry.phase_plane import backdrop
from pwsviz.geometry.window import Window

WINDOW = Window(-3.0, 3.0, -2.0, 2.0)


def ends(points):
    there = points[np.isfinite(points).all(axis=1)]
    return (there.min(axis=0), there.max(axis=0)) if len(there) else None


def pieces(points):
    """The pieces of a line, each from its gap to the next."""
    gaps = np.flatnonzero(np.isnan(points).any(axis=1))
    return [part[np.isfinite(part).all(axis=1)] for part in np.split(points, gaps) if len(part) > 1]


def quadrants(surfaces=("x", "y"), **fields):
    """A system of two surfaces, with a constant field in each region: keys mm, mp, pm and pp for the signs."""
    signs = {"m": "-", "p": "+"}
    regions = {"".join(signs[s] for s in key): core.Region(f) for key, f in fields.items()}
    return core.PiecewiseSystem(name="quadrants", variables=("x", "y"), surfaces=surfaces, regions=regions)


UP, DOWN = ("1", "1"), ("1", "-1")


def test_a_block_sticks_where_the_spring_is_weaker_than_the_friction():
    found = backdrop(core.CATALOGUE["coulomb_friction"], WINDOW, {})
    low, high = ends(found.attracting)
    assert low == pytest.approx([-0.4, 0.0], abs=1e-9)
    assert high == pytest.approx([0.4, 0.0], abs=1e-9)
    assert ends(found.repelling) is None


def test_a_watershed_repels_along_its_whole_length():
    found = backdrop(core.CATALOGUE["type_repelling"], WINDOW, {})
    low, high = ends(found.repelling)
    assert (low[0], high[0]) == (-3.0, 3.0)
    assert ends(found.attracting) is None


@pytest.mark.parametrize("name", ["bouncing_ball", "moving_interface", "harmonic_oscillator", "two_walls"])
def test_no_piece_is_drawn_where_a_state_jumps_the_surface_moves_or_both_fields_cross_it(name):
    found = backdrop(core.CATALOGUE[name], WINDOW, {})
    assert ends(found.attracting) is ends(found.repelling) is None


def test_pieces_of_one_surface_stop_at_the_other():
    found = backdrop(quadrants(mm=UP, mp=DOWN, pm=DOWN, pp=UP), WINDOW, {})
    (attracting,), (repelling,) = pieces(found.attracting), pieces(found.repelling)
    assert ends(attracting) == (pytest.approx([-3.0, 0.0], abs=1e-9), pytest.approx([0.0, 0.0], abs=1e-9))
    assert ends(repelling) == (pytest.approx([0.0, 0.0], abs=1e-9), pytest.approx([3.0, 0.0], abs=1e-9))


def test_where_one_side_of_a_surface_has_no_law_nothing_slides():
    found = backdrop(quadrants(mm=UP, mp=DOWN, pp=DOWN), WINDOW, {})
    low, high = ends(found.attracting)
    assert (low, high) == (pytest.approx([-3.0, 0.0], abs=1e-9), pytest.approx([0.0, 0.0], abs=1e-9))
    assert ends(found.repelling) is None


def test_pieces_of_curves_that_cross_lie_on_their_curve_where_both_fields_point_to_it():
    # x = y² is crossed from left to right; the circle attracts to the left of it, and is crossed on the right.
    fields = {"mm": ("3 + x", "y"), "mp": ("3 - x", "-y"), "pm": ("1", "0"), "pp": ("1", "0")}
    found = backdrop(quadrants(("x - y**2", "x**2 + y**2 - 1"), **fields), WINDOW, {})
    points = found.attracting[np.isfinite(found.attracting).all(axis=1)]
    x, y = points.T
    assert np.abs(np.hypot(x, y) - 1.0).max() < 3e-3

    def rates(x, y):
        return x * (3 + x) + y * y, x * (3 - x) - y * y

    assert (rates(x, y)[0] > -1e-2).all(), "from within outwards"
    assert (rates(x, y)[1] < 1e-2).all(), "from beyond inwards"
    angle = np.linspace(-np.pi, np.pi, 2001)
    cx, cy = np.cos(angle), np.sin(angle)
    there = (rates(cx, cy)[0] > 0) & (rates(cx, cy)[1] < 0) & (cx < cy**2)
    nearest = np.abs(np.angle(np.exp(1j * (angle[there][:, None] - np.arctan2(y, x))))).min(axis=1)
    assert there.any()
    assert nearest.max() < 0.05, "and all of it is drawn"
    assert (x < y**2 + 1e-2).all()


@pytest.mark.parametrize("sign", [1, -1])
def test_a_piece_between_two_others_stops_at_both(sign):
    surfaces = ("y", "x + 1", "x - 1")
    regions = {
        side + strip: core.Region(("0", f"{-1 if (side == '+') == (strip == '+-') else 1}*{sign}"))
        for side in "-+"
        for strip in ("--", "+-", "++")
    }
    system = core.PiecewiseSystem(name="strips", variables=("x", "y"), surfaces=surfaces, regions=regions)
    found = backdrop(system, WINDOW, {})
    inner, outer = (found.attracting, found.repelling) if sign > 0 else (found.repelling, found.attracting)
    (middle,) = pieces(inner)
    assert ends(middle) == (pytest.approx([-1.0, 0.0], abs=1e-9), pytest.approx([1.0, 0.0], abs=1e-9))
    left, right = sorted(pieces(outer), key=lambda piece: piece[:, 0].mean())
    assert left[:, 0].max() == pytest.approx(-1.0, abs=1e-9)
    assert right[:, 0].min() == pytest.approx(1.0, abs=1e-9)
