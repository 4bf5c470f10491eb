"""Files hold the numbers of the page to the bit, under names that every system takes, and say what they are."""

import csv
import io
import json
import re
import zipfile

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import core
from pwsviz.export.about import about
from pwsviz.export.files import ROWS, csv_bytes, file_name, npz_bytes
from pwsviz.scene.scene import Scene


def read_csv(file):
    """Return the comments, and the cells of each column by name."""
    lines = file.decode().split("\n")
    comments = [line for line in lines if line.startswith("# ")]
    head, *rows = csv.reader(io.StringIO("\n".join(lines[len(comments) :])))
    return comments, dict(zip(head, zip(*rows, strict=True), strict=True)) if rows else dict.fromkeys(head, ())


@given(st.lists(st.floats(), min_size=1, max_size=30))
def test_csv_holds_every_bit_of_a_float(numbers):
    _, columns = read_csv(csv_bytes({"x": numbers}))
    found = np.array([float(cell) for cell in columns["x"]])
    assert np.array_equal(found, numbers, equal_nan=True)
    assert np.array_equal(np.signbit(found), np.signbit(numbers)) or np.isnan(numbers).any()


@given(st.lists(st.floats(), max_size=30), st.lists(st.text(st.characters(exclude_characters="\0")), max_size=5))
def test_npz_holds_the_columns_and_where_they_come_from(numbers, words):
    words = np.array(words, dtype=np.str_)
    tables = {"": {"file": numbers}, "crossings": {"kind": words}}
    file = np.load(io.BytesIO(npz_bytes(tables, {"link": "?v=1&system=kepler"})))
    assert np.array_equal(file["file"], np.array(numbers), equal_nan=True)
    assert file["crossings.kind"].tolist() == words.tolist()
    about = json.loads(str(file["about"]))
    assert about["link"] == "?v=1&system=kepler"
    assert "kind: what happens" in about["columns"]


def test_counts_are_written_as_whole_numbers():
    _, columns = read_csv(csv_bytes({"crossings": [21.0, np.nan, 0.0], "t": [1.0, 2.0, 3.0]}))
    assert columns["crossings"] == ("21", "nan", "0")
    assert columns["t"] == ("1.0", "2.0", "3.0")


def test_a_long_table_is_written_whole():
    t = np.arange(2.0 * ROWS + 3)
    _, columns = read_csv(csv_bytes({"t": t}))
    assert [float(cell) for cell in columns["t"]] == t.tolist()


def test_columns_of_different_lengths_are_no_table():
    for write in (csv_bytes, lambda table: npz_bytes({"": table})):
        with pytest.raises(ValueError, match="one length; there are t 2, few 1"):
            write({"t": [1.0, 2.0], "few": [1.0]})


def test_the_header_says_what_was_computed_and_what_each_column_is():
    scene = Scene(starts=((-1.0, -1.0), (-1.2, 0.0)), tau=0.02)
    comments, _ = read_csv(csv_bytes({"t": [0.0], "seconds": [1.0]}, about(scene, "http://here/app")))
    said = dict(line.removeprefix("# ").split(": ", 1) for line in comments)
    assert said["link"].startswith("http://here/app?v=2")
    assert said["equations"].startswith("g < 0: x′ = 2y, y′ = 3x² + a₋, ψ₋ = ")
    assert "a₋ = −3, a₊ = −2" in said["parameters"]
    assert said["starts"] == "initial states 1 and 2: (x, y) = (−1, −1); (−1.2, 0)"
    assert "dmm2 and rk2 with step size τ = 0.02 for t ≤ 20" in said["integration"]
    assert said["variables"].startswith("x, y; a column of such a name")
    assert said["columns"].startswith("t: time, ")
    assert "in s" in said["columns"]


@pytest.mark.parametrize("word", ["=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "\r=1", '=cmd|"/c calc"!A0'])
def test_no_spreadsheet_takes_a_word_for_a_formula(word):
    _, columns = read_csv(csv_bytes({word: np.array([-1.5]), "words": np.array([word])}, {"link": word}))
    shown = "'" + re.sub(r"\s", " ", word)
    assert columns["words"] == (shown,)
    assert columns[shown] == ("-1.5",), "a number is no word"


def test_the_signs_of_regions_are_read_by_a_program_as_they_are():
    keys = np.array(["+-", "--", "0+", "+0", "-+-0"])
    _, columns = read_csv(csv_bytes({"region": keys}))
    assert columns["region"] == tuple(keys)


@given(st.text(st.characters(exclude_categories=["Cs"])))
def test_each_comment_is_one_line_whatever_it_says(words):
    lines = csv_bytes({"x": [1]}, {"link": words}).decode().splitlines()
    assert lines[1:] == ["x", "1"]
    assert lines[0].startswith("# link: ")


def test_a_column_of_anything_else_is_refused():
    for column in ([[1.0]], 1.0, [None], [1j]):
        for write in (csv_bytes, lambda table: npz_bytes({"": table})):
            with pytest.raises(ValueError, match="'x' is not a list of numbers or words"):
                write({"x": column})


@given(st.text(max_size=80), st.text(max_size=20))
def test_a_file_name_is_one_that_every_system_takes(name, what):
    scene = Scene()
    scene.use(core.PiecewiseSystem(name, ("x", "y"), ("y", "-x"), ("y", "-x"), "y"))
    assert re.fullmatch(r"pwsviz(-[a-z0-9_-]*[a-z0-9_])?\.csv", file_name(scene, what, "csv"))


def test_a_file_name_says_what_the_file_is():
    scene = Scene()
    mark = about(scene)["scene"]
    assert file_name(scene, "Conserved quantity", "npz") == f"pwsviz-elliptic_curve-conserved-quantity-{mark}.npz"


def test_a_system_too_long_for_a_link_has_a_file_name_all_the_same():
    scene = Scene()
    scene.use(core.PiecewiseSystem("Long", ("x", "y"), ("y", "-x"), ("y", "-x"), "y", doc="é" * 5000))
    assert about(scene)["link"].startswith("none")
    assert file_name(scene, "Order", "csv") == f"pwsviz-long-order-{about(scene)['scene']}.csv"


@pytest.mark.parametrize("change", [{"perturbation_order": 1}, {"methods": ["rk4"]}, {"starts": ((0.0, 0.5),)}])
def test_files_of_different_scenes_have_different_names(change):
    assert file_name(Scene(), "Order", "csv") == file_name(Scene(), "Order", "csv")
    assert file_name(Scene(**change), "Order", "csv") != file_name(Scene(), "Order", "csv")


def test_the_archive_is_one_that_other_programs_open():
    with zipfile.ZipFile(io.BytesIO(npz_bytes({"": {"x": [1.0]}}))) as archive:
        assert archive.testzip() is None
        assert archive.namelist() == ["x.npy", "about.npy"]
