"""The editor takes walls and hysteresis: it starts from a system of the catalogue, and the page shows the change."""

import re

import pytest

from tests.browser.looking import await_painted, field
from tests.browser.test_portrait import PORTRAIT, await_that

sync_api = pytest.importorskip("playwright.sync_api")

pytestmark = [pytest.mark.browser, pytest.mark.deep]


def test_walls_are_changed_in_the_editor_and_kept_in_the_link(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    page.get_by_text("Write your own").click()
    several = field(page, "Switching functions g1, g2")
    field(page, "Switching function g").wait_for()
    assert several.count() == 0, "few need it"
    page.get_by_role("button", name="Start from").click()
    page.get_by_role("menuitem", name="Oscillator between walls").click()
    several.wait_for()
    resets = field(page, "Resets at surfaces")
    sync_api.expect(resets).to_have_value(re.compile("g1"))  # painted a moment after the fields are
    resets.fill("g1 => x")
    page.get_by_text("At g1: 1 expression given, 2 needed").wait_for()
    page.get_by_role("button", name="Use this system").click()
    sync_api.expect(resets).to_be_focused()
    resets.fill("g1, g2 => x, -v/2")
    page.get_by_text("This system is ready.").wait_for()
    page.get_by_role("button", name="Use this system").click()
    await_that(page, PORTRAIT, lambda seen: "Oscillator between walls" in seen["words"] and "jumps" in seen["words"])
    page.wait_for_function("location.search.includes('own=')")
    page.reload()
    await_that(page, PORTRAIT, lambda seen: "jumps" in seen["words"])
    page.get_by_text("Write your own").click()
    resets.wait_for()
    assert re.fullmatch(r"g1 => x, -v/2\ng2 => x, -v/2", resets.input_value())
