"""The look of pictures for print: of integrators, of letters, and of what stands around a portrait."""

import re

import pytest

from tests.browser.test_export import MARKERS, TEXTS, both_pictures, downloaded, opened_for_a_column
from tests.browser.test_portrait import PORTRAIT, await_still, await_that

pytestmark = [pytest.mark.browser, pytest.mark.deep]

BOXES = """markup => {
    const svg = new DOMParser().parseFromString(markup, "image/svg+xml").documentElement
    const host = document.createElement("div")
    host.append(svg)
    document.body.append(host)
    const page = svg.getBoundingClientRect()
    const box = one => {
        const { left, right, top, bottom } = one.getBoundingClientRect()
        return {left: left - page.left, right: right - page.left, top: top - page.top, bottom: bottom - page.top}
    }
    const ground = [...svg.querySelectorAll("clipPath path")].map(one => one.getBBox()).find(one => one.x > 0)
    const scale = page.width / svg.viewBox.baseVal.width
    const frame = {left: ground.x * scale, right: (ground.x + ground.width) * scale,
                   top: ground.y * scale, bottom: (ground.y + ground.height) * scale}
    const entry = /^(dmm2|rk2|start|crossing|S: g = 0|S attracts|g < 0|ψ = const[.]|f.*f.)$/
    const beside = [...svg.querySelectorAll("text")].filter(one => one.closest("[clip-path]") == null)
    const legend = beside.filter(one => entry.test(one.textContent)).map(box)
    host.remove()
    return {frame, legend, width: page.width}
}"""
"""Where the frame and the entries of the legend of a picture are, in pixels from its left and upper edges."""


def test_a_curve_has_in_print_the_same_markers_in_every_figure_and_its_dash_beside_others(visit):
    looks = []
    for methods in ("rk2", "dmm2,rk2"):
        page = visit(query=f"v=2&methods={methods}&view=conserved")
        await_that(page, PORTRAIT)
        for markup in both_pictures(page):
            colour = "rgb(162,52,0)"  # of rk2
            dashes = re.findall(rf'<path[^>]*stroke="{re.escape(colour)}"[^>]*stroke-dasharray="([^"]*)"', markup)
            marks = [one for one in page.evaluate(MARKERS, markup) if one["colour"] == colour]
            looks.append((set(dashes), {one["corners"] for one in marks}, {one["key"] for one in marks}))
    assert all(look[1:] == ({5}, {True, False}) for look in looks), "in every figure"
    alone, beside = looks[:2], looks[2:]
    assert all(dashes <= {"none", ""} for dashes, *_ in alone)
    assert beside[0][0] == beside[1][0]
    assert len(beside[0][0]) == 1


def test_a_picture_in_a_serif_typeface_names_and_holds_its_fonts(visit):
    page = opened_for_a_column(visit)
    for typeface, fonts in (
        ("serif", {"Pwsviz Serif", "Pwsviz Serif Italic"}),
        ("sans serif", {"Pwsviz Sans", "Pwsviz Sans Italic"}),
    ):
        page.get_by_role("button", name=typeface, exact=True).click()
        svg = downloaded(page, page.get_by_role("button", name="SVG").nth(1)).decode()
        assert page.evaluate(TEXTS, svg)["fonts"] == [min(fonts, key=len)]
        assert svg.count("@font-face") == svg.count("data:font/ttf;base64,") == 2
        pdf = downloaded(page, page.get_by_role("button", name="PDF").nth(1))
        names = set(re.findall(rb"/BaseFont */(\S+)", pdf))
        assert {name.decode().replace("#20", " ") for name in names} == fonts
        assert pdf.count(b"/FontFile2") >= 2
    assert page.get_by_text("in place of").count() == 0, "the fonts have all characters"


def test_a_portrait_in_a_wide_picture_has_its_legend_beside_it_and_the_height_for_itself(visit):
    page = visit()
    await_that(page, PORTRAIT)
    await_still(page)
    page.get_by_role("button", name=re.compile("Export")).click()
    page.get_by_role("button", name="175 mm").click()
    svg = downloaded(page, page.get_by_role("button", name="SVG").first).decode()
    boxes = page.evaluate(BOXES, svg)
    frame = boxes["frame"]
    assert len(boxes["legend"]) > 5
    assert all(one["left"] > frame["right"] and one["bottom"] < frame["bottom"] for one in boxes["legend"])
    assert frame["right"] - frame["left"] > 0.64 * boxes["width"]
    assert max(one["right"] for one in boxes["legend"]) < boxes["width"]


CAPTION = """markup => {
    const svg = new DOMParser().parseFromString(markup, "image/svg+xml").documentElement
    document.body.append(svg)
    const lines = [...svg.querySelectorAll(":scope > text")].map(one => one.getComputedTextLength())
    svg.remove()
    return lines
}"""
"""The lengths of the lines of a caption."""


def test_a_long_caption_is_a_paragraph_of_even_lines_and_leaves_the_portrait_its_width(visit):
    page = visit()
    await_that(page, PORTRAIT)
    await_still(page)
    page.get_by_role("button", name=re.compile("Export")).click()
    for name in ("85 mm", "full"):
        page.get_by_role("button", name=name, exact=True).click()
    svg = downloaded(page, page.get_by_role("button", name="SVG").first).decode()
    *lines, _last = page.evaluate(CAPTION, svg)
    assert len(lines) > 9
    assert min(lines) > 0.8 * max(lines), lines
    boxes = page.evaluate(BOXES, svg)
    assert boxes["frame"]["right"] - boxes["frame"]["left"] > 0.8 * boxes["width"]


GROUNDS = """markup => {
    const svg = new DOMParser().parseFromString(markup, "image/svg+xml").documentElement
    document.body.append(svg)
    const clear = [...svg.querySelectorAll('path[fill-opacity="0.8"][clip-path]')].map(one => {
        const clip = one.getAttribute("clip-path").slice(4, -1).replaceAll('"', "")
        const frame = svg.querySelector(clip).firstElementChild
        const [inner, outer] = [one, frame].map(part => part.getBBox())
        return Math.min(inner.x - outer.x, inner.y - outer.y, outer.x + outer.width - inner.x - inner.width)
    })
    svg.remove()
    return clear
}"""
"""Pixels between the ground of each name within a frame and that frame."""


def test_the_name_of_a_slope_leaves_the_frame_as_it_is(visit):
    page = visit(query="v=2&view=order")
    page.get_by_text(re.compile("slope 2.00 before")).first.wait_for()
    await_still(page)
    page.get_by_role("button", name=re.compile("Export")).click()
    page.get_by_role("button", name="85 mm", exact=True).click()
    clear = page.evaluate(GROUNDS, downloaded(page, page.get_by_role("button", name="SVG").nth(1)).decode())
    assert clear
    assert min(clear) >= 2, clear


def test_levels_leave_a_plot_of_a_column_four_fifths_of_its_width(visit):
    page = opened_for_a_column(visit)
    svg = downloaded(page, page.get_by_role("button", name="SVG").nth(1)).decode()
    boxes = page.evaluate(BOXES, svg)
    assert boxes["frame"]["right"] - boxes["frame"]["left"] >= 68 / 85 * boxes["width"]


def test_levels_have_their_names_without_a_caption(visit):
    page = opened_for_a_column(visit)
    page.get_by_role("button", name="no caption", exact=True).click()
    svg = downloaded(page, page.get_by_role("button", name="SVG").nth(1)).decode()
    assert "Dotted" not in re.sub("<desc>.*?</desc>", "", svg)
    assert all(re.search(f">{name}<", svg) for name in ("round-off", "eps", "tiny, or 0"))
