"""What is painted of every run: crossings, touches and ends, and whose figures stand below."""

import re

import pytest

from pwsviz.figures.colours import BLUE, GREEN, VERMILION
from pwsviz.scene.permalink import query
from pwsviz.scene.presets import PRESETS
from pwsviz.scene.scene import Scene
from tests.browser.looking import await_painted, becomes, settled_picture

pytestmark = [pytest.mark.browser, pytest.mark.deep]

#: Colours painted in a square of 16 pixels around a place of the plane.
AROUND = """([x, y]) => {
    const view = [...Bokeh.index.query(view => view.el?.getAttribute?.("aria-label")?.startsWith("Phase portrait"))][0]
    const layer = view.canvas_view.primary, {x_scale, y_scale} = view.frame, ratio = layer.pixel_ratio
    const corner = [x_scale.compute(x) - 8, y_scale.compute(y) - 8].map(value => Math.round(value * ratio))
    const side = Math.round(16 * ratio), {data} = layer.canvas.getContext("2d").getImageData(...corner, side, side)
    const count = Math.round(side * side)
    return Array.from({length: count}, (_, k) => Array.from(data.slice(4 * k, 4 * k + 3)))
}"""


def rgb(colour):
    """Red, green and blue of a colour such as "#0064A6"."""
    return tuple(int(colour[k : k + 2], 16) for k in (1, 3, 5))


def close(colour, wanted):
    return sum(abs(a - b) for a, b in zip(colour, wanted, strict=True)) < 60


def preset_link(key, **changes):
    scene = Scene()
    scene.load({**PRESETS[key].settings, **changes})
    return query(scene)


def painted(page, place, colour):
    """How many pixels around a place have about a colour."""
    return sum(close(one, colour) for one in page.evaluate(AROUND, list(place)))


@pytest.fixture
def shown(visit):
    def open_preset(key, **changes):
        page = visit(query=preset_link(key, **changes))
        settled_picture(page, await_painted(page, "Phase portrait"))
        return page

    return open_preset


def test_a_touch_is_marked_whichever_start_is_selected(shown):
    page = shown("grazing", selected=0)
    assert painted(page, (0.5, 0.0), rgb(VERMILION)) > 20  # vermilion, at the end of start 3
    page.get_by_text(re.compile(r"Start 1 of 3\. Start 3 stops early \(tangency\)")).wait_for()


def test_runs_that_slide_end_there_and_do_not_look_joined(shown):
    page = shown("vf_sliding")
    for x in (-1.3784, -0.3784, 0.6216):
        assert painted(page, (x, 0.0), rgb(GREEN)) > 20, "green, of sliding"
        assert painted(page, (x, 0.0), rgb(BLUE)) == 0, "no curve, which is blue, runs through"


def test_a_block_that_sticks_is_followed_and_stops_on_request(shown):
    page = shown("sticking")
    page.get_by_text(re.compile("3 crossings, 1 slide")).first.wait_for()
    page.get_by_text(re.compile("keeps g exactly while it slides")).first.wait_for()
    assert becomes(page, lambda: painted(page, (0.2, 0.0), rgb(GREEN)) > 20), "where the surface attracts"
    page.get_by_label("Slide along the surface (Filippov)").uncheck()
    page.get_by_text(re.compile("To follow it along the surface, choose “Slide along the surface”")).first.wait_for()
    page.wait_for_function("location.search.includes('slide=off')")


def test_sliding_cannot_be_chosen_where_the_state_jumps_and_says_why(visit):
    page = visit(query="v=2&system=bouncing_ball&methods=dmm2")
    slide = page.get_by_label("Slide along the surface (Filippov)")
    await_painted(page, "Phase portrait")
    assert slide.is_disabled()
    assert not slide.is_checked()
    assert "Where the state jumps" in slide.get_attribute("aria-description")
    page.get_by_label("Locate crossings (transition scheme)").uncheck()
    page.wait_for_function("location.search.includes('locate=off')")
    assert "slide" not in page.url, "the setting stays for other systems"
