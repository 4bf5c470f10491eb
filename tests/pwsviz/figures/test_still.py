"""A figure drawn without a browser shows what its glyphs hold."""

import re
from itertools import accumulate

import numpy as np
import pytest
from bokeh.models import ColumnDataSource
from bokeh.models.glyphs import Line, MultiLine, MultiPolygons, Scatter
from bokeh.plotting import figure

from pwsviz.figures.still import UNITS, still
from pwsviz.geometry.window import Window

WINDOW = Window(-1.0, 3.0, 0.0, 2.0)


def drawn(glyph, columns):
    plot = figure()
    plot.add_glyph(ColumnDataSource(columns), glyph)
    svg = still(plot, WINDOW)
    return svg, [places(track) for track in re.findall(r' d="([^"]*)"', svg)]


def places(track):
    """The points of the pieces of a path, in the plane."""
    pieces = []
    for piece in re.findall(r"M([^M]*)", track):
        steps = [tuple(map(int, pair)) for pair in re.findall(r"(-?\d+) (-?\d+)", piece)]
        whole = np.array(list(accumulate(steps, lambda a, b: (a[0] + b[0], a[1] + b[1]))))
        pieces.append(whole * [1, -1] * 4.0 / UNITS + [WINDOW.x_low, WINDOW.y_high])
    return pieces


def test_a_line_passes_through_its_points_and_is_broken_where_there_is_none():
    t = np.linspace(0.0, 1.0, 50)
    x, y = np.cos(t), np.sin(t)
    y[20] = np.nan
    _, (pieces,) = drawn(Line(), {"x": x, "y": y})
    assert [len(piece) for piece in pieces] == [20, 29]
    there = np.column_stack([x, y])[np.isfinite(y)]
    assert np.abs(np.concatenate(pieces) - there).max() <= 0.5 * 4.0 / UNITS * (1 + 1e-9)


def test_each_of_several_lines_has_its_own_look():
    columns = {"xs": [[0, 1], [0, 1]], "ys": [[0, 1], [1, 0]], "colour": ["#111111", "#222222"], "dash": [[], [8, 6]]}
    svg, tracks = drawn(MultiLine(line_color="colour", line_dash="dash"), columns)
    assert len(tracks) == 2
    assert re.findall(r'stroke="(#\d+)"', svg) == ["#111111", "#222222"]
    assert re.findall(r'stroke-dasharray="([^"]*)"', svg) == ["8 6"]


def test_areas_have_holes():
    ring, hole = [[0.0, 2.0, 2.0, 0.0], [0.0, 0.0, 2.0, 2.0]], [[0.5, 1.0, 1.0], [0.5, 0.5, 1.0]]
    svg, (pieces,) = drawn(MultiPolygons(), {"xs": [[[ring[0], hole[0]]]], "ys": [[[ring[1], hole[1]]]]})
    assert [len(piece) for piece in pieces] == [4, 3]
    assert 'fill-rule="evenodd"' in svg


def test_marks_have_the_size_and_place_that_they_are_given_and_unseen_ones_none():
    svg, _ = drawn(Scatter(size="size"), {"x": [1.0, np.nan], "y": [1.0, 1.0], "size": [20, 30]})
    assert 'd="M1000 500h0"' in svg
    assert 'stroke-width="20"' in svg
    assert 'stroke-width="30"' not in svg
    assert "<path" not in drawn(Scatter(fill_alpha=0.0, line_alpha=0.0), {"x": [1.0], "y": [1.0]})[0]


@pytest.mark.parametrize("hidden", [True, False])
def test_what_is_not_visible_is_not_drawn(hidden):
    plot = figure()
    plot.add_glyph(ColumnDataSource({"x": [0, 1], "y": [0, 1]}), Line()).visible = not hidden
    assert ("<path" in still(plot, WINDOW)) != hidden
