"""The cover: a fresh page shows its portrait before any script has run, at the place where it is drawn then."""

import io

import numpy as np
import pytest
from PIL import Image

from pwsviz.figures.colours import BLUE, PURPLE
from tests.browser.looking import await_built, await_painted, moments

pytestmark = pytest.mark.browser

NEAR = 3  #: pixels


def seen(page):
    """Where a screenshot has the colours of the surface and of dmm2."""
    shot = np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB")).astype(int)
    colours = [[int(colour[k : k + 2], 16) for k in (1, 3, 5)] for colour in (PURPLE, BLUE)]
    return [np.abs(shot - colour).max(axis=2) < 25 for colour in colours]  # less than between these and level sets


def grown(mask):
    """The pixels near those of a mask."""
    shifts = range(-NEAR, NEAR + 1)
    return np.any([np.roll(mask, (a, b), (0, 1)) for a in shifts for b in shifts], axis=0)


def box(mask):
    """The rectangle around the pixels of a mask."""
    rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    around = np.zeros_like(mask)
    around[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1] = True
    return around


def covered(context, address):
    """A page of which no script is loaded."""
    page = context.new_page()
    page.route("**/*.js*", lambda route: route.abort())
    for _ in moments(page):
        page.goto(address, wait_until="commit")
        page.locator("#loader").wait_for(state="attached")
        if page.locator("#cover").count():
            return page  # else the server still draws it
    raise AssertionError("no cover")


@pytest.mark.parametrize("size", [(1400, 900), pytest.param((420, 800), marks=pytest.mark.deep)])
def test_the_portrait_stands_on_the_page_before_a_script_has_run(chromium, address, size):
    context = chromium.new_context(viewport=dict(zip(("width", "height"), size, strict=True)))
    try:
        still = seen(covered(context, address))
        page = context.new_page()
        page.goto(address)
        await_built(page)
        await_painted(page, "Phase portrait")
        page.wait_for_timeout(500)
        live = seen(page)
        assert page.locator("#cover").count() == 0
        for before, after in zip(still, live, strict=True):
            assert before.sum() > 300
            portrait = after & box(before)
            # but for the thin turns of rk2, whose widths follow the size of the view
            assert (grown(after)[before]).mean() > 0.93
            assert (grown(before)[portrait]).mean() > 0.93
    finally:
        context.close()


def test_a_page_of_another_scene_does_not_show_the_portrait_of_a_fresh_one(chromium, address):
    context = chromium.new_context()
    try:
        assert covered(context, address).locator("#cover svg").count() == 1
        assert covered(context, f"{address}?system=kepler").locator("#cover svg").count() == 0
    finally:
        context.close()


@pytest.mark.deep
def test_the_code_of_the_components_is_fetched_once_and_by_the_browser_itself(visit):
    fetched = """() => performance.getEntriesByType("resource")
        .filter(one => one.name.includes("panel-material-ui.bundle.js")).map(one => one.initiatorType)"""
    assert visit().evaluate(fetched) == ["other"]
