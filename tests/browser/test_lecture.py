"""A lecture in a window that is small, as on an old projector: the pictures have the room, and nothing lies over it."""

import re
from itertools import pairwise

import pytest

from pwsviz.widgets.lecture import LABELS, ROOMY
from tests.browser.looking import PATIENCE, await_built, await_painted, becomes
from tests.browser.test_layout import BEGUN, FRAME, TYPE
from tests.browser.test_portrait import PORTRAIT, await_still, await_that, inside

pytestmark = pytest.mark.browser

SMALL = (1280, 720)

VIEW = """() => {
    const {frame, el} = [...Bokeh.index.query(one => one.model.type == "Figure" && one.el.checkVisibility())].at(-1)
    return [frame.bbox.height, el.getBoundingClientRect().bottom]
}"""
"""Height of the frame of the figure beside the portrait, and where the figure ends on the screen."""


@pytest.fixture
def small_window(chromium, address):
    """Open a scene in a window on a larger screen, which a lecture does not fill, and begin a lecture."""
    context = chromium.new_context(
        viewport={"width": SMALL[0], "height": SMALL[1]}, screen={"width": 1920, "height": 1080}
    )

    def begin(query):
        page = context.new_page()
        page.set_default_timeout(PATIENCE)
        page.goto(f"{address}?{query}" if query else address)
        await_built(page)
        await_painted(page, "Phase portrait")
        page.keyboard.press("l")
        page.wait_for_function(BEGUN, arg=True)
        return page

    yield begin
    context.close()


@pytest.mark.parametrize("query", ["", "v=2&system=kepler&methods=dmm2,dmm4,rk2,rk4"])
def test_in_a_small_window_of_a_large_screen_the_portrait_has_nearly_half_the_height(small_window, query):
    page = small_window(query)
    assert becomes(page, lambda: page.evaluate(FRAME)[1] > 0.45 * SMALL[1]), page.evaluate(FRAME)
    tops = [tab.bounding_box()["y"] for tab in page.get_by_role("tab").all()]
    assert max(tops) - min(tops) < 1, "titles of views keep to one row"
    assert page.evaluate("parseFloat(getComputedStyle(document.documentElement).fontSize)") > 18, "type is large"


ENTRIES = """() => {
    const {el} = Bokeh.index.query_one(one => one.model.type == "Legend" && one.grid_el?.button?.isConnected)
    return ["button", ".bk-label"].map(part => getComputedStyle(el.shadowRoot.querySelector(part)).fontSize)
}"""
"""Size of the letters of the button that unfolds a legend, and of those beside it."""


def test_the_button_that_unfolds_a_legend_has_the_type_of_its_entries(small_window):
    page = small_window("")
    assert becomes(page, lambda: len(set(page.evaluate(ENTRIES))) == 1), page.evaluate(ENTRIES)
    assert float(page.evaluate(ENTRIES)[0].removesuffix("px")) > 14, "large"


@pytest.mark.deep
@pytest.mark.parametrize("query", ["v=2&system=chua&view=sweep", "v=2&system=kepler&view=stability"])
def test_the_figure_of_a_view_has_nearly_half_the_height_however_much_is_told_below(small_window, query):
    page = small_window(query)
    assert becomes(page, lambda: page.evaluate(VIEW)[0] > 0.45 * SMALL[1]), page.evaluate(VIEW)
    page.wait_for_timeout(3000)  # what is told comes with the results
    height, bottom = page.evaluate(VIEW)
    assert height > 0.45 * SMALL[1]
    assert bottom < SMALL[1], "and is whole on the screen"


@pytest.mark.deep
def test_type_follows_the_size_of_the_window_during_a_lecture(visit):
    page = visit(*ROOMY)
    await_painted(page, "Phase portrait")
    usual = page.evaluate(TYPE)
    page.keyboard.press("l")
    page.wait_for_function(BEGUN, arg=True)
    for factor in (1.5, 1.2):
        page.set_viewport_size({"width": round(factor * ROOMY[0]), "height": round(factor * ROOMY[1])})
        grown = [factor * LABELS * size for size in usual]
        assert becomes(page, lambda grown=grown: page.evaluate(TYPE) == pytest.approx(grown)), page.evaluate(TYPE)


@pytest.mark.deep
def test_beside_the_tools_that_lie_in_a_small_portrait_a_click_places_a_star(small_window):
    page = small_window("")
    await_that(page, PORTRAIT)
    await_still(page)
    page.mouse.click(*inside(page.evaluate(PORTRAIT), 0.3, 0.03))
    assert becomes(page, lambda: len(page.evaluate(PORTRAIT)["stars"]) == 2)


WARNING = re.compile("^rk4: The step of 0.5 at")


@pytest.mark.deep
def test_in_a_small_lecture_a_warning_takes_one_line_until_it_is_pointed_at(visit):
    page = visit(*SMALL, query="v=2&system=kepler&methods=dmm2,rk2,rk4&tau=0.5")
    warning = page.get_by_text(WARNING).first
    warning.wait_for()
    page.keyboard.press("l")
    line = 1.6 * 0.875 * 16 * min(SMALL[0] / ROOMY[0], SMALL[1] / ROOMY[1])
    assert becomes(page, lambda: warning.bounding_box()["height"] < line), warning.bounding_box()
    warning.hover()
    assert becomes(page, lambda: warning.bounding_box()["height"] > line), warning.bounding_box()
    page.set_viewport_size({"width": 1920, "height": 1080})
    page.mouse.move(5, 5)
    page.wait_for_function("() => document.documentElement.style.fontSize == '165%'")
    assert becomes(page, lambda: warning.bounding_box()["height"] > line), "where there is room it is whole"


SPY = """names => {
    const { prototype } = CanvasRenderingContext2D, { fillText } = prototype
    window.painted = {}
    prototype.fillText = function (text, x, y, ...rest) {
        const at = this.getTransform().f + y, size = this.measureText(text)
        const ends = [at - size.actualBoundingBoxAscent, at + size.actualBoundingBoxDescent]
        if (names.includes(text)) { window.painted[text] = ends }
        return fillText.call(this, text, x, y, ...rest)
    }
}"""
"""Notes the upper and lower end of some words as they are painted, in pixels."""

NAMES = ["round-off", "eps = 2⁻⁵²", "tiny, or 0:", "drawn here"]


@pytest.mark.deep
@pytest.mark.parametrize(("height", "named"), [(540, 3), (1000, 4)])
def test_names_of_levels_do_not_lie_over_one_another_even_in_a_low_figure(visit, height, named):
    page = visit(1280, 800, query="")
    await_painted(page, "conserved quantity")
    page.set_viewport_size({"width": 1280, "height": height})
    await_still(page)
    page.evaluate(SPY, NAMES)
    page.set_viewport_size({"width": 1270, "height": height})
    assert becomes(page, lambda: len(page.evaluate("window.painted")) == named), page.evaluate("window.painted")
    ends = sorted(page.evaluate("Object.values(window.painted)"))
    assert all(above[1] <= below[0] for above, below in pairwise(ends)), ends


@pytest.mark.deep
def test_in_a_small_lecture_a_warning_of_a_view_is_whole(visit):
    page = visit(*SMALL, query="v=2&system=kepler&methods=dmm2&view=section&tau=0.2")
    warning = page.get_by_role("tabpanel").get_by_text(re.compile("^The step of 0.2 at"))
    warning.wait_for()
    page.keyboard.press("l")
    page.wait_for_function(BEGUN, arg=True)
    assert becomes(
        page, lambda: page.evaluate("document.documentElement.style.getPropertyValue('--warned')") == "nowrap"
    )
    assert warning.evaluate("one => getComputedStyle(one).whiteSpace") == "normal", "it scrolls into sight"


TOLD = """() => {
    const figure = [...Bokeh.index.query(one => one.model.type == "Figure" && one.el.checkVisibility())].at(-1)
    const floor = figure.el.getBoundingClientRect().bottom, found = []
    const walk = root => root.querySelectorAll("*").forEach(one => {
        if (one.shadowRoot) { walk(one.shadowRoot) }
        if (!one.matches("p, tr") || !one.checkVisibility()) { return }
        const {left, top, bottom, height} = one.getBoundingClientRect()
        if (height && top >= floor - 1 && left > innerWidth / 2 - 20) { found.push([one.tagName, top, bottom]) }
    })
    walk(document)
    return found
}"""
"""The paragraphs and rows told below the figure of the view: what each is, where it begins and where it ends."""


@pytest.mark.deep
@pytest.mark.parametrize("size", [SMALL, (1024, 768)])
@pytest.mark.parametrize(("view", "rows"), [("conserved", 0), ("cost", 4), ("stability", 3)])
def test_in_a_small_lecture_no_paragraph_and_no_table_ends_at_the_edge_of_the_screen(visit, size, view, rows):
    page = visit(*size, query=f"v=2&view={view}")
    await_painted(page, "Phase portrait")
    page.keyboard.press("l")
    page.wait_for_function(BEGUN, arg=True)

    def is_whole():
        told = page.evaluate(TOLD)
        cut = [one for one in told if one[1] < size[1] - 5 and one[2] > size[1] + 1]
        seen = [what for what, _, end in told if end <= size[1] + 1]
        return told and not cut and seen.count("TR") >= rows and (rows or "P" in seen)

    assert becomes(page, is_whole), page.evaluate(TOLD)
    page.wait_for_timeout(1500)
    assert is_whole(), "it stays so"
    assert page.evaluate(VIEW)[0] >= 324, "the figure keeps nearly half the height"
    ends = [tab.bounding_box() for tab in page.get_by_role("tab").all()]
    assert max(one["x"] + one["width"] for one in ends) <= size[0], "and all titles are in sight"
