"""The window of the portrait stays where it is put."""

import re

import pytest
from playwright import sync_api

from pwsviz.page.window_fields import LABELS
from tests.browser.looking import becomes, field, type_into
from tests.browser.test_portrait import PORTRAIT, await_still, await_that, double_click, drag, inside

pytestmark = [pytest.mark.browser, pytest.mark.deep]


@pytest.fixture
def page(visit):
    page = visit()
    await_that(page, PORTRAIT)
    page.get_by_text(re.compile("2,000 steps, 21 crossings")).first.wait_for()
    await_still(page)
    return page


def window(page):
    """The range that is seen, and the size of its frame, which a legend that grows leaves as it is."""
    seen = page.evaluate(PORTRAIT)
    return [*seen["range"], *(side / 100 for side in seen["frame"][2:])]


def test_neither_a_new_start_nor_one_that_escapes_moves_the_window(page):
    before = window(page)
    heard = page.evaluate(PORTRAIT)["heard"]
    double_click(page, inside(page.evaluate(PORTRAIT), 0.97, 0.95))
    await_that(page, PORTRAIT, lambda seen: seen["heard"] > heard and len(seen["stars"]) == 1)  # it only fits
    sync_api.expect(page.get_by_role("button", name="Undo")).to_be_disabled()
    page.mouse.click(*inside(page.evaluate(PORTRAIT), 0.97, 0.95))  # from here the solution runs off to infinity
    await_that(page, PORTRAIT, lambda seen: len(seen["stars"]) == 2)
    page.get_by_text(re.compile("Start 2 of 2")).first.wait_for()
    await_still(page)
    assert window(page) == pytest.approx(before, abs=0.01)
    star = page.evaluate(PORTRAIT)["stars"][0]
    drag(page, star, (90, 120))
    page.mouse.up()
    await_still(page)
    assert window(page) == pytest.approx(before, abs=0.01)
    for method in ("dmm4", "rk4", "prk8", "taylor"):
        page.get_by_role("checkbox", name=method).check()
    page.get_by_text(re.compile(r"taylor: [\d,]+ steps")).first.wait_for()
    await_still(page)
    assert window(page) == pytest.approx(before, abs=0.01)


def test_pan_is_kept_in_the_link_and_fit_returns(page):
    before = page.evaluate(PORTRAIT)["range"]
    drag(page, inside(page.evaluate(PORTRAIT), 0.9, 0.9), (-80, 40))
    page.mouse.up()
    page.wait_for_url(re.compile("window="))
    panned = page.evaluate(PORTRAIT)["range"]
    assert panned[0] > before[0]
    page.reload()
    await_that(page, PORTRAIT)
    await_still(page)
    size = panned[1] - panned[0]
    assert page.evaluate(PORTRAIT)["range"] == pytest.approx(panned, abs=0.02 * size)
    type_tau = field(page, "Step size τ")
    type_tau.fill("0.02")
    type_tau.press("Enter")
    page.get_by_text(re.compile("1,000 steps")).first.wait_for()
    assert page.evaluate(PORTRAIT)["range"] == pytest.approx(panned, abs=0.02 * size)
    page.mouse.move(*inside(page.evaluate(PORTRAIT), 0.5, 0.9))
    page.get_by_title("Fit to the trajectories").click()
    await_that(page, PORTRAIT, lambda seen: seen["range"] == pytest.approx(before, abs=0.02 * size))
    page.wait_for_url(lambda url: "window=" not in url)
    drag(page, inside(page.evaluate(PORTRAIT), 0.9, 0.9), (-80, 40), rest=600)  # however long it is held before
    page.mouse.up()
    page.wait_for_url(re.compile("window="))
    starts = page.evaluate(PORTRAIT)["at"]
    double_click(page, inside(page.evaluate(PORTRAIT), 0.9, 0.9))
    await_that(page, PORTRAIT, lambda seen: seen["range"] == pytest.approx(before, abs=0.02 * size))
    page.wait_for_url(lambda url: "window=" not in url and "starts=" not in url)
    assert page.evaluate(PORTRAIT)["at"] == starts


def test_limits_can_be_typed(page):
    page.get_by_role("button", name="Limits of the portrait").click()
    for number, (label, value) in enumerate((("Left end", -1), ("Right end", 6), ("Bottom end", -2), ("Top end", 5))):
        before = page.evaluate(PORTRAIT)["range"]
        typed = [value if k == number else before[k] for k in range(4)]
        entry = field(page, label)
        entry.fill(str(value))
        entry.press("Enter")
        kept = (0, 1) if number < 2 else (2, 3)
        near = 0.01 * (typed[kept[1]] - typed[kept[0]])
        seen = await_that(
            page,
            PORTRAIT,
            lambda seen: all(abs(seen["range"][k] - typed[k]) < near for k in kept),  # noqa: B023
        )
        left, right, bottom, top = seen["range"]
        assert seen["frame"][2] / (right - left) == pytest.approx(seen["frame"][3] / (top - bottom), rel=0.01)
    page.wait_for_url(re.compile("window="))


@pytest.mark.parametrize("begun", ["", "-"])
def test_what_is_being_typed_is_not_replaced_by_an_answer_to_another_field(page, begun):
    page.get_by_role("button", name="Limits of the portrait").click()
    bottom, top = field(page, "Bottom end"), field(page, "Top end")
    before = top.input_value()
    type_into(page, "Right end", "6")
    bottom.select_text()
    page.keyboard.type(begun)
    sync_api.expect(top).not_to_have_value(before)  # the answer is there: the axis across has followed
    page.keyboard.type("-2".removeprefix(begun))
    assert bottom.input_value() == "-2"
    bottom.press("Enter")
    await_that(page, PORTRAIT, lambda seen: abs(seen["range"][2] + 2) < 0.01)
    sync_api.expect(bottom).to_have_value("−2")


def test_of_texts_sent_faster_than_they_are_answered_each_field_shows_what_holds(page):
    page.get_by_role("button", name="Limits of the portrait").click()
    ends = [field(page, label) for label in LABELS]
    ends[2].evaluate(
        """(bottom, left) => {
            for (const [entry, text] of [[bottom, "-3"], [left, "-1"], [bottom, "-2"]]) {
                entry.value = text
                for (const name of ["input", "change"]) entry.dispatchEvent(new Event(name))
            }
        }""",
        ends[0].element_handle(),
    )
    await_that(page, PORTRAIT, lambda seen: abs(seen["range"][2] + 2) < 0.01)
    await_still(page)
    limits = pytest.approx(page.evaluate(PORTRAIT)["range"], abs=0.01)
    assert becomes(page, lambda: [float(entry.input_value().replace("−", "-")) for entry in ends] == limits)


def test_a_zoom_by_the_wheel_is_in_the_link_and_so_is_the_pan_after_it(page):
    def linked(page):
        ends = re.search("window=([^&]*)", page.url)
        return [float(end) for end in ends[1].split(",")] if ends else None

    page.mouse.move(*inside(page.evaluate(PORTRAIT), 0.7, 0.7))
    page.keyboard.down("Control")
    page.mouse.wheel(0, -240)
    page.keyboard.up("Control")
    page.wait_for_url(re.compile("window="))
    zoomed = page.evaluate(PORTRAIT)["range"]
    size = zoomed[1] - zoomed[0]
    assert linked(page) == pytest.approx(zoomed, abs=0.002 * size)
    before = page.url
    drag(page, inside(page.evaluate(PORTRAIT), 0.9, 0.9), (-80, 40))
    page.mouse.up()
    page.wait_for_url(lambda url: url != before)
    assert linked(page) == pytest.approx(page.evaluate(PORTRAIT)["range"], abs=0.002 * size)
    assert page.evaluate(PORTRAIT)["range"][0] > zoomed[0]
