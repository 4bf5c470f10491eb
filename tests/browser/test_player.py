"""What is animated: every run, every crossing, all that depends on time; and what is told of the pointer's place."""

import math
import re

import numpy as np
import pytest

import core
from pwsviz.figures.colours import PURPLE, SHADES, TINT
from pwsviz.scene.permalink import query
from pwsviz.scene.scene import Scene
from tests.browser.looking import await_painted, becomes
from tests.browser.test_ends import AROUND, painted, rgb
from tests.browser.test_portrait import PORTRAIT, await_still, await_that, inside

pytestmark = [pytest.mark.browser, pytest.mark.deep]

SURFACE = rgb(PURPLE)
TINTED = tuple(round(TINT * c + (1 - TINT) * 255) for c in rgb(SHADES[-1]))  # over white


def opened(visit, scene):
    page = visit(query=query(scene))
    await_painted(page, "Phase portrait")
    await_that(page, PORTRAIT)
    await_still(page)
    return page


@pytest.fixture
def shown(visit):
    def open_scene(**settings):
        scene = Scene()
        scene.load(settings)
        return opened(visit, scene)

    return open_scene


SCROLLED = "[...document.querySelectorAll('*')].reduce((sum, one) => sum + one.scrollTop, 0)"
"""Pixels by which parts of the page are scrolled."""


def animate(page):
    """Open the player, and stop it at the beginning; return its slider."""
    page.get_by_role("button", name="Animate").click()
    page.get_by_role("button", name="Pause", exact=True).click()
    return page.get_by_role("slider", name="Time")


def at_time(page, slider, time):
    slider.evaluate("(slider, time) => { slider.value = time; slider.dispatchEvent(new Event('input')) }", time)
    page.wait_for_timeout(400)


def test_a_moving_surface_moves_with_the_player(shown):
    page = shown(system="moving_interface")
    assert painted(page, (2.4, 0.0), SURFACE) > 10
    slider = animate(page)
    at_time(page, slider, math.pi / 2 / 0.7)
    assert becomes(page, lambda: painted(page, (2.4, 0.5), SURFACE) > 10)
    assert painted(page, (2.4, 0.0), SURFACE) == 0
    page.get_by_role("button", name="Close the animation").click()
    assert becomes(page, lambda: painted(page, (2.4, 0.0), SURFACE) > 10)


def test_the_animation_ends_where_another_example_or_system_is_chosen(shown):
    page = shown()
    for name, entry in (("Examples", "Dry friction sticks"), ("System", "Pendulum")):
        animate(page)
        page.get_by_role("combobox", name=name).select_option(entry)
        page.get_by_role("button", name="Animate").wait_for()
        page.get_by_role("slider", name="Time").wait_for(state="hidden")


def test_in_a_lecture_the_space_bar_opens_the_animation_and_scrolls_nothing(shown):
    page = shown()
    page.keyboard.press("l")
    page.wait_for_function("() => document.documentElement.style.getPropertyValue('--usual') == 'none'")
    page.keyboard.press("Space")
    page.get_by_role("button", name="Pause", exact=True).wait_for()
    assert page.evaluate(SCROLLED) == 0
    page.keyboard.press("Space")
    page.get_by_role("button", name="Play", exact=True).wait_for()


def test_time_that_runs_on_after_a_run_has_ended_is_not_counted_as_its_own(shown):
    page = shown(starts=((-1.0, 0.5), (1.5, 2.0)), selected=1, t_end=20.0)
    slider, told = animate(page), page.locator(".player .now")
    at_time(page, slider, 0.1)
    assert re.fullmatch(r"t = 0\.1000, 0 crossings \(start 2, dmm2\)", told.inner_text())
    at_time(page, slider, 15.0)
    assert re.fullmatch(r"t = 15\.00, \d+ crossings? until it ended at t = 0\.8 \(start 2, dmm2\)", told.inner_text())


def test_each_time_the_player_opens_space_is_its_own(shown):
    page = shown(system="moving_interface")
    play, pause = (page.get_by_role("button", name=name, exact=True) for name in ("Play", "Pause"))
    for _ in range(3):
        page.get_by_role("button", name="Animate").click()
        pause.wait_for()
        page.wait_for_timeout(300)
        assert pause.evaluate("button => button.getRootNode().activeElement == button")
        page.keyboard.press("Space")
        play.wait_for()
        page.keyboard.press("Space")
        pause.wait_for()
        page.get_by_role("button", name="Close the animation").click()
        page.get_by_role("button", name="Animate").wait_for()


def tinted(page, place):
    """Whether most of the pixels around a place have the tint to a unit of colour or two."""
    pixels = np.array(page.evaluate(AROUND, list(place)))[:, :3]
    return bool((np.abs(pixels - TINTED).max(axis=1) <= 2).mean() > 0.5)


def test_of_moving_surfaces_the_tint_leaves_out_a_region_that_is_not_declared(visit):
    law = core.Region(("1", "0.4"))
    gate = core.PiecewiseSystem(
        "Gate", ("x", "y"), surfaces=("x - sin(t)", "y"), regions={"-+": law, "++": law, "--": law}, x0=(-3.0, 0.5)
    )
    scene = Scene()
    scene.use(gate)
    page = visit(query=f"{query(scene)}&t_end=6&window=-3,3,-2,2")
    await_painted(page, "Phase portrait")
    await_that(page, PORTRAIT)
    await_still(page)
    slider = animate(page)
    for time, place in ((0.0, 0.0), (math.pi / 2, 1.0)):
        at_time(page, slider, time)
        assert becomes(page, lambda place=place: tinted(page, (place - 0.5, 1.0))), "-+ has the first shade"
        assert not tinted(page, (place + 0.5, 1.0))
        assert not tinted(page, (place - 0.5, -1.0))
        assert not tinted(page, (place + 0.5, -1.0)), "+- would have it, but is not declared"
        for on in ((place, 1.0), (place, -1.0), (place + 1.0, 0.0)):
            assert painted(page, on, SURFACE) > 10


def test_where_the_law_changes_at_instants_the_whole_plane_changes_its_shade(visit):
    scene = Scene()
    scene.use(core.PiecewiseSystem("Wave", ("x", "y"), ("y", "-x"), ("y", "-2*x"), "sin(t)", x0=(1.0, 0.0)))
    page = visit(query=f"{query(scene)}&t_end=8&window=-3,3,-3,3")
    await_painted(page, "Phase portrait")
    await_that(page, PORTRAIT)
    await_still(page)
    slider = animate(page)
    for time, shaded in ((0.0, False), (1.0, False), (4.0, True), (7.0, False)):
        at_time(page, slider, time)
        for place in ((2.5, 2.5), (-2.4, 0.3), (0.3, -2.6)):
            assert becomes(page, lambda place=place, shaded=shaded: tinted(page, place) == shaded)


def test_all_starts_move_and_one_click_and_the_space_bar_play(shown):
    page = shown(starts=((-1.0, -1.0), (-1.0, -0.5)))
    page.get_by_role("button", name="Animate").click()
    await_that(page, PORTRAIT, lambda seen: len(seen["moving"]) == 4)
    page.get_by_role("button", name="Pause", exact=True).wait_for()
    page.get_by_text(re.compile(r"crossings? \(start 1, dmm2\)")).wait_for()
    page.mouse.move(*inside(page.evaluate(PORTRAIT), 0.9, 0.9))
    page.locator("body").evaluate("() => document.activeElement.blur()")
    page.keyboard.press(" ")
    page.get_by_role("button", name="Play", exact=True).wait_for()
    page.get_by_role("tab", name="State").click()
    page.keyboard.press(" ")  # a tab that is open leaves it
    page.get_by_role("button", name="Pause", exact=True).wait_for()


BLUE = """canvas => {
    const {width, height} = canvas
    const pixels = canvas.getContext("2d").getImageData(0, 0, width, height).data
    let count = 0
    for (let k = 0; k < pixels.length; k += 4) {
        count += pixels[k] == 0 && pixels[k + 1] == 114 && pixels[k + 2] == 178
    }
    return count
}"""


def test_a_long_run_that_is_animated_paints_no_chord_across_its_curve(shown):
    page = shown(t_end=1000.0, methods=["dmm2"])
    drawing = await_painted(page, "Phase portrait")
    still = drawing.evaluate(BLUE)
    at_time(page, animate(page), 600.0)
    marker = 200  # pixels
    assert 0.9 * still - marker < drawing.evaluate(BLUE) < 1.1 * still + marker


def test_the_player_counts_every_crossing(shown):
    page = shown(t_end=5000.0, methods=["dmm2"])
    slider = animate(page)
    at_time(page, slider, 5000.0)
    counted = re.search(r"([\d,]+) crossings", slider.get_attribute("aria-valuetext"))[1]
    page.get_by_text(re.compile(rf"steps, {counted} crossings")).first.wait_for()
    assert int(counted.replace(",", "")) > 5000


def test_the_place_under_the_pointer_is_told_with_side_and_invariant(shown):
    page = shown()
    seen = page.evaluate(PORTRAIT)
    for across, side in ((0.02, "g > 0 · ψ₊"), (0.7, "g < 0 · ψ₋")):
        page.mouse.move(*inside(seen, across, 0.5))
        words = page.get_by_text(re.compile(rf"{side} = [−\d.]+$"))
        words.wait_for()
        found = re.fullmatch(r"x = (\S+), y = (\S+) · g . 0 · ψ. = (\S+)", words.inner_text())
        x, y, psi = (float(number.replace("−", "-")) for number in found.groups())
        assert psi == pytest.approx(y**2 - x**3 - (-2.0 if across < 0.5 else -3.0) * x, abs=0.05)
    page.mouse.move(2, 2)
    words.wait_for(state="detached")


def test_the_place_is_told_in_values_of_the_variables_where_one_is_drawn_in_a_unit(visit):
    energy = ("(y**2 + 1e8*x**2)/2",)
    spring = core.PiecewiseSystem(
        "Fast spring", ("x", "y"), f_minus=("y", "-1e8*x"), f_plus=("y", "-1e8*x"), g="x", x0=(1.0, 0.0),
        psi_minus=energy, psi_plus=energy,
    )  # fmt: skip
    scene = Scene()
    scene.use(spring)
    page = opened(visit, scene)
    page.mouse.move(*inside(page.evaluate(PORTRAIT), 0.3, 0.7))
    words = page.get_by_text(re.compile("g < 0 · ψ₋ = "))
    words.wait_for()
    found = re.fullmatch(r"x = (\S+), y = (\S+) · g . 0 · ψ. = ([\d.]+)×10⁷", words.inner_text())
    x, y, psi = (float(number.replace("−", "-")) for number in found.groups())
    assert psi * 1e7 == pytest.approx((y**2 + 1e8 * x**2) / 2, rel=0.01)
    assert y > 1e3


def test_the_legend_tells_whether_the_tint_it_names_is_there_at_the_time_shown(visit):
    """Of a law that changes at an instant the whole plane is on one side, then on the other."""
    scene = Scene()
    scene.use(core.PiecewiseSystem("Pushed", ("x", "v"), ("v", "-x"), ("v", "1 - x"), "t - 3", x0=(1.0, 0.0)))
    scene.accept("t_end", 7.0)
    page = opened(visit, scene)
    names = page.locator(".bk-label", has_text="g < 0")  # of the portrait, and beside it
    for time, told in ((0.0, "g < 0"), (5.0, "g < 0 (at other times)"), (2.0, "g < 0")):
        if time:
            at_time(page, page.get_by_role("slider", name="Time"), time)
        assert becomes(page, lambda told=told: names.count() > 0 and names.first.inner_text() == told), time
        if not time:
            animate(page)
