"""Lines count as hidden if, and only if, a curve is painted over all of them that is seen."""

import itertools

import numpy as np
import pytest

from pwsviz.geometry.hiding import MOST, any_seen, unhidden
from pwsviz.geometry.window import Window

WINDOW = Window(-2.0, 2.0, -2.0, 2.0)
PIXEL = 4.0 / 500


def arc(radius, begin, end, count=60):
    angle = np.linspace(begin, end, count)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


@pytest.mark.parametrize(
    ("line", "hidden"),
    [
        (arc(1.0, 0.3, 2.0, 7), True),  # the same curve by other vertices
        (arc(1.0 + 2 * PIXEL, 0.0, 6.0), True),
        (arc(1.0 + 4 * PIXEL, 0.0, 6.0), False),
        (arc(1.0, 0.0, 2 * np.pi, 90), False),  # closed, where the curve is not
        (arc(5.0, 0.0, 6.0), True),  # not seen
        (np.vstack([arc(1.0, 0.5, 1.0), [[np.nan, np.nan]], arc(1.5, 0.5, 1.0)]), False),
        (np.empty((0, 2)), True),
    ],
)
def test_a_line_is_hidden_if_a_curve_lies_over_all_that_is_seen_of_it(line, hidden):
    curves = [arc(1.0, 0.0, 3.2), arc(1.0, 3.2, 6.0)]
    assert (len(unhidden(line, curves, WINDOW, WINDOW)) == 0) == hidden
    levels = np.column_stack([line, np.zeros(len(line))])  # with the value of a level set
    assert (len(unhidden(levels, curves, WINDOW, WINDOW)) == 0) == hidden


def test_below_no_curve_and_below_very_long_ones_lines_count_as_seen():
    line = arc(1.0, 0.3, 2.0)
    assert len(unhidden(line, [], WINDOW, WINDOW))
    turns = arc(1.0, 0.0, 2 * np.pi * 200, 20_000)
    assert len(turns) < MOST < 200 * 2 * np.pi / PIXEL
    assert len(unhidden(line, [turns], WINDOW, WINDOW))
    assert not len(unhidden(line, [turns[:2000]], WINDOW, WINDOW))


def test_what_is_not_hidden_of_a_line_is_told_point_by_point():
    points = unhidden(arc(1.0, 0.0, 2 * np.pi, 90), [arc(1.0, 0.0, np.pi)], WINDOW, WINDOW)
    assert len(points) == pytest.approx(np.pi / PIXEL, rel=0.1)
    assert points[:, 1].max() < 3 * PIXEL


@pytest.mark.parametrize("seed", range(200))
def test_a_line_is_seen_if_it_passes_through_the_window_even_with_no_vertex_there(seed):
    random = np.random.default_rng(seed)
    line = random.normal(0.0, 4.0, (4, 2))
    line[random.integers(0, 4)] = np.nan
    share = np.linspace(0.0, 1.0, 20_001)[:, None]
    inside = [WINDOW.holds(a + share * (b - a)).any() for a, b in itertools.pairwise(line)]
    assert any_seen(line, WINDOW) == any(inside)
    assert not any_seen(line[:1], WINDOW)
