"""What a visitor sees and does, in a real browser."""

import re
import urllib.request

import pytest

from pwsviz.text.numbers import PRINTED, printed
from tests.browser.looking import (
    BLANK_KEYS,
    GROUND,
    THEME,
    TIP,
    UNPRINTED,
    await_ground,
    await_other_picture,
    await_painted,
    becomes,
    canvas,
    field,
    picture,
    settled_picture,
    type_into,
)
from tests.browser.test_portrait import CONSERVED, PORTRAIT, await_that

pytestmark = pytest.mark.browser


def test_first_paint_shows_portrait_and_conserved_quantity(visit):
    page = visit(query="")
    await_painted(page, "Phase portrait")
    await_painted(page, "conserved quantity")
    page.get_by_text(re.compile("240 steps, 20 crossings")).first.wait_for()
    page.get_by_text("dmm2 keeps the conserved quantity").first.wait_for()
    assert page.get_by_text("dmm2:").count() + page.get_by_text("dmm2").count() >= 2


@pytest.mark.deep
def test_later_visitors_get_their_page_before_their_session_is_made_and_their_own_scene(visit, address):
    pages = [urllib.request.urlopen(f"{address}?{query}").read() for query in ("", "v=1&tau=0.02")]  # noqa: S310
    roots = [re.findall(rb'data-root-id="(p\d+)"', page) for page in pages]
    assert roots[0] == roots[1], "each page was made with a session of its own"
    page = visit(query="v=1&t_end=3")
    page.get_by_text(re.compile("300 steps")).first.wait_for()
    assert field(page, "End time").input_value() == "3"


def test_typing_a_step_size_repaints_and_updates_the_status(visit):
    page = visit()
    drawing = await_painted(page, "conserved quantity")
    page.get_by_text(re.compile("2,000 steps")).first.wait_for()
    before = settled_picture(page, drawing)
    type_into(page, "Step size τ", "0.001")
    page.get_by_text(re.compile("20,000 steps")).first.wait_for()
    await_other_picture(page, drawing, before)


@pytest.mark.deep
def test_the_slider_moves_the_step_size(visit):
    page = visit()
    drawing = await_painted(page, "conserved quantity")
    page.get_by_text(re.compile("2,000 steps")).first.wait_for()
    before = settled_picture(page, drawing)
    slider = page.get_by_role("slider", name="Step size τ, slider")
    slider.focus()
    for _ in range(20):
        slider.press("ArrowLeft")
    await_other_picture(page, drawing, before)
    assert becomes(page, lambda: float(field(page, "Step size τ").input_value()) < 0.01)
    page.get_by_text(re.compile(r"[2-9],\d{3} steps")).first.wait_for()
    for one in ("Phase portrait", "Absolute change"):
        settled_picture(page, canvas(page, one))
    assert page.evaluate(BLANK_KEYS) == [], "a legend is painted again after what it reaches has changed"


@pytest.mark.deep
def test_order_and_crossing_time_show_slopes_near_two(visit):
    page = visit()
    for tab, figure in (("Order", "State error"), ("Crossing time", "Crossing-time error")):
        page.get_by_role("tab", name=tab).click()
        # What there is of a study is shown as it comes; at first it has no slopes. Slopes that agree are told once.
        whole = re.compile(r"dmm2: slope \d\.\d+[^.]*(?:\.\d+[^.]*)*20 and 30.*The end time has no effect", re.DOTALL)
        words = page.get_by_text(whole).locator("visible=true").first
        words.wait_for()
        slopes = [float(slope) for slope in re.findall(r"slope (\d+\.\d+)", words.inner_text())]
        assert slopes
        assert all(1.9 < slope < 2.1 for slope in slopes)
        await_painted(page, figure)


@pytest.mark.deep
def test_bad_input_is_told_and_the_picture_stays(visit):
    page = visit()
    drawing = await_painted(page, "Phase portrait")
    page.get_by_text(re.compile("2,000 steps")).first.wait_for()
    before = settled_picture(page, drawing)
    type_into(page, "Step size τ", "tiny")
    page.get_by_text(re.compile("is not a number")).wait_for()
    page.wait_for_timeout(300)
    assert picture(drawing) == before
    type_into(page, "Step size τ", "0.02")
    page.get_by_text(re.compile("1,000 steps")).first.wait_for()
    assert page.get_by_text(re.compile("is not a number")).count() == 0


@pytest.mark.deep
def test_a_narrow_screen_shows_the_picture_first_and_the_rest_below(visit):
    page = visit(420, 800)
    drawing = await_painted(page, "Phase portrait")
    page.get_by_label("Open menu").wait_for()
    portrait = drawing.bounding_box()
    tab = page.get_by_role("tab", name="Conserved quantity").bounding_box()
    assert portrait["x"] >= 0
    assert portrait["x"] + portrait["width"] <= 420
    assert tab["y"] >= portrait["y"] + portrait["height"]


@pytest.mark.deep
def test_dark_mode_repaints_the_figures_and_is_remembered(visit):
    page = visit()
    light = await_painted(page, "Phase portrait").evaluate(GROUND)
    page.get_by_label(THEME).click()
    dark = await_ground(page, canvas(page, "Phase portrait"), lambda ground: ground != light)
    assert page.evaluate(UNPRINTED) == []
    x, y = await_that(page, CONSERVED)["ticks"][1]
    page.mouse.move(x, y - 60)
    page.mouse.move(x, y, steps=3)
    page.wait_for_function(f"({TIP})()")
    words, *colours = page.evaluate(TIP)
    assert words.startswith("crossing 2t = ")
    assert colours == ["rgb(255, 255, 255)", "rgb(18, 18, 18)"], "as other texts of the dark page"
    for number in ("2.5e-16", "1e+21", "-1e-7", "-3.25", "0.001"):
        assert page.evaluate(f"number => {{ {PRINTED} return printed(number) }}", number) == printed(number)
    page.reload()
    drawing = await_painted(page, "Phase portrait")
    await_ground(page, drawing, lambda ground: ground == dark)
    page.get_by_label(THEME).click()
    await_ground(page, drawing, lambda ground: ground == light)
    assert page.evaluate("localStorage.length") == 0  # as the system has it: there is nothing to remember


def choose_system(page, name):
    page.get_by_role("combobox", name="System").select_option(name)


def opacity(drawing):
    return drawing.evaluate("node => { let o = 1; for (; node; node = node.parentElement ?? node.getRootNode().host) "
                            "o *= getComputedStyle(node).opacity; return o }")  # fmt: skip


FRAMES = """() => [...Bokeh.index.query(view => view.model.type == "Figure")]
    .map(({ model }) => model.outline_line_alpha)"""


@pytest.mark.deep
def test_figures_have_the_same_frame_on_light_and_on_dark_ground(visit):
    page = visit(color_scheme="light")
    await_painted(page, "Phase portrait")
    light = page.evaluate(FRAMES)
    page.close()
    page = visit(color_scheme="dark")
    await_painted(page, "Phase portrait")
    assert light == page.evaluate(FRAMES)
    assert set(light) == {0.25}


@pytest.mark.deep
def test_a_system_without_conserved_quantities_says_so_and_another_brings_them_back(visit):
    page = visit()
    await_painted(page, "conserved quantity")
    choose_system(page, "Thermostat")
    await_painted(page, "Coordinate T against time")
    page.get_by_role("tab", name="Conserved quantity").click()
    page.get_by_text(re.compile("no conserved quantity is known in any region")).wait_for()
    page.get_by_text(re.compile("need a conserved quantity; none is known here")).wait_for()
    page.get_by_label("dmm2", exact=True).wait_for(state="detached")
    page.get_by_role("application", name=re.compile("conserved quantity")).wait_for(state="hidden")
    choose_system(page, "Elliptic curve")
    page.get_by_text(re.compile("2,000 steps, 21 crossings")).first.wait_for()
    assert page.get_by_label("dmm2", exact=True).is_checked()
    await_painted(page, "conserved quantity")


@pytest.mark.deep
def test_a_picture_in_more_dimensions_says_that_it_is_projected_and_is_not_left_faded(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    before = await_that(page, PORTRAIT)["frame"]
    choose_system(page, "Rigid body")
    page.get_by_text(re.compile("Projection onto the plane of y₁, y₂")).wait_for()
    field(page, "initial y₃").wait_for()
    drawing = await_painted(page, "Phase portrait")
    page.wait_for_timeout(200)
    assert opacity(drawing) == 1
    assert page.evaluate(PORTRAIT)["frame"] == before, "what the legend needs is added below"


@pytest.mark.deep
def test_taylor_brings_its_tolerance(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    assert not field(page, "Taylor tolerance").is_visible()
    page.get_by_label("taylor", exact=True).check()
    type_into(page, "Taylor tolerance", "1e-6")
    page.get_by_text(re.compile(r"taylor: 2,0\d\d steps")).wait_for()
