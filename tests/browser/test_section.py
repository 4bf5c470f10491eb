"""The Section view: islands are painted in the colours of their starts, and a click adds one of the same energy."""

import re

import pytest

from tests.browser.looking import await_painted
from tests.browser.test_export import downloaded, shapes_of
from tests.browser.test_portrait import FIGURE, await_still, await_that

pytestmark = pytest.mark.browser

QUERY = (
    "v=2&methods=taylor&system=henon_heiles&wall=0.0&starts=0,0.2,0.4640402281411961,0;0,-0.1,0.48921706157219547,0"
    "&tau=1.0&tolerance=1e-10&view=section&section_points=4000"
)
CLOUD = f"""() => {{
    const figure = ({FIGURE})("Poincaré section")
    if (figure == null) {{ return null }}
    const codes = Array.from(figure.rows.find(row => "image" in row).image[0] ?? [])
    const kinds = new Set(codes.filter(code => code > 0).map(code => code - 1 >> 4))
    const marks = figure.rows.filter(row => "kind" in row)
    return {{kinds: [...kinds].sort(), range: figure.range, place: figure.on_screen([0.3], [0.1])[0],
             marks: marks.flatMap(row => Array.from(row.x, (x, k) => [x, row.y[k]])), words: figure.words}}
}}"""


@pytest.mark.deep
def test_islands_have_the_colours_of_their_starts_and_a_click_adds_one_of_the_same_energy(visit):
    page = visit(query=QUERY)
    seen = await_that(page, CLOUD, lambda seen: "8,000 points of 2 starts" in seen["words"])
    assert seen["kinds"] == [0, 1]
    await_painted(page, "Poincaré section", colours=3)
    await_still(page)  # the room for the legend may have moved the place
    page.mouse.click(*page.evaluate(CLOUD)["place"])
    page.get_by_text(re.compile(r"Start 3 at x = 0, .*x and u from g = 0 and ψ = 0\.125")).wait_for()
    seen = await_that(page, CLOUD, lambda seen: "12,000 points of 3 starts" in seen["words"])
    assert seen["kinds"] == [0, 1, 2]
    page.mouse.move(*seen["place"])
    page.keyboard.down("Control")
    page.mouse.wheel(0, -400)
    page.keyboard.up("Control")
    seen = await_that(page, CLOUD, lambda seen: len(seen["marks"]) > 0)
    left, right, bottom, top = seen["range"]
    assert all(left <= x <= right and bottom <= y <= top for x, y in seen["marks"])
    assert seen["kinds"] == []


PLANE = f"""() => {{
    const figure = ({FIGURE})("Poincaré section")
    if (figure == null) {{ return null }}
    const curves = figure.rows.filter(row => Object.keys(row).sort().join() == "x,y" && row.x.length > 50)
    const [left, right, bottom, top] = figure.range
    const far = curves.flatMap(row => Array.from(row.x, (x, k) => Math.abs(Math.hypot(x, row.y[k]) - 1)))
    const place = figure.on_screen([(left + right) / 2], [0.3 * bottom + 0.7 * top])[0]
    return {{words: figure.words, far: far.filter(Number.isFinite), place}}
}}"""


def test_in_the_plane_the_surface_is_drawn_and_a_click_near_it_starts_on_it(visit):
    page = visit(query="v=2&view=section&methods=dmm2")  # the elliptic curve, and the unit circle
    seen = await_that(page, PLANE, lambda seen: "points on" in seen["words"] and len(seen["far"]) > 50)
    assert max(seen["far"]) < 1e-2
    page.mouse.click(*seen["place"])
    said = page.get_by_text(re.compile(r"^Start 2 at x = ")).inner_text().replace("−", "-")
    x, y = (float(number) for number in re.findall(r"= (-?\d+(?:\.\d+)?)", said))
    assert abs(x**2 + y**2 - 1) < 1e-5


SCALES = f"""() => {{
    const figure = ({FIGURE})("Poincaré section")
    if (figure == null) {{ return null }}
    const [left, right, bottom, top] = figure.range, [, , width, height] = figure.frame
    return {{words: figure.words, ratio: width / (right - left) * (top - bottom) / height,
             seen: [left, right, bottom, top], shape: width / height}}
}}"""


def test_a_circle_in_the_plane_of_the_portrait_is_drawn_and_saved_as_a_circle(visit):
    page = visit(query="v=2&view=section&methods=dmm2")  # the elliptic curve, and the unit circle
    seen = await_that(page, SCALES, lambda seen: "points on" in seen["words"] and abs(seen["ratio"] - 1) < 1e-3)
    left, right, bottom, top = seen["seen"]
    assert left < -1 < 1 < right, "and all of it is seen"
    assert bottom < -1 < 1 < top
    page.get_by_role("button", name="Return map").click()
    await_that(page, SCALES, lambda seen: abs(seen["ratio"] - 1) > 1e-2)
    page.get_by_role("button", name="Section", exact=True).click()
    seen = await_that(page, SCALES, lambda seen: abs(seen["ratio"] - 1) < 1e-3)
    page.get_by_role("button", name=re.compile("Export")).click()
    svg = downloaded(page, page.get_by_role("button", name="SVG").nth(1)).decode()
    assert any(shape == pytest.approx(seen["shape"], rel=0.02) for shape in shapes_of(svg))
