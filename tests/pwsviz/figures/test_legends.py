"""A legend is made anew at each change of what its entries reach; that is to be their own glyphs and nothing more."""

import pytest
from bokeh.models import Legend, LegendItem, Plot

from pwsviz.figures.conserved import ConservedView
from pwsviz.figures.cost import CostView
from pwsviz.figures.linking import link_crossings, link_portrait
from pwsviz.figures.order import OrderView
from pwsviz.figures.portrait import PortraitView
from pwsviz.figures.stability import StabilityView
from pwsviz.figures.state import StateView


def figures():
    portrait, conserved, state = PortraitView(*[print] * 5), ConservedView(), StateView()
    link_portrait(portrait)
    link_crossings(portrait, conserved, conserved.instants)
    panels = [state.panel(k) for k in range(2)]
    for panel in panels:
        link_crossings(portrait, panel, state.shared.instants)
    yield from (view.figure for view in (portrait, conserved, *panels, OrderView("state error"), CostView()))
    stability = StabilityView(print)
    yield from (stability.figure(part) for part in ("map", "drift", "grazing"))


@pytest.mark.parametrize("plot", list(figures()))
def test_entries_of_a_legend_reach_no_figure_and_no_other_legend(plot):
    for legend in plot.select(Legend):
        for item in legend.items:
            reached = item.references() - {item}
            assert not [model for model in reached if isinstance(model, Plot | Legend | LegendItem)], item.label


def test_the_key_of_a_part_of_the_surface_is_painted_as_the_part_is():
    ground = PortraitView(*[print] * 5).ground
    *_, attracts, repels = ground._line_entries
    for entry in (attracts, repels):
        band, surface = entry.renderers
        assert band.glyph.line_alpha == 1.0, "its colour is not mixed with that of the ground"
        assert surface.data_source is ground.surface
        assert ground.figure.renderers.index(band) < ground.figure.renderers.index(surface), "as in the key"
