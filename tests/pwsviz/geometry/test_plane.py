"""Units in which variables of very different sizes are drawn at equal scales."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pwsviz.geometry.plane import SLENDER, XY, Plane, units_of

sizes = st.floats(-9, 9).map(lambda power: 10.0**power)


def turn(across, up):
    """Return an ellipse of these extents about the origin."""
    angle = np.linspace(0.0, 2 * np.pi, 101)
    return np.column_stack([across / 2 * np.cos(angle), up / 2 * np.sin(angle)])


@given(sizes, sizes)
def test_a_curve_is_drawn_with_no_side_longer_than_the_other_by_slender(across, up):
    if abs(math.log10(up / across)) >= 11.9:  # the smaller is rounding then
        return
    units = units_of(turn(across, up))
    drawn = np.ptp(turn(across, up) / units, axis=0)
    assert max(drawn) <= SLENDER * min(drawn) * (1 + 1e-9)
    assert 1.0 in units
    if units != (1.0, 1.0):
        assert max(drawn) <= math.sqrt(10) * min(drawn) * (1 + 1e-9)
        kept = units.index(1.0)
        extents = (across, up)
        assert abs(math.log10(extents[kept])) <= abs(math.log10(extents[1 - kept])) + 1e-9


@pytest.mark.parametrize(("across", "up"), [(1.0, 4.9), (3.0, 0.61), (1e-5, 2e-5), (4e8, 1e8)])
def test_variables_of_about_one_size_have_no_units(across, up):
    assert units_of(turn(across, up)) == (1.0, 1.0)


@pytest.mark.parametrize(
    "points",
    [
        [[0.0, 1.0], [5.0, 1.0]],
        [[0.0, 1.0], [0.0, 1.0]],
        [[0.0, 0.0], [5.0, 1e-13]],
        [[0.0, 7.0], [1e-4, 7.0 + 1e-14]],
        [[0.0, 0.0], [5.0, math.inf]],
    ],
)
def test_what_rests_or_changes_by_rounding_alone_or_has_no_end_has_no_unit(points):
    assert units_of(np.array(points)) == (1.0, 1.0)


def test_places_are_variables_divided_by_their_units_and_back():
    states = np.array([[1.0, 2000.0, 3.0], [4.0, 5000.0, 6.0]])
    plane = Plane((2, 1), (1.0, 1000.0))
    assert plane.points(states).tolist() == [[3.0, 2.0], [6.0, 5.0]]
    assert plane.place(states[1]) == (6.0, 5.0)
    assert plane.values(plane.points(states)).tolist() == [[3.0, 2000.0], [6.0, 5000.0]]
    assert np.shares_memory(XY.points(states), states), "without units nothing is copied"
    assert Plane((3, 1)).points(np.arange(12.0).reshape(3, 4)).tolist() == [[3.0, 1.0], [7.0, 5.0], [11.0, 9.0]]
