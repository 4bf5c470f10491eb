"""A legend is made anew at each change of what its entries reach; that is to be their own glyphs and nothing more."""

import numpy as np
import pytest
from bokeh.models import Legend, LegendItem, Plot
from bokeh.models.glyphs import Scatter

import core
from pwsviz.figures.colours import SIDES
from pwsviz.figures.conserved import ConservedView
from pwsviz.figures.cost import CostView
from pwsviz.figures.ground import ATTRACTS, REPELS
from pwsviz.figures.legends import LEGEND_GLYPH
from pwsviz.figures.linking import link_crossings, link_portrait
from pwsviz.figures.order import OrderView, state_rows, studied
from pwsviz.figures.portrait import PortraitView
from pwsviz.figures.stability import StabilityView
from pwsviz.figures.state import StateView
from pwsviz.figures.sweep import SweepView
from pwsviz.geometry.window import Window
from pwsviz.results.results import PortraitInputs, Results
from pwsviz.scene.scene import Scene

OSCILLATOR = core.CATALOGUE["harmonic_oscillator"]


def figures():
    portrait, conserved, state = PortraitView(*[print] * 5), ConservedView(), StateView()
    link_portrait(portrait)
    link_crossings(portrait, conserved, conserved.instants)
    panels = [state.panel(k) for k in range(2)]
    for panel in panels:
        link_crossings(portrait, panel, state.shared.instants)
    yield from (view.figure for view in (portrait, conserved, *panels, OrderView("state error"), CostView()))
    stability = StabilityView(print)
    yield SweepView(print, print).figure
    yield from (stability.figure(part) for part in ("map", "drift", "grazing"))


@pytest.mark.parametrize("plot", list(figures()))
def test_entries_of_a_legend_reach_no_figure_and_no_other_legend(plot):
    for legend in plot.select(Legend):
        for item in legend.items:
            reached = item.references() - {item}
            assert not [model for model in reached if isinstance(model, Plot | Legend | LegendItem)], item.label


def test_what_a_surface_does_is_told_before_the_field_and_folded_on_phones_alone():
    ground = PortraitView(*[print] * 5).ground
    names = [name for name, _ in ground.legend]
    assert {ATTRACTS, REPELS}.isdisjoint(names[-ground.additional :])
    assert names.index(REPELS) < names.index("f/|f|")


def test_the_key_of_a_part_of_the_surface_is_painted_as_the_part_is():
    ground = PortraitView(*[print] * 5).ground
    attracts, repels, *_ = ground._line_entries
    for entry in (attracts, repels):
        band, surface = entry.renderers
        assert band.glyph.line_alpha == 1.0, "its colour is not mixed with that of the ground"
        assert surface.data_source is ground.surface
        assert ground.figure.renderers.index(band) < ground.figure.renderers.index(surface), "as in the key"


def keys_of(view):
    """The mark that a legend paints over the line of each label: colour and marker."""
    item = view.figure.legend[0].items[0]
    lines, *_, marks = item.renderers
    assert isinstance(marks.glyph, Scatter)
    columns = marks.data_source.data
    assert marks.data_source is lines.data_source, "as Bokeh asks for, or it complains"
    assert np.isnan(columns["nowhere"]).all(), "nothing of it is in the plot"
    return list(zip(columns["colour"], columns["marker"], strict=True))


def test_the_legend_of_the_cost_has_the_markers_of_its_curves():
    settings = {"dmm2": [0.01], "rk4": [0.01]}
    view, study = CostView(), core.work_precision(OSCILLATOR, methods=list(settings), settings=settings, peers=())
    view.show(study, "seconds", "state")
    drawn = set(zip(view.points.data["colour"], view.points.data["marker"], strict=True))
    assert set(keys_of(view)) == drawn
    assert len(drawn) == 2


def test_the_legend_of_the_order_has_the_markers_of_its_curves_and_names_their_fillings_apart():
    view = OrderView("state error")
    studies = [
        core.order_study(OSCILLATOR, np.geomspace(0.02, 0.1, 4), method=name, crossings=(2, 4))
        for name in ("dmm2", "rk4")
    ]
    one, two = (studied(tuple(studies[:count]), state_rows) for count in (1, 2))
    for shown, several in ((one, False), (two, True)):
        view.show(shown)
        assert set(keys_of(view)) == set(zip(view.points.data["colour"], view.points.data["marker"], strict=True))
        assert view.figure.legend[0].items[1].visible is several


def test_the_key_of_level_sets_is_half_in_the_colour_of_each_side_on_which_they_are():
    view = PortraitView(*[print] * 5)
    pictures = Results().pictures(PortraitInputs.of(Scene()))
    view.show_orbits(Scene().declaration, pictures, [(-1.0, -1.0)], 0)
    problem, levels = pictures.inputs.selected[0].problem, pictures.orbits[0].levels
    half = LEGEND_GLYPH // 2
    for window, sides in ((Window(-2, 2, -2, 2), [-1, 1]), (Window(-0.2, 0.2, -0.2, 0.2), [-1])):
        view.show_backdrop(Results().backdrop(problem, window, levels))
        keys = [renderer.glyph for renderer in view.ground._line_entries[3].renderers]
        assert [key.line_color for key in keys] == list(SIDES.values())
        dashes = [[half, half]] * 2 if len(sides) == 2 else [[], [0, LEGEND_GLYPH]]
        assert [key.line_dash for key in keys] == dashes, "a dash of no length is not seen"
        own = view.ground._line_entries[4]
        assert own.visible == (len(sides) == 2), "in the small window the trajectory hides its level set"
        dotted = [renderer.glyph.line_dash for renderer in own.renderers]
        assert dotted == [[0, LEGEND_GLYPH], [2, 3]], "that where g < 0 is hidden, in either window"
    assert [key.line_dash_offset for key in keys] == [0, half]


def test_the_legend_names_what_is_seen_alone_also_after_a_pan_within_the_backdrop():
    view, system = PortraitView(*[print] * 5), Scene().declaration
    pictures = Results().pictures(PortraitInputs.of(Scene()))
    view.show_orbits(system, pictures, [(-1.0, -1.0)], 0)
    ground = Results().backdrop(pictures.inputs.selected[0].problem, Window(-2, 2, -2, 2), ())
    names = [name for name, _ in view.ground.legend]
    for window, absent in (
        (Window(-1.9, 1.9, -1.9, 1.9), set()),
        (Window(0.2, 1.9, -1.9, 0.2), {"S repels"}),
        (Window(0.2, 1.9, -0.2, 1.9), {"S attracts"}),
        (Window(-1.9, -1.2, -1.9, 1.9), {"S: g = 0", "g < 0", "S attracts", "S repels"}),
        (Window(-0.5, 0.5, -0.5, 0.5), {"S: g = 0", "S attracts", "S repels"}),
    ):
        view.look_at(window)
        view.show_backdrop(ground)
        entries = dict(zip(names, view.figure.legend[0].items[-len(names) :], strict=True))
        hidden = {name for name, entry in entries.items() if not entry.visible}
        assert hidden == absent | {"no law", "ψ = ψ(trajectory)"}
