"""Figures, words and columns of a stability study say what its arrays say."""

from dataclasses import replace

import numpy as np
import pytest

import core
from core.studies.stability import NO_START, NOT_YET, WENT_ON, WRONG_CROSSINGS
from pwsviz.figures.conserved import FLOOR
from pwsviz.figures.stability import StabilityView, stability_tables, stability_text
from pwsviz.figures.stability_map import COLOURS
from pwsviz.figures.stability_text import cell_words
from pwsviz.figures.style import line_of

ELLIPTIC = core.CATALOGUE["elliptic_curve"]
METHODS = ("dmm2", "rk2")


@pytest.fixture(scope="module")
def study():
    return core.stability_study(
        ELLIPTIC, methods=METHODS, taus=np.geomspace(0.02, 1.0, 6), values=np.linspace(-1.6, -0.8, 5), steps=20_000
    )


@pytest.fixture(scope="module")
def without():
    """A study of a system without a conserved quantity."""
    gene = core.CATALOGUE["gene_switch"]
    return core.stability_study(gene, methods=("rk4",), steps=2000, parts=("drift", "grazing", "largest_tau"))


def empty(study):
    return replace(study, largest_tau=None, map=None, drift=None, grazing=None)


def test_figures_are_made_when_first_asked_for_and_then_kept():
    view = StabilityView()
    assert not view._made
    assert view.figure("drift") is view.figure("drift")
    assert list(view._made) == ["drift"]


@pytest.mark.parametrize("part", ["map", "drift", "grazing"])
def test_a_study_of_which_nothing_is_there_yet_is_an_empty_figure(study, part):
    view = StabilityView()
    view.show(study, part, "dmm2")
    view.show(empty(study), part, "dmm2")
    drawn = view._made[part]
    for source in (drawn.cells, drawn.limits) if part == "map" else (drawn.curves,):
        assert all(len(column) == 0 for column in source.data.values())
    assert stability_text(empty(study), part, "dmm2") == "Nothing is computed yet."
    assert stability_tables(empty(study), part) == {}


# The map -------------------------------------------------------------------------------------------------------------


def test_cells_of_the_map_tile_the_range_and_lie_about_their_runs(study):
    view = StabilityView()
    view.show(study, "map", "rk2")
    data = view._made["map"].cells.data
    assert len(data["left"]) == 6 * 5
    area = np.log(np.array(data["right"]) / data["left"]) * (np.array(data["top"]) - data["bottom"])
    whole = np.log(max(data["right"]) / min(data["left"])) * (max(data["top"]) - min(data["bottom"]))
    assert area.sum() == pytest.approx(whole)
    for left, right, tau in zip(data["left"], data["right"], data["tau"], strict=True):
        assert left < float(tau) < right


def test_cells_have_the_colour_and_the_words_of_their_outcome(study):
    view, found = StabilityView(), study.map
    view.show(study, "map", "rk2")
    data = view._made["map"].cells.data
    row, column = np.nonzero(found.outcome[1] != NOT_YET)
    for n, (i, j) in enumerate(zip(row, column, strict=True)):
        good = found.works[1, i, j]
        code = core.Status.COMPLETED if good else found.outcome[1, i, j]
        assert data["colour"][n] == COLOURS[code]
        assert (data["words"][n] == "correct sequence of crossings") == good
    assert len(set(data["colour"])) == len(set(data["words"])) > 1


def test_a_solution_that_runs_away_is_no_failure_of_the_run_that_does_too(study):
    view, found = StabilityView(), study.map
    gone = np.flatnonzero(found.expected == core.Status.ESCAPED)
    assert len(gone)
    view.show(study, "map", "dmm2")
    assert found.outcome[0, 0, gone[0]] == core.Status.ESCAPED
    assert view._made["map"].cells.data["words"][gone[0]] == "correct sequence of crossings"


def test_the_error_map_has_a_colour_bar_and_the_outcome_map_a_legend(study):
    view = StabilityView()
    for what, heat, cells in (("error", 30, 0), ("outcome", 0, 30)):
        view.show(study, "map", "dmm2", what)
        drawn = view._made["map"]
        assert len(drawn.heat.data["left"]) == heat
        assert len(drawn.cells.data["left"]) == cells
        assert drawn.bar.visible == (what == "error")
        assert drawn.figure.legend[0].visible == (what == "outcome")


def test_heights_of_the_error_map_are_the_errors_raised_to_the_floor(study):
    view = StabilityView()
    view.show(study, "map", "rk2", "error")
    shown, errors = np.array(view._made["map"].heat.data["height"]), study.map.error[1].ravel()
    assert np.array_equal(np.isnan(shown), np.isnan(errors))
    assert np.allclose(shown[errors > 1e-12], errors[errors > 1e-12], rtol=1e-15)


def test_the_largest_step_sizes_are_lines_named_after_their_integrators(study):
    view = StabilityView()
    view.show(study, "map", "dmm2")
    data = view._made["map"].limits.data
    assert [text.strip() for text in data["text"]] == list(METHODS)
    assert list(data["x"]) == study.largest_tau.tau.tolist()
    assert data["colour"] == [line_of(name).colour for name in METHODS]


def test_every_outcome_has_a_colour_and_words():
    codes = [s for s in core.Status if s not in (core.Status.RUNNING, core.Status.CANCELLED)]
    for code in (*codes, WRONG_CROSSINGS, WENT_ON, NO_START):
        assert COLOURS[code].startswith("#")
        assert cell_words(code, core.Status.COMPLETED)
    assert cell_words(core.Status.STEP_LIMIT, core.Status.STEP_LIMIT) == "the reference gives up"


# Drift and tangency --------------------------------------------------------------------------------------------------


def test_drift_is_a_curve_for_each_integrator(study):
    view = StabilityView()
    view.show(study, "drift", "dmm2")
    data = view._made["drift"].curves.data
    assert data["method"] == list(METHODS)
    assert np.allclose(data["ys"][1], study.drift.error[1])
    assert np.min(data["ys"][0]) >= FLOOR


def test_a_run_that_stops_is_marked_where_it_does(study):
    error = study.drift.error.copy()
    error[1, 10:] = np.nan
    stopped = replace(study.drift, error=error, message=("", "t = 5: it <stops>"))
    view = StabilityView()
    view.show(replace(study, drift=stopped), "drift", "dmm2")
    stops = view._made["drift"].stops.data
    assert stops["x"] == [stopped.t[9]]
    assert stops["method"] == ["rk2"]
    assert stops["message"] == ["t = 5: it <stops>"]


def test_rings_mark_the_runs_with_a_wrong_number_of_crossings(study):
    view, grazing = StabilityView(), study.grazing
    view.show(study, "grazing", "dmm2")
    drawn = view._made["grazing"]
    assert grazing.found
    assert len(drawn.wrong.data["x"]) == np.count_nonzero(grazing.missed) > 0
    assert [len(source.data["x"]) for source in drawn.points] == [2 * 14, 2 * 14]
    assert len(drawn.curves.data["xs"]) == 4
    assert drawn._entries[0].label["value"].startswith("x < −1.55")


def test_without_a_conserved_quantity_and_without_a_tangency_there_are_words(without):
    view = StabilityView()
    view.show(without, "drift", "rk4")
    view.show(without, "grazing", "rk4")
    assert len(view._made["grazing"].curves.data["xs"]) == 0
    assert np.isnan(view._made["drift"].curves.data["ys"][0]).all()
    assert "No conserved quantity is known" in stability_text(without, "drift", "rk4")
    assert "No tangency" in stability_text(without, "grazing", "rk4")


# Words and columns ---------------------------------------------------------------------------------------------------


def test_the_text_of_the_map_tells_limits_shares_and_what_they_are_held_against(study):
    words = stability_text(study, "map", "rk2")
    for k, name in enumerate(METHODS):
        assert f"{name}: works up to τ = {study.largest_tau.tau[k]:.3g}" in words
        assert study.largest_tau.reason[k] in words
    assert f"Map of rk2, 30 runs: correct sequence of crossings: {study.map.works[1].mean():.0%}" in words
    assert "Taylor method at tolerance 1e-15" in words


def test_a_small_share_is_not_said_to_be_none(study):
    outcome = np.full((2, 25, 25), core.Status.COMPLETED)
    outcome[0, 0, 0] = WRONG_CROSSINGS
    found = replace(
        study.map, outcome=outcome, error=np.zeros((2, 25, 25)), expected=np.full(25, core.Status.COMPLETED)
    )
    words = stability_text(replace(study, map=found), "map", "dmm2")
    assert "correct sequence of crossings: over 99% and wrong number of crossings: under 1%" in words


def test_the_text_of_a_tangency_tells_where_it_is_and_who_misses_it(study):
    words = stability_text(study, "grazing", "dmm2")
    assert "x = -1.5513915128" in words
    assert "dmm2 finds every crossing and no other" in words
    assert "rk2 has a wrong number of crossings at" in words


def test_nobody_finds_every_crossing_where_the_solution_stops(study):
    stopped = replace(study.grazing, expected=np.full((2, 14), -1))
    words = stability_text(replace(study, grazing=stopped), "grazing", "dmm2")
    assert "finds every crossing" not in words
    assert "the solution itself stops" in words


def test_the_text_of_drift_bounds_each_integrator(study):
    words = stability_text(study, "drift", "dmm2")
    assert "20,000 steps of τ = 0.02" in words
    assert words.count("|Δψ| ≤") == 2


@pytest.mark.parametrize(("part", "rows"), [("largest_tau", 2), ("map", 60), ("drift", None), ("grazing", 56)])
def test_columns_are_of_one_length_and_hold_every_run(study, part, rows):
    table = stability_tables(study, part)[part]()
    lengths = {len(column) for column in table.values()}
    assert lengths == {rows or 2 * len(study.drift.t)}
    assert set(table["integrator"]) == set(METHODS)


def test_rows_of_the_map_are_its_cells(study):
    table = stability_tables(study, "map")["map"]()
    for n in (0, 17, 59):
        k = METHODS.index(table["integrator"][n])
        i, j = (
            int(np.argmin(np.abs(a - b[n])))
            for a, b in ((study.map.taus, table["tau"]), (study.map.values, table["x"]))
        )
        assert table["crossings"][n] == study.map.crossings[k, i, j]
        assert table["as_the_solution"][n] == study.map.works[k, i, j]
