"""Level sets are drawn to where they end."""

import numpy as np
import pytest
from scipy.optimize import brentq

import core
from pwsviz.geometry.phase_plane import backdrop
from pwsviz.geometry.window import Window

HALF = 0.005
"""Half a pixel where a frame of 450 pixels shows the windows here."""

WINDOW = Window(-0.31, 4.13, -0.52, 4.57)


@pytest.mark.parametrize("nearest", [0.01, 0.02, 0.03])
def test_a_level_set_of_a_logarithm_goes_on_to_where_it_is_not_defined(nearest):
    system = core.CATALOGUE["predator_prey"]
    (psi,) = system.conserved("-", 0.0, (nearest, 1.0))  # the orbit turns at y = a/b = 1, where x is least
    lines = backdrop(system, WINDOW, {0: (float(psi),)}).orbit_levels[-1]
    assert not np.isnan(lines[:-1]).any(), "one piece, from the surface or the edge of the window to the surface"
    assert np.nanmin(lines[:, 0]) == pytest.approx(nearest, abs=HALF)


@pytest.mark.parametrize("draw", range(12))
def test_a_drawn_level_set_ends_half_a_pixel_from_where_a_logarithm_does(draw):
    """ψ = a(u − log u) + b(v − log v), u = x − s, v = y − r: closed curves, whose least u solves one equation."""
    rng = np.random.default_rng(draw)
    s, r, a, b = (*rng.uniform(-2, 2, 2).round(3).tolist(), *rng.uniform(0.5, 3, 2).round(3).tolist())
    u, v = f"(x - {s!r})", f"(y - {r!r})"
    field = (f"{b!r}*({v} - 1)/{v}", f"-{a!r}*({u} - 1)/{u}")
    psi = (f"{a!r}*({u} - log{u}) + {b!r}*({v} - log{v})",)
    given = {"f_minus": field, "f_plus": field, "psi_minus": psi, "psi_plus": psi, "x0": (s + 1.0, r + 1.5)}
    system = core.PiecewiseSystem(name="Two logarithms", variables=("x", "y"), g=f"y - {r + 1.0!r}", **given)
    window = Window(s - rng.uniform(0.1, 0.5), s + 4.0, r - rng.uniform(0.1, 0.5), r + 4.0)
    nearest = rng.uniform(0.008, 0.02)
    level = a * (nearest - np.log(nearest)) + b
    left = [backdrop(system, window, {mode: (level,)}).orbit_levels[side] for mode, side in ((0, -1), (1, 1))]
    assert min(np.nanmin(lines[:, 0]) for lines in left) - s == pytest.approx(nearest, abs=HALF)
    u_low, v_low = (np.nanmin(left[0][:, k]) - end for k, end in ((0, s), (1, r)))
    least = brentq(lambda v: b * (v - np.log(v)) + a - level, 1e-12, 1.0)  # where u = 1
    assert v_low == pytest.approx(least, abs=HALF)
    assert u_low == pytest.approx(nearest, abs=HALF)


@pytest.mark.parametrize("draw", range(6))
def test_a_circle_is_smooth_in_a_window_of_any_shape(draw):
    rng = np.random.default_rng(draw)
    (x, y), ratio = rng.uniform(-0.5, 0.5, 2), 3.0 ** rng.uniform(-1, 1)
    wide, high = 2.4 * max(1.0, ratio), 2.4 * max(1.0, 1 / ratio)
    view = Window(x - wide, x + wide, y - high, y + high)
    circle = backdrop(core.CATALOGUE["elliptic_curve"], view.surroundings(), {}).surface
    line = circle[np.isfinite(circle).all(axis=1)]
    directions = np.unwrap(np.arctan2(*np.diff(line, axis=0).T))
    assert np.abs(np.diff(directions)).max() < np.radians(8), "no polygon to the eye on a page"


@pytest.mark.parametrize(("turns", "drawn"), [(3, True), (60, False), (200, False)])
def test_level_sets_that_wind_in_less_than_the_grid_resolves_are_not_drawn(turns, drawn):
    """Those of a pendulum which has turned round so often that all of it is in the window."""
    system, length = core.CATALOGUE["pendulum"], 2 * np.pi * turns
    (psi,) = system.conserved("+", 0.0, (1.0, 6.0))
    view = backdrop(system, Window(-0.1 * length, length, -length / 2, length / 2), {1: (float(psi),)})
    assert np.isfinite(view.orbit_levels[1]).any() == drawn
    curves = np.isnan(view.levels[1][:, 0]).sum()
    assert 3 < curves < 30, "those far from p = 0 are nearly straight"
