"""Lists to choose from: what they show is what the page paints, and the keyboard suffices."""

import re

import pytest

from tests.browser.looking import await_built, await_painted, moments, type_into

pytestmark = pytest.mark.browser

SHOWN = "list => list.selectedOptions[0].text"
"""Of a list: the entry that a visitor reads."""


def await_shown(page, name, entry):
    """Wait until a list shows an entry."""
    chosen = page.get_by_role("combobox", name=name)
    for _ in moments(page):
        if (shown := chosen.evaluate(SHOWN)) == entry:
            return
    raise AssertionError(f"{name} shows {shown}, not {entry}")


@pytest.mark.deep
def test_the_plane_named_is_the_plane_drawn_after_another_system(visit):
    page = visit(query="v=1&system=rigid_body&t_end=1")
    await_painted(page, "Phase portrait")
    await_built(page)
    await_shown(page, "plane", "automatic")
    page.get_by_role("combobox", name="plane").select_option("y₁, y₃")
    await_shown(page, "plane", "y₁, y₃")
    page.get_by_role("combobox", name="System").select_option("Kepler with a shell")
    await_shown(page, "plane", "automatic")
    await_shown(page, "System", "Kepler with a shell")


@pytest.mark.deep
def test_the_system_named_is_the_last_that_was_written(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    await_built(page)
    for name in ("First", "Second", "Third"):
        page.get_by_role("button", name="Write your own").click()
        page.get_by_text("This system is ready.").wait_for()
        type_into(page, "Name", name)
        page.wait_for_timeout(500)
        page.get_by_role("button", name="Use this system").click()
        page.get_by_role("dialog").wait_for(state="hidden")
        await_shown(page, "System", f"Yours: {name}")
    page.get_by_role("combobox", name="System").select_option("Pendulum")
    await_shown(page, "System", "Pendulum")


@pytest.mark.deep
def test_a_list_is_chosen_from_by_keyboard(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    await_built(page)
    type_into(page, "End time", "2")
    system = page.get_by_role("combobox", name="System")
    system.focus()
    page.keyboard.press("ArrowDown")
    page.wait_for_url(re.compile("system=pendulum"))
    page.keyboard.type("Pred")
    page.wait_for_url(re.compile("system=predator_prey"))
    await_shown(page, "System", "Predator and prey")


@pytest.mark.deep
def test_arrow_keys_go_through_the_examples_one_by_one_and_the_name_stays_until_something_changes(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    await_built(page)
    examples = page.get_by_role("combobox", name="Examples")
    first, second = [one.text_content() for one in examples.locator("option").all()][1:3]
    examples.focus()
    for entry in (first, second):
        page.keyboard.press("ArrowDown")
        page.get_by_role("main").get_by_text(re.compile(r"\d steps")).first.wait_for()
        page.wait_for_timeout(1500)
        await_shown(page, "Examples", entry)
    type_into(page, "End time", "2")
    await_shown(page, "Examples", "choose …")


FADED_AT = """async entry => {
    const deep = (node, found) => [...node.querySelectorAll("*")].flatMap(
        part => [...(found(part) ? [part] : []), ...(part.shadowRoot ? deep(part.shadowRoot, found) : [])])
    const [list] = deep(document, part => part.tagName == "SELECT" && [...part.options].some(o => o.text == entry))
    const {el} = Bokeh.index.query_one(view => view.model.type == "Figure" && view.model.match_aspect)
    list.value = [...list.options].find(option => option.text == entry).value
    list.dispatchEvent(new Event("change", {bubbles: true}))
    await new Promise(requestAnimationFrame)
    return getComputedStyle(el).opacity
}"""
"""Chooses an entry from the list that has it, and returns the opacity of the portrait when it is painted next."""

PORTRAIT_OF = """() => Bokeh.index.query_one(view => view.model.match_aspect)
    .model.html_attributes["aria-label"].match(/of (.*)/)?.[1]"""
"""The system whose portrait is painted."""


@pytest.mark.deep
def test_the_picture_of_the_system_before_fades_at_the_moment_of_the_choice(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    await_built(page)
    opacity = "() => getComputedStyle(Bokeh.index.query_one(v => v.model.match_aspect).el).opacity"
    for entry in ("Pendulum", "Kepler with a shell", "Pendulum"):
        assert float(page.evaluate(FADED_AT, entry)) < 0.5
        for _ in moments(page):
            if page.evaluate(PORTRAIT_OF) == entry and page.evaluate(opacity) == "1":
                break
        else:
            pytest.fail(f"the portrait is of {page.evaluate(PORTRAIT_OF)}, its opacity {page.evaluate(opacity)}")
