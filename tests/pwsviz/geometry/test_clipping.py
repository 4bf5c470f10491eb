"""A curve is cut where it crosses the border of a window, however far its vertices lie beyond."""

import numpy as np
import pytest

from pwsviz.geometry.clipping import clipped
from pwsviz.geometry.window import Window

BOX = Window(-1.0, 1.0, -2.0, 2.0)


def cut(*points):
    given = np.array(points, dtype=float)
    there, kinks, within = clipped(given, np.ones(len(given), dtype=bool), BOX)
    assert np.array_equal(there[kinks], given, equal_nan=True)
    assert BOX.holds(there[within]).all()
    return there[within].tolist()


def test_a_curve_within_stays_as_it_is():
    assert cut((0, 0), (1, 2), (-1, -2)) == [[0, 0], [1, 2], [-1, -2]]


@pytest.mark.parametrize("far", [3.0, 1e6, 1e200])
def test_a_curve_that_leaves_and_returns_ends_on_the_border(far):
    assert cut((0, 0), (far, 0), (0, 0), (0, -far)) == [[0, 0], [1, 0], [1, 0], [0, 0], [0, -2]]


def test_an_edge_through_the_window_is_drawn_and_one_beside_it_is_not():
    assert cut((-3, 0), (3, 0)) == [[-1, 0], [1, 0]]
    assert cut((-3, 3), (3, 3)) == []
    assert cut((-3, 0), (0, 6)) == []
    assert cut((-1.5, -9), (-1.5, 9)) == []


def test_no_edge_leads_across_a_gap():
    assert cut((0, 0), (np.nan, np.nan), (5, 0), (np.inf, 0)) == [[0, 0]]
