"""Of marks and shades that a screen cannot tell apart some are left out, and the legend says so."""

import pytest

from tests.browser.looking import await_painted, becomes, moments

pytestmark = pytest.mark.browser

LEGENDS = """() => [...Bokeh.index.query(view => view.model.type == "Legend")]
    .map(view => view.entries.map(entry => entry.label))"""
"""The labels in each legend, as they are painted."""

ZOOM = """factor => {
    const [view] = [...Bokeh.index.query(view => view.model.type == "Figure" && view.model.y_scale.type == "LogScale")]
    const range = view.model.x_range
    range.have_updated_interactively = true  // else it follows the data again
    range.setv({ start: 0, end: factor })
}"""
"""Shows the first part of the time in the conserved quantity."""

NARROW, SOME_BRIEF, SOME = "sides not shaded", "brief stays not shaded", " (some)"


def labels(page):
    return [label for legend in page.evaluate(LEGENDS) for label in legend]


def await_labels(page, says):
    for _ in moments(page):
        if says(labels(page)):
            return
    raise AssertionError(labels(page))


def test_shades_too_narrow_to_tell_apart_are_left_out_until_one_zooms_in(visit):
    page = visit(query="v=2&t_end=150")
    await_painted(page, "Absolute change of the conserved quantity")
    await_labels(page, lambda found: NARROW in found and "g > 0" not in found)
    page.evaluate(ZOOM, 10)
    await_labels(page, lambda found: NARROW not in found and "g > 0" in found)
    page.evaluate(ZOOM, 150)
    await_labels(page, lambda found: NARROW in found and "g > 0" not in found)


@pytest.mark.deep
def test_of_a_periodic_run_all_shades_are_left_out_or_none(visit):
    page = visit(query="v=2&t_end=60")
    await_painted(page, "Absolute change of the conserved quantity")
    seen = set()
    for end in range(36, 240, 6):  # the stays become narrower
        page.evaluate(ZOOM, end)
        page.wait_for_timeout(60)
        found = labels(page)
        assert SOME_BRIEF not in found, end
        seen.add(NARROW in found)
    assert seen == {True, False}


@pytest.mark.deep
def test_the_legend_says_of_marks_that_some_are_left_out(visit):
    page = visit(query="v=2&system=bouncing_ball")
    await_painted(page, "Phase portrait")
    await_labels(page, lambda found: f"jump{SOME}" in found)


@pytest.mark.deep
def test_the_legend_says_so_where_successive_crossings_are_too_close_in_time_to_be_marked(visit):
    page = visit(query="v=2&t_end=60")
    await_painted(page, "Absolute change of the conserved quantity")
    await_labels(page, lambda found: "crossing" in found and f"crossing{SOME}" in found)
    page.evaluate(ZOOM, 10)
    await_labels(page, lambda found: "crossing" in found and f"crossing{SOME}" not in found)


@pytest.mark.deep
def test_marks_of_two_integrators_at_one_place_count_as_one(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    await_labels(page, lambda found: "crossing" in found and f"crossing{SOME}" not in found)


COVERED = """() => [...Bokeh.index.query(view => view.model.type == "Label")]
    .every(view => view.model.text == "")
    && [...Bokeh.documents[0]._all_models.values()].some(model => model.data?.text?.[0]?.includes("window"))"""
"""Whether the page knows which part of the plane its backdrop covers, and that is all that is seen."""

FAR = """() => {
    const said = (window.said = [])
    for (const { model } of Bokeh.index.query(view => view.model.type == "Label")) {
        model.properties.text.change.connect(() => said.push(model.text))
    }
    const [view] = [...Bokeh.index.query(view => view.model.type == "Figure" && view.model.match_aspect)]
    for (const range of [view.model.x_range, view.model.y_range]) {
        range.have_updated_interactively = true  // else they follow the data again
        range.setv({ start: -30, end: 30 })
    }
}"""
"""Shows far more of the plane than before, and keeps what is said of it from now on."""


def test_the_portrait_says_so_while_its_backdrop_does_not_cover_what_is_seen(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    assert becomes(page, lambda: page.evaluate(COVERED))
    page.evaluate(FAR)
    assert becomes(page, lambda: page.evaluate("said") == ["drawing what lies here …", ""])
