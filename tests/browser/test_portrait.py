"""What a person does to the portrait with mouse, finger and keys, and what follows in the browser alone."""

import re
from time import monotonic
from time import time as wall_time

import pytest

from pwsviz.text.numbers import printed
from tests.browser.looking import await_built, field, moments
from tests.levels import deep_but

pytestmark = pytest.mark.browser

# Each returns plain numbers of a figure: places on the screen, and what its sources hold.
FIGURE = """label => {
    const view = [...Bokeh.index.query(view => view.el?.getAttribute?.("aria-label")?.startsWith(label))][0]
    if (view == null) { return null }
    const {left, top} = view.canvas_view.events_el.getBoundingClientRect(), {x_scale, y_scale, bbox} = view.frame
    const rows = view.model.renderers.map(renderer => renderer.data_source.data)
    const on_screen = (xs, ys) => Array.from(xs, (x, k) => [left + x_scale.compute(x), top + y_scale.compute(ys[k])])
    const {x_range, y_range} = view.frame, words = view.el.ariaLabel + ", " + view.el.getAttribute("aria-description")
    return {view, rows, on_screen, range: [x_range.start, x_range.end, y_range.start, y_range.end],
            frame: [left + bbox.left, top + bbox.top, bbox.width, bbox.height], words}
}"""
PORTRAIT = f"""() => {{
    const figure = ({FIGURE})("Phase portrait")
    const stars = figure?.rows.find(row => "heard" in row)
    if (stars == null || stars.x.length == 0 || figure.view.canvas_view.events_el.dataset.gestures == null) {{
        return null
    }}
    const marks = figure.rows.find(row => "number" in row && "time" in row)
    const rings = figure.rows.filter(row => Object.keys(row).join() == "x,y").map(row => Array.from(row.x))
    const moving = figure.rows.find(row => "marker" in row && "x" in row && !("kind" in row))
    return {{stars: figure.on_screen(stars.x, stars.y), at: Array.from(stars.x, (x, k) => [x, stars.y[k]]),
             chosen: Array.from(stars.chosen).indexOf(true), marks: figure.on_screen(marks.x, marks.y),
             times: Array.from(marks.time), ringed: rings.filter(row => row.length == 1 && !isNaN(row[0])).length,
             moving: Array.from(moving.x), range: figure.range, frame: figure.frame, words: figure.words,
            heard: stars.heard[0]}}
}}"""
CONSERVED = f"""() => {{
    const figure = ({FIGURE})("Absolute change")
    const ticks = figure?.rows.find(row => "foot" in row)
    if (ticks == null || ticks.t.length == 0) {{ return null }}
    const [pointed, played] = figure.rows.filter(row => Object.keys(row).join() == "t")
    return {{ticks: figure.on_screen(ticks.t, ticks.foot), times: Array.from(ticks.t),
             pointed: Array.from(pointed.t), now: played.t[0] ?? null}}
}}"""


def await_that(page, what, true=bool):
    """Wait until a look at a figure satisfies a condition, and return it."""
    for _ in moments(page):
        seen = page.evaluate(what)
        if seen is not None and true(seen):
            return seen
    raise AssertionError(f"it never came true; last seen: {seen}")


@pytest.fixture
def page(visit):
    page = visit()
    await_that(page, PORTRAIT)
    page.get_by_text(re.compile("2,000 steps, 21 crossings")).first.wait_for()
    await_still(page)
    return page


def await_still(page):
    """Wait until the first picture is laid out and fitted: until it can be touched, and nothing moves for a while."""
    await_built(page)
    before = None
    for _ in range(50):
        seen = page.evaluate(PORTRAIT)
        if seen == before:
            return
        before = seen
        page.wait_for_timeout(300)


def inside(portrait, across, up):
    left, top, width, height = portrait["frame"]
    return left + across * width, top + (1 - up) * height


def drag(page, start, by, steps=10, rest=0):
    """Drag from a place, by so many pixels, after `rest` milliseconds without motion; the button stays down."""
    page.mouse.move(*start)
    page.mouse.down()
    page.wait_for_timeout(rest)
    for k in range(1, steps + 1):
        page.mouse.move(start[0] + by[0] * k / steps, start[1] + by[1] * k / steps)
        page.wait_for_timeout(20)


def double_click(page, place):
    """Click twice, 0.1 s apart by the events' own times, however late a busy machine handles them."""
    page.mouse.move(*place)
    session, began = page.context.new_cdp_session(page), wall_time()
    for click in (1, 2):
        for late, kind in ((0.0, "mousePressed"), (0.05, "mouseReleased")):
            event = {"type": kind, "x": place[0], "y": place[1], "button": "left", "clickCount": click}
            session.send("Input.dispatchMouseEvent", {**event, "timestamp": began + 0.1 * click + late})
    page.wait_for_timeout(1000)  # a click that came sooner would be one of these


def place_second(page):
    page.mouse.click(*inside(page.evaluate(PORTRAIT), 0.3, 0.7))
    return await_that(page, PORTRAIT, lambda seen: len(seen["stars"]) == 2)


def sent(page):
    """Collect what the browser tells the server from the next load on."""
    messages = []
    page.on("websocket", lambda socket: socket.on("framesent", lambda message: messages.append(message)))
    return messages


def test_a_click_on_empty_ground_places_one_more_and_looks_into_it(page):
    seen = place_second(page)
    assert seen["chosen"] == 1
    assert "2 trajectories; number 2" in seen["words"]


@pytest.mark.deep
def test_stars_and_crossings_take_the_pointer_the_ground_pans_and_typing_removes_nothing(page):
    seen = page.evaluate(PORTRAIT)
    page.mouse.move(*inside(seen, 0.9, 0.9))
    page.mouse.move(*seen["marks"][0], steps=3)
    await_that(page, CONSERVED, lambda other: other["pointed"] == seen["times"][:1])
    page.mouse.move(2, 2)
    other = await_that(page, CONSERVED, lambda other: other["pointed"] == [])
    x, y = other["ticks"][1]
    page.mouse.move(x, y - 60)
    page.mouse.move(x, y, steps=3)
    await_that(page, PORTRAIT, lambda seen: seen["ringed"] == 1)
    page.mouse.move(2, 2)
    await_that(page, PORTRAIT, lambda seen: seen["ringed"] == 0)

    seen = place_second(page)
    page.mouse.click(*seen["stars"][0])
    seen = await_that(page, PORTRAIT, lambda seen: seen["chosen"] == 0)
    assert len(seen["stars"]) == 2, "a click on a star selects it and places nothing"
    entry = field(page, "Step size τ")
    entry.focus()
    entry.press("End")
    entry.press("Backspace")
    page.wait_for_timeout(500)
    before = page.evaluate(PORTRAIT)
    assert len(before["stars"]) == 2
    drag(page, inside(before, 0.9, 0.9), (-50, 30))
    page.mouse.up()
    after = await_that(page, PORTRAIT, lambda seen: seen["range"] != before["range"])
    assert after["at"] == before["at"]


@pytest.mark.parametrize("key", deep_but(["Delete"], ["Delete", "Backspace"]))
def test_a_key_removes_the_selected_one(page, key):
    seen = place_second(page)
    page.keyboard.press(key)
    left = await_that(page, PORTRAIT, lambda seen: len(seen["stars"]) == 1)
    assert left["at"] == seen["at"][:1]


def test_a_star_follows_the_pointer_the_view_stays_and_the_trajectory_follows(page):
    before = page.evaluate(PORTRAIT)
    drag(page, before["stars"][0], (60, -40))
    moved = await_that(page, PORTRAIT, lambda seen: seen["words"] != before["words"])  # recomputed on the way
    assert moved["range"][:2] == pytest.approx(before["range"][:2], abs=0.01)  # a legend that grows takes height
    assert moved["stars"][0] == pytest.approx([before["stars"][0][0] + 60, before["stars"][0][1] - 40], abs=1)
    page.mouse.up()
    x, y = (printed(f"{value:.3g}") for value in moved["at"][0])
    await_that(page, PORTRAIT, lambda seen: f"starts at ({x}" in seen["words"] and y in seen["words"])


TIPS = """() => [...document.querySelectorAll(".bk-Tooltip")]
    .filter(tip => tip.checkVisibility({visibilityProperty: true})).map(tip => tip.getBoundingClientRect().width)"""
"""The widths of all tips that are seen."""


@pytest.mark.deep
def test_what_tells_of_the_place_under_the_pointer_is_not_seen_while_a_star_is_dragged(page):
    x, y = page.evaluate(PORTRAIT)["stars"][0]
    page.mouse.move(x, y)  # a level set passes through it
    page.wait_for_function(f"() => ({TIPS})().some(width => width > 0)")
    page.mouse.down()
    page.mouse.move(x + 30, y - 30)
    assert page.evaluate(TIPS) == []
    page.mouse.up()
    for _ in range(100):  # until the level set that the start has left for comes, on which the star lies then
        for away in (5, 0):
            page.mouse.move(x + 30 + away, y - 30)
        page.wait_for_timeout(100)
        if any(width > 0 for width in page.evaluate(TIPS)):
            break
    assert any(width > 0 for width in page.evaluate(TIPS))


@pytest.mark.deep
def test_a_finger_drags_a_star_and_a_double_tap_removes_it(page):
    before = place_second(page)
    touch = page.context.new_cdp_session(page)

    def finger(kind, *place):
        points = [{"x": place[0], "y": place[1]}] if place else []
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    x, y = before["stars"][0][0] + 12, before["stars"][0][1] - 12  # fingers are thick
    finger("touchStart", x, y)
    for k in range(1, 9):
        finger("touchMove", x + 5 * k, y - 4 * k)
        page.wait_for_timeout(20)
    finger("touchEnd")
    after = await_that(page, PORTRAIT, lambda seen: seen["chosen"] == 0)
    assert after["stars"][0] == pytest.approx([before["stars"][0][0] + 40, before["stars"][0][1] - 32], abs=2)
    for _ in range(5):  # taps that a busy machine sees too far apart are two, and a person would try again
        for _ in range(2):
            finger("touchStart", *after["stars"][0])
            finger("touchEnd")
        page.wait_for_timeout(1500)
        if len(page.evaluate(PORTRAIT)["stars"]) == 1:
            break
    left = await_that(page, PORTRAIT, lambda seen: len(seen["stars"]) == 1)
    assert left["at"] == after["at"][1:]


@pytest.mark.deep
def test_the_player_moves_a_marker_for_each_integrator_and_tells_the_server_nothing(visit):
    page = visit()
    messages = sent(page)
    page.reload()
    await_that(page, PORTRAIT)
    await_still(page)
    assert page.evaluate(PORTRAIT)["moving"] == []
    page.get_by_role("button", name="Animate").click()  # and it plays
    await_that(page, PORTRAIT, lambda seen: len(seen["moving"]) == 2)
    page.wait_for_timeout(500)
    count = len(messages)
    first = await_that(page, CONSERVED, lambda other: (other["now"] or 0) > 0)["now"]
    await_that(page, CONSERVED, lambda other: other["now"] > first)
    page.get_by_role("button", name="Pause", exact=True).click()
    assert len(messages) == count
    page.get_by_role("button", name="Close the animation").click()
    await_that(page, CONSERVED, lambda other: other["now"] is None)
    assert page.evaluate(PORTRAIT)["moving"] == []


@pytest.mark.deep
def test_keys_step_through_the_run_and_its_crossings(page):
    page.get_by_role("button", name="Animate").click()
    await_that(page, PORTRAIT, lambda seen: len(seen["moving"]) == 2)
    page.get_by_role("button", name="Pause", exact=True).click()
    page.get_by_role("slider", name="Time").press("Home")
    times = page.evaluate(CONSERVED)["times"]
    slider = page.get_by_role("slider", name="Time")
    slider.focus()
    for key, time in (("ArrowRight", 0.01), ("Shift+ArrowRight", times[0]), ("Shift+ArrowRight", times[1]),
                      ("Shift+ArrowLeft", times[0])):  # fmt: skip
        slider.press(key)
        await_that(page, CONSERVED, lambda other, time=time: other["now"] == pytest.approx(time))
    assert "1 crossing" in slider.get_attribute("aria-valuetext")
    slider.press(" ")
    await_that(page, CONSERVED, lambda other: other["now"] > times[0] + 0.05)
    slider.press(" ")
    page.get_by_role("button", name="Play", exact=True).wait_for()


@pytest.mark.deep
def test_those_who_want_no_motion_get_single_pictures(visit):
    page = visit(reduced_motion="reduce")
    await_that(page, PORTRAIT)
    page.get_by_role("button", name="Animate").click()
    await_that(page, PORTRAIT, lambda seen: len(seen["moving"]) == 2)
    seen, begun = set(), monotonic()
    while (passed := monotonic() - begun) < 1.3:
        seen.add(page.evaluate(CONSERVED)["now"])
        page.wait_for_timeout(50)
    assert 2 <= len(seen) <= 2 + passed / 0.5, "a picture each half second"


@pytest.mark.deep
def test_the_first_window_of_a_bouncing_ball_is_mostly_where_the_ball_may_be(visit):
    page = visit(query="v=2&system=bouncing_ball")
    left, right, *_ = await_that(page, PORTRAIT, lambda seen: "jump" in seen["words"])["range"]
    assert 0 < -left < 0.25 * (right - left)  # the wall is at y = 0


@pytest.mark.deep
def test_a_triangle_is_painted_as_large_as_a_square(visit):
    page = visit(query="v=2&system=stick_slip&methods=rk4")
    look = f"""() => {{
        const marks = ({FIGURE})("Phase portrait")?.rows.find(row => "number" in row && "time" in row)
        return Object.fromEntries(Array.from(marks?.marker ?? [], (marker, k) => [marker, marks.size[k]]))
    }}"""
    sizes = await_that(page, look, lambda seen: {"square", "inverted_triangle"} <= {*seen})
    assert sizes["inverted_triangle"] > 1.3 * sizes["square"]


@pytest.mark.deep
def test_the_wheel_alone_says_that_it_zooms_with_ctrl(visit):
    page = visit()
    await_still(page)
    page.mouse.move(*inside(page.evaluate(PORTRAIT), 0.5, 0.5))
    page.mouse.wheel(0, 10)
    page.get_by_text("use ctrl + scroll to zoom").locator("visible=true").wait_for()  # the words are Bokeh's
