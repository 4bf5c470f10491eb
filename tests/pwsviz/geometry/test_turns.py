"""How densely the turns of an orbit lie is measured in pixels of the view."""

import numpy as np
import pytest

from pwsviz.geometry.turns import PIXELS, spacing
from pwsviz.geometry.window import Window

VIEW = Window(-1.0, 1.0, -1.0, 1.0)


def spiral(turns, distance):
    """Turns around the origin, so many pixels apart."""
    angle = np.linspace(0, 2 * np.pi * turns, 200 * turns)
    radius = 0.3 + distance * angle / (2 * np.pi) * VIEW.longest / PIXELS
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


@pytest.mark.parametrize("distance", [2.0, 3.0, 4.0, 6.0])
def test_the_distance_between_turns_is_found(distance):
    assert spacing(spiral(30, distance), VIEW) == pytest.approx(distance, rel=0.3)


def test_turns_that_are_zoomed_apart_do_not_touch_any_more():
    path = spiral(30, 2.0)
    assert spacing(path, VIEW.scaled(0.5)) > 1.5 * spacing(path, VIEW)
    assert spacing(path, VIEW.scaled(0.02)) == np.inf, "a few pieces are no turns that could touch"


def test_turns_on_the_same_pixels_count_as_one():
    path = spiral(1, 0.0)
    assert spacing(path, VIEW) == np.inf
    assert spacing(np.concatenate([path] * 20), VIEW) > 6.0


def test_gaps_and_points_outside_the_view_do_not_count():
    path = np.concatenate([spiral(30, 3.0), [[np.nan, np.nan]], 100 * spiral(3, 1.0)])
    assert spacing(path, VIEW) == pytest.approx(3.0, rel=0.3)
