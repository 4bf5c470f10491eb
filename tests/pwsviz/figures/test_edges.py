"""Marks at the edge of a plot are not cut by its frame."""

from functools import partial

import pytest
from bokeh.core.property.vectorization import Value
from bokeh.models.glyphs import Scatter

from pwsviz.figures.conserved import TICK, ConservedView
from pwsviz.figures.cost import CostView
from pwsviz.figures.marks import LARGER
from pwsviz.figures.order import STATE_ERROR, OrderView
from pwsviz.figures.stability_lines import DriftFigure, GrazingFigure
from pwsviz.figures.state import MARK, StateView

#: Pixels that an axis has at least.
PHONE = 300


@pytest.mark.parametrize(
    "view",
    [ConservedView, CostView, DriftFigure, GrazingFigure, partial(OrderView, *STATE_ERROR)],
    ids=["conserved", "cost", "drift", "grazing", "order"],
)
def test_a_mark_at_the_edge_of_a_plot_is_whole(view):
    plot = view().figure
    marks = [renderer.glyph for renderer in plot.renderers if isinstance(renderer.glyph, Scatter)]
    seen = [mark for mark in marks if mark.line_alpha != 0.0]
    assert seen
    for mark in seen:
        size, width = (one.value if isinstance(one, Value) else one for one in (mark.size, mark.line_width))
        size = TICK * max(LARGER.values()) if size == "size" else size  # of crossings, the largest of all kinds
        assert 0.5 * (size + width) <= 0.5 * plot.x_range.range_padding * PHONE


def test_a_mark_at_the_end_of_a_panel_of_the_state_is_whole():
    shared = StateView().shared
    shared.look_at(7.0)
    assert -shared.across.start == pytest.approx(shared.across.end - 7.0)
    assert -shared.across.start / 7.0 * PHONE >= 0.5 * (MARK * max(LARGER.values()) + 1.8)
