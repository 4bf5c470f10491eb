"""What is exported is what is painted."""

import csv
import io
import re
import zlib
from itertools import combinations
from math import ceil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import core
from pwsviz.scene.permalink import query
from pwsviz.scene.scene import Scene
from tests.browser.test_portrait import FIGURE, PORTRAIT, await_still, await_that, inside

pytestmark = [pytest.mark.browser, pytest.mark.deep]

CURVES = f"""label => ({FIGURE})(label).rows.filter(row => "xs" in row && "method" in row).flatMap(row =>
    Array.from(row.method, (method, k) => ({{method, x: Array.from(row.xs[k]), y: Array.from(row.ys[k])}})))"""
"""The curves of a figure as the browser has them."""


def downloaded(page, button):
    with page.expect_download() as download:
        button.click()
    return download.value.path().read_bytes()


def both_pictures(page):
    """The portrait and the view beside it as SVG, once they are offered."""
    await_still(page)
    page.get_by_role("button", name=re.compile("Export")).click()
    files = page.get_by_role("button", name="SVG")
    files.nth(1).wait_for()
    return [downloaded(page, files.nth(k)).decode() for k in range(2)]


def saved(page, button):
    """The rows of a CSV file that a button saves, without its comments."""
    lines = downloaded(page, button).decode().splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def test_files_of_the_portrait_and_of_the_drift_hold_every_curve_that_is_painted(visit):
    page = visit()
    await_that(page, PORTRAIT)
    page.get_by_text(re.compile("2,000 steps, 21 crossings")).first.wait_for()
    await_still(page)
    page.mouse.click(*inside(page.evaluate(PORTRAIT), 0.3, 0.7))
    await_that(page, PORTRAIT, lambda seen: len(seen["stars"]) == 2)
    page.wait_for_timeout(1500)
    painted = [page.evaluate(CURVES, label) for label in ("Phase portrait", "Absolute change")]
    painted = [[curve for curve in curves if len(curve["x"]) > 1] for curves in painted]  # without legend entries
    page.get_by_role("button", name=re.compile("Export")).click()
    files = page.get_by_role("button", name=re.compile("^Save CSV"))
    files.nth(4).wait_for()  # the last of three tables of the portrait and two of the drift
    names = [files.nth(k).inner_text() for k in range(files.count())]
    tables = [saved(page, files.nth(k)) for k, name in enumerate(names) if "crossings" not in name]
    portrait, drawn, drift = tables
    assert len({(row["start"], row["integrator"]) for row in portrait}) == len(painted[0]) == 4
    for curve in painted[0]:  # each is that of a run in the file, at the resolution of the screen
        runs = [[row for row in portrait if row["integrator"] == curve["method"] and row["start"] == n] for n in "12"]
        states = [np.array([(float(row["x"]), float(row["y"])) for row in run]) for run in runs]
        (state,) = [one for one in states if tuple(one[0]) == (curve["x"][0], curve["y"][0])]
        away = np.array([np.hypot(*(state - place).T).min() for place in zip(curve["x"], curve["y"], strict=True)])
        assert away.max() < 0.02, "it may end where the orbit repeats itself"
    for curve in painted[0]:
        vertices = [row for row in drawn if row["integrator"] == curve["method"]]
        assert (curve["x"][1], curve["y"][1]) in [(float(row["x"]), float(row["y"])) for row in vertices]
    for curve in painted[1]:
        rows = [row for row in drift if row["integrator"] == curve["method"]]
        assert np.allclose([float(row["t"]) for row in rows[1:]], curve["x"])
    assert {row["integrator"] for row in drift} == {"dmm2", "rk2"}


PARTS = """async words => {
    const path = "components/pwsviz.export.pictures/PictureFiles/_resources/files/picture_letters.js"
    const { parts_of } = await import(new URL(path, document.baseURI))
    return parts_of(words).map(([part, look]) => look == "" ? part : `[${look[0]}:${part}]`).join("")
}"""
"""A text with the parts of a formula marked: i for italics, r for raised."""

HAT = """async () => {
    const path = "components/pwsviz.export.pictures/PictureFiles/_resources/files/picture_letters.js"
    const { typeset } = await import(new URL(path, document.baseURI))
    const text = document.createElementNS("http://www.w3.org/2000/svg", "text")
    text.textContent = "|t̂| = 1"
    typeset(text, 10)
    const shift = (one, along) => Number(one.getAttribute(along))
    return [...text.children].map(one => [one.textContent, shift(one, "dx"), shift(one, "dy")])
}"""
"""The parts of a text of 10 pixels that has a letter with a hat, and their shifts in pixels."""

SET = {
    "a run of rk2 from a start, at t = 2, a = 3": "a run of rk2 from a start, at [i:t] = 2, [i:a] = 3",
    "400 values of a from 1 to 2": "400 values of [i:a] from 1 to 2",
    "u′ = −μ₋·x/(x² + y²)^(3/2)": "[i:u]′ = −[i:μ]₋[i:x]/([i:x]² + [i:y]²)[r:3/2]",
    "ψ₋,₁ = x·v − 2·10⁻³": "[i:ψ]₋[l:,]₁ = [i:x][i:v] − 2·10⁻³",
    "run time (s), x (w not shown), sin(s)": "run time (s), [i:x] ([i:w] not shown), sin([i:s])",
    "“Hénon–Heiles”, Poincaré, Čech": "“Hénon–Heiles”, Poincaré, Čech",
    "|Δψ|, the size of ψ’s terms": "|Δ[i:ψ]|, the size of [i:ψ]’s terms",
    "sin(x)·y, alpha·x, k·(q − 0.3)": "sin([i:x])·[i:y], alpha·[i:x], [i:k]([i:q] − 0.3)",
    "S: g = 0, t̂, ‖x − x*‖₂, Σ |∂ψ/∂xᵢ|": "[i:S]: [i:g] = 0, [i:t̂], ‖[i:x] − [i:x]*‖₂, Σ |∂[i:ψ]/∂[i:x]ᵢ|",
}

TEXTS = """svg => {
    const root = new DOMParser().parseFromString(svg, "image/svg+xml").documentElement
    const texts = [...root.querySelectorAll("text")]
    return {width: root.getAttribute("width"), images: root.querySelectorAll("image").length,
            paths: root.querySelectorAll("path").length, words: texts.map(text => text.textContent).join(" "),
            fonts: [...new Set(texts.map(text => text.getAttribute("font-family")))],
            slanted: [...new Set([...root.querySelectorAll("tspan[font-style=italic]")].map(one => one.textContent))],
            edges: root.querySelectorAll("path[stroke='#ffffff'][stroke-dasharray][stroke-linejoin=round]").length,
            ground: root.querySelector("rect").getAttribute("fill")}
}"""


def test_every_figure_is_saved_as_vectors_with_its_equations_as_caption_and_as_a_png(visit):
    page = visit(color_scheme="dark")
    await_that(page, PORTRAIT)
    page.get_by_text(re.compile("2,000 steps, 21 crossings")).first.wait_for()
    await_still(page)
    page.get_by_role("button", name=re.compile("Take away|Export")).click()
    page.get_by_role("button", name="85 mm").click()
    page.get_by_role("button", name="full", exact=True).click()
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page.get_by_role("button", name="Copy caption").first.click()
    page.get_by_role("button", name="Copied").first.wait_for()
    page.wait_for_function(
        "async () => (await navigator.clipboard.readText()).startsWith('Phase portrait of the system “Elliptic')"
    )
    for kind, start in (("link", "http"), ("program", "import core")):
        page.get_by_role("button", name=f"Copy the {kind}").click()
        page.get_by_role("button", name="Copied").first.wait_for()
        page.wait_for_function(f"async () => (await navigator.clipboard.readText()).trim().startsWith('{start}')")
        page.get_by_role("button", name=f"Copy the {kind}").wait_for()
    for k in range(2):
        svg = page.evaluate(TEXTS, downloaded(page, page.get_by_role("button", name="SVG").nth(k)).decode())
        assert (svg["width"], svg["images"], svg["fonts"]) == ("85mm", 0, ["Pwsviz Sans"])
        assert svg["paths"] > 20
        assert svg["ground"] == "#ffffff", "for print, on a dark page, too"
        assert svg["edges"] == 1, "of rk2, which is dashed, on dmm2, and not in the legend"
        assert "g < 0: x′ = 2y, y′ = 3x² + a₋" in svg["words"]
        assert {"x", "y", "g", "ψ", "a", "τ"} <= set(svg["slanted"]), "names of quantities are in italics"
        assert max(map(len, svg["slanted"])) == 1
        assert "step size τ = 0.01" in svg["words"]
        pdf = downloaded(page, page.get_by_role("button", name="PDF").nth(k))
        assert pdf.startswith(b"%PDF-")
        assert b"/Subtype /Image" not in pdf
        assert b"/FontFile2" in pdf
        assert set(re.findall(rb"/BaseFont */(\S+)", pdf)) == {b"Pwsviz#20Sans", b"Pwsviz#20Sans#20Italic"}, (
            "no font is named that is not embedded"
        )
        assert set(re.findall(rb"/Ordering *\((.*?)\)", pdf)) == {b"Identity"}, "of CID fonts: ISO 32000-1, 9.7.3"
        assert set(re.findall(rb"/Encoding */(\S+)", pdf)) >= {b"Identity-H"}
        table = int(re.search(rb"startxref\s+(\d+)", pdf)[1])
        assert pdf[table : table + 4] == b"xref"
        for number, place in enumerate(re.findall(rb"(\d{10}) 00000 n", pdf[table:]), 1):
            assert pdf[int(place) :].startswith(b"%d 0 obj" % number)
    for words, typeset in SET.items():
        assert page.evaluate(PARTS, words) == typeset
    words, aside, down = zip(*page.evaluate(HAT), strict=True)
    assert words == ("|", "t", "\u02c6", "| = 1"), "no combining mark, which a PDF sets aside"
    assert -6 < aside[2] < -2 < down[2] < 0, "above the letter"
    assert aside[2] + 0.457 * 10 + aside[3] == pytest.approx(0), "and the rest as without it"
    assert down[2] + down[3] == 0
    page.get_by_role("button", name="600 dpi").click()
    png = downloaded(page, page.get_by_role("button", name="PNG").first)
    wide = int.from_bytes(png[16:20])
    assert wide == round(85 / 25.4 * 600) == 2008
    page.get_by_text("2,008 pixels wide").wait_for()
    chunk = png[33:54]
    assert chunk[4:8] == b"pHYs"
    assert chunk[16] == 1, "pixels per metre"
    assert wide / int.from_bytes(chunk[8:12]) == pytest.approx(0.085, rel=1e-4)
    assert int.from_bytes(chunk[17:]) == zlib.crc32(chunk[4:17])


def opened_for_a_column(visit):
    """The page with the dialog open, and the pictures as wide as a column."""
    page = visit()
    await_that(page, PORTRAIT)
    page.get_by_text(re.compile("2,000 steps, 21 crossings")).first.wait_for()
    await_still(page)
    page.get_by_role("button", name=re.compile("Export")).click()
    page.get_by_role("button", name="85 mm").click()
    return page


def test_a_short_caption_takes_at_most_five_lines_and_the_full_one_is_in_the_metadata(visit):
    page = opened_for_a_column(visit)
    svg = downloaded(page, page.get_by_role("button", name="SVG").first).decode()
    lines = page.evaluate(TEXT_LINES, svg)
    words = " ".join(lines)
    assert words.startswith(
        "Phase portrait of the system “Elliptic curve”: a₋ = −3, a₊ = −2, r = 1. Initial state (x, y) = (−1, −1)."
    )
    assert words.endswith("Integrated by dmm2 and rk2 with step size τ = 0.01 for t ≤ 20.")
    assert len(lines) <= 5
    assert "y′ = 3x² + a₋" in re.search("<desc>(.*?)</desc>", svg)[1]


def test_a_full_caption_takes_at_most_a_fourth_of_a_picture_of_one_column_in_type_of_seven_points(visit):
    page = opened_for_a_column(visit)
    page.get_by_role("button", name="full", exact=True).click()
    svg = downloaded(page, page.get_by_role("button", name="SVG").first).decode()
    lines = re.findall(r'<text x="[^"]*" y="([^"]*)"[^>]*font-size="([0-9.]+)px"', svg.rpartition("</g>")[2])
    height = float(re.search(r'viewBox="0 0 [0-9.]+ ([0-9.]+)"', svg)[1])
    wide = float(re.search(r'viewBox="0 0 ([0-9.]+) ', svg)[1])
    assert len(lines) > 7
    assert (height - float(lines[0][0])) / height < 0.25
    assert float(lines[0][1]) / wide * 85 / 25.4 * 72 >= 6.99, "points"


TEXT_LINES = """svg => {
    const root = new DOMParser().parseFromString(svg, "image/svg+xml").documentElement
    return [...root.querySelectorAll(":scope > text")].map(text => text.textContent)
}"""
"""The lines of the caption, which stand directly in a picture."""


HOLD = """() => {
    const {send} = WebSocket.prototype, kept = []
    WebSocket.prototype.send = function(words) { kept.push(() => send.call(this, words)) }
    window.release = () => { WebSocket.prototype.send = send; kept.forEach(one => one()) }
}"""
"""Keep from the server what the page sends, until it is released: as a server does that is at work."""


def test_the_dialog_says_at_once_that_it_prepares_and_has_its_files_when_the_server_answers(visit):
    page = visit(1400, 900)
    await_still(page)
    page.evaluate(HOLD)
    button = page.get_by_role("button", name=re.compile("Export"))
    for _ in range(2):
        button.click()
        words = page.get_by_role("dialog").get_by_text("Preparing …")
        words.wait_for(timeout=3000)
        assert not page.get_by_label("Link to this scene").is_visible()
        page.evaluate("release()")
        page.get_by_role("button", name="SVG").nth(1).wait_for()
        words.wait_for(state="hidden")
        assert page.get_by_label("Link to this scene").input_value()
        page.keyboard.press("Escape")
        page.get_by_role("dialog").wait_for(state="hidden")
        page.wait_for_timeout(500)
        page.evaluate(HOLD)


def test_a_failing_export_says_why(visit):
    page = visit()
    await_that(page, PORTRAIT)
    await_still(page)
    page.route("**/PwsvizSans-subset.ttf", lambda route: route.fulfill(body="no font"))
    page.get_by_role("button", name=re.compile("Export")).click()
    page.get_by_role("button", name="SVG").first.click()
    page.get_by_text("could not be saved: ").wait_for()
    page.unroute("**/PwsvizSans-subset.ttf")
    downloaded(page, page.get_by_role("button", name="SVG").first)
    page.get_by_text("could not be saved").wait_for(state="detached")
    page.evaluate("navigator.clipboard.writeText = () => Promise.reject(new Error('forbidden')); null")
    page.get_by_role("button", name="Copy the link").click()
    page.get_by_role("button", name="Not copied: the browser forbids it").wait_for()


@pytest.mark.parametrize("height", [80, 160])
def test_a_portrait_is_no_taller_than_asked_for_with_equal_scales(visit, height):
    page = visit()
    await_that(page, PORTRAIT)
    await_still(page)
    page.get_by_role("button", name=re.compile("Export")).click()
    page.get_by_role("button", name=f"{height} mm", exact=True).click()
    svg = downloaded(page, page.get_by_role("button", name="SVG").first).decode()
    assert float(re.search(r'height="([0-9.]+)mm"', svg)[1]) <= height
    texts = [text for text in page.evaluate(PLACES, svg)["texts"] if not text["within"]]
    middles = {axis: {} for axis in (0, 1)}
    for text in texts:
        if re.fullmatch("−?[0-9.]+", text["words"]):
            left, right, top, bottom = text["box"]
            value = float(text["words"].replace("−", "-"))
            middles[0].setdefault(round(bottom), []).append((value, (left + right) / 2))
            middles[1].setdefault(round(right), []).append((value, (top + bottom) / 2))
    across, up = (max(found.values(), key=len) for found in middles.values())
    slopes = [(max(ends)[1] - min(ends)[1]) / (max(ends)[0] - min(ends)[0]) for ends in (across, up)]
    assert slopes[0] == pytest.approx(-slopes[1], rel=0.03)


@pytest.mark.parametrize("query", ["", "system=gene_ring&t_end=2"])
def test_a_picture_is_higher_where_its_caption_needs_more_and_the_page_says_so(visit, query):
    page = visit(query=query)
    await_that(page, PORTRAIT)
    await_still(page)
    page.get_by_role("button", name=re.compile("Export")).click()
    for choice in ("85 mm", "80 mm", "12 pt", "full"):
        page.get_by_role("button", name=choice, exact=True).click()
    for number in range(2):
        svg = downloaded(page, page.get_by_role("button", name="SVG").nth(number)).decode()
        height = float(re.search(r'height="([0-9.]+)mm"', svg)[1])
        words = f"its (caption needs|figures need) {ceil(height - 80)} mm more than the height chosen"
        page.get_by_text(re.compile(words)).wait_for()
        full = re.search("<desc>(.*?)</desc>", svg)[1].replace("&lt;", "<").replace("&gt;", ">")
        lines = page.evaluate(TEXT_LINES, svg)
        told, computed = re.fullmatch(r"(.*)( Computed with pwsviz .*)", full.replace("·", "")).groups()
        written = " ".join(lines).replace("·", "")
        assert written.startswith(told), "no word of it is left out"
        assert computed in written.removeprefix(told), "after what the browser adds"
        assert not [line for line in lines if re.search(r"\([^()]*,$", line)], "a state stays on one line"
    page.get_by_role("button", name="8 pt", exact=True).click()
    page.get_by_role("button", name="200 mm", exact=True).click()
    downloaded(page, page.get_by_role("button", name="SVG").first)
    page.get_by_text(re.compile("more than the height chosen")).wait_for(state="detached")


def test_a_width_is_typed_where_none_of_those_offered_is_that_of_the_journal(visit):
    page = visit()
    await_that(page, PORTRAIT)
    await_still(page)
    page.get_by_role("button", name=re.compile("Export")).click()
    page.get_by_role("button", name="other", exact=True).click()
    field = page.get_by_label("30 to 500 mm")
    field.fill("130.5")
    with page.expect_download() as download:
        page.get_by_role("button", name="SVG").first.click()
    assert 'width="130.5mm"' in Path(download.value.path()).read_text(encoding="utf-8")
    assert download.value.suggested_filename.endswith("-130.5mm-short.svg")
    page.get_by_text("1,541 pixels wide").wait_for()
    for wrong in ("20", "wide"):
        field.fill(wrong)
        page.get_by_role("button", name="SVG").first.click()
        page.get_by_text(f"its width, “{wrong}”, is not a number from 30 to 500, in mm.", exact=False).wait_for()


PIXELS = """async svg => {
    const root = new DOMParser().parseFromString(svg, "image/svg+xml").documentElement
    const images = [...root.querySelectorAll("image")].map(async one => {
        const made = new Image()
        made.src = one.getAttribute("href")
        await made.decode()
        return [made.width, made.height, Number(one.getAttribute("width"))]
    })
    return [Number(root.getAttribute("viewBox").split(" ")[2]), await Promise.all(images)]
}"""
"""The width of a picture, and of each image in it its pixels and the width in which it is painted."""


def test_a_cloud_of_points_is_saved_with_600_pixels_an_inch(visit):
    page = visit(query="system=chua&view=sweep&methods=taylor&sweep_parameter=alpha&sweep_points=40")
    page.get_by_text(re.compile("The 40 points requested were found for every value")).first.wait_for(state="attached")
    page.get_by_role("button", name=re.compile("Export")).click()
    page.get_by_role("button", name="85 mm", exact=True).click()
    svg = downloaded(page, page.get_by_role("button", name="SVG").nth(1)).decode()
    whole, [(across, _, painted)] = page.evaluate(PIXELS, svg)
    assert across / (85 / 25.4 * painted / whole) >= 600


PLACES = """svg => {
    const root = new DOMParser().parseFromString(svg, "image/svg+xml").documentElement
    document.body.append(root)
    const box = one => (({left, right, top, bottom}) => [left, right, top, bottom])(one.getBoundingClientRect())
    const texts = [...root.querySelectorAll("text")].map(one =>
        ({words: one.textContent, box: box(one), within: one.closest("[clip-path]") != null}))
    const page = box(root)
    root.remove()
    return {page, texts}
}"""
"""Where the texts of a picture are, and which of them are within the frame of a plot."""


NAMED_LEVELS = "Dotted: (a) round-off; (b) eps = 2⁻⁵²; (c) tiny, or 0: drawn here."
"""What is said of the levels of a figure of a column: beside them are letters, which leave the plot its width."""


def test_every_text_of_a_narrow_picture_is_inside_and_apart_from_the_others(visit):
    page = opened_for_a_column(visit)
    for points in ("8 pt", "12 pt"):
        page.get_by_role("button", name=points, exact=True).click()
        for k in range(2):
            svg = downloaded(page, page.get_by_role("button", name="SVG").nth(k)).decode()
            seen = page.evaluate(PLACES, svg)
            left, right, top, bottom = seen["page"]
            texts = [text for text in seen["texts"] if not text["within"]]
            for text in texts:
                a, b, c, d = text["box"]
                assert left <= a <= b <= right, (points, text["words"])
                assert top <= c <= d <= bottom, (points, text["words"])
            words = " ".join(text["words"] for text in texts)
            assert (NAMED_LEVELS in words) == (k == 1)
            alone = [text["words"] for text in texts]
            assert [name for name in (*"abc", "round-off", "eps", "tiny, or 0") if name in alone] == (
                ["a", "b", "c"] * (k == 1)
            )
            for one, other in combinations(texts, 2):
                across = min(one["box"][1], other["box"][1]) - max(one["box"][0], other["box"][0])
                down = min(one["box"][3], other["box"][3]) - max(one["box"][2], other["box"][2])
                assert min(across, down / 2) < 2, (points, one["words"], other["words"])  # lines have leading


def test_the_legend_of_a_narrow_picture_is_no_wider_than_the_caption_below_it(visit):
    page = opened_for_a_column(visit)
    seen = page.evaluate(PLACES, downloaded(page, page.get_by_role("button", name="SVG").first).decode())
    (left, right, *_), outside = seen["page"], [text for text in seen["texts"] if not text["within"]]
    margin = min(text["box"][0] for text in outside if text["words"].startswith("Phase portrait")) - left
    (below,) = {text["box"][3] for text in outside if text["words"] == "x"}
    assert all(right - text["box"][1] >= margin - 1 for text in outside if text["box"][2] > below)


def test_a_picture_without_a_caption_ends_below_its_legend(visit):
    page = visit(query="t_end=2")
    await_that(page, PORTRAIT)
    await_still(page)
    page.get_by_role("button", name=re.compile("Export")).click()
    page.get_by_role("button", name="no caption").click()
    seen = page.evaluate(PLACES, downloaded(page, page.get_by_role("button", name="SVG").first).decode())
    lowest = max(text["box"][3] for text in seen["texts"])
    assert seen["page"][3] - lowest > 3


CROSSED = """svg => {
    const root = new DOMParser().parseFromString(svg, "image/svg+xml").documentElement
    document.body.append(root)
    const within = [...root.querySelectorAll("[clip-path]")].flatMap(part => [...part.querySelectorAll("path")])
    const lines = within.filter(path => path.getAttribute("fill") == "none" || path.getAttribute("fill") == null)
    const points = lines.filter(path => path.getAttribute("stroke") != "#e2e2e2").flatMap(path => {
        const to = path.getScreenCTM(), long = path.getTotalLength()
        return Array.from({length: Math.ceil(long) + 1}, (_, k) => path.getPointAtLength(k).matrixTransform(to))
    })
    const names = [...root.querySelectorAll("text")].filter(one => NAME.test(one.textContent))
    const found = names.map(one => {
        const {left, right, top, bottom} = one.getBoundingClientRect()
        const crossed = points.some(({x, y}) => left < x && x < right && top + 2 < y && y < bottom - 2)
        return [one.textContent, crossed]
    })
    root.remove()
    return found
}"""
"""Names within the frame of a picture, and whether a line passes through each."""


def narrow_picture(page, number):
    page.get_by_role("button", name=re.compile("Export")).click()
    page.get_by_role("button", name="85 mm").click()
    return downloaded(page, page.get_by_role("button", name="SVG").nth(number)).decode()


def test_no_line_passes_through_the_name_of_a_slope_in_a_narrow_picture(visit):
    page = visit(query="view=order")
    page.get_by_text("and after 10, 20 and 30 crossings").first.wait_for()
    svg = narrow_picture(page, 1)
    assert page.evaluate(CROSSED.replace("NAME", "/^slope/"), svg) == [["slope 2", False]]


def test_no_trajectory_passes_through_the_name_of_a_region_in_a_narrow_picture(visit):
    page = visit(query="system=chua&t_end=40&window=-2.5,2.5,-3.4,3.4")
    await_that(page, PORTRAIT)
    await_still(page)
    found = page.evaluate(CROSSED.replace("NAME", "/^[+−]+$/"), narrow_picture(page, 0))
    assert sorted(found) == [["++", False], ["+−", False], ["−−", False]]


def test_the_frame_of_a_narrow_plot_with_names_of_levels_beside_it_is_at_least_57_mm_wide(visit):
    page = visit()
    await_that(page, PORTRAIT)
    await_still(page)
    svg = narrow_picture(page, 1)
    wide = float(re.search(r'viewBox="0 0 ([0-9.]+)', svg)[1])
    clips = [
        tuple(map(float, ends)) for ends in re.findall(r'd="M ([0-9.]+) [0-9.]+ L ([0-9.]+) [^"]*"/></clipPath>', svg)
    ]
    frame = min(right - left for left, right in clips if left > 0)
    assert 85 * frame / wide >= 57


def test_panels_of_one_figure_stand_below_one_another(visit):
    law = ("y/1000000", "-1000000*x")  # whose coordinates have labels of different widths
    scene = Scene()
    scene.use(core.PiecewiseSystem("Scales", ("x", "y"), law, law, "x", x0=(1.0, 0.0)))
    page = visit(query=f"{query(scene)}&view=state&t_end=5")
    await_that(page, PORTRAIT)
    await_still(page)
    page.get_by_role("button", name=re.compile("Export")).click()
    png = downloaded(page, page.get_by_role("button", name="PNG").nth(1))
    dark = np.asarray(Image.open(io.BytesIO(png)).convert("L")) < 100
    dark = dark[: len(dark) * 3 // 4]  # without legend and caption
    for side in (dark[:, : dark.shape[1] // 4], dark[:, -dark.shape[1] // 4 :]):
        assert side.mean(axis=0).max() > 0.9, "the frames have one left edge, and one right edge"


@pytest.mark.parametrize(("width", "height", "query"), [(1500, 1600, ""), (1700, 700, "window=-3,2,-1,4")])
def test_a_portrait_is_saved_with_the_limits_of_the_screen_in_a_window_of_any_shape(visit, width, height, query):
    page = visit(width=width, height=height, query=query)
    await_that(page, PORTRAIT)
    await_still(page)
    *_, wide, high = page.evaluate(PORTRAIT)["frame"]
    page.get_by_role("button", name=re.compile("Export")).click()
    for choices in (["85 mm", "full"], ["250 mm", "80 mm", "no caption"]):
        for choice in choices:
            page.get_by_role("button", name=choice, exact=True).click()
        svg = downloaded(page, page.get_by_role("button", name="SVG").first).decode()
        assert max(shapes_of(svg)) == pytest.approx(wide / high, rel=0.02), "at equal scales it shows the same plane"


def shapes_of(svg):
    """Width by height of the frames that clip what is within."""
    path = r'd="M ([0-9.]+) ([0-9.]+) L ([0-9.]+) [0-9.]+ L [0-9.]+ ([0-9.]+) [^"]*"/></clipPath>'
    for ends in re.findall(path, svg):
        left, top, right, bottom = map(float, ends)
        if left > 0:
            yield (right - left) / (bottom - top)


MARKERS = """markup => {
    const svg = new DOMParser().parseFromString(markup, "image/svg+xml").documentElement
    const host = document.createElement("div")
    host.append(svg)
    document.body.append(host)
    const found = [...svg.querySelectorAll("path[fill^=rgb][stroke='rgb(255,255,255)']")].map(mark => {
        const box = mark.getBoundingClientRect(), key = mark.closest("[clip-path]") == null
        return {colour: mark.getAttribute("fill"), corners: mark.getAttribute("d").match(/[ML]/g).length, key,
                x: box.x + box.width / 2, y: box.y + box.height / 2, scale: svg.viewBox.baseVal.width / svg.clientWidth}
    })
    host.remove()
    return found
}"""
"""The filled marks with a white edge in a picture, and those of its legend."""

EDGES = """markup => {
    const svg = new DOMParser().parseFromString(markup, "image/svg+xml").documentElement
    const curves = [...svg.querySelectorAll("path[stroke-linejoin=round]")]
    const [dashed, white] = ["stroke-dasharray", "white"].map(name => new Set(curves.filter(
        path => name == "white" ? path.getAttribute("stroke") == "#ffffff" : path.hasAttribute(name))))
    const width = path => Number(path.getAttribute("stroke-width")), way = path => path.getAttribute("d")
    let solid = null
    const below = new Map()  // the way of a dashed curve -> the solid curve painted before it
    for (const path of curves) {
        if (!dashed.has(path)) { solid = path }
        else if (!white.has(path)) { below.set(way(path), solid) }
    }
    return [...white].map(path => [width(path), width(below.get(way(path)))])
}"""
"""The width of each white edge of a dashed curve, and of the solid curve on which that lies."""


@pytest.mark.parametrize(
    ("query", "bordered"), [("view=conserved", 3), ("view=state", 6), ("view=stability&stability_part=drift", 0)]
)
def test_in_print_each_curve_has_the_markers_of_its_integrator_and_so_has_the_legend(visit, query, bordered):
    """So that curves can be named without colours, and where one lies on another: circles, squares, other shapes."""
    page = visit(query=f"v=2&methods=dmm2,rk2,rk4,dmm4&starts=-1,-1;-1.5,0.3;-0.5,-0.5&{query}")
    await_that(page, PORTRAIT)
    page.get_by_text(re.compile("2,000 steps, 21 crossings")).first.wait_for()
    for k, markup in enumerate(both_pictures(page)):
        found, edges = page.evaluate(MARKERS, markup), page.evaluate(EDGES, markup)
        told = "three dashed curves, from each of three starts in the portrait, in each panel of the view"
        assert len(edges) == (bordered if k else 9), told
        assert all(width < solid for width, solid in edges), "no white edge hides the curve below"
        keys, marks = ([one for one in found if one["key"] is wanted] for wanted in (True, False))
        shapes = {one["corners"] for one in keys}
        assert shapes == {1, 3, 5, 6}, "a square ends at the corner where it began"
        assert len({one["colour"] for one in keys}) == len(keys) == 4
        for key in keys:
            of_curve = [one for one in marks if one["colour"] == key["colour"]]
            assert {one["corners"] for one in of_curve} == {key["corners"]}
            assert len(of_curve) >= 2
        panels = 1 if "state" not in query or k == 0 else 2
        apart = [
            np.hypot(one["x"] - other["x"], one["y"] - other["y"]) * one["scale"]
            for one, other in combinations(marks, 2)
        ]
        assert panels > 1 or min(apart) > 20, "no marker covers another"


@pytest.mark.deep
def test_a_curve_that_runs_off_ends_beside_the_frame_and_keeps_its_dashes_and_its_entry(visit):
    """Of one that goes on for millions of points, programs leave out the dashes, or all of it."""
    page = visit(query="v=2&tau=0.2&methods=dmm2,rk2&view=state")
    page.get_by_text(re.compile("^rk2: 35 steps")).first.wait_for()
    await_still(page)
    page.get_by_role("button", name=re.compile("Export")).click()
    markup = downloaded(page, page.get_by_role("button", name="SVG").nth(1)).decode()
    colour = "rgb(162,52,0)"  # of rk2
    dashed = [
        path for path in re.findall(r"<path[^>]*>", markup)
        if f'stroke="{colour}"' in path and re.search('stroke-dasharray="[1-9]', path)
    ]  # fmt: skip
    long = [path for path in dashed if path.count("L") > 20]
    assert len(long) == 2, "one a panel"
    assert len(dashed) > 2, "and in the legend"
    numbers = [float(one) for path in long for one in re.findall(r"-?[0-9.]+", re.search(' d="([^"]*)"', path)[1])]
    assert max(map(abs, numbers)) < 2000
