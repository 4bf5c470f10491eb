"""The coordinates of a section, and the state of a point of it, follow from the declaration."""

import math

import numpy as np
import pytest

import core
from pwsviz.geometry.projection import surface_texts
from pwsviz.geometry.section_plane import (
    angles,
    coordinate_names,
    surface_curves,
    surface_functions,
    usual_plane,
)
from pwsviz.geometry.section_state import state_at
from pwsviz.geometry.window import Window

HENON_HEILES = core.CATALOGUE["henon_heiles"]
TABLE = core.CATALOGUE["vibrating_table"]
CHUA = core.CATALOGUE["chua"]


@pytest.mark.parametrize(
    ("name", "of", "wanted"),
    [
        ("elliptic_curve", "", "x y"), ("henon_heiles", "", "y v"), ("henon_heiles", "y - 1/10", "x u"),
        ("vibrating_table", "", "φ v"), ("vibrating_table", "sin(phi)", "y v"), ("chua", "", "y z"),
        ("chua", "y + z", "x z"), ("pendulum", "sin(t)", "q p"), ("bouncing_ball", "", "v t"),
        ("damped_oscillator", "", "v t"), ("coulomb_friction", "", "y t"), ("chua", "x**2 - 1", "y z"),
    ],
)  # fmt: skip
def test_the_coordinate_that_the_surface_gives_is_left_out(name, of, wanted):
    system = core.CATALOGUE[name]
    assert " ".join(coordinate_names(system)[k] for k in usual_plane(system, of)) == wanted


def test_an_angle_is_what_a_full_turn_leaves_as_it_is():
    assert {name for name, system in core.CATALOGUE.items() if angles(system)} == {"vibrating_table"}
    assert angles(TABLE) == {0}
    rotor = core.PiecewiseSystem(
        "Rotor", ("q", "p"), ("p", "-sin(q)"), ("p", "-2*sin(q)"), "cos(q) - 1/2", x0=(0.1, 0.0)
    )
    assert angles(rotor) == {0}
    halved = core.PiecewiseSystem(
        "Halved", ("q", "p"), ("p", "-sin(q)"), ("p", "-sin(q)"), "sin(q)", x0=(0.1, 0.0), jump=("q/2", "p")
    )
    assert angles(halved) == set()


def test_surfaces_are_named_as_core_reads_them():
    assert surface_texts(CHUA) == ("x + 1", "x - 1")
    for name, system in core.CATALOGUE.items():
        for text, g in zip(surface_texts(system), system.laws.surfaces, strict=True):
            assert surface_functions(system, text) == (g,), name
            assert text in (*system.surfaces, *(way.guard for way in system.transitions)), "as it is declared"
    with pytest.raises(ValueError, match="constant"):
        surface_functions(CHUA, "1 + 1")


def energy(y, v, u, x=0.0):
    return (u**2 + v**2 + x**2 + y**2) / 2 + x**2 * y - y**3 / 3


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("point", [(0.3, 0.1), (-0.2, 0.3), (0.45, 0.01)])
def test_a_point_of_henon_and_heiles_has_the_energy_of_the_orbit_nearby(point, sign):
    system = HENON_HEILES.with_parameters(wall=0.1)
    near = np.array([-0.1, 0.0, sign * 0.4, 0.1])
    found = state_at(system, "", {1: point[0], 3: point[1]}, near, 1)
    level = energy(0.0, 0.1, 0.4, -0.1)
    y, v = point
    u = sign * math.sqrt(2 * level - v**2 - y**2 - 0.01 - 0.02 * y + 2 * y**3 / 3)
    assert found.x == pytest.approx((-0.1, y, u, v), abs=1e-9)
    assert found.taken == ("g = 0", f"ψ = {level:.6g}")


def test_where_the_energy_does_not_reach_there_is_no_state():
    with pytest.raises(ValueError, match=r"No state here has g = 0 and ψ = 0\.09"):
        state_at(HENON_HEILES, "", {1: 0.9, 3: 0.9}, np.array([-0.1, 0.0, 0.4, 0.1]), 1)


def test_a_point_over_the_table_lies_on_it_whatever_its_energy():
    found = state_at(TABLE, "", {0: 2.0, 2: 1.5}, np.array([0.1, 0.02, 3.0]), 1)
    assert found.x == pytest.approx((2.0, 0.25 * math.sin(2.0), 1.5), abs=1e-12)
    assert found.taken == ("g = 0",)


def test_of_several_surfaces_it_is_the_one_of_the_point_nearby_and_of_none_all_are_free():
    near = np.array([1.0, 0.2, -1.0])
    assert state_at(CHUA, "", {1: 0.1, 2: -0.5}, near, 0).x == pytest.approx((1.0, 0.1, -0.5))
    assert state_at(CHUA, "y + z", {0: 0.4, 2: 0.25}, np.array([0.0, 0.5, -0.5]), 0).x == pytest.approx(
        (0.4, -0.25, 0.25)
    )
    free = state_at(CHUA, "sin(t)", {0: 0.4, 2: 0.25}, near, 0)
    assert free == ((0.4, 0.2, 0.25), ())


CURVE = core.CATALOGUE["elliptic_curve"]


@pytest.mark.parametrize("click", [(0.9, 0.9), (-0.2, 1.4), (-1.1, 0.0)])
def test_where_the_two_coordinates_decide_h_a_click_is_moved_to_the_surface(click):
    found = state_at(CURVE, "", dict(enumerate(click)), np.array([0.6, 0.8]), 0)
    assert math.hypot(*found.x) == pytest.approx(1.0, abs=1e-9)
    assert math.dist(found.x, click) < 1.1 * abs(math.hypot(*click) - 1.0)
    assert found.taken == ()


def test_the_surface_is_a_curve_in_the_plane_of_coordinates_that_decide_h():
    around = Window(-2.0, 2.0, -1.5, 1.5)
    lines = surface_curves(CURVE, "", (1, 0), around)
    assert np.hypot(*lines[np.isfinite(lines).all(axis=1)].T) == pytest.approx(1.0, abs=1e-3)
    assert not np.isfinite(surface_curves(CURVE, "", (0, 2), around)).any()  # over time
    assert not np.isfinite(surface_curves(HENON_HEILES, "", (1, 3), around)).any()
    line = surface_curves(HENON_HEILES, "y + v", (1, 3), around)
    assert np.nansum(line, axis=1) == pytest.approx(0.0, abs=1e-12)
