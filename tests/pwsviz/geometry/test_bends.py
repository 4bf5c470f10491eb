"""Which pieces of a curve bend visibly: those at a vertex off the line through its neighbours."""

import numpy as np
import pytest

from pwsviz.geometry.bends import bent_pieces

T = np.arange(6.0)
NO_KINKS = np.zeros(6, dtype=bool)


def bent(y, tolerance=0.1, t=T, kinks=NO_KINKS, **window):
    return bent_pieces(t, np.column_stack([T, np.asarray(y, float)]), kinks, tolerance, **window).tolist()


def test_a_straight_line_does_not_bend_and_a_turn_bends_beside_it():
    assert bent([0, 1, 2, 3, 4, 5]) == [False] * 5
    assert bent([0, 0, 0, 1, 2, 3]) == [False, True, True, False, False]
    # The vertex (2, 0) is h / √(4 + h²) off the line from (1, 0) to (3, h): 0.447 for h = 1.
    assert bent([0, 0, 0, 1, 2, 3], tolerance=0.44) == [False, True, True, False, False]
    assert bent([0, 0, 0, 1, 2, 3], tolerance=0.45) == [False] * 5


def test_corners_do_not_bend_but_a_piece_between_two_may():
    kinks = np.arange(6) == 2
    assert bent([0, 0, 0, 1, 2, 3], kinks=kinks) == [False] * 5
    assert bent([0, 0, 0, 1, 2, 3], kinks=kinks | (np.arange(6) == 3)) == [False, False, True, False, False]


def test_gaps_and_jumps_are_corners():
    assert bent([0, 0, np.nan, 1, 3, 5]) == [True, False, False, False, False]  # the first piece: between two corners
    jump = np.array([0.0, 1.0, 2.0, 2.0, 3.0, 4.0])
    assert bent([0, 0, 0, 5, 5, 5], t=jump) == [False] * 5


def test_a_curve_that_returns_to_a_point_bends_there():
    points = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 0.0], [-1.0, 0.0]])
    assert bent_pieces(T[:4], points, NO_KINKS[:4], 0.1).tolist() == [True, True, False]


def test_what_lies_outside_the_window_is_not_seen():
    assert bent([0, 0, 0, 1, 2, 3], window=(2.5, 9.0, 0.0, 9.0)) == [False, False, True, False, False]
    assert bent([0, 0, 0, 1, 2, 3], window=(3.5, 9.0, 0.0, 9.0)) == [False] * 5


@pytest.mark.parametrize("count", [0, 1, 2])
def test_short_curves(count):
    assert bent_pieces(T[:count], np.zeros((count, 2)), NO_KINKS[:count], 0.1).tolist() == [True] * max(0, count - 1)
