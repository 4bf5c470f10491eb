"""The page for those who use a keyboard or a screen reader, measured by axe-core."""

import re
from contextlib import contextmanager
from importlib import resources

import pytest

from pwsviz.figures.colours import ON_DARK
from pwsviz.widgets.widths import NARROW
from tests.browser.looking import THEME, UNPRINTED, await_built, await_painted, becomes, field, moments, type_into

sync_api = pytest.importorskip("playwright.sync_api")

pytestmark = [pytest.mark.browser, pytest.mark.deep]

#: What stands on the screen of which axe is asked: the page, or the part whose role is given and that is seen.
PART = """role => {
    const found = []
    const search = node => node.querySelectorAll("*").forEach(one => {
        if (one.role == role && one.checkVisibility()) found.push(one)
        if (one.shadowRoot) search(one.shadowRoot)
    })
    search(document)
    return role == null ? document : found.at(-1)
}"""

#: What axe objects to, by the success criteria of WCAG 2.2, levels A and AA, and by its own best practices: the
#: rule, and the first place. A contrast that axe leaves open, as something overlaps the text, is measured here.
OBJECTIONS = """async ([part, rules]) => {
    const WCAG = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"]
    // Of landmarks and headings the whole page is asked; over the formulas of Scheme these rules take many minutes.
    if (part == document) { WCAG.push("best-practice") }
    const blind = {"empty-table-header": {enabled: false}}  // to formulas in MathML
    const asked = rules == null ? {runOnly: WCAG, rules: blind} : {runOnly: {type: "rule", values: rules}}
    const told = await axe.run(part, {...asked, elementRef: true})

    const canvas = new OffscreenCanvas(1, 1), pen = canvas.getContext("2d", {willReadFrequently: true})
    const painted = colours => {
        pen.reset()
        for (const colour of colours) { pen.fillStyle = colour; pen.fillRect(0, 0, 1, 1) }
        return [...pen.getImageData(0, 0, 1, 1).data].slice(0, 3)
    }
    const light = colour => colour.map(value => value / 255)
        .map(value => value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4)
        .reduce((sum, value, k) => sum + [0.2126, 0.7152, 0.0722][k] * value, 0)
    const contrast = element => {
        const layers = []
        for (let node = element; node; node = node.assignedSlot ?? node.parentElement ?? node.getRootNode().host) {
            layers.unshift(getComputedStyle(node).backgroundColor)
        }
        layers.unshift("white")
        const [ink, ground] = [painted([...layers, getComputedStyle(element).color]), painted(layers)].map(light)
        return (Math.max(ink, ground) + 0.05) / (Math.min(ink, ground) + 0.05)
    }
    const pale = told.incomplete.filter(one => one.id == "color-contrast").flatMap(one => one.nodes)
        .filter(one => one.element.isConnected && contrast(one.element) < 4.5)  // a legend may just have been made anew
        .map(one => `contrast ${contrast(one.element).toFixed(2)}: ${one.html.slice(0, 200)}`)
    return [...told.violations.map(one => `${one.id}: ${one.nodes[0].html.slice(0, 200)}`), ...pale]
}"""

#: What each view says once its study is done.
SAID = {
    "State": r"up to t = 2",
    "Order": r"The end time has no effect",
    "Crossing time": r"The end time has no effect",
    "Cost": r"Shortest measured run time",
    "Section": r"points on ",
    "Stability": r"Largest step size with correct crossings",
    "Sweep": r"points",
    "Scheme": r"The scheme: dmm2",
}


def objections(page, role=None, rules=None):
    return page.evaluate(OBJECTIONS, [page.evaluate_handle(PART, role), rules])


def assert_without_objections(page, role=None, rules=None):
    """Assert that axe-core comes to object to nothing: colours that fade in have their contrast at the end."""
    for _ in moments(page):
        if (found := objections(page, role, rules)) == []:
            return
    assert found == [], role


FOCUSED = """() => {
    let node = document.activeElement
    while (node.shadowRoot?.activeElement) { node = node.shadowRoot.activeElement }
    return node.ariaLabel ?? node.innerText
}"""


def focused(page):
    """The name of what has the focus."""
    return page.evaluate(FOCUSED)


@pytest.fixture(params=[(1400, 900), (420, 800)], ids=["wide", "phone"])
def inspected(visit, request):
    """The page, with all that is computed shortened, and axe-core in it."""
    script = (resources.files(pytest.importorskip("axe_playwright_python")) / "axe.min.js").read_text()
    page = visit(*request.param, query="v=1&t_end=2", reduced_motion="reduce")
    await_painted(page, "Phase portrait")
    await_built(page)
    page.evaluate(script)
    return page


@contextmanager
def controls(page):
    """The controls at hand, which on a phone lie over the page."""
    narrow = page.viewport_size["width"] < NARROW
    if narrow:
        page.get_by_label("Open menu").click()
        page.locator(".sidebar").get_by_label("Examples").wait_for()
    yield
    if narrow:
        page.keyboard.press("Escape")
        page.locator(".sidebar").wait_for(state="hidden")


def test_every_view_and_dialog_shows_itself_without_violating_wcag(inspected):
    page = inspected
    wide = page.viewport_size["width"] >= NARROW
    for rules in (None, ["color-contrast"])[: 1 + wide]:  # in the dark only colours differ, on a phone as elsewhere
        for name in ("Animate", "Limits of the portrait"):
            page.get_by_role("button", name=name).click()
        page.get_by_role("textbox", name="Top end").wait_for()
        assert_without_objections(page, None, rules)
        with controls(page):
            assert_without_objections(page, None, rules)
        for name in ("Close the animation", "Limits of the portrait"):
            page.get_by_role("button", name=name).click()
        for tab, words in SAID.items():
            page.get_by_role("tab", name=tab).click()
            page.get_by_role("tabpanel", name=tab).wait_for()
            page.get_by_text(re.compile(words)).locator("visible=true").first.wait_for()
            assert_without_objections(page, "tabpanel", rules if wide else ["target-size"])
            assert page.evaluate(UNPRINTED) == [], tab
        for name, ready in (("Export & share", "Copy the link"), ("Help", "How to use it")):
            look_at_dialog(page, name, ready, rules)
        with controls(page):
            look_at_dialog(page, "Write your own", "This system is ready.", rules)
        page.get_by_label(THEME).click()
        page.mouse.move(200, 300)  # away from its tip
        page.wait_for_timeout(1000)  # for the colours, which fade from light to dark
    assert page.locator("math").count() > 5
    page.keyboard.press("?")
    page.get_by_role("dialog").get_by_text("Ctrl+Z").wait_for()


@pytest.mark.deep
def test_the_words_of_a_button_under_the_pointer_keep_their_contrast(inspected):
    page = inspected
    with controls(page):
        page.get_by_role("button", name="Write your own").hover()
        page.wait_for_timeout(500)  # for the colours, which fade in
        assert_without_objections(page, None, ["color-contrast"])


def look_at_dialog(page, name, ready, rules):
    page.get_by_role("button", name=name).click()
    page.get_by_role("dialog").get_by_text(ready).wait_for()
    assert_without_objections(page, "dialog", rules)
    page.keyboard.press("Escape")
    page.get_by_role("dialog").get_by_text(ready).wait_for(state="hidden")
    assert name in focused(page)


PAINTED = """() => [...Bokeh.index.query(view => view.glyph?.line_color != null)].flatMap(({glyph: {line_color}}) => {
    const values = line_color.is_Scalar() ? [line_color.value] : [...line_color]
    return values.map(one => typeof one == "string" ? one : "#" + (one >>> 8).toString(16).padStart(6, "0"))
})"""
"""The colours in which the lines of all figures are painted."""


def test_figures_are_painted_in_the_colours_that_go_with_the_page(visit):
    page = visit(color_scheme="dark")
    await_painted(page, "conserved quantity")
    for own, other in ((ON_DARK.values(), ON_DARK.keys()), (ON_DARK.keys(), ON_DARK.values())):
        for _ in moments(page):
            painted = {colour.upper() for colour in page.evaluate(PAINTED)}
            if not painted & {*other}:
                break
        assert len(painted & {*own}) > 6
        assert not painted & {*other}
        page.get_by_label(THEME).click()


def test_the_button_of_the_controls_and_its_tip_speak_of_a_menu(visit):
    page = visit()
    page.get_by_role("navigation", name="Controls").wait_for()
    for name in ("Close menu", "Open menu"):
        button = page.get_by_label(name)
        button.hover()
        page.get_by_role("tooltip", name=name).wait_for()
        button.click()


ICON = """button => [getComputedStyle(button, "::before").content, button.querySelector("svg").checkVisibility()]"""
"""The icon of a button as it is painted, and whether that of the template is, too."""


def test_the_button_of_the_theme_and_its_tip_say_what_a_click_does(visit):
    page = visit()
    for name, icon in (("Dark theme", "dark_mode"), ("Light theme", "light_mode"), ("Dark theme", "dark_mode")):
        button = page.get_by_role("button", name=name)
        button.wait_for()
        painted = [f'"{icon}"', False]  # a moon that brings the night, or a sun the day
        assert becomes(page, lambda button=button, painted=painted: button.evaluate(ICON) == painted)
        button.hover()
        page.get_by_role("tooltip", name=name).wait_for()
        button.click()


def test_the_button_of_the_lecture_says_whether_it_is_pressed(visit):
    page = visit()
    button = page.get_by_role("button", name="Lecture mode (L)")
    for key, pressed in ((None, "false"), ("l", "true"), ("Escape", "false")):
        if key:
            page.keyboard.press(key)
        assert becomes(page, lambda pressed=pressed: button.get_attribute("aria-pressed") == pressed), key


@pytest.mark.parametrize("view", ["conserved", "state", "order", "stability", "section"])
def test_the_name_of_a_figure_is_short_and_what_else_there_is_to_tell_describes_it(visit, view):
    page = visit(query=f"v=2&methods=dmm2&t_end=5&view={view}")
    await_painted(page, "Phase portrait")
    figures = page.get_by_role("application")
    told = lambda key: [figures.nth(k).get_attribute(key) or "" for k in range(figures.count())]  # noqa: E731
    assert becomes(
        page, lambda: len(told("aria-label")) > 1 and all(len(words) > 20 for words in told("aria-description"))
    )
    assert all(10 < len(name) < 80 for name in told("aria-label")), told("aria-label")


def test_buttons_of_the_export_dialog_say_what_they_save(visit):
    page = visit()
    await_painted(page, "conserved quantity")
    page.get_by_role("button", name=re.compile("Export")).click()
    for what in ("Phase portrait", "Conserved quantity"):
        for kind in ("CSV curves", "NPZ", "SVG", "PDF", "PNG"):
            page.get_by_role("button", name=f"Save {kind} of {what}", exact=True).wait_for()
    page.get_by_role("button", name="Save TEX of Equations", exact=True).wait_for()


ENDS = """name => {
    const { x_range, y_range } = [...Bokeh.index.query(view => view.model.type == "Figure")]
        .map(view => view.model).find(model => model.html_attributes["aria-label"].includes(name))
    return [x_range.start, x_range.end, Math.log(y_range.start), Math.log(y_range.end)]
}"""


@pytest.mark.parametrize("name", ["Phase portrait", "conserved quantity"])
def test_a_figure_is_reached_by_tab_and_moved_zoomed_and_fitted_by_keys(visit, name):
    page = visit()
    await_painted(page, name)
    figure, before = page.get_by_role("application", name=name), page.evaluate(ENDS, name)
    page.get_by_role("button", name="Close menu").focus()
    while focused(page) != figure.get_attribute("aria-label"):
        page.keyboard.press("Tab")
    ring = "one => [getComputedStyle(one, '::after')].map(one => [one.borderTopWidth, one.zIndex])[0]"
    assert figure.evaluate(ring) == ["2px", "100"], "above the canvas"
    width = before[1] - before[0]
    for key, across in (("ArrowRight", (0.1, 0.1)), ("ArrowLeft", (0, 0)), ("+", (0.1, -0.1)), ("-", (0, 0))):
        page.keyboard.press(key)
        wanted = [end + share * width for end, share in zip(before[:2], across, strict=True)]
        assert page.evaluate(ENDS, name)[:2] == pytest.approx(wanted)
    page.keyboard.press("ArrowUp")
    assert page.evaluate(ENDS, name) != pytest.approx(before, nan_ok=True)
    page.keyboard.press("0")
    for _ in moments(page):
        if page.evaluate(ENDS, name) == pytest.approx(before, nan_ok=True):
            break
    assert page.evaluate(ENDS, name) == pytest.approx(before, nan_ok=True)
    page.keyboard.press("Tab")
    assert focused(page) != figure.get_attribute("aria-label"), "no trap"


STARTS = """() => {
    const documents = Bokeh.documents, models = documents.flatMap(one => [...one._all_models.values()])
    return models.find(model => model.data != null && "crowd" in model.data)
}"""
"""The source of the stars."""


def test_the_selected_start_is_moved_by_keys_and_told_where_it_is(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    figure, before = page.get_by_role("application", name="Phase portrait"), page.evaluate(ENDS, "Phase portrait")
    source = page.evaluate_handle(STARTS)
    start = lambda: source.evaluate("({ data: { x, y } }) => [x[0], y[0]]")  # noqa: E731
    figure.focus()
    x, y = start()
    page.keyboard.press("Shift+ArrowRight")
    moved = start()
    assert (moved[0] > x, moved[1]) == (True, y)
    page.keyboard.press("Control+Shift+ArrowRight")
    assert start()[0] - moved[0] == pytest.approx(0.1 * (moved[0] - x), abs=1e-3), "the server rounds to a pixel"
    page.keyboard.press("Shift+ArrowUp")
    assert start()[1] - y == pytest.approx(moved[0] - x, abs=1e-3), "at equal scales"
    page.get_by_text(re.compile("Start 1 moved to x = ")).wait_for(state="attached")
    typed = field(page, "initial x")
    assert becomes(page, lambda: float(typed.input_value().replace("−", "-")) == pytest.approx(start()[0], abs=1e-3))
    assert page.evaluate(ENDS, "Phase portrait")[:2] == pytest.approx(before[:2]), "the view stays"
    name = figure.get_attribute("aria-label")
    assert focused(page) == name, "what is told of the new run leaves the figure the focus"
    page.keyboard.press("Control+z")
    assert becomes(page, lambda: start() == pytest.approx([x, y])), "a series of keys is one change"


def test_the_first_stop_leads_to_the_portrait(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    page.keyboard.press("Tab")
    assert focused(page) == "Skip to the portrait"
    sync_api.expect(page.get_by_role("link", name="Skip to the portrait")).to_be_in_viewport(ratio=1)
    page.keyboard.press("Enter")
    assert focused(page).startswith("Phase portrait of")


SLIDERS = """() => {
    const found = []
    const look = node => node.querySelectorAll("*").forEach(one => {
        if (one.type == "range" && one.checkVisibility()) found.push([one.getAttribute("aria-valuenow"),
            one.getAttribute("aria-valuetext"), one.getAttribute("aria-valuemin"), one.getAttribute("aria-valuemax")])
        if (one.shadowRoot) look(one.shadowRoot)
    })
    look(document)
    return found
}"""


def test_the_value_of_a_slider_is_the_number_that_its_field_shows_between_its_ends(visit):
    page = visit()
    await_painted(page, "conserved quantity")
    sliders = page.evaluate(SLIDERS)
    assert len(sliders) == 4
    for now, text, low, high in sliders:
        assert float(now) == float(text.replace("−", "-"))
        assert float(low) <= float(now) <= float(high)
    page.get_by_role("button", name="Animate").click()
    time = page.get_by_role("slider", name="Time")
    time.press("ArrowRight")
    value, words = time.evaluate("one => [one.value, one.ariaValueText]")  # at one instant: the time runs on
    told = re.match(r"t = ([0-9.]+), ", words)[1]
    assert float(value) == float(told)
    assert len(told.replace(".", "").lstrip("0")) <= 4, "digits"


TAB_STOP = """() => {
    let node = document.activeElement
    while (node.shadowRoot?.activeElement) { node = node.shadowRoot.activeElement }
    return [node.nodeName, node.role ?? "", node.className]
}"""


def test_every_stop_of_the_tab_key_has_a_role(visit):
    page = visit()
    await_painted(page, "conserved quantity")
    stops = []
    while not stops or stops[-1][0] != "BODY":
        page.keyboard.press("Tab")
        stops.append(page.evaluate(TAB_STOP))
        assert len(stops) < 100
    assert len(stops) > 30
    assert [stop for stop in stops if stop[0] == "DIV" and not stop[1]] == []


def test_fields_take_formulas_sliders_tell_their_numbers_and_undo_is_the_fields_own(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    await_built(page)
    for name, told in (("a₋", "−3"), ("Step size τ", "0.01")):
        slider = page.get_by_role("slider", name=f"{name}, slider")
        sync_api.expect(slider).to_have_attribute("aria-valuetext", told)
    slider.press("ArrowRight")
    sync_api.expect(slider).not_to_have_attribute("aria-valuetext", "0.01")
    assert slider.get_attribute("aria-valuetext") == field(page, "Step size τ").input_value()

    for typed, shown in (("-2.5", "−2.5"), ("−3", "−3")):
        type_into(page, "a₋", typed)
        sync_api.expect(field(page, "a₋")).to_have_value(shown)
    end = field(page, "End time")
    type_into(page, "End time", "2^3/4")
    page.get_by_text("= 2", exact=True).wait_for()
    assert end.input_value() == "2^3/4"
    type_into(page, "End time", "two")
    page.get_by_text("“two” is not a number").wait_for()
    assert end.get_attribute("aria-invalid") == "true"
    type_into(page, "End time", "3")
    page.wait_for_timeout(1000)  # or the next change would be undone together with it

    type_into(page, "Step size τ", "0.02")
    sync_api.expect(page.get_by_role("button", name="Undo")).to_be_enabled()
    end.click()
    page.keyboard.press("End")
    page.keyboard.type("7")
    page.keyboard.press("Control+z")
    sync_api.expect(end).to_have_value("3")
    assert field(page, "Step size τ").input_value() == "0.02"
    page.keyboard.press("Control+z")  # there is nothing more to undo in the field
    sync_api.expect(field(page, "Step size τ")).not_to_have_value("0.02")
    sync_api.expect(end).to_have_value("3")
    page.keyboard.press("Control+y")
    sync_api.expect(field(page, "Step size τ")).to_have_value("0.02")
    page.get_by_role("tab", name="Order").focus()
    page.keyboard.press("Control+z")
    sync_api.expect(field(page, "Step size τ")).not_to_have_value("0.02")


def test_undo_in_a_field_whose_text_is_in_force_is_that_of_the_page(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    await_built(page)
    step, slider = field(page, "Step size τ"), page.get_by_role("slider", name="Step size τ, slider")
    step.click()
    page.keyboard.press("Control+a")
    page.keyboard.type("1/30")
    page.keyboard.press("Enter")
    sync_api.expect(slider).to_have_attribute("aria-valuetext", re.compile(r"^0\.0333"))
    for key, text, told in (("z", "0.01", r"^0\.01$"), ("y", "1/30", r"^0\.0333")):
        page.keyboard.press(f"Control+{key}")
        sync_api.expect(slider).to_have_attribute("aria-valuetext", re.compile(told))
        sync_api.expect(step).to_have_value(text)


def test_each_press_of_undo_and_of_redo_counts_however_fast_they_come(visit):
    page = visit()
    tau = field(page, "Step size τ")
    for text in ("0.02", "0.03", "0.04"):
        type_into(page, "Step size τ", text)
        page.wait_for_timeout(1000)  # or the next change would be undone together with it
    page.evaluate("() => document.activeElement.blur()")
    for key, button, text in (("z", "Undo", "0.01"), ("y", "Redo", "0.04")):
        page.evaluate(
            """key => [1, 2, 3].forEach(() => document.dispatchEvent(
                new KeyboardEvent("keydown", { key, ctrlKey: true, bubbles: true, composed: true })))""",
            key,
        )
        sync_api.expect(tau).to_have_value(text)
        sync_api.expect(page.get_by_role("button", name=button)).to_be_disabled()


def test_what_a_field_refuses_is_said_each_time_and_on_screen(visit):
    page = visit()
    type_into(page, "End time", "-5")
    refusal = page.get_by_role("status").filter(has_text="must lie between")
    refusal.wait_for()
    sync_api.expect(refusal).to_be_in_viewport(ratio=1)
    refusal.evaluate("""note => { window.said = []
        new MutationObserver(() => said.push(note.textContent)).observe(note, {childList: true}) }""")
    type_into(page, "End time", "1e9")
    page.wait_for_function("() => said.length > 1 && said.at(-1).includes('must lie between')")
