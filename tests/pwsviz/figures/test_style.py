"""Integrators are told apart, by those who see fewer colours too."""

from itertools import combinations

import numpy as np
import pytest
from bokeh.models import ColumnDataSource, WheelZoomTool
from bokeh.models.glyphs import Line, MultiLine, MultiPolygons, Scatter, Text

import core
from pwsviz.figures.colours import CALM, GROUND, MILD, OCCUPIED, ON_DARK, PRINTED_OPACITY, SHADES
from pwsviz.figures.cost import EXTERNAL_LINES
from pwsviz.figures.legends import LEGEND_GLYPH
from pwsviz.figures.lines import line_of, together, widths_in_time
from pwsviz.figures.marks import ENDS, KIND_COLOURS
from pwsviz.figures.portrait import OTHERS_ALPHA, PortraitView
from pwsviz.figures.section import START_COLOURS
from pwsviz.figures.style import LEVEL, assign, describe, described, plain_figure, show_methods, side_strips
from pwsviz.geometry.shades import REGION_SHADES

#: Linear RGB as seen with one kind of cone missing: Machado, Oliveira, Fernandes, IEEE TVCG 15 (2009).
SIGHT = {
    "normal": np.eye(3),
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
PAGES = {"#ffffff": False, "#121212": True}
"""Colours of the page, and whether that is dark."""

OPEN = {"asterisk", "cross", "dash", "dot", "x", "y"}
"""Markers of Bokeh without an area."""

TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])


def lab(colour, seen):
    """CIE L*a*b* of a colour as it is seen."""
    srgb = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)]) / 255
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    xyz = TO_XYZ @ np.clip(np.array(seen) @ linear, 0, 1) / TO_XYZ.sum(axis=1)
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def test_every_integrator_has_a_look_of_its_own():
    looks = [line_of(name) for name in core.METHODS]
    assert len({look.colour for look in looks}) == len({look.dash for look in looks}) == len(core.METHODS)
    assert len({look.marker for look in looks}) == len(core.METHODS)


@pytest.mark.parametrize("name", core.METHODS)
def test_a_curve_has_one_look_beside_any_others_and_alone_but_for_the_dash_and_so_has_its_key(name):
    look, keys = line_of(name), ColumnDataSource({"method": []})
    assert together([look, look]) == [look._replace(dash=())] * 2, "also those of several starts"
    for names in ([name], [name, "rk2"], ["dmm6", name]):
        show_methods(keys, names)
        k, dash = keys.data["method"].index(name), look.dash if len({*names}) > 1 else ()
        told = {column: keys.data[column][k] for column in ("colour", "dash", "marker")}
        assert told == {"colour": look.colour, "dash": list(dash), "marker": look.marker}
        beside = together(map(line_of, dict.fromkeys(names)))[k]
        assert beside._replace(width=look.width) == look._replace(dash=dash)


def test_every_marker_in_an_order_plot_can_be_filled():
    assert all(line_of(name).marker not in OPEN for name, one in core.METHODS.items() if one.order)


@pytest.mark.parametrize("names", [("dmm2", "prk8"), ("prk8", "dmm2"), ("rk4", "prk8"), tuple(core.METHODS)])
def test_of_curves_that_coincide_those_below_are_seen_beside_those_above(names):
    for widths in (
        [line.width for line in together(map(line_of, names))],
        widths_in_time(names),
    ):
        assert (np.diff(widths) < 0).all()
        assert 2 <= widths[0] / widths[-1] <= 3


@pytest.mark.parametrize("ground", PAGES)
@pytest.mark.parametrize("seen", SIGHT.values(), ids=SIGHT)
def test_no_two_colours_are_close_in_any_sight(seen, ground):
    # A difference of 2.3 is just noticed side by side; the palette of Okabe and Ito keeps 16 among those used here.
    for a, b in combinations([painted(line_of(name).colour, ground) for name in core.METHODS], 2):
        assert np.linalg.norm(lab(a, seen) - lab(b, seen)) > 15


def contrast(a, b):
    """As WCAG 2.2 defines it."""
    light = [TO_XYZ[1] @ (((np.array(rgb(colour)) / 255 + 0.055) / 1.055) ** 2.4) + 0.05 for colour in (a, b)]
    return max(light) / min(light)


def rgb(colour):
    return [int(colour[k : k + 2], 16) for k in (1, 3, 5)]


def mixed(colour, alpha, ground):
    parts = (alpha * np.array(rgb(colour)) + (1 - alpha) * np.array(rgb(ground))).round().astype(int)
    return "#" + "".join(f"{part:02x}" for part in parts)


def painted(colour, page):
    """What the browser paints a colour in."""
    return ON_DARK.get(colour, colour) if PAGES[page] else colour


def grounds(page):
    """The page, and every shade that may lie on it."""
    strips = [mixed(colour, side_strips(side).fill_alpha, page) for side, (_, colour) in OCCUPIED.items()]
    return [page, *strips]


CURVES = {line_of(name).colour for name in core.METHODS} | {line.colour for line in EXTERNAL_LINES.values()}
MARKS = {*KIND_COLOURS.values(), *(look.colour for look in ENDS.values()), *START_COLOURS, *ON_DARK} - {
    CALM,
    MILD,
    GROUND,
}


@pytest.mark.parametrize("page", PAGES)
@pytest.mark.parametrize("colour", sorted(CURVES | MARKS | {LEVEL["line_color"]}))
def test_every_colour_of_curves_and_marks_stands_out_from_both_pages_and_all_shades(colour, page):
    least = min(contrast(painted(colour, page), ground) for ground in grounds(page))
    assert least >= 3, "WCAG 1.4.11"


@pytest.mark.parametrize("page", PAGES)
def test_every_line_and_mark_of_the_portrait_stands_out_as_it_is_painted(page):
    plot = PortraitView(*[lambda *_: None] * 5).figure
    fills = [one.glyph for one in plot.renderers if isinstance(one.glyph, MultiPolygons)]
    on = [page, *(mixed(painted(one.fill_color, page), one.fill_alpha, page) for one in fills)]
    strokes = {(one.glyph.line_color, one.glyph.line_alpha) for one in plot.renderers
               if isinstance(one.glyph, Line | MultiLine | Scatter) and one.glyph.line_alpha != 0}  # fmt: skip
    assert len(strokes) > 8
    for given, told in strokes:
        alpha = OTHERS_ALPHA if told == "alpha" else told  # of the player, at least
        for colour in sorted(CURVES | MARKS) if given == "colour" else [] if given == "white" else [given]:
            for ground in on:
                assert contrast(mixed(painted(colour, page), alpha, ground), ground) >= 3, (given, alpha, ground)


@pytest.mark.parametrize("page", PAGES)
def test_names_in_a_figure_are_read_on_every_shade(page):
    plot = PortraitView(*[lambda *_: None] * 5).figure
    names = {one.glyph.text_color for one in plot.renderers if isinstance(one.glyph, Text)} - {"black"}
    assert names
    for colour in names:
        assert min(contrast(painted(colour, page), ground) for ground in grounds(page)) >= 4.5, "WCAG 1.4.3"


def test_the_colours_of_one_ground_are_not_those_of_the_other():
    assert not {*ON_DARK} & {*ON_DARK.values()}, "a colour that is painted twice stays as it is"


@pytest.mark.parametrize("ground", ["#ffffff", "#1e1e1e"], ids=["light", "dark"])
@pytest.mark.parametrize("seen", SIGHT.values(), ids=SIGHT)
def test_no_two_shades_of_regions_are_closer_than_those_of_two_sides_need_be_in_any_sight(seen, ground):
    shades = [mixed(OCCUPIED[shade][1], side_strips(shade).fill_alpha, ground) for shade in REGION_SHADES]
    for a, b in combinations([*shades, ground], 2):  # 2.3 is just noticed, see above
        assert np.linalg.norm(lab(a, seen) - lab(b, seen)) > 5


def test_the_shades_of_two_sides_differ_in_a_print_without_colours():
    deeper = 1.5  # as some printers make them
    greys = [0.299 * r + 0.587 * g + 0.114 * b for side in (-1, 1) for r, g, b in
             [rgb(mixed(OCCUPIED[side][1], deeper * side_strips(side).fill_alpha, "#ffffff"))]]  # fmt: skip
    assert all(abs(a - b) > 10 for a, b in combinations([*greys, 255], 2))


def test_a_legend_shows_every_dash_once():
    assert all(sum(line.dash) <= LEGEND_GLYPH for line in map(line_of, core.METHODS))


def test_short_columns_of_numbers_are_sent_as_text_and_long_ones_as_they_are():
    source = ColumnDataSource({"t": [], "word": []})
    words = np.array(["a", "b", "c"])
    assign(source, t=np.array([0.1, np.nan, -0.0]), word=words)
    assert source.data["t"][::2] == [0.1, -0.0]
    assert np.isnan(source.data["t"][1])
    assert source.data["word"] is words
    sent = source.data
    assign(source, t=np.array([0.1, np.nan, -0.0]), word=words)
    assert source.data is sent, "the same again is not sent"
    assign(source, t=np.arange(1000.0), word=np.full(1000, "a"))
    assert isinstance(source.data["t"], np.ndarray)


def test_the_tool_that_zooms_says_that_it_needs_a_key():
    (tool,) = plain_figure("A figure").select(WheelZoomTool)
    assert tool.modifiers == {"ctrl": True}
    assert "Ctrl" in tool.description


def test_the_name_of_a_figure_is_its_first_words_and_the_others_describe_it():
    plot = plain_figure("state error, ‖x‖")
    told = plot.html_attributes
    assert (told["aria-label"], told["aria-description"]) == ("State error", "‖x‖")
    assert described(plot) == "State error, ‖x‖"
    describe(plot, "State error against τ. Of dmm2: slope 2.00.")
    told = plot.html_attributes
    assert (told["aria-label"], told["aria-description"]) == ("State error against τ", "Of dmm2: slope 2.00.")
    assert described(plot) == "State error against τ. Of dmm2: slope 2.00."


def test_printed_shades_differ_without_their_colours():
    def grey(colour):
        red, green, blue = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
        alpha = PRINTED_OPACITY[colour]
        return 1 - alpha + alpha * (0.299 * red + 0.587 * green + 0.114 * blue) / 255

    minus, plus, sliding = (grey(SHADES[shade]) for shade in (-1, 1, 0))
    assert minus > 0.9, "ink lies on it, which is to be read"
    assert 1 - plus > 0.025, "it is seen"
    assert plus - minus > 0.05
    assert minus - sliding > 0.1
    assert min(np.diff(sorted(grey(colour) for colour in PRINTED_OPACITY))) > 0.04
