"""What the browser needs to leave out marks and shades, and how marks look."""

import pytest
from bokeh.core.properties import value
from bokeh.models.glyphs import Scatter

from pwsviz.figures.conserved import ConservedView
from pwsviz.figures.crowding import NARROW_SHADES
from pwsviz.figures.portrait import PortraitView
from pwsviz.figures.state import Panel, Shared


def portrait():
    view = PortraitView(*[print] * 5)
    return view.figure, view.marks


def conserved():
    view = ConservedView()
    return view.figure, view.ticks


def panel():
    one = Panel(0, Shared())
    return one.figure, one.marks


@pytest.mark.parametrize("made", [portrait, conserved, panel])
def test_marks_of_crossings_do_not_hide_the_curve_beneath_them(made):
    _, marks = made()
    assert marks.painted.glyph.fill_alpha == marks.key.glyph.fill_alpha == 0.0


@pytest.mark.parametrize("made", [portrait, conserved, panel])
def test_a_legend_reaches_no_source_that_changes_with_the_zoom(made):
    plot, marks = made()
    reached = plot.legend[0].references()
    assert marks.filter not in reached
    assert marks.painted.data_source not in reached


@pytest.mark.parametrize("made", [conserved, panel])
def test_no_entry_says_at_first_that_shades_are_left_out(made):
    plot, _ = made()
    (entry,) = [item for item in plot.legend[0].items if item.label == value(NARROW_SHADES)]
    assert not entry.visible


def test_a_legend_names_each_kind_of_mark_once():
    view = ConservedView()
    kinds = {"label": ["jump", "grazing", "jump"], "marker": list("abc"), "colour": list("def"), "size": [1, 2, 3]}
    view.ticks.name(kinds)
    keys = view.ticks.key.data_source.data
    assert (keys["label"], keys["marker"], keys["size"]) == (["jump", "grazing"], ["a", "b"], [1, 2])
    assert isinstance(view.ticks.key.glyph, Scatter)
