"""The bifurcation diagram: it is painted, a click sets the parameter, and what is in sight is swept again."""

import re

import pytest

from tests.browser.looking import BLANK_KEYS, COLOURS, UNPRINTED, await_built, canvas, field, settled_picture
from tests.browser.test_portrait import FIGURE, await_that

pytestmark = [pytest.mark.browser, pytest.mark.deep]

CHUA = "v=2&system=chua&methods=taylor&tau=1.0&t_end=30.0&view=sweep&sweep_discard=200&sweep_values=120&sweep_end=3e3"
LOOK = f"""() => {{
    const figure = ({FIGURE})("Bifurcation diagram")
    return figure == null ? null : {{frame: figure.frame, range: figure.range, words: figure.words}}
}}"""


def whole(page, pattern):
    """Wait until the words below the diagram, which are folded, say that it is whole, and return what is seen of it."""
    page.locator("details").get_by_text(re.compile(pattern)).wait_for(state="attached")
    settled_picture(page, canvas(page, "Bifurcation"))
    return await_that(page, LOOK)


@pytest.mark.parametrize("look", [{}, {"color_scheme": "dark", "width": 420, "height": 800}], ids=["light", "phone"])
def test_a_click_sets_the_parameter_and_the_portrait_follows(visit, look):
    page = visit(query=CHUA, **look)
    seen = whole(
        page, r"12,000 points: y on any of the surfaces gᵢ = 0 where gᵢ increases for 120 values of α from 8 to 9\.2"
    )
    assert "12,000 points" in seen["words"], "told to screen readers"
    drawing = canvas(page, "Bifurcation")
    drawing.scroll_into_view_if_needed()
    assert drawing.evaluate(COLOURS) > 10
    assert page.evaluate(UNPRINTED) == []
    assert page.evaluate(BLANK_KEYS) == []
    portrait = settled_picture(page, canvas(page, "Phase portrait"))
    left, top, width, height = await_that(page, LOOK)["frame"]
    low, high, *_ = seen["range"]
    page.mouse.click(left + width * (8.3 - low) / (high - low), top + 0.5 * height)
    page.wait_for_function("() => /alpha=8\\.(29|30|31|3)/.test(location.href)")
    page.get_by_text("the points have period 2").locator("visible=true").first.wait_for()
    assert settled_picture(page, canvas(page, "Phase portrait")) != portrait


def test_values_in_sight_are_swept_again_and_a_slider_sweeps_anew(visit):
    page = visit(query=CHUA)
    left, top, width, height = whole(page, "120 values of α from 8 to")["frame"]
    page.mouse.move(left + 0.5 * width, top + 0.5 * height)
    page.keyboard.down("Control")
    for _ in range(4):
        page.mouse.wheel(0, -200)
        page.wait_for_timeout(100)
    page.keyboard.up("Control")
    page.get_by_role("button", name="Sweep the visible range").click()
    page.wait_for_function("() => /sweep_range=8\\.[0-9]+,(8|9)\\./.test(location.href)")
    seen = whole(page, r"120 values of α from 8\.[1-5]")
    assert 0 < seen["range"][1] - seen["range"][0] < 1.0
    await_built(page)
    field(page, "β").fill("15")
    field(page, "β").press("Enter")
    page.wait_for_function("() => /beta=15/.test(location.href)")
    whole(page, r"120 values of α from 8\.[1-5]")
