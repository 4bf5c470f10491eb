"""Names of surfaces and regions in the portrait stand where these are, also after a pan and as time moves them."""

import numpy as np
import pytest

import core
from pwsviz.scene.permalink import query
from pwsviz.scene.presets import PRESETS
from pwsviz.scene.scene import Scene
from tests.browser.looking import await_painted, becomes
from tests.browser.test_player import animate, at_time
from tests.browser.test_portrait import FIGURE, await_that

pytestmark = [pytest.mark.browser, pytest.mark.deep]

LABELS = f"""() => {{
    const figure = ({FIGURE})("Phase portrait"), row = figure?.rows.find(row => "baseline" in row)
    if (row == null || row.x.length == 0) {{ return null }}
    return {{places: Object.fromEntries(row.text.map((text, k) => [text, [row.x[k], row.y[k]]])), range: figure.range}}
}}"""

LAW = core.Region(("1", "0.4"))
GATE = core.PiecewiseSystem(
    "Gate", ("x", "y"), surfaces=("x - sin(t)", "x + y"), regions={"-+": LAW, "++": LAW, "--": LAW}, x0=(-3.0, 0.5)
)


def assert_in_place(seen, t):
    left, right, low, high = seen["range"]
    places = {text: np.array(place) for text, place in seen["places"].items()}
    assert all(left < x < right and low < y < high for x, y in places.values())
    heights = {text: (x - np.sin(t), x + y) for text, (x, y) in places.items()}
    assert abs(heights["g₁ = x − sin(t) = 0"][0]) < 0.02
    assert abs(heights["g₂ = x + y = 0"][1]) < 0.02
    for name in ("−+", "++", "−−"):
        assert [np.sign(height) for height in heights[name]] == [1 if sign == "+" else -1 for sign in name]
    assert [np.sign(height) for height in heights["no law"]] == [1, -1]
    assert len(places) == 6


def test_surfaces_and_regions_are_named_where_they_are(visit):
    scene = Scene()
    scene.use(GATE)
    page = visit(query=f"{query(scene)}&t_end=6&window=-3,3,-2,2")
    await_painted(page, "Phase portrait")
    assert_in_place(await_that(page, LABELS), 0.0)
    slider = animate(page)
    at_time(page, slider, np.pi / 2)
    assert_in_place(page.evaluate(LABELS), np.pi / 2)


def test_no_label_stands_under_the_mark_of_a_start(visit):
    scene = Scene()
    scene.use(GATE)
    page = visit(query=f"{query(scene)}&t_end=0.01&window=-3,3,-2,2")
    await_painted(page, "Phase portrait")
    before = await_that(page, LABELS)
    marks = [place for text, place in before["places"].items() if text != "no law"]  # nothing can start there
    starts = ";".join(f"{x:.6g},{y:.6g}" for x, y in marks)
    page = visit(query=f"{query(scene)}&t_end=0.01&window=-3,3,-2,2&starts={starts}")
    await_painted(page, "Phase portrait")
    seen = await_that(page, LABELS, lambda seen: seen["places"] != before["places"])
    size = (seen["range"][1] - seen["range"][0]) / 36
    for place in seen["places"].values():
        assert min(np.abs(np.subtract(place, mark)).max() for mark in marks) > size


def test_a_single_surface_has_no_label(visit):
    page = visit()
    await_painted(page, "Phase portrait")
    page.wait_for_timeout(500)
    assert becomes(page, lambda: page.evaluate(LABELS) is None), page.evaluate(LABELS)


BOXES = f"""() => {{
    const figure = ({FIGURE})("Phase portrait"), row = figure?.rows.find(row => "baseline" in row)
    if (row == null || row.x.length == 0) {{ return null }}
    const [left, right, low, high] = figure.range, pen = document.createElement("canvas").getContext("2d")
    pen.font = "12px Roboto, Helvetica, Arial, sans-serif"
    const across = FRAME / (right - left)
    return row.text.map((text, k) => {{
        const lines = text.split("\\n"), long = Math.max(...lines.map(line => pen.measureText(line).width))
        const x = (row.x[k] - left) * across + row.dx[k], half = 8 * lines.length
        const start = x - {{left: 0, center: long / 2, right: long}}[row.align[k]]
        const middle = (row.y[k] - low) * across - row.dy[k] + {{bottom: half, middle: 0, top: -half}}[row.baseline[k]]
        const wall = (0 - left) * across
        return {{text: text.replace("\\n", " "), start, end: start + long, middle, veil: row.veil[k], wall}}
    }})
}}"""
"""Pixels from the lower left corner of the frame that each label takes, and where x = 0 is; lines are 12 high."""

FRAME_WIDTH = "[...Bokeh.index.query(view => view.model.match_aspect)][0].frame.bbox.width"


NEAR = ("y - 0.15", "y - 0.05", "y + 0.05", "y + 0.15")
STRATA = core.PiecewiseSystem(
    "Strata", ("x", "y"), surfaces=NEAR, regions={"-" * k + "+" * (4 - k): LAW for k in range(5)}, x0=(-2.0, 1.0)
)


def test_labels_of_near_surfaces_do_not_cover_one_another_on_a_phone(visit):
    scene = Scene()
    scene.use(STRATA)
    page = visit(420, 800, query=f"{query(scene)}&t_end=1&window=-3,3,-2,2")
    await_painted(page, "Phase portrait")
    boxes = await_that(page, BOXES.replace("FRAME", FRAME_WIDTH))
    assert sum("=" in box["text"] for box in boxes) >= 2
    assert_room(boxes, page.evaluate(f"() => {FRAME_WIDTH}"))


def test_labels_have_room_on_a_phone(visit):
    page = visit(420, 800, query="system=two_walls")
    await_painted(page, "Phase portrait")
    boxes = await_that(page, BOXES.replace("FRAME", FRAME_WIDTH))
    assert [box["text"] for box in boxes].count("beyond the wall") == 2
    assert_room(boxes, page.evaluate(f"() => {FRAME_WIDTH}"))


def test_a_label_longer_than_the_room_beside_its_surface_is_not_cut(visit):
    scene = Scene()
    scene.load(PRESETS["chua_sweep"].settings)
    page = visit(420, 800, query=query(scene))
    await_painted(page, "Phase portrait")
    boxes = await_that(page, BOXES.replace("FRAME", FRAME_WIDTH))
    assert_room(boxes, page.evaluate(f"() => {FRAME_WIDTH}"))


def assert_room(boxes, width):
    """Neither does a label stand beyond the frame, nor over another."""
    for k, one in enumerate(boxes):
        assert one["start"] >= -1, one
        assert one["end"] <= width + 1, one
        for other in boxes[:k]:
            beside = one["end"] < other["start"] or other["end"] < one["start"]
            assert beside or abs(one["middle"] - other["middle"]) >= 12, (one, other)


def test_a_label_that_would_lie_across_another_surface_leaves_out_the_function(visit):
    scene = Scene()
    laws = {"+" * k + "-" * (3 - k): LAW for k in range(4)}
    slits = ("x + 0.375", "x", "x - 0.375")
    scene.use(core.PiecewiseSystem("Slits", ("x", "y"), surfaces=slits, regions=laws, x0=(-0.4, 0.0)))
    page = visit(420, 800, query=f"{query(scene)}&t_end=0.1&window=-0.5,0.5,-0.5,0.5")
    await_painted(page, "Phase portrait")
    boxes = await_that(page, BOXES.replace("FRAME", FRAME_WIDTH))
    assert "g₂ = x = 0" in [box["text"] for box in boxes]
    assert "g₁ = 0" in [box["text"] for box in boxes]


def test_the_name_of_a_narrow_region_stands_within_it_and_has_a_ground_only_across_lines(visit):
    scene = Scene()
    scene.load(PRESETS["henon_heiles_section"].settings)
    page = visit(query=query(scene))
    await_painted(page, "Phase portrait")
    boxes = {box["text"]: box for box in await_that(page, BOXES.replace("FRAME", FRAME_WIDTH))}
    beyond = boxes["beyond the wall"]
    assert 0 < beyond["start"] < beyond["end"] < beyond["wall"] - 3
    assert [boxes[text]["veil"] for text in ("beyond the wall", "g > 0")] == [0.8, 0], "across hatches alone"
