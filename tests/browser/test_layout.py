"""The screen is used, whatever its size: two columns, a portrait in sight, a lecture mode, and fingers."""

import re
from time import time

import pytest

from pwsviz.scene.views import VIEWS
from pwsviz.widgets.lecture import LABELS, LARGER
from tests.browser.looking import BLANK_KEYS, RUN, THEME, await_built, await_painted, becomes, canvas, field
from tests.browser.test_portrait import PORTRAIT, await_still, await_that, inside

pytestmark = pytest.mark.browser

TYPE = """() => [...Bokeh.documents[0]._all_models.values()].filter(part => /Axis$/.test(part.type))
    .map(part => parseFloat(part.major_label_text_font_size))"""

SCROLLED = """() => {
    const tops = []
    const walk = node => node.querySelectorAll("*").forEach(one => {
        tops.push(one.scrollTop)
        if (one.shadowRoot) walk(one.shadowRoot)
    })
    walk(document)
    return Math.max(window.scrollY, ...tops)
}"""


@pytest.mark.deep
def test_portrait_and_view_share_a_wide_screen(visit):
    page = visit(1920, 1080)
    boxes = [await_painted(page, name).bounding_box() for name in ("Phase portrait", "conserved quantity")]
    assert all(box["width"] > 700 and box["height"] > 750 for box in boxes)
    assert boxes[1]["x"] + boxes[1]["width"] > 1850


@pytest.mark.deep
@pytest.mark.parametrize(("scheme", "width"), [("light", 1400), ("dark", 1400), ("light", 1280)])
def test_the_titles_of_all_views_are_seen_in_one_row(visit, scheme, width):
    tabs = visit(width, color_scheme=scheme).get_by_role("tab").all()
    assert len({tab.bounding_box()["y"] for tab in tabs}) == 1
    assert tabs[-1].bounding_box()["x"] + tabs[-1].bounding_box()["width"] < width


@pytest.mark.parametrize("size", [(420, 800), (1200, 900)])
def test_on_narrower_screens_the_row_of_titles_scrolls_to_the_one_chosen(visit, size):
    page = visit(*size, query="v=2&view=scheme")
    tabs = page.get_by_role("tab").all()

    def sides(tab):
        box = tab.bounding_box()
        return box["x"], box["x"] + box["width"]

    assert len({tab.bounding_box()["y"] for tab in tabs}) == 1
    assert becomes(page, lambda: sides(tabs[-1])[1] <= size[0]), "it was chosen by the link"
    page.get_by_text("The scheme: dmm2").wait_for()
    await_painted(page, "Phase portrait")

    def first_is_seen():
        tabs[-1].focus()
        page.keyboard.press("Home")
        page.wait_for_timeout(500)  # it scrolls smoothly
        return sides(tabs[0])[0] >= 0 and sides(tabs[0])[1] <= size[0]

    assert becomes(page, first_is_seen)
    assert page.evaluate("document.documentElement.scrollWidth") <= size[0], "the page itself does not scroll sideways"


def test_on_a_phone_check_boxes_are_large_enough_for_a_finger(visit):
    page = visit(420, 800)
    page.get_by_label("Open menu").click()
    boxes = page.locator(".sidebar").get_by_role("checkbox")
    boxes.first.wait_for()

    def are_large():  # once the sheet that holds them has its style
        found = [box.bounding_box() for box in boxes.all()]
        return all(one is not None and min(one["width"], one["height"]) >= 24 for one in found)

    assert becomes(page, are_large)


@pytest.mark.deep
def test_on_a_narrow_screen_the_portrait_makes_way_for_the_view_below(visit):
    page = visit(420, 800)
    portrait = await_painted(page, "Phase portrait")
    before = portrait.bounding_box()["y"]
    page.mouse.move(210, 560)
    page.mouse.wheel(0, 400)
    assert becomes(page, lambda: portrait.bounding_box()["y"] < before - 350)


@pytest.mark.deep
def test_the_portrait_stays_in_sight_beside_a_long_view(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    page.get_by_role("tab", name="Scheme").click()
    page.get_by_text("The scheme: dmm2").wait_for()
    page.mouse.move(1150, 600)
    page.mouse.wheel(0, 600)
    page.wait_for_function(f"() => ({SCROLLED})() > 300")
    top = canvas(page, "Phase portrait").bounding_box()["y"]
    assert 0 < top < 300


def test_a_system_without_psi_opens_on_its_state_against_time(visit):
    page = visit(query="v=1&system=relay_feedback")
    await_painted(page, "Coordinate x against time")
    page.get_by_text("rk2 up to t = 19.1: x from").wait_for()


WIDTHS = """() => [...Bokeh.index.query(view => ["GlyphRenderer", "Span"].includes(view.model.type))]
    .map(view => view.glyph ?? view)
    .flatMap(({visuals: {line}, size}) => [line?.line_width, size].map(one => one?.get?.(0) ?? one?.value ?? 0))"""
"""Widths in pixels of the lines of all figures, and sizes of their marks."""


@pytest.fixture
def lecture(visit):
    """A page in lecture mode, with the sizes of its type and the widths of its lines before."""
    page = visit(1920, 1080)
    await_painted(page, "Phase portrait")
    await_built(page)
    usual, widths = page.evaluate(TYPE), page.evaluate(WIDTHS)
    page.keyboard.press("l")
    page.wait_for_function(f"() => document.documentElement.style.fontSize == '{100 * LARGER:g}%'")
    return page, usual, widths


BEGUN = "on => (document.documentElement.style.getPropertyValue('--usual') == 'none') == on"
"""Whether a lecture has begun."""


@pytest.mark.deep
def test_a_key_turns_the_lecture_mode_on_and_off(lecture):
    page, usual, widths = lecture
    assert page.evaluate(TYPE) == pytest.approx([LABELS * LARGER * size for size in usual])
    assert page.evaluate(WIDTHS) == pytest.approx([LARGER * width for width in widths]), "lines and marks grow with it"
    for leave in ("l", "Escape"):
        page.keyboard.press(leave)
        page.wait_for_function("() => document.documentElement.style.fontSize == ''")
        assert page.evaluate(TYPE) == usual
        assert page.evaluate(WIDTHS) == widths
        page.keyboard.press("l")
        page.wait_for_function(BEGUN, arg=True)


@pytest.mark.deep
def test_the_help_has_a_button_for_the_lecture_mode_as_a_phone_has_no_keys(phone):
    for begun in (True, False):
        phone.get_by_role("button", name="Help (?)").click()
        phone.get_by_role("button", name="Lecture mode").click()
        phone.wait_for_function(BEGUN, arg=begun)
        assert phone.evaluate("document.documentElement.style.fontSize") == "", "there is no room for larger type"
        assert becomes(phone, lambda: not phone.get_by_role("dialog").is_visible())


@pytest.mark.deep
def test_in_a_lecture_type_stays_large_when_the_theme_changes(lecture):
    page, usual, widths = lecture
    for _ in range(2):
        page.get_by_label(THEME).click()
        page.wait_for_timeout(1500)
        assert becomes(page, lambda: page.evaluate(TYPE) == pytest.approx([LABELS * LARGER * size for size in usual]))
        assert becomes(page, lambda: page.evaluate(WIDTHS) == pytest.approx([LARGER * width for width in widths]))
    page.keyboard.press("l")
    page.wait_for_function("() => document.documentElement.style.fontSize == ''")
    assert becomes(page, lambda: page.evaluate(TYPE) == usual)
    assert becomes(page, lambda: page.evaluate(WIDTHS) == widths)


FRAME = """() => {
    const {frame: {bbox}, el} = Bokeh.index.query_one(view => view.model.type == "Figure" && view.model.match_aspect)
    const foot = el.getBoundingClientRect().bottom
    return [bbox.width, bbox.height, window.innerHeight - foot]
}"""
"""Width and height of the frame of the portrait, and how far from the lower end of the screen its figure ends."""


@pytest.mark.deep
@pytest.mark.parametrize("screen", [(1920, 1080), (1400, 900), (1280, 720)])
def test_in_lecture_mode_the_portrait_is_wider_and_nearly_as_high_with_what_is_told_below_it(visit, screen):
    page = visit(*screen)
    await_painted(page, "Phase portrait")
    await_still(page)
    width, height, _ = page.evaluate(FRAME)
    page.keyboard.press("l")
    assert becomes(page, lambda: page.evaluate(FRAME)[0] > 1.1 * width), "the controls make way"
    await_still(page)
    page.get_by_role("button", name="Animate").click()
    page.get_by_role("slider", name="Time").wait_for()
    assert becomes(page, lambda: page.evaluate(FRAME)[1] > 0.8 * height), page.evaluate(FRAME)
    assert page.evaluate(FRAME)[2] > 0, "the figure and its legend are whole on the screen"
    assert page.get_by_role("slider", name="Time").bounding_box()["y"] < screen[1]
    told = page.get_by_text(re.compile("rk2: 2,000 steps")).first.bounding_box()
    assert told["y"] + told["height"] <= 1080 or screen[1] < 1080, "on a projector, both integrators' results"


@pytest.fixture
def phone(chromium, address):
    context = chromium.new_context(viewport={"width": 420, "height": 800}, has_touch=True, is_mobile=True)
    page = context.new_page()
    page.goto(f"{address}?v=2")
    await_built(page)
    await_that(page, PORTRAIT)
    await_still(page)
    yield page
    context.close()


def double_tap(page, place):
    """Tap twice, 0.1 s apart by the events' own times, however late a busy machine handles them."""
    touch, began = page.context.new_cdp_session(page), time()
    for tap in (1, 2):
        for late, kind, points in ((0.0, "touchStart", [{"x": place[0], "y": place[1]}]), (0.05, "touchEnd", [])):
            event = {"type": kind, "touchPoints": points, "timestamp": began + 0.1 * tap + late}
            touch.send("Input.dispatchTouchEvent", event)


def swipe(page, fingers, by):
    """Move fingers that start at these places by (dx, dy) pixels."""
    touch = page.context.new_cdp_session(page)
    for k in range(9):
        points = [{"x": x + by[0] * k / 8, "y": y + by[1] * k / 8, "id": i} for i, (x, y) in enumerate(fingers)]
        touch.send("Input.dispatchTouchEvent", {"type": "touchMove" if k else "touchStart", "touchPoints": points})
        page.wait_for_timeout(20)
    touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})


@pytest.mark.deep
def test_one_finger_scrolls_the_page_and_two_move_the_portrait(phone):
    before = phone.evaluate(PORTRAIT)
    x, y = inside(before, 0.5, 0.5)
    swipe(phone, [(x - 40, y), (x + 40, y)], (60, 30))
    await_that(
        phone, PORTRAIT, lambda now: now["range"][0] < before["range"][0] and now["range"][2] > before["range"][2]
    )
    phone.wait_for_timeout(500)
    seen = phone.evaluate(PORTRAIT)
    swipe(phone, [(x, y)], (0, -200))
    phone.wait_for_function(f"() => ({SCROLLED})() > 100")
    assert phone.evaluate(PORTRAIT)["range"] == pytest.approx(seen["range"])


@pytest.mark.deep
def test_on_a_phone_most_titles_of_views_are_in_sight_and_the_controls_leave_the_portrait_so(phone):
    tabs = [tab.bounding_box() for tab in phone.get_by_role("tab").all()]
    assert len(tabs) == len(VIEWS)
    seen = [tab for tab in tabs if tab["x"] >= 0 and tab["x"] + tab["width"] <= 420]
    assert 2 * len(seen) > len(tabs)
    assert any(tab["x"] < 420 < tab["x"] + tab["width"] for tab in tabs), "one is cut: the row goes on"
    drawer = phone.locator(".sidebar")
    for close in (lambda: phone.touchscreen.tap(200, 200), lambda: phone.keyboard.press("Escape")):
        phone.get_by_label("Open menu").tap()
        drawer.get_by_label("Examples").wait_for()
        phone.wait_for_timeout(400)  # it slides in
        assert drawer.bounding_box()["y"] >= 0.4 * 800
        close()
        drawer.wait_for(state="hidden")
    assert len(phone.evaluate(PORTRAIT)["stars"]) == 1, "the tap beside the controls places nothing"
    double_tap(phone, inside(phone.evaluate(PORTRAIT), 0.3, 0.7))
    phone.wait_for_timeout(1000)  # the first of them places a star for a moment, or longer while the server is busy
    assert becomes(phone, lambda: len(phone.evaluate(PORTRAIT)["stars"]) == 1), "two taps fit"


@pytest.mark.deep
@pytest.mark.parametrize("system", ["elliptic_curve", "two_walls"])
def test_on_a_phone_the_view_begins_on_the_screen_of_the_portrait(visit, system):
    page = visit(420, 800, query=f"v=2&system={system}")
    await_painted(page, "Phase portrait")
    figure = await_painted(page, "conserved quantity").bounding_box()
    tabs = [tab.bounding_box()["y"] for tab in page.get_by_role("tab").all()]
    assert max(tabs) < 680
    assert figure["y"] < 740
    runs = page.get_by_text(re.compile("^dmm2: .* steps")).locator("visible=true").bounding_box()
    assert runs["y"] + runs["height"] < min(tabs), "the figures of the runs stand by the portrait"
    assert runs["height"] < 30, "each in a line"


@pytest.mark.deep
def test_on_a_phone_the_words_on_a_run_that_blows_up_stand_between_the_portrait_and_the_view(visit):
    page = visit(420, 800, query="v=2&tau=0.4")
    words = page.get_by_text(re.compile("^rk2: .*grows beyond bounds")).locator("visible=true")
    assert becomes(page, lambda: words.count() == 1)
    place, tab = words.bounding_box()["y"], page.get_by_role("tab").first.bounding_box()["y"]
    assert canvas(page, "Phase portrait").bounding_box()["y"] < place < tab


@pytest.mark.deep
@pytest.mark.parametrize("width", [420, 1400])
def test_a_warning_is_folded_after_its_first_sentence_on_a_phone_and_whole_on_a_wide_screen(visit, width):
    page = visit(width, 900, query="v=2&methods=rk2&tau=0.4")
    whole = page.locator(".others").get_by_text("Otherwise take a smaller step size").locator("visible=true")
    more = page.get_by_role("button", name="more", exact=True)
    first = page.get_by_text(re.compile("^rk2: .*grows beyond bounds")).locator("visible=true")
    assert becomes(page, lambda: first.count() == 1)
    if width > 1000:
        assert whole.count() == 1
        assert more.count() == 0
        return
    assert whole.count() == 0
    more.click()
    assert becomes(page, lambda: whole.count() == 1)
    page.get_by_role("button", name="less", exact=True).click()
    assert becomes(page, lambda: whole.count() == 0)


@pytest.mark.deep
def test_a_warning_that_is_unfolded_on_a_phone_stays_so_when_the_next_run_brings_other_words(visit):
    page = visit(420, 900, query="v=2&methods=rk2&tau=0.4")
    page.get_by_role("button", name="more", exact=True).click()
    advice = page.locator(".others").get_by_text("Otherwise take a smaller step size").locator("visible=true")
    assert becomes(page, lambda: advice.count() == 1)
    page.get_by_role("button", name="menu").click()
    for tau in ("0.39", "0.38"):
        before = page.locator(".stopped").first.text_content()
        field(page, "Step size τ").fill(tau)
        field(page, "Step size τ").press("Enter")
        told = page.locator(".stopped").first
        assert becomes(page, lambda told=told, before=before: told.text_content() != before)
        assert becomes(page, lambda: advice.count() == 1)
    assert page.locator(".more[aria-label=less]").count() == 1


def test_the_footer_of_the_first_page_is_seen_whole(visit):
    page = visit(1400, 900)
    await_painted(page, "conserved quantity")
    words = page.locator("footer p").last
    assert becomes(page, lambda: words.bounding_box()["y"] + words.bounding_box()["height"] <= 900)


@pytest.mark.deep
def test_on_a_phone_the_first_screen_says_what_the_page_is_and_what_to_try(phone):
    words = phone.get_by_text(re.compile("across a surface.*Tap in the portrait")).locator("visible=true")
    assert words.count() == 1
    assert words.bounding_box()["y"] < canvas(phone, "Phase portrait").bounding_box()["y"]


LEGENDS = """() => [...Bokeh.index.query(view => view.model.type == "Legend")].flatMap(({entries, plot_view}) =>
    entries.filter(({el}) => el.offsetWidth > 0).map(({el, label}) => {
        const [entry, plot] = [el, plot_view.el].map(part => part.getBoundingClientRect())
        return {label, inside: entry.left >= plot.left && entry.right <= plot.right}
    }))"""
"""The entries of all legends that are shown, and whether they are inside their figures."""


@pytest.mark.deep
@pytest.mark.parametrize(
    ("view", "wanted"),
    [("cost", "incorrect sequence of crossings"), ("stability", "incorrect or mistimed crossings")],
)
def test_no_entry_of_a_legend_is_cut_on_a_narrow_screen(visit, view, wanted):
    page = visit(420, 800, query=f"v=2&view={view}")
    await_painted(page, "Phase portrait")
    page.wait_for_function(f"() => ({LEGENDS})().some(one => one.label == '{wanted}')", timeout=90_000)
    page.wait_for_timeout(500)
    assert [one["label"] for one in page.evaluate(LEGENDS) if not one["inside"]] == []


def test_on_a_phone_the_legend_of_the_portrait_has_two_rows_until_it_is_unfolded(phone):
    shown = lambda: [one["label"] for one in phone.evaluate(LEGENDS)]  # noqa: E731
    rest = ["f/|f|", "ψ = const.", "S attracts", "S repels"]
    assert becomes(phone, lambda: "start" in shown() and not {*rest} & {*shown()}), shown()
    assert phone.evaluate(KEYS)["legend"] <= 2 * 18 + 2
    button = phone.get_by_role("button", name="more entries of the legend")
    assert button.get_attribute("aria-expanded") == "false"
    button.focus()
    phone.keyboard.press("Enter")
    assert becomes(phone, lambda: {*rest} <= {*shown()}), shown()
    assert phone.evaluate(BLANK_KEYS) == []
    phone.get_by_role("button", name="fewer entries of the legend").click()
    assert becomes(phone, lambda: not {*rest} & {*shown()}), shown()


def test_on_a_phone_a_button_shows_the_tabs_that_are_out_of_sight(phone):
    last = phone.get_by_role("tab", name="Scheme")
    in_sight = lambda: last.bounding_box()["x"] + last.bounding_box()["width"] <= 420 - 16  # noqa: E731
    assert not in_sight()
    for _ in range(3):
        if phone.get_by_role("button", name="First views").count() == 0:
            phone.get_by_role("button", name="More views").click()
            phone.wait_for_timeout(800)  # it scrolls smoothly
    assert becomes(phone, in_sight), last.bounding_box()
    phone.get_by_role("button", name="First views").click()
    phone.get_by_role("button", name="More views").wait_for()


def test_where_all_tabs_are_in_sight_there_is_no_such_button(visit):
    page = visit(1280, 720)
    page.get_by_role("tab", name="Scheme").wait_for()
    assert becomes(page, lambda: page.locator(".more-tabs").count() == 1)
    assert not page.locator(".more-tabs").is_visible()


ROOM = """() => [...Bokeh.index.query(view => view.model.type == "Legend")].filter(({el}) => el.offsetHeight > 0)
    .map(({el, layout}) => Math.round(layout.bbox.height) - el.offsetHeight)"""
"""By how many pixels the room of each legend that is shown is larger than the legend."""


@pytest.mark.deep
def test_a_figure_has_just_as_much_room_for_its_legend_as_that_needs(visit):
    for _ in range(3):  # it was a matter of chance
        page = visit(1400, 900)
        for name in ("Phase portrait", "conserved quantity"):
            await_painted(page, name)
        page.wait_for_timeout(1000)
        assert becomes(page, lambda page=page: page.evaluate(ROOM) == [0, 0]), page.evaluate(ROOM)


MADE_ANEW = """() => {
    const view = Bokeh.index.query_one(view => view.model.type == "Legend"), before = view.bbox.height
    view._render_items()
    view.update_position()
    return [before, view.bbox.height]
}"""
"""Heights of the first legend, as its figure knows them, before and after its entries are made anew."""


def test_a_figure_keeps_its_height_when_the_entries_of_its_legend_are_made_anew(visit):
    page = visit(1400, 900)
    await_painted(page, "Phase portrait")
    page.get_by_role("button", name="more entries of the legend").wait_for()
    before, after = page.evaluate(MADE_ANEW)
    assert after == before, "entries that are folded take no room"


KEYS = """() => {
    const view = Bokeh.index.query_one(view => view.model.type == "Legend")
    const marked = ({canvas}) => {
        const {width, height} = canvas, pixels = canvas.getContext("2d").getImageData(0, 0, width, height).data
        const rows = Array.from({length: height}, (_, j) => j)
        return rows.filter(j => pixels.slice(4 * j * width, 4 * (j + 1) * width).some(value => value > 0)).length
    }
    return {legend: view.grid_el.offsetHeight, frame: view.plot_view.frame.bbox.height,
            heights: Object.fromEntries(view.entries.map(({label, glyph}) => [label, marked(glyph)]))}
}"""
"""Heights in pixels: of the first legend and the frame above it, and of what is painted in each key."""


@pytest.mark.deep
def test_on_a_phone_a_legend_is_small_beside_its_picture_and_its_marks_are_as_those_in_it(phone):
    seen = await_that(phone, KEYS, lambda now: now["heights"]["start"] > 15)
    assert seen["legend"] < 0.25 * seen["frame"]
    assert 8 <= seen["heights"]["crossing"] <= 12  # 9 and the rim


CUT = """() => {
    const found = []
    const look = node => {
        for (const part of [...node.children ?? [], ...(node.shadowRoot?.children ?? [])]) {
            const seen = part.nodeName == "LABEL" && part.checkVisibility({visibilityProperty: true}) &&
                part.clientWidth > 1  // those for screen readers alone are a pixel wide
            if (seen && part.scrollWidth > part.clientWidth) { found.push(part.textContent) }
            look(part)
        }
    }
    look(document.body)
    return found
}"""
"""The names of fields that do not fit."""


@pytest.mark.deep
def test_on_a_phone_a_view_that_is_chosen_comes_into_sight(phone):
    tabs = phone.get_by_role("tablist")
    phone.get_by_text(RUN).first.wait_for()  # what is told of the first run moves the tabs
    await_still(phone)
    assert tabs.bounding_box()["y"] > 400
    phone.get_by_role("tab", name="Order").tap()
    assert becomes(phone, lambda: tabs.bounding_box()["y"] < 200)
    figure = phone.get_by_role("tabpanel").get_by_role("application").first
    figure.wait_for()
    assert figure.bounding_box()["y"] < 400


def test_in_lecture_mode_titles_of_views_keep_to_one_row_and_names_of_fields_are_whole(visit):
    page = visit(query="v=2&system=chua&view=section")
    await_painted(page, "Poincaré section")
    page.keyboard.press("l")
    page.wait_for_function(BEGUN, arg=True)
    page.wait_for_timeout(500)
    tops = [tab.bounding_box()["y"] for tab in page.get_by_role("tab").all()]
    assert max(tops) - min(tops) < 1
    assert becomes(page, lambda: page.evaluate(CUT) == []), page.evaluate(CUT)


@pytest.mark.deep
@pytest.mark.parametrize(
    ("view", "words"),
    [
        ("section&system=bouncing_ball", "53 points on"),
        ("stability", "crossings instead of"),
        ("order", "slope 2.00 before"),
    ],
)
def test_in_a_lecture_the_conclusion_of_a_figure_below_controls_is_in_sight(visit, view, words):
    page = visit(1366, 768, query=f"v=2&view={view}")
    page.keyboard.press("l")
    panel = page.get_by_role("tabpanel").locator("visible=true")
    figure = panel.get_by_role("application").first
    figure.wait_for()
    told = panel.get_by_text(re.compile(words)).first
    told.wait_for()

    def is_in_sight():
        text, plot = told.bounding_box(), figure.bounding_box()
        return plot["y"] + plot["height"] <= text["y"] and text["y"] + 30 < 768 and plot["height"] > 340

    assert becomes(page, is_in_sight), (told.bounding_box(), figure.bounding_box())


@pytest.mark.parametrize("screen", [(1920, 1080), (1280, 720)])
def test_in_a_lecture_reasons_to_stop_and_warnings_are_in_sight(visit, screen):
    page = visit(*screen, query="v=2&system=kepler&methods=dmm2,rk2,rk4&tau=0.5")
    await_painted(page, "Phase portrait")
    page.get_by_text(re.compile("rk4: The step of 0.5 at .* too long")).wait_for()
    page.keyboard.press("l")
    page.wait_for_function(BEGUN, arg=True)
    told = [page.get_by_text(re.compile(words)).first for words in ("^dmm2: t = 0", "^rk2: The step", "^rk4: The step")]

    def are_in_sight():
        boxes = [one.bounding_box() for one in told]
        return all(box["y"] + box["height"] <= screen[1] for box in boxes)

    assert becomes(page, are_in_sight), [one.bounding_box() for one in told]
    width, height, _ = page.evaluate(FRAME)
    assert min(width, height) > 0.2 * screen[1], "the portrait is still seen"
    laid_out = """() => {
        const view = Bokeh.index.query_one(view => view.model.type == "Figure" && view.model.match_aspect)
        return view.layout.bbox.height == view.bbox.height
    }"""
    assert becomes(page, lambda: page.evaluate(laid_out)), "what is painted fills its place"


STARTS = ";".join(f"-1.3,{0.15 * k - 0.9:.2f}" for k in range(12))


@pytest.mark.deep
def test_the_numbers_of_many_starts_stand_in_rows_within_the_controls(visit):
    page = visit(query=f"v=2&starts={STARTS}")
    controls = page.locator(".MuiDrawer-paper.sidebar")
    last = page.get_by_role("button", name="12", exact=True)
    last.wait_for()
    last.focus()
    assert controls.evaluate("box => box.scrollWidth - box.clientWidth") <= 0
    assert controls.evaluate("box => box.scrollLeft") == 0
    right = controls.bounding_box()["x"] + controls.bounding_box()["width"]
    for number in range(1, 13):
        box = page.get_by_role("button", name=str(number), exact=True).bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= right


@pytest.mark.deep
def test_a_lecture_names_the_system_in_place_of_what_the_page_is(visit):
    page = visit(1920, 1080, query="v=2&system=kepler")
    await_painted(page, "Phase portrait")
    name = page.locator("header").get_by_text("Kepler with a shell")
    purpose = page.locator("header").get_by_text(re.compile("For teaching and research"))
    assert (name.is_visible(), purpose.is_visible()) == (False, True)
    page.keyboard.press("l")
    assert becomes(page, lambda: (name.is_visible(), purpose.is_visible()) == (True, False))
    page.keyboard.press("Escape")
    assert becomes(page, lambda: (name.is_visible(), purpose.is_visible()) == (False, True))


LAWS = """() => {
    const seen = node => [...node.querySelectorAll("*")].flatMap(part => [
        ...(part.matches(".law") && part.checkVisibility() ? [part] : []),
        ...(part.shadowRoot ? seen(part.shadowRoot) : [])])
    return seen(document).map(part => part.getBoundingClientRect()).map(box => [box.left, box.top])
}"""
"""Where the laws stand that are seen."""


@pytest.mark.deep
def test_the_laws_are_in_sight_all_the_time_and_below_one_another_in_the_header_of_a_lecture(visit):
    page = visit(1920, 1080, query="v=2&system=kepler")
    await_painted(page, "Phase portrait")
    assert becomes(page, lambda: len(page.evaluate(LAWS)) == 3)
    page.evaluate(f"""() => {{
        window.fewest = Infinity
        const look = () => {{ window.fewest = Math.min(window.fewest, ({LAWS})().length); requestAnimationFrame(look) }}
        look()
    }}""")
    page.keyboard.press("l")
    assert becomes(page, lambda: len(page.evaluate(LAWS)) == 4), "two laws, g, and parameters with τ"
    (left, top), (other_left, other_top), *_ = page.evaluate(LAWS)
    assert left == other_left
    assert top < other_top < 100
    page.keyboard.press("Escape")
    assert becomes(page, lambda: [place[1] > 500 for place in page.evaluate(LAWS)] == [True] * 3)
    assert page.evaluate("window.fewest") >= 3


@pytest.mark.deep
def test_on_a_phone_on_its_side_portrait_and_view_stand_side_by_side(visit):
    page = visit(844, 390)
    portrait, view = (await_painted(page, name).bounding_box() for name in ("Phase portrait", "conserved quantity"))
    assert becomes(page, lambda: not page.locator(".sidebar").get_by_label("Examples").is_visible())
    assert portrait["x"] + portrait["width"] <= view["x"]
    assert view["x"] + view["width"] <= 844
    assert portrait["y"] < view["y"] < 200, "both begin on the screen"


@pytest.mark.deep
def test_each_entry_of_a_legend_shows_its_key_whatever_was_shown_before(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    systems = page.get_by_label("System", exact=True).last
    for system in ("Stick-slip on a belt", "Sliding surface", "Bouncing ball", "Moving interface", "Elliptic curve"):
        systems.select_option(label=system)
        page.get_by_text(re.compile("^dmm2: .* steps")).locator("visible=true").wait_for()
        page.wait_for_timeout(1500)
        assert becomes(page, lambda: page.evaluate(BLANK_KEYS) == []), (system, page.evaluate(BLANK_KEYS))
    box = canvas(page, "Phase portrait").bounding_box()
    page.mouse.move(box["x"] + 200, box["y"] + 150)
    page.mouse.down()
    page.mouse.move(box["x"] + 400, box["y"] + 350, steps=5)
    page.mouse.up()
    page.wait_for_timeout(1500)
    assert becomes(page, lambda: page.evaluate(BLANK_KEYS) == []), page.evaluate(BLANK_KEYS)
