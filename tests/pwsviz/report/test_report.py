"""The report: one page without anything from outside, and data equal to the core's."""

import csv
import io
import os
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import core
from pwsviz.__main__ import main
from pwsviz.bench import Table
from pwsviz.report import PAGE, figures_of_paper, write_report
from pwsviz.report import write as writing
from pwsviz.results.studies import STUDY_TAUS
from pwsviz.scene.presets import PRESETS

ROOT = Path(__file__).parents[3]
FIGURES = ("fig:portraits", "fig:elliptic_time", "fig:CQ_elliptic")


class Resources(HTMLParser):
    """What a page would fetch, and the text people read."""

    def __init__(self, page):
        super().__init__()
        self.fetched, self.links, self.labels, self.text = [], [], [], []
        self._silent = 0
        self.feed(page)

    def handle_starttag(self, tag, attributes):  # noqa: D102
        given = dict(attributes)
        self.fetched += [given[name] for name in ("src", "srcset", "data", "poster") if given.get(name)]
        if tag == "link":
            self.fetched.append(given.get("href"))
        if tag == "a":
            self.links.append(given.get("href"))
        self._silent += tag in ("script", "style")

    def handle_endtag(self, tag):  # noqa: D102
        self._silent -= tag in ("script", "style")

    def handle_data(self, data):  # noqa: D102
        if not self._silent:
            self.text.append(data)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder, say = tmp_path_factory.mktemp("report") / "new", io.StringIO()
    files = []
    write_report(folder, say, files, FIGURES, bench=False)
    return folder, files, say.getvalue()


@pytest.fixture(scope="module")
def page(written):
    return (written[0] / PAGE).read_text(encoding="utf-8")


def model_of(page):
    """The document that Bokeh draws, as it is written on the page."""
    return re.search(r'<script type="application/json"[^>]*>(.*?)</script>', page, re.DOTALL).group(1)


def table_of(path):
    """Columns of a CSV, without the cells that fill them up."""
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    header, *rows = csv.reader(lines)
    return {name: [cell for cell in column if cell] for name, *column in zip(header, *rows, strict=True)}


def numbers(column):
    return np.array([float(cell) for cell in column])


def test_every_figure_of_the_paper_has_panels():
    labels = list(figures_of_paper())
    assert labels == [
        "fig:vftypes", "fig:portraits", "fig:harmonic_timeError", "fig:harmonic_transition", "fig:CQ_harmonic",
        "fig:elliptic_time", "fig:elliptic_transition", "fig:CQ_elliptic",
    ]  # fmt: skip
    assert all(figures_of_paper().values())
    assert {preset.figure for preset in PRESETS.values()} - {""} == set(labels)


def test_the_page_fetches_nothing(page):
    assert Resources(page).fetched == []
    styles = "".join(re.findall(r"<style[^>]*>(.*?)</style>", page, re.DOTALL))
    assert not re.search(r"url\(|@import", styles)


def test_the_page_holds_bokeh_and_weighs_little_more(page):
    assert "Bokeh.embed" in page or "embed_items" in page
    assert len(page.encode()) < 3.5e6


def test_every_panel_says_what_it_shows_and_what_was_measured(page):
    text = " ".join(" ".join(Resources(page).text).split())
    for label in FIGURES:
        for preset in figures_of_paper()[label]:
            assert preset.look in text
        assert label in text
    assert "reference: exact (Weierstrass ℘)" in text
    assert re.search(r"crossing 30 (1\.99|2\.0)\d ", text)  # a fitted slope
    assert re.search(r"dmm2 \(−1, −1\) 100,000 105 crossings \d×10⁻¹⁶ ", text)  # steps, crossings, largest error
    assert re.search(r"numpy \d", text)
    assert re.search(r"\d+ cores", text)


def test_figures_have_their_summary_for_those_who_cannot_see_them(page):
    assert model_of(page).count('"aria-label"') == 4
    assert "dmm2 conserves ψ to " in " ".join(Resources(page).text)


def test_nothing_can_be_dragged(page):
    assert "setPointerCapture" not in model_of(page)


def test_every_file_named_on_the_page_is_there(written, page):
    folder, files, _ = written
    named = {link for link in Resources(page).links if not link.startswith("#")}
    assert named == {file.name for file in files} - {PAGE}
    assert all(file.exists() for file in files)
    assert {file.name for file in folder.iterdir()} == {file.name for file in files}


def test_anchors_lead_somewhere(page):
    assert all(f'<section id="{link[1:]}">' in page for link in Resources(page).links if link.startswith("#"))


def test_runs_are_those_of_the_core_to_the_last_digit(written):
    curves, crossings = (table_of(written[0] / f"portrait_elliptic-{name}.csv") for name in ("curves", "crossings"))
    for number, start in enumerate(((-1, -1), (-1, -0.5), (-1.2, 0)), 1):
        run = core.integrate(core.CATALOGUE["elliptic_curve"], (0.0, 20.0), x0=start, tau=0.01)
        rows, met = (numbers(table["start"]) == number for table in (curves, crossings))
        assert np.array_equal(numbers(curves["t"])[rows], run.t)
        assert np.array_equal(np.column_stack([numbers(curves[v])[rows] for v in "xy"]), run.x)
        assert np.array_equal(numbers(crossings["t"])[met], run.crossings.t)


def test_errors_of_crossing_times_are_those_of_the_core(written):
    table = table_of(written[0] / "elliptic_time-errors.csv")
    study = core.order_study(core.CATALOGUE["elliptic_curve"], STUDY_TAUS, x0=(-1, -1))
    for k, row in zip((10, 20, 30), study.time_error, strict=True):
        there = np.array(table["curve"]) == f"crossing {k}"
        assert np.array_equal(numbers(table["tau"])[there], study.taus)
        assert np.array_equal(numbers(table["error"])[there], row)


def test_one_line_a_figure_is_said(written):
    lines = written[2].splitlines()
    assert [line.split("  ")[0] for line in lines] == [f"[{k}/3] {label}" for k, label in enumerate(FIGURES, start=1)]
    assert all(re.search(r"… \d+\.\d s$", line) for line in lines)


def test_a_summary_ends_the_command(tmp_path, capsys):
    assert main(["report", "--out", str(tmp_path), "--no-bench", "--only", "fig:elliptic_time"]) == 0
    assert re.search(r"^3 files are written to .* \(\d\.\d MB\); open .*report\.html\. \d+ s in all\.$",
                     capsys.readouterr().out, re.MULTILINE)  # fmt: skip


def test_an_unknown_figure_is_refused_before_anything_is_written(tmp_path, capsys):
    assert main(["report", "--out", str(tmp_path / "new"), "--only", "fig:nothing"]) == 2
    assert "'fig:nothing' is not a figure of the paper; there are fig:vftypes" in capsys.readouterr().err
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("place", ["file", "file/below"])
def test_a_folder_that_cannot_be_written_is_said_at_once(place, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(writing, "draw_panel", lambda *_: pytest.fail("computed for nothing"))
    (tmp_path / "file").write_text("")
    assert main(["report", "--out", str(tmp_path / place), "--no-bench"]) == 1
    words = capsys.readouterr().err
    assert f"cannot write to {tmp_path / place}: " in words
    assert "--out" in words


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() == 0, reason="the administrator may write anywhere")
def test_a_folder_without_permission_is_said(tmp_path, capsys):
    tmp_path.chmod(0o500)
    assert main(["report", "--out", str(tmp_path), "--no-bench"]) == 1
    assert f"cannot write to {tmp_path}" in capsys.readouterr().err


def test_a_file_that_cannot_be_written_later_on_is_said(tmp_path, capsys):
    (tmp_path / "elliptic_time-errors.csv").mkdir()
    assert main(["report", "--out", str(tmp_path), "--no-bench", "--only", "fig:elliptic_time"]) == 1
    assert f"cannot write {tmp_path / 'elliptic_time-errors.csv'}: " in capsys.readouterr().err


def test_an_interrupted_report_keeps_and_names_what_there_is(tmp_path, capsys, monkeypatch):
    draw = writing.draw_panel

    def interrupted(preset, results):
        if preset.figure == "fig:elliptic_transition":
            raise KeyboardInterrupt
        return draw(preset, results)

    monkeypatch.setattr(writing, "draw_panel", interrupted)
    only = [word for label in ("fig:elliptic_time", "fig:elliptic_transition") for word in ("--only", label)]
    assert main(["report", "--out", str(tmp_path), *only]) == 130
    assert "Interrupted; 3 files are written" in capsys.readouterr().err
    text = (tmp_path / PAGE).read_text(encoding="utf-8")
    assert "Given up before the end; missing: fig:elliptic_transition, Benchmark." in text
    assert (tmp_path / "elliptic_time-errors.csv").exists()


# The benchmark -------------------------------------------------------------------------------------------------------

STEPS = Table("Cost of a step", "in ns", ("system", "ns a step", "least"), [("elliptic_curve", "51.8", "-")])


def test_the_benchmark_is_on_the_page_and_beside_it(tmp_path, monkeypatch):
    monkeypatch.setattr(writing, "sections", lambda plan: [STEPS])
    files, say = [], io.StringIO()
    write_report(tmp_path, say, files, ["fig:elliptic_time"], quick=True)
    assert "[2/2] Benchmark … a minute; Cost of a step: " in say.getvalue()
    page = (tmp_path / PAGE).read_text(encoding="utf-8")
    assert "elliptic_curve        51.8" in page
    assert "too short for these times to be stated" in page
    assert (tmp_path / "bench.txt").read_text(encoding="utf-8").endswith(f"{STEPS.text}\n")
    table = table_of(tmp_path / "bench-cost-of-a-step.csv")
    assert table["ns a step"] == ["51.8"]
