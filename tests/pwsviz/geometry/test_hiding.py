"""Lines count as hidden if, and only if, a curve is painted over all of them that is seen."""

import numpy as np
import pytest

from pwsviz.geometry.hiding import MOST, are_hidden
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
    assert are_hidden([line], curves, WINDOW) == hidden
    levels = np.column_stack([line, np.zeros(len(line))])  # with the value of a level set
    assert are_hidden([levels], curves, WINDOW) == hidden


def test_below_no_curve_and_below_very_long_ones_lines_count_as_seen():
    line = arc(1.0, 0.3, 2.0)
    assert not are_hidden([line], [], WINDOW)
    turns = arc(1.0, 0.0, 2 * np.pi * 200, 20_000)
    assert len(turns) < MOST < 200 * 2 * np.pi / PIXEL
    assert not are_hidden([line], [turns], WINDOW)
    assert are_hidden([line], [turns[:2000]], WINDOW)
