"""Files hold the numbers of the page to the bit, under names that every system takes, and the picture as it is seen."""

import base64
import csv
import io
import re
import zipfile

import numpy as np
import pytest
from bokeh.embed import file_html
from bokeh.models import Button, CustomJS
from bokeh.resources import INLINE
from hypothesis import given
from hypothesis import strategies as st

import core
from pwsviz.export.tables import (
    ROWS,
    csv_bytes,
    file_name,
    npz_bytes,
    order_table,
    png_callback,
    run_table,
    runs_table,
)
from pwsviz.figures.style import plain_figure
from pwsviz.results.requests import study_inputs
from pwsviz.results.results import Results
from pwsviz.scene.permalink import query
from pwsviz.scene.scene import Scene

# Files ---------------------------------------------------------------------------------------------------------------


def read_csv(file):
    """Return the comment, and the cells of each column by name."""
    comment, _, rest = file.decode().partition("\n")
    head, *rows = csv.reader(io.StringIO(rest))
    return comment, dict(zip(head, zip(*rows, strict=True), strict=True)) if rows else dict.fromkeys(head, ())


@given(st.lists(st.floats(), min_size=1, max_size=30))
def test_csv_holds_every_bit_of_a_float(numbers):
    _, columns = read_csv(csv_bytes({"x": numbers}))
    found = np.array([float(cell) for cell in columns["x"]])
    assert np.array_equal(found, numbers, equal_nan=True)
    assert np.array_equal(np.signbit(found), np.signbit(numbers)) or np.isnan(numbers).any()


@given(st.lists(st.floats(), max_size=30), st.lists(st.text(st.characters(exclude_characters="\0")), max_size=5))
def test_npz_holds_the_columns_and_where_they_come_from(numbers, words):
    words = np.array(words, dtype=np.str_)
    file = np.load(io.BytesIO(npz_bytes({"file": numbers, "words": words}, "v=1&system=kepler")))
    assert np.array_equal(file["file"], np.array(numbers), equal_nan=True)
    assert file["words"].tolist() == words.tolist()
    assert str(file["about"]).startswith("pwsviz ")
    assert str(file["about"]).endswith(" v=1&system=kepler")


def test_short_columns_end_in_empty_cells_however_long_the_others_are():
    t = np.arange(2.0 * ROWS + 3)
    _, columns = read_csv(csv_bytes({"t": t, "few": np.arange(ROWS + 2), "none": np.zeros(0)}))
    assert [float(cell) for cell in columns["t"]] == t.tolist()
    assert [int(cell) for cell in columns["few"] if cell] == list(range(ROWS + 2))
    assert columns["few"][ROWS + 2 :] == ("",) * (ROWS + 1)
    assert set(columns["none"]) == {""}


@pytest.mark.parametrize("word", ["=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "\r=1", '=cmd|"/c calc"!A0'])
def test_no_spreadsheet_takes_a_word_for_a_formula(word):
    file = csv_bytes({word: np.array([-1.5]), "words": np.array([word])}, word)
    comment, columns = read_csv(file)
    assert comment.startswith("# pwsviz")
    shown = "'" + re.sub(r"\s", " ", word)
    assert columns["words"] == (shown,)
    assert columns[shown] == ("-1.5",), "a number is no word"


@given(st.text(st.characters(exclude_categories=["Cs"])))
def test_the_comment_is_one_line_whatever_it_says(about):
    lines = csv_bytes({"x": [1]}, about).decode().splitlines()
    assert lines[1:] == ["x", "1"]
    assert lines[0].startswith("# pwsviz ")


def test_a_column_of_anything_else_is_refused():
    for column in ([[1.0]], 1.0, [None], [1j]):
        for write in (csv_bytes, npz_bytes):
            with pytest.raises(ValueError, match="'x' is no list of numbers or words"):
                write({"x": column})


@given(st.text(max_size=80), st.text(max_size=20))
def test_a_file_name_is_one_that_every_system_takes(name, what):
    scene = Scene()
    scene.use(core.PiecewiseSystem(name, ("x", "y"), ("y", "-x"), ("y", "-x"), "y"))
    assert re.fullmatch(r"pwsviz(-[a-z0-9_-]*[a-z0-9_])?\.csv", file_name(scene, what, "csv"))


def test_a_file_name_says_what_the_file_is():
    assert file_name(Scene(), "Conserved quantity", "npz") == "pwsviz-elliptic_curve-conserved-quantity.npz"


# Tables --------------------------------------------------------------------------------------------------------------


def test_a_run_is_given_at_the_integrators_own_steps():
    run = core.integrate(core.CATALOGUE["kepler"], (0.0, 5.0))
    table = run_table(run)
    assert np.array_equal(table["t"], run.t)
    assert np.array_equal(np.column_stack([table[name] for name in ("x", "y", "u", "v")]), run.x)
    assert np.array_equal(table["side"], run.side)
    assert np.array_equal(table["change_of_psi"], run.change_of_psi())
    assert len(table["crossing_t"]) == len(run.crossings) > 1
    _, columns = read_csv(csv_bytes(table))
    assert [float(cell) for cell in columns["v"]] == run.x[:, 3].tolist()
    assert columns["crossing_kind"][: len(run.crossings)] == tuple(run.crossings.kind)


def test_runs_stand_side_by_side():
    runs = {method: core.integrate(core.CATALOGUE["pendulum"], (0.0, 1.0), method=method) for method in ("rk2", "rk4")}
    table = runs_table(runs)
    assert np.array_equal(table["rk4.q"], runs["rk4"].x[:, 0])
    assert len(table) == 2 * len(run_table(runs["rk2"]))


def test_a_variable_may_be_called_as_a_column_of_ours():
    names = ("side", "about", "crossing_t")
    system = core.PiecewiseSystem("clash", names, ("1", "1", "1"), ("1", "1", "1"), "side", x0=(-1.0, 2.0, 3.0))
    table = run_table(core.integrate(system, (0.0, 2.0), method="rk2"))
    assert table["side"].dtype.kind == "i"
    assert table["variable_about"][0] == 2.0
    assert table["variable_crossing_t"][0] == 3.0
    assert table["crossing_t"] == pytest.approx([1.0])
    assert set(np.load(io.BytesIO(npz_bytes(table))).files) == {*table, "about"}


def test_an_order_study_gives_errors_slopes_and_reference():
    study = Results().study(study_inputs(Scene(methods=["rk2"])))
    table = order_table(study)
    _, columns = read_csv(csv_bytes(table, query(Scene())))
    assert [float(cell) for cell in columns["tau"]] == study.taus.tolist()
    assert [float(cell) for cell in columns["time_error_20"]] == pytest.approx(study.time_error[1], nan_ok=True, rel=0)
    assert [float(cell) for cell in columns["state_error_after_0"]] == pytest.approx(
        study.state_error[0], nan_ok=True, rel=0
    )
    assert table["time_slope"][1:].tolist() == study.time_slope.tolist()
    assert table["state_fit_to"].tolist() == study.window[:, 1].tolist()
    assert (columns["reference"][0], columns["method"][0]) == (study.reference, "rk2")


def test_the_archive_is_one_that_other_programs_open():
    with zipfile.ZipFile(io.BytesIO(npz_bytes({"x": [1.0]}))) as archive:
        assert archive.testzip() is None
        assert archive.namelist() == ["x.npy", "about.npy"]


# Pictures ------------------------------------------------------------------------------------------------------------

PIXELS = """async address => {
    const image = new Image()
    image.src = address
    await image.decode()
    const canvas = document.createElement("canvas")
    canvas.width = image.width
    canvas.height = image.height
    const pen = canvas.getContext("2d")
    pen.drawImage(image, 0, 0)
    return {width: image.width, corner: [...pen.getImageData(1, 1, 1, 1).data],
            shades: new Set(new Uint32Array(pen.getImageData(0, 0, image.width, image.height).data.buffer)).size}
}"""


@pytest.mark.browser
@pytest.mark.parametrize(("scale", "ground"), [(1, [250, 250, 250, 255]), (2, [17, 18, 19, 255])])
def test_a_picture_is_saved_at_the_resolution_of_the_device_on_the_ground_of_the_page(chromium, scale, ground):
    plot = plain_figure("A line", sizing_mode="fixed", width=400, height=300, border_fill_color=None)
    plot.line([0, 1, 2], [0, 1, 0])
    button = Button(label="PNG")
    button.js_on_click(CustomJS(args={"name": "pwsviz-line.png"}, code=png_callback(plot)))
    page_text = file_html([button, plot], INLINE)
    window = chromium.new_context(device_scale_factor=scale)
    page = window.new_page()
    page.set_content(page_text)
    page.add_style_tag(content=f"body {{ background: rgb({', '.join(map(str, ground[:3]))}) }}")
    page.wait_for_function("Bokeh.documents.length && Bokeh.documents[0].is_idle")
    with page.expect_download() as download:
        page.get_by_role("button", name="PNG").click()
    assert download.value.suggested_filename == "pwsviz-line.png"
    saved = base64.b64encode(download.value.path().read_bytes()).decode()
    picture = page.evaluate(PIXELS, f"data:image/png;base64,{saved}")
    window.close()
    assert picture["width"] == 400 * scale
    assert picture["corner"] == ground
    assert picture["shades"] > 10
