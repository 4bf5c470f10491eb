"""The rest of the page in a real browser: views, own system, link, undo, taking away."""

import re
import subprocess
import sys

import pytest

from tests.browser.looking import (
    await_built,
    await_other_picture,
    await_painted,
    field,
    settled_picture,
    type_into,
)

sync_api = pytest.importorskip("playwright.sync_api")

pytestmark = pytest.mark.browser


@pytest.mark.deep
def test_the_address_holds_the_scene_and_undo_brings_it_back(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    type_into(page, "Step size τ", "0.0125")
    page.wait_for_url(re.compile(r"tau=0\.0125"))
    page.get_by_role("combobox", name="System").select_option("Pendulum")
    page.wait_for_url(re.compile("system=pendulum"))
    page.reload()
    page.get_by_text(re.compile("1,600 steps")).first.wait_for()
    assert field(page, "Step size τ").input_value() == "0.0125"
    type_into(page, "Step size τ", "0.02")
    page.get_by_text(re.compile("1,000 steps")).first.wait_for()
    page.get_by_role("tab", name="Order").focus()
    page.keyboard.press("Control+z")
    page.get_by_text(re.compile("1,600 steps")).first.wait_for()
    page.keyboard.press("Control+y")
    page.get_by_text(re.compile("1,000 steps")).first.wait_for()


@pytest.mark.deep
def test_a_broken_link_is_told_and_harms_nothing(visit):
    page = visit(query="v=1&system=pendulum&tau=soon&<script>alert(1)</script>=1&t_end=4.0")
    page.get_by_text(re.compile("“soon”|soon")).first.wait_for()
    await_painted(page, "Phase portrait")
    page.get_by_text(re.compile("400 steps")).first.wait_for()
    assert page.locator("script", has_text="alert(1)").count() == 0
    assert "soon" not in page.url, "the address is that of the scene that is shown"
    assert "t_end=4" in page.url
    complaint = page.get_by_role("alert").filter(has_text="soon")
    assert complaint.is_visible()
    type_into(page, "Step size τ", "0.02")
    complaint.wait_for(state="detached")


@pytest.mark.deep
def test_a_system_is_typed_checked_and_used(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    page.get_by_role("button", name="Write your own").click()
    page.get_by_text("This system is ready.").wait_for()
    law = field(page, "Field f₋, where g < 0")
    law.fill("2*y\n3*x**2 + b")
    page.get_by_text("The definition is not valid yet. Please check: Field f₋").wait_for()
    page.get_by_role("button", name="Use this system").click()
    sync_api.expect(law).to_be_focused()
    law.fill("2*y\n3*x**2 + a_minus")
    page.get_by_text("This system is ready.").wait_for()
    page.get_by_role("button", name="Use this system").click()
    page.wait_for_url(re.compile("own="))
    page.get_by_text(re.compile("21 crossings")).first.wait_for()


@pytest.mark.deep
def test_a_field_and_a_button_told_of_at_once_are_both_heard(visit):
    page = visit()
    portrait = await_painted(page, "Phase portrait")
    page.get_by_role("button", name="Write your own").click()
    page.get_by_text("This system is ready.").wait_for()
    before = settled_picture(page, portrait)
    field(page, "Field f₊, where g > 0").fill("4*y\n6*x**2 - 2.5")
    field(page, "Conserved quantities ψ₊").fill("")
    page.get_by_role("button", name="Use this system").click()  # leaves the field, and comes before it is checked
    page.get_by_role("dialog").wait_for(state="hidden")
    await_other_picture(page, portrait, before)
    page.wait_for_url(re.compile("own="))


@pytest.mark.deep
def test_the_program_taken_away_computes_what_the_page_shows(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    page.get_by_text(re.compile("2,000 steps, 21 crossings")).first.wait_for()
    page.get_by_role("button", name="Export & share").click()
    program = page.get_by_label("Python program")
    program.wait_for()
    out = subprocess.run(
        [sys.executable, "-c", program.inner_text()], check=True, capture_output=True, text=True
    ).stdout
    assert "21 crossings" in out
    page.get_by_role("dialog").get_by_role("button", name=re.compile("^Save CSV")).first.wait_for()


@pytest.mark.deep
def test_a_click_saves_one_file_and_the_next_another(visit):
    page, saved = visit(), []
    page.on("download", lambda download: saved.append(download.suggested_filename.rpartition(".")[2]))
    page.get_by_text(re.compile("2,000 steps, 21 crossings")).first.wait_for()
    page.get_by_role("button", name="Export & share").click()
    for ending in ("csv", "csv", "npz", "npz", "png", "csv"):
        with page.expect_download():
            page.get_by_role("button", name=re.compile(f"^Save {ending}", re.IGNORECASE)).first.click()
        page.wait_for_timeout(200)  # for one too many
        assert saved == [ending]
        saved.clear()
    page.keyboard.press("Escape")
    page.get_by_role("button", name=re.compile("^Save CSV")).first.wait_for(state="detached")


@pytest.mark.deep
def test_what_the_editor_says_of_conservative_methods_is_what_the_page_then_offers(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    page.get_by_role("button", name="Write your own").click()
    page.get_by_text("This system is ready.").wait_for()
    field(page, "Field f₊, where g > 0").fill("2*y\n3*x**2 - 2 - y")
    field(page, "Conserved quantities ψ₊").fill("")
    page.get_by_text(re.compile("where g > 0.*conservative methods|conservative methods will not")).first.wait_for()
    refused = page.get_by_text(re.compile("will not be offered")).count() > 0
    page.get_by_role("button", name="Use this system").click()
    page.get_by_role("dialog").wait_for(state="hidden")
    page.get_by_role("checkbox", name="rk2").wait_for()
    assert (page.get_by_role("checkbox", name="dmm2").count() == 0) == refused


@pytest.mark.deep
def test_a_system_comes_with_its_own_end_time_whatever_came_before(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    await_built(page)
    systems = page.get_by_role("combobox", name="System")
    for name, end in (("Crossing upward", "40"), ("Pendulum", "20")):
        systems.select_option(name)
        sync_api.expect(field(page, "End time")).to_have_value(end)
