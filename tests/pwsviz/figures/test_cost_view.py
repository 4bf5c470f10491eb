"""The work-precision diagram draws what the study holds, and says it in words."""

import math
from dataclasses import replace

import numpy as np
import pytest

import core
from core.interface import processor
from core.studies.cost import CANCELLED, DONE, WAITING, CostCurve, WorkPrecision
from pwsviz.figures.cost import EXTERNAL_LINES, CostView, cost_details, cost_numbers, cost_rows, cost_text, timed_how
from pwsviz.figures.cost_text import missing_text, settings_text, shows_round_off
from pwsviz.figures.lines import line_of
from pwsviz.figures.style import BELOW_RANGE

FLOOR = {"state": 1e-14, "time": 1e-13, "invariant": 1e-15}


def curve(name, seconds, state, **changes):
    m = len(seconds)
    given = {
        "name": name,
        "title": {"scipy": "SciPy DOP853"}.get(name, name),
        "peer": name in EXTERNAL_LINES,
        "setting_name": "tolerance" if name in (*EXTERNAL_LINES, "taylor") else "tau",
        "setting": np.geomspace(0.1, 0.01, m),
        "seconds": np.array(seconds),
        "evaluations": 1e6 * np.array(seconds),
        "state_error": np.array(state),
        "time_error": 2 * np.array(state),
        "invariant_error": np.full(m, 1e-16),
        "crossings": np.full(m, 8.0),
        "status": (DONE,) * m,
        "compile_seconds": 0.25,
        "correct_sequence": np.full(m, True),
    }
    return CostCurve(**{**given, **changes})


MET = core.Tally(8)


def study(*curves, met=MET):
    return WorkPrecision((0.0, 20.0), curves, met, "exact (linear flow)", FLOOR, 3)


DMM2 = curve("dmm2", [1e-4, 1e-3, 1e-2], [1e-2, 1e-4, 1e-7])
SCIPY = curve("scipy", [1e-2, 2e-2, 3e-2], [1e-4, 1e-8, 1e-10])
BOTH = study(DMM2, SCIPY)


@pytest.mark.parametrize("across", ["seconds", "evaluations"])
@pytest.mark.parametrize("up", ["state", "time", "invariant"])
def test_every_curve_stands_where_the_study_has_it(across, up):
    view = CostView()
    view.show(BOTH, across, up)
    for k, one in enumerate(BOTH.curves):
        assert np.array_equal(view.curves.data["xs"][k], getattr(one, across))
        assert np.array_equal(view.curves.data["ys"][k], getattr(one, f"{up}_error"))
    assert view.points.data["x"] == [*getattr(DMM2, across), *getattr(SCIPY, across)]
    assert view.levels.ticker.ticks[0] == FLOOR[up]


def test_the_axes_are_named_by_what_stands_on_them_and_nothing_is_built_anew():
    view = CostView()
    models = set(view.figure.references())
    labels = set()
    for across, up in (("seconds", "state"), ("evaluations", "time"), ("seconds", "invariant")):
        view.show(BOTH, across, up)
        labels.add((view.figure.xaxis[0].axis_label, view.figure.yaxis[0].axis_label))
    assert labels == {
        ("run time (s)", "state error at the end, ‖x − x*‖₂"),
        ("evaluations of the field", "error of the last crossing time, |t* − t̂|"),
        ("run time (s)", "largest |Δψ|"),
    }
    assert set(view.figure.references()) == models


def test_the_axis_of_errors_goes_down_to_round_off_only_where_that_is_near():
    view = CostView()
    ends = {}
    for up in ("state", "invariant"):
        view.show(study(DMM2), "seconds", up)
        ends[up] = view.corners.data["y"]
    assert ends["state"] == [1e-7, 1e-2]
    assert ends["invariant"] == [1e-16, pytest.approx(1e-15)]
    exact = curve("dmm2", [1e-4, 1e-3], [1e-2, 0.0])
    view.show(study(exact), "seconds", "state")
    assert view.corners.data["y"][0] < FLOOR["state"], "an error of 0 is drawn below round-off"


def test_integrators_look_as_everywhere_and_peers_like_none_of_them():
    view = CostView()
    view.show(BOTH, "seconds", "state")
    assert view.curves.data["colour"][0] == line_of("dmm2").colour
    assert view.curves.data["dash"] == [list(line_of("dmm2").dash), list(EXTERNAL_LINES["scipy"].dash)]
    looks = [*map(line_of, core.METHODS), *EXTERNAL_LINES.values()]
    assert len({line.dash for line in looks}) == len({line.marker for line in looks}) == len(looks)
    assert len({line.colour for line in looks}) == len(looks)


def test_what_is_missing_is_a_gap_and_has_no_point():
    gap = curve("rk4", [1e-4, math.nan, 1e-2], [1e-2, math.nan, 1e-7])
    view = CostView()
    view.show(study(gap), "seconds", "state")
    assert np.isnan(view.curves.data["ys"][0]).tolist() == np.isnan(view.curves.data["xs"][0]).tolist()
    assert np.isnan(view.curves.data["ys"][0]).tolist() == [False, True, False]
    assert view.points.data["y"] == [1e-2, 1e-7]


def test_a_curve_without_a_point_is_not_in_the_legend():
    silent = curve("heyoka", [1e-3], [1e-3], evaluations=np.array([math.nan]))
    view = CostView()
    view.show(study(DMM2, silent), "evaluations", "state")
    assert view.curves.data["label"] == ["dmm2"]
    view.show(study(DMM2, silent), "seconds", "state")
    assert view.curves.data["label"] == ["dmm2", "heyoka"]


def test_errors_of_zero_and_below_the_plot_are_marked_on_its_lower_end_and_told_as_they_are():
    view = CostView()
    faint = curve("prk8", [1e-4, 1e-3, 1e-2], [1e-5, 1e-20, 0.0])
    view.show(study(faint), "seconds", "state")
    level, bottom = view.levels.ticker.ticks
    assert (level, view.points.data["x"], view.below.data["x"]) == (FLOOR["state"], [1e-4], [1e-3, 1e-2])
    assert view.below.data["y"] == [bottom, bottom]
    assert np.isnan(view.curves.data["xs"][0]).tolist() == [False, True, True], "no line joins what is not measured"
    assert view.below.data["error"] == ["1.0×10⁻²⁰", "0"]
    assert view.corners.data["y"][0] < bottom < level
    assert view.levels.names.args["names"][1] == BELOW_RANGE
    told = "Errors of 0 or below the plot’s range, drawn as downward triangles: prk8, τ = 0.0316 and 1 other value."
    assert told in cost_details(study(faint), "seconds", "state")
    view.show(BOTH, "seconds", "state")
    assert view.levels.ticker.ticks[1] < 1e-99
    assert not view.below.data["x"]
    assert "downward" not in cost_details(BOTH, "seconds", "state")


def test_the_setting_is_told_on_a_point():
    view = CostView()
    view.show(BOTH, "seconds", "state")
    assert view.points.data["setting"][0] == "τ = 0.1"
    assert view.points.data["setting"][-1] == "tolerance = 0.01"
    assert view.points.data["cost"][0] == "0.1 ms"
    view.show(BOTH, "evaluations", "state")
    assert view.points.data["cost"][0] == "100 evaluations"


def test_a_caption_tells_between_which_settings_the_points_lie():
    assert settings_text(BOTH) == "step sizes from 0.01 to 0.1 (dmm2); tolerances from 0.01 to 0.1 (SciPy DOP853)"
    assert settings_text(study(DMM2)) == "step sizes from 0.01 to 0.1 (dmm2)"
    failed = replace(DMM2, seconds=np.array([np.nan, 1e-3, 1e-2]))
    assert settings_text(study(failed)) == "step sizes from 0.01 to 0.0316 (dmm2)", (
        "a run that did not end is not drawn"
    )


def test_a_run_without_a_point_is_told_with_its_reason_and_one_that_is_still_to_come_is_not():
    seconds, status = np.array([np.nan, np.nan, 1e-2]), ("the numerical solution blows up", WAITING, DONE)
    assert missing_text(BOTH) == ""
    told = missing_text(study(replace(DMM2, seconds=seconds, status=status)))
    assert told == "; no point: dmm2 with τ = 0.1 (the numerical solution blows up)"


def test_round_off_is_explained_only_where_errors_come_near_it():
    assert not shows_round_off(BOTH, "state")
    assert shows_round_off(study(curve("dmm2", [1e-4, 1e-3], [1e-4, 2 * FLOOR["state"]])), "state")


def test_a_study_with_nothing_in_it_yet_can_be_drawn():
    nothing = curve("dmm2", [math.nan], [math.nan], status=(WAITING,), compile_seconds=math.nan)
    view = CostView()
    view.show(study(nothing), "seconds", "state")
    assert view.points.data["x"] == []
    assert "no run has reached the end" in cost_text(study(nothing), "seconds", "state")
    assert cost_numbers(study(nothing), "seconds", "state").rows == ()


def test_rows_hold_everything_once():
    rows = cost_rows(BOTH)
    assert {len(column) for column in rows.values()} == {6}
    assert list(rows["integrator"]) == ["dmm2"] * 3 + ["SciPy DOP853"] * 3
    assert list(rows["setting_name"]) == ["tau"] * 3 + ["tolerance"] * 3
    assert list(rows["state_error"]) == [1e-2, 1e-4, 1e-7, 1e-4, 1e-8, 1e-10]
    assert set(rows["compile_seconds"]) == {0.25}
    assert set(rows["outcome"]) == {DONE}


def test_the_table_names_the_cheapest_of_ours_and_of_the_external_solvers():
    table = cost_numbers(study(DMM2, curve("dmm4", [2e-3], [1e-4]), SCIPY), "seconds", "state")
    assert table.rows == (
        ("10⁻³", "dmm2, τ = 0.0316", "1\u00a0ms", "SciPy DOP853, tolerance = 0.1", "10\u00a0ms"),
        ("10⁻⁶", "dmm2, τ = 0.01", "10\u00a0ms", "SciPy DOP853, tolerance = 0.0316", "20\u00a0ms"),
        ("10⁻⁹", "–", "–", "SciPy DOP853, tolerance = 0.01", "30\u00a0ms"),
    )
    words = cost_details(BOTH, "seconds", "state")
    assert "a curve may level off above that" in words
    assert "Compile/load time (not included): dmm2 250 ms and SciPy DOP853 250 ms" in words
    assert "exact (linear flow)" in words


def test_times_that_differ_by_no_more_than_noise_are_a_tie_and_counts_are_not():
    near = study(curve("dmm2", [1e-4], [1e-4]), curve("dmm4", [1.4e-4], [1e-4]), curve("rk4", [1.6e-4], [1e-4]))
    best = cost_numbers(near, "seconds", "state").rows[0][1:3]
    assert best == ("dmm2, τ = 0.1 or dmm4, τ = 0.1", "0.1\u00a0ms or 0.14\u00a0ms")
    assert cost_numbers(near, "evaluations", "state").rows[0][1] == "dmm2, τ = 0.1"
    assert "up to 1.5 times slower" in cost_numbers(near, "seconds", "state").caption
    assert "as long" not in cost_numbers(near, "evaluations", "state").caption


def test_words_say_what_a_run_time_is_where_it_was_measured_and_whose_field_is_not_compiled():
    how = "processor time of one thread, excluding compilation (the shortest of 3 runs)"
    measured = f"Run time is the {how[:-1]}; {processor()})"
    slow = "SciPy DOP853 evaluates the field in Python, whereas the others use compiled code"
    assert f"{measured}; {slow}" in timed_how(BOTH)
    assert f"{slow}." in cost_text(BOTH, "seconds", "state")
    assert slow not in cost_text(BOTH, "evaluations", "state")
    assert f"{measured}. " in cost_details(study(DMM2, curve("heyoka", [1e-3], [1e-3])), "seconds", "state")
    assert "Run time" not in cost_details(BOTH, "evaluations", "state")


def test_a_run_with_other_crossings_never_wins_and_is_drawn_hollow():
    wrong = curve("rk2", [1e-9, 1e-2], [1e-12, 1e-3], correct_sequence=np.array([False, True]))
    table = cost_numbers(study(DMM2, wrong), "seconds", "state")
    assert [row[1] for row in table.rows] == ["dmm2, τ = 0.0316", "dmm2, τ = 0.01", "–"]
    view = CostView()
    view.show(study(DMM2, wrong), "seconds", "state")
    assert (view.wrong.data["x"], view.wrong.data["label"]) == ([1e-9], ["rk2"])
    assert 1e-9 not in view.points.data["x"]
    assert 1e-9 not in view.curves.data["xs"][-1], "no line joins it to those of the right runs"
    assert view.figure.legend[0].items[1].visible
    view.show(BOTH, "seconds", "state")
    assert not view.figure.legend[0].items[1].visible


def test_evaluations_are_counted_where_these_are_shown():
    silent = curve("heyoka", [1e-9], [1e-12], evaluations=np.array([math.nan]))
    table = cost_numbers(study(DMM2, silent), "evaluations", "state")
    assert table.rows[0] == ("10⁻³", "dmm2, τ = 0.0316", "1,000", "–", "–")
    assert "heyoka does not count its evaluations." in cost_details(study(DMM2, silent), "evaluations", "state")


def test_words_say_what_is_missing_and_why():
    late = curve(
        "rk4", [1e-3] + [math.nan] * 2, [1e-3] + [math.nan] * 2, status=(DONE, "takes too long", "takes too long")
    )
    gone = curve("heyoka", [math.nan], [math.nan], status=("heyoka is not installed",))
    off = curve("rk2", [1e-3], [1.0], status=("7 crossings instead of 8",), correct_sequence=np.array([False]))
    rest = curve("dmm4", [math.nan] * 2, [math.nan] * 2, status=(WAITING, CANCELLED))
    words = cost_text(study(late, gone, off, rest), "seconds", "state")
    assert "rk4, τ = 0.0316 and 1 other value: takes too long." in words
    assert "heyoka: heyoka is not installed." in words
    assert "rk2: the sequence of crossings differs from that of the solution, which has 8 crossings (open sy" in words
    assert "1 setting not measured yet." in words
    assert "1 setting cancelled." in words


def test_words_say_why_there_is_no_error_of_psi_or_of_a_crossing():
    bare = curve("rk4", [1e-3], [1e-3], invariant_error=np.array([math.nan]), time_error=np.array([math.nan]))
    assert "no conserved quantity is known" in cost_text(study(bare), "seconds", "invariant")
    assert "there is no crossing" in cost_text(study(bare, met=core.Tally()), "seconds", "time")


def test_a_real_study_is_drawn_and_told():
    real = core.work_precision(
        core.CATALOGUE["harmonic_oscillator"], (0.0, 10.0), methods=("taylor",), settings={"taylor": (1e-6, 1e-12)},
        repeats=1,
    )  # fmt: skip
    view = CostView()
    view.show(real, "seconds", "state")
    assert view.curves.data["label"] == ["taylor", "SciPy DOP853"]
    assert cost_numbers(real, "seconds", "state").rows[2][1].startswith("taylor, tolerance = ")
