"""The page for those who use a keyboard or a screen reader, measured by axe-core."""

from importlib import resources

import pytest

from tests.browser.looking import await_built, await_painted, field, type_into

sync_api = pytest.importorskip("playwright.sync_api")

pytestmark = [pytest.mark.browser, pytest.mark.deep]

#: The success criteria of WCAG 2.2, levels A and AA; and two of axe's own rules.
RULES = """() => axe.run(document, {runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"],
    rules: {"empty-heading": {enabled: true}, "page-has-heading-one": {enabled: true}}})"""


def violations(page):
    """What axe objects to: the rule, and the first place."""
    return [f"{v['id']}: {v['nodes'][0]['html'][:200]}" for v in page.evaluate(RULES)["violations"]]


@pytest.fixture
def inspected(visit):
    """Return a function that opens the page, light or dark, with axe-core in it."""
    script = (resources.files(pytest.importorskip("axe_playwright_python")) / "axe.min.js").read_text()

    def open_page(scheme="light"):
        page = visit()
        page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
        page.goto(f"{page.url.partition('?')[0]}?v=1&t_end=2")
        await_painted(page, "Phase portrait")
        await_built(page)
        page.wait_for_timeout(1500)  # for the colours, which fade from light to dark
        page.evaluate(script)
        return page

    return open_page


@pytest.mark.deep
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_on_the_page_violates_wcag(inspected, scheme):
    page = inspected(scheme)
    assert violations(page) == []
    for tab in ("Order", "Crossing time", "Cost", "Stability", "Scheme"):
        page.get_by_role("tab", name=tab).click()
        page.wait_for_timeout(1500)
        assert violations(page) == [], tab
    for name in ("Export & share", "Help"):
        page.get_by_role("button", name=name).click()
        page.get_by_role("dialog").get_by_role("heading").first.wait_for()
        page.wait_for_timeout(800)
        assert violations(page) == [], name
        page.keyboard.press("Escape")
        page.get_by_role("dialog").wait_for(state="hidden")
    page.get_by_role("button", name="Write your own").click()
    page.get_by_text("This system is ready.").wait_for()
    assert violations(page) == [], "editor"


def test_a_slider_tells_the_number_of_its_field(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    await_built(page)
    for name, told in (("a₋", "−3.0"), ("Step size τ", "0.01")):
        slider = page.get_by_role("slider", name=f"{name}, slider")
        sync_api.expect(slider).to_have_attribute("aria-valuetext", told)
    slider.press("ArrowRight")
    sync_api.expect(slider).not_to_have_attribute("aria-valuetext", "0.01")
    assert slider.get_attribute("aria-valuetext") == field(page, "Step size τ").input_value()


def test_formulas_are_numbers_and_shown_back_as_read(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    await_built(page)
    type_into(page, "End time", "2^3/4")
    page.get_by_text("2^3/4 = 2.0").wait_for()
    assert field(page, "End time").input_value() == "2.0"
    type_into(page, "End time", "two")
    page.get_by_text("“two” is not a number").wait_for()
    assert field(page, "End time").get_attribute("aria-invalid") == "true"


@pytest.mark.deep
def test_undo_in_a_field_is_the_fields_own(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    await_built(page)
    type_into(page, "Step size τ", "0.02")
    sync_api.expect(page.get_by_role("button", name="Undo")).to_be_enabled()
    end = field(page, "End time")
    end.click()
    page.keyboard.press("End")
    page.keyboard.type("7")
    page.keyboard.press("Control+z")
    sync_api.expect(end).to_have_value("20.0")
    assert field(page, "Step size τ").input_value() == "0.02"
    page.get_by_role("tab", name="Order").focus()
    page.keyboard.press("Control+z")
    sync_api.expect(field(page, "Step size τ")).to_have_value("0.01")


def test_the_view_is_the_panel_of_its_tab(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    await_built(page)
    page.get_by_role("tabpanel", name="Conserved quantity").wait_for()
    page.get_by_role("tab", name="Scheme").click()
    page.get_by_role("tabpanel", name="Scheme").wait_for()


@pytest.mark.deep
def test_a_question_mark_opens_the_help(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    await_built(page)
    page.keyboard.press("?")
    page.get_by_role("dialog").get_by_text("Ctrl+Z").wait_for()
