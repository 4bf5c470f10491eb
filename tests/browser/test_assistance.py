"""What those need who look at a small screen or large type, use the keyboard, or are told what the screen shows."""

import re

import pytest

from tests.browser.looking import THEME, await_painted, becomes, moments
from tests.browser.test_access import focused

sync_api = pytest.importorskip("playwright.sync_api")

pytestmark = [pytest.mark.browser, pytest.mark.deep]

SMALL = """() => {
    const found = []
    const look = node => node.querySelectorAll("*").forEach(one => {
        if (one.matches("button, label:has(input), [type=range], [role=tab]") && one.checkVisibility()) {
            const {width, height} = one.getBoundingClientRect()
            if (width > 0 && Math.min(width, height) < 24) { found.push([one.outerHTML.slice(0, 200), width, height]) }
        }
        if (one.shadowRoot) look(one.shadowRoot)
    })
    look(document)
    return found
}"""
"""What is pressed and is smaller than 24 × 24 pixels."""


@pytest.mark.parametrize("width", [320, 390])
def test_on_a_small_phone_nothing_is_cut_and_all_that_is_pressed_is_large_enough(visit, width):
    page = visit(width, 800, query="v=2&view=stability")
    portrait = await_painted(page, "Phase portrait")
    for name in ("Open menu", "Undo", "Redo", "Export & share", "Help", THEME):
        box = page.get_by_role("button", name=name).bounding_box()
        assert box["x"] >= 0, name
        assert box["x"] + box["width"] <= width, name
    greeting = page.locator("p.greeting").locator("visible=true")
    assert greeting.evaluate("one => one.scrollHeight - one.clientHeight") == 0
    box = greeting.bounding_box()
    assert box["y"] + box["height"] <= portrait.bounding_box()["y"]
    page.get_by_role("button", name="Animate").click()
    page.get_by_role("slider", name="Time").wait_for()
    page.get_by_role("button", name="y", exact=True).wait_for()
    assert page.evaluate(SMALL) == []
    page.get_by_role("button", name="Open menu").click()
    page.get_by_label("rk4").wait_for()
    for _ in moments(page):  # it slides in
        if not (small := page.evaluate(SMALL)):
            break
    assert small == []


def test_large_type_makes_the_header_higher_and_what_is_below_begins_below_it(visit):
    page = visit(1280, 800)
    await_painted(page, "Phase portrait")
    page.evaluate("document.documentElement.style.fontSize = '200%'")
    header, parts = page.locator("header"), [page.get_by_label("Examples"), page.get_by_role("tab").first]
    for _ in moments(page):
        bottom = header.evaluate("one => one.getBoundingClientRect().bottom")
        tops = [part.bounding_box()["y"] for part in parts]
        if bottom > 60 and min(tops) >= bottom:
            break
    assert bottom > 60
    assert min(tops) >= bottom


BLUR = """() => {
    let one = document.activeElement
    while (one.shadowRoot?.activeElement) { one = one.shadowRoot.activeElement }
    one.blur()
}"""


@pytest.mark.parametrize(
    ("opener", "ready", "last"),
    [
        ("Export & share", "Copy the link", "Copy the program"),
        ("Write your own", "This system is ready.", "Use this system"),
    ],
)
def test_a_window_holds_the_focus_and_esc_closes_it_from_anywhere(visit, opener, ready, last):
    page = visit()
    await_painted(page, "Phase portrait")
    page.get_by_role("button", name=opener).click()
    window = page.get_by_role("dialog")
    window.get_by_text(ready).wait_for()
    end = window.get_by_role("button", name=last)
    sync_api.expect(end).to_be_enabled()
    end.focus()
    page.keyboard.press("Tab")
    assert focused(page) == "close"
    page.keyboard.press("Shift+Tab")
    assert last in focused(page)
    page.evaluate(BLUR)
    for key in ("?", "l"):
        page.keyboard.press(key)
    page.keyboard.press("Tab")
    assert focused(page) == "close", "back in the window"
    page.evaluate(BLUR)
    page.keyboard.press("Escape")
    window.wait_for(state="hidden")
    assert page.evaluate("document.documentElement.style.fontSize") == ""
    for _ in moments(page):
        if opener in focused(page):
            break
    assert opener in focused(page)
    page.keyboard.press("?")
    window.get_by_text("How to use it").wait_for()


def test_the_end_of_a_computation_is_told(visit):
    page = visit(query="v=2&t_end=2")
    told = page.get_by_role("status").filter(has_text=re.compile("dmm2: .*end time reached"))
    told.wait_for()
    page.get_by_role("tab", name="Order", exact=True).click()
    page.get_by_role("status").filter(has_text="Order: finished.").wait_for()
    page = visit(query="v=2&system=stick_slip&slide=off")
    page.get_by_role("status").filter(has_text="rk2: t = 0.362").wait_for()


def test_what_a_figure_shows_is_told_when_keys_move_it_and_which_start_runs_are_told_of(visit):
    page = visit(query="v=2&t_end=2")
    await_painted(page, "Phase portrait")
    told = page.get_by_role("status")
    page.get_by_role("application", name=re.compile("Phase portrait")).focus()
    page.keyboard.press("ArrowRight")
    told.filter(has_text=re.compile(r"In sight: x from −[\d.]+ to [\d.]+, y from −[\d.]+ to [\d.]+\.")).wait_for()
    moved = told.filter(has_text="In sight").text_content()
    page.keyboard.press("0")
    assert becomes(page, lambda: "In sight" in (now := " ".join(told.all_text_contents())) and moved not in now)
    page.get_by_role("button", name="Add a trajectory").click()
    told.filter(has_text="Start 2 of 2.").wait_for()


def test_the_tip_of_a_list_makes_way_for_what_is_chosen_and_for_escape(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    examples = page.get_by_label("Examples").locator("visible=true")
    tip = """one => getComputedStyle(one.closest(".bk-input-group"), "::before").content"""
    examples.focus()
    page.keyboard.press("Shift+Tab")
    page.keyboard.press("Tab")
    assert becomes(page, lambda: examples.evaluate(tip) != "none")
    page.keyboard.press("Escape")
    assert becomes(page, lambda: examples.evaluate(tip) == "none")
    page.keyboard.press("Shift+Tab")
    page.keyboard.press("Tab")
    assert becomes(page, lambda: examples.evaluate(tip) != "none"), "it comes back"
    page.keyboard.press("ArrowDown")
    assert becomes(page, lambda: examples.evaluate(tip) == "none")


def test_controls_are_told_where_the_system_chooses_the_colours(visit):
    page = visit(query="v=2&view=stability", forced_colors="active")
    await_painted(page, "Phase portrait")
    ground = "one => getComputedStyle(one).backgroundColor"
    pressed, other = (page.get_by_role("button", name=name, exact=True) for name in ("x", "y"))
    pressed.wait_for()
    assert pressed.evaluate(ground) != other.evaluate(ground)
    line = "one => getComputedStyle(one).borderBottomWidth"
    assert page.get_by_role("tab", name="Stability").evaluate(line) == "3px"
    assert page.get_by_role("tab", name="Sweep").evaluate(line) == "0px"
    slider = page.get_by_role("slider", name="a₋, slider")
    assert slider.evaluate("one => getComputedStyle(one).forcedColorAdjust") == "none"


def test_groups_have_names(visit):
    page = visit(query="v=2&view=stability&t_end=2")
    await_painted(page, "Phase portrait")
    for name in (
        "Starts",
        "Part of Stability",
        "Coordinate of Stability",
        "Colours of the map",
        "Integrator of the view",
    ):
        sync_api.expect(page.get_by_role("group", name=name)).to_be_visible()
    page.get_by_role("tab", name="Cost").click()
    solvers = page.get_by_role("group", name="External solvers")
    sync_api.expect(solvers.get_by_role("checkbox", name="SciPy")).to_be_checked()
    page.get_by_role("button", name="Export & share").click()
    row = page.get_by_role("dialog").get_by_role("group", name="Phase portrait")
    row.get_by_role("button", name="SVG").wait_for()
    assert row.get_by_role("button", name="SVG").count() == 1


def test_buttons_tell_what_they_open_and_lists_what_they_are(visit):
    page = visit(query="v=2&view=section")
    await_painted(page, "Phase portrait")
    listed = page.get_by_role("combobox", name="Examples")
    sync_api.expect(listed).to_have_attribute("aria-description", re.compile("Scenes to start from"))
    for name in ("Limits of the portrait", "More choices"):
        button = page.get_by_role("button", name=name)
        sync_api.expect(button).to_have_attribute("aria-expanded", "false")
        button.click()
        sync_api.expect(button).to_have_attribute("aria-expanded", "true")
    page.get_by_role("button", name="Write your own").click()
    several = page.get_by_role("button", name="Several surfaces")
    sync_api.expect(several).to_have_attribute("aria-expanded", "false")
    several.click()
    sync_api.expect(several).to_have_attribute("aria-expanded", "true")


TIP_OF_BOX = "box => getComputedStyle(box.closest('span'), '::after').content"
"""What is written beside a check box."""


def test_an_integrator_entered_by_the_keyboard_says_what_it_is(visit):
    page = visit()
    family = page.get_by_role("group", name="Runge–Kutta", exact=True)
    box = family.get_by_role("checkbox", name="rk4", exact=True)
    sync_api.expect(box).to_have_attribute("aria-description", re.compile("Runge"))
    assert box.evaluate(TIP_OF_BOX) == "none"
    page.get_by_role("checkbox", name="rk2", exact=True).focus()
    page.keyboard.press("Tab")
    sync_api.expect(box).to_be_focused()
    assert "Runge" in box.evaluate(TIP_OF_BOX)


def test_a_button_that_can_no_longer_be_pressed_hands_the_focus_on(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    page.get_by_role("button", name="Add a trajectory").click()
    less = page.get_by_role("button", name="Remove this trajectory")
    sync_api.expect(less).to_be_enabled()
    less.press("Enter")
    sync_api.expect(page.get_by_role("button", name="Add a trajectory")).to_be_focused()
    page.get_by_role("textbox", name="End time").fill("3")
    page.get_by_role("textbox", name="End time").press("Enter")
    undo, redo = (page.get_by_role("button", name=name) for name in ("Undo", "Redo"))
    sync_api.expect(undo).to_be_enabled()
    for _ in moments(page):
        if not undo.is_enabled():
            break
        undo.press("Enter")
    sync_api.expect(redo).to_be_focused()


LAST_TITLE = """() => {
    const find = (node, chosen) => [...node.querySelectorAll("*")].map(part => part.matches(chosen) ? part
        : part.shadowRoot ? find(part.shadowRoot, chosen) : null).find(part => part)
    const row = find(document, ".MuiTabs-scroller"), titles = row.querySelectorAll("[role=tab]")
    row.scrollLeft = row.scrollWidth
    const [end, edge] = [[...titles].at(-1), row].map(one => one.getBoundingClientRect().right)
    return end <= edge + 1 && getComputedStyle(row).maskImage == "none"
}"""
"""Whether the last title is whole, and does not fade, when the row of titles is scrolled to its end."""


def test_on_a_phone_the_last_title_can_be_scrolled_out_of_the_fade(visit):
    page = visit(420, 800)
    page.get_by_role("tab", name="Scheme").wait_for()
    assert becomes(page, lambda: page.evaluate(LAST_TITLE))
