"""Conserved quantity, Cost and Stability say what they paint."""

import re

import pytest

from tests.browser.looking import BLANK_KEYS, await_built, await_painted, becomes, canvas, field, settled_picture
from tests.browser.test_portrait import FIGURE, await_that

pytestmark = [pytest.mark.browser, pytest.mark.deep]

ABOUT = "About this figure"
WRONG = re.compile("crossings? .*instead of")
POINTS = f"""() => {{
    const figure = ({FIGURE})("Error against run time")
    if (figure == null) {{ return null }}
    return figure.view.model.renderers.filter(one => "status" in one.data_source.data).flatMap(one =>
        Array.from(one.data_source.data.status, (status, k) => ({{status, label: one.data_source.data.label[k],
            setting: one.data_source.data.setting[k], filled: one.glyph.fill_alpha.value !== 0}})))
}}"""
PANELS = """() => {
    const views = [...Bokeh.index.query(view => view.model.type == "Figure" && view.model.left[0].axis_label != null)]
    const shown = views.filter(view => view.el.closest("*").checkVisibility() && view.model.x_range.end > 0)
    return shown.map(view => ({name: view.model.left[0].axis_label, top: view.el.getBoundingClientRect().top,
                               left: view.el.getBoundingClientRect().left,
                               range: [view.model.y_range.start, view.model.y_range.end]}))
        .filter(one => one.left > 700).sort((one, other) => one.top - other.top)
}"""
CURVES = f"""() => ({FIGURE})("Absolute change")?.rows.filter(row => "xs" in row && "method" in row).flatMap(row =>
    Array.from(row.method, (method, k) => ({{method, y: Array.from(row.ys[k]).filter(Number.isFinite)}})))"""
CELLS = f"""() => {{
    const figure = ({FIGURE})("Outcome of runs")
    const cells = figure?.rows.find(row => "colour" in row && "left" in row)
    if (cells == null || cells.left.length == 0) {{ return null }}
    const legend = figure.view.model.below.find(part => part.type == "Legend")
    return {{looks: Array.from(cells.words, (words, k) => [words, cells.colour[k]]), frame: figure.frame,
             entries: legend.items.filter(item => item.visible).length}}
}}"""


def test_a_run_with_other_crossings_than_the_solution_is_hollow_and_never_the_cheapest(visit):
    page = visit(query="v=1&view=cost&methods=dmm2,rk2")
    page.get_by_role("row", name=re.compile("^10⁻³")).wait_for()
    page.get_by_text(ABOUT).locator("visible=true").click()
    page.get_by_text(re.compile("reference: ", re.IGNORECASE)).locator("visible=true").first.wait_for()
    points = await_that(page, POINTS, lambda seen: any(WRONG.search(one["status"]) for one in seen))
    wrong = [one for one in points if WRONG.search(one["status"])]
    assert not any(one["filled"] for one in wrong)
    assert all(one["filled"] for one in points if one["status"] == "completed")
    cells = page.get_by_role("cell").all_inner_texts()
    assert not {f"{one['label']}, {one['setting']}" for one in wrong} & set(cells)


def test_how_a_study_was_made_is_unfolded_by_key_and_stays_so_for_the_next_result(visit):
    page = visit(query="v=1&view=order&methods=rk2,rk4")
    line, words = page.get_by_text(ABOUT).locator("visible=true"), page.get_by_text(re.compile("Reference: "))
    line.wait_for()
    assert not words.is_visible()
    line.focus()
    page.keyboard.press("Enter")
    assert words.is_visible()
    page.get_by_role("button", name="rk4", exact=True).click()
    page.get_by_text(re.compile("^rk4")).locator("visible=true").first.wait_for()
    assert words.is_visible()


def test_a_panel_of_state_that_comes_back_shows_the_range_of_what_it_shows_then(visit):
    page = visit(query="v=2&system=chua&view=state")
    for name, variables in (("Thermostat", ["T", "r"]), ("Ring of three genes", ["x", "y", "z"])):
        page.get_by_role("combobox", name="System", exact=True).select_option(label=name)
        panels = await_that(page, PANELS, lambda seen, wanted=variables: [one["name"] for one in seen] == wanted)
    low, high = panels[2]["range"]
    assert 0.0 < low < high < 2.0, "those of Chua's circuit reach from −3.4 to 3.4"


def test_a_curve_that_leaves_the_plot_reaches_its_end_and_the_words_say_how_far(visit):
    page = visit(query="v=1&tau=0.05&methods=rk2,dmm2&starts=0.9,1.5")
    words = page.get_by_text(
        re.compile("conserves ψ|shows no visible drift|stays at the level|drifts:|leaves the plot")
    ).locator("visible=true")
    words.first.wait_for()
    curves = {curve["method"]: curve["y"] for curve in await_that(page, CURVES)}
    assert max(curves["rk2"]) == 1e9, "it goes out through the upper end of the axis"
    assert re.search(r"rk2 stops at t = \S+: max \|Δψ\| = [\d.]+×10[⁰¹²³⁴-⁹]{2}", words.first.inner_text())


def test_round_off_of_a_large_psi_is_no_drift(visit):
    page = visit(query="v=1&system=harmonic_oscillator&methods=dmm2&starts=40000.0,0.0")
    await_painted(page, "conserved quantity", colours=10)
    words = page.get_by_text(re.compile("^dmm2 (conserves|drifts|keeps|stays)")).locator("visible=true").first
    assert re.match(r"dmm2 conserves ψ to (accumulated )?round-off: .* \(relative: ", words.inner_text())


@pytest.mark.deep
def test_a_reference_that_gives_up_has_a_colour_of_its_own(visit):
    page = visit(query="v=1&system=kepler&view=stability&methods=rk4&t_end=20.0")
    page.get_by_text("625 runs").wait_for(timeout=400_000)  # at the centre both reference and steps take long
    seen = await_that(page, CELLS, lambda now: any("no reference to the end" in words for words, _ in now["looks"]))
    looks = {tuple(look) for look in seen["looks"]}
    assert len({words for words, _ in looks}) == len({colour for _, colour in looks}) == len(looks)


def test_near_grazing_takes_the_step_size_of_the_page(visit):
    page = visit(query="v=1&view=stability&stability_part=grazing&methods=rk2&t_end=2.0&tau=0.005")
    words = page.get_by_text(re.compile("Started at .* touches the surface")).locator("visible=true").first
    words.wait_for()
    assert re.search(r"τ = 0\.005\b", words.inner_text())


def test_a_click_on_the_map_goes_there(visit):
    page = visit(query="v=1&view=stability&methods=rk2&t_end=2.0&tau=0.005")
    page.get_by_text(re.compile("Map of rk2, 625 runs$")).wait_for()
    await_built(page)
    settled_picture(page, canvas(page, "Outcome of runs"))  # its legend may grow once more, and move it
    left, top, width, height = await_that(page, CELLS)["frame"]
    page.mouse.click(left + 0.25 * width, top + 0.5 * height)
    page.wait_for_function("() => /tau=0.00[0-4]/.test(location.href)")
    assert becomes(page, lambda: float(field(page, "Step size τ").input_value()) < 0.005)


LIMITS = """() => {
    const is_diamond = ({glyph, data_source}) => glyph?.marker?.value == "diamond" && data_source.data.x.length > 0
    const marked = Bokeh.index.query_one(({model}) => is_diamond(model))
    if (marked == null) { return null }
    const legend = [...Bokeh.index.query(view => view.model.type == "Legend")].flatMap(({entries}) => entries)
    return legend.map(entry => entry.label)
}"""


def test_the_legend_of_the_map_has_a_mark_for_the_largest_successful_step_size(visit):
    page = visit(query="v=2&view=stability&methods=dmm2,rk2&t_end=5")
    await_that(page, LIMITS, lambda seen: "largest successful τ" in seen)
    assert page.evaluate(BLANK_KEYS) == []


def test_labels_of_ticks_do_not_overlap_in_the_flat_panels_of_many_coordinates(visit):
    page = visit(1400, 600, query="system=three_bodies&view=state&t_end=5")
    page.get_by_role("application", name=re.compile("^Coordinate y₃")).wait_for()
    page.wait_for_timeout(1000)
    policies = page.evaluate("""() => [...Bokeh.index.query(view => view.model.type == "LinearAxis")]
        .filter(({model}) => /^[xy]₃$/.test(model.axis_label ?? "")).map(({model}) => model.major_label_policy.type)""")
    assert policies == ["NoOverlap"] * 2
