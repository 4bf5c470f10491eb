"""Order plots draw what a study says, with its fits."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import linregress

import core
from core.studies import FIT_ABOVE
from pwsviz.figures.conserved import NOWHERE
from pwsviz.figures.lines import line_of
from pwsviz.figures.order import (
    OrderView,
    Row,
    Studied,
    compared_with,
    exact_text,
    fitted_line,
    guide_slopes,
    order_numbers,
    order_tables,
    state_rows,
    studied,
    time_rows,
)
from pwsviz.figures.style import BELOW_RANGE, FAINT
from pwsviz.figures.summaries import fit_rule, slopes_text, study_text
from pwsviz.results.requests import study_inputs
from pwsviz.results.results import Results
from pwsviz.scene.scene import Scene
from pwsviz.text.words import rounded


def test_order_plot_has_a_curve_and_a_fit_for_each_number_of_crossings():
    studies = Results().studies(study_inputs(Scene()))
    for rows, count in ((state_rows, 4), (time_rows, 3)):
        view = OrderView("error")
        view.show(studied(studies, rows))
        assert len(view.curves.data["xs"]) == len(view.fits.data["xs"]) == count
        above = [row.fit_above for row in rows(studies[0])]
        assert view.floor.ticker.ticks == [min(above), NOWHERE, NOWHERE], "limits are alike, and no error is below"
        assert all("slope 2.0" in label or "slope 1.9" in label for label in view.curves.data["label"])


def test_a_crossing_has_one_look_in_the_plots_of_states_and_of_times():
    studies = Results().studies(study_inputs(Scene()))
    plots, look = [], line_of(studies[0].method)
    for rows in (state_rows, time_rows):
        view = OrderView("error")
        view.show(studied(studies, rows))
        names = ("colour", "dash", "marker")
        assert {tuple(map(str, row)) for row in zip(*(view.curves.data[name] for name in names), strict=True)} == {
            (look.colour, str(list(look.dash)), look.marker)
        }, "it is that of the integrator"
        plots.append(list(view.curves.data["filling"]))
    states, times = plots
    assert states[1:] == times
    assert states == sorted(set(states)) == [0.0, *states[1:]], "the more crossings, the fuller are the marks"


def test_the_tables_hold_every_curve_and_fit_that_is_drawn():
    (study,) = Results().studies(study_inputs(Scene(methods=["rk2"])))
    for curves, errors, slopes in (
        (state_rows, study.state_error, study.state_slope),
        (time_rows, study.time_error, study.time_slope),
    ):
        rows = curves(study)
        tables = {name: table() for name, table in order_tables(studied([study], curves)).items()}
        assert tables["errors"]["error"].tolist() == pytest.approx(errors.ravel().tolist(), nan_ok=True, rel=0)
        assert tables["errors"]["tau"].reshape(len(rows), -1).tolist() == [study.taus.tolist()] * len(rows)
        assert tables["fits"]["slope"].tolist() == slopes.tolist()
        assert {name: len(set(map(len, table.values()))) for name, table in tables.items()} == {"errors": 1, "fits": 1}
        assert set(tables["errors"]["integrator"]) == {"rk2"}


def one_curve(taus, row, floor):
    return Studied("rk2", 2, taus, [replace(row, fit_above=floor)], "exact")


def test_several_integrators_have_their_own_looks_and_their_slopes_in_a_table():
    scene = Scene(methods=["dmm2", "rk4", "taylor"], order_all=True)
    results, told = Results(), []
    results.studies(study_inputs(Scene(methods=["rk4"])))
    studies = results.studies(study_inputs(scene), report=lambda *news: told.append(news))
    assert results.computed["study"] == 2, "what is studied already is not studied again"
    assert [(done, total) for done, total, _ in told] == [(k, 42) for k in range(1, 22)], "dmm2 comes first"
    assert [one.method for one in studies] == ["dmm2", "rk4"], "taylor has no order"
    view, shown = OrderView("error"), studied(studies, time_rows)
    view.show(shown)
    assert [label.partition(": slope")[0] for label in view.curves.data["label"]] == ["dmm2"] * 3 + ["rk4"] * 3
    row = shown[0].rows[0]
    for slopes, label in (
        ((2.0, 2.0), "dmm2: slope 2.00"),
        ((2.11, np.nan, 1.98), "dmm2: slopes 1.98 to 2.11"),
        ((np.nan,), "dmm2"),
    ):
        assert shown[0]._replace(rows=[replace(row, slope=slope) for slope in slopes]).label == label
    assert view.curves.data["colour"] == [line_of(name).colour for name in ["dmm2"] * 3 + ["rk4"] * 3]
    assert set(view.points.data["marker"]) == {line_of(name).marker for name in ("dmm2", "rk4")}
    assert len(set(view.points.data["filling"])) == len(set(view.points.data["label"])) == 3
    assert set(view.curves.data["filling"]) == {1.0}, "in the legend, where a key stands for all curves of one"
    assert view.guide_names.data["text"] == ["slope 2", "slope 4"]
    (table,) = order_numbers(shown)
    assert [row[:2] for row in table.rows] == [("dmm2", "2"), ("rk4", "4")]
    assert [float(row[2]) for row in table.rows] == pytest.approx([2, 4], abs=0.15)
    errors = order_tables(shown)["errors"]()
    assert list(dict.fromkeys(errors["integrator"])) == ["dmm2", "rk4"]
    assert len(errors["error"]) == 6 * len(studies[0].taus)
    view.show(shown[:1])
    assert view.curves.data["label"][0].startswith("crossing 10: slope")
    assert order_numbers(shown[:1]) == []


def test_an_integrator_that_cannot_be_studied_leaves_the_others(monkeypatch):
    whole = core.order_study

    def study(*args, **options):
        if options["method"] == "rk2":
            raise ValueError("too few")
        return whole(*args, **options)

    monkeypatch.setattr(core, "order_study", study)
    scene = Scene(methods=["dmm2", "rk2"], order_all=True)
    assert [one.method for one in Results().studies(study_inputs(scene))] == ["dmm2"]
    with pytest.raises(ValueError, match="too few"):
        Results().studies(study_inputs(Scene(methods=["rk2"])))


def test_the_axes_end_where_the_data_do():
    taus = np.geomspace(1e-4, 1e-1, 10)
    error = np.where(taus < 1e-3, np.nan, taus**2)
    view = OrderView("error", "|t|")
    view.show([one_curve(taus, Row("x", "x", error, 2.0, (1e-3, 1e-1)), 1e-7)])
    assert view.corners.data["x"] == [taus[taus >= 1e-3].min(), taus.max()]
    assert all(guide.min() >= view.corners.data["x"][0] for guide in view.guides.data["xs"])
    assert view.figure.yaxis[0].axis_label == "error, |t|"


@pytest.mark.parametrize(("floor", "end"), [(1e-14, 1e-6), (1e-7, 1e-7)])
def test_the_axis_of_errors_goes_down_to_round_off_only_where_that_is_near(floor, end):
    taus = np.geomspace(1e-3, 1e-1, 10)
    view = OrderView("error")
    view.show([one_curve(taus, Row("x", "x", taus**2, 2.0, (1e-3, 1e-1)), floor)])
    assert view.corners.data["y"] == pytest.approx([end, 2e-2])
    assert min(guide.min() for guide in view.guides.data["ys"]) >= end * (1 - 1e-9)


def test_errors_far_below_round_off_are_drawn_at_the_lower_end_and_stretch_no_axis():
    taus, floor = np.geomspace(0.1, 0.001, 6), 5e-14
    error = np.array([1e-2, 1e-6, 1e-10, 1e-14, 1e-19, 0.0])
    view, exact = OrderView("error"), Row("y", "y", np.zeros(6), np.nan, (np.nan, np.nan), floor)
    shown = one_curve(taus, Row("x", "x", error, 2.0, (0.01, 0.1)), floor)
    view.show([shown._replace(rows=[*shown.rows, exact])])
    end = floor / FIT_ABOVE / FAINT
    assert view.points.data["y"].tolist() == [*error[:4], end, end], "a curve of zeros has no points"
    assert [marker == "inverted_triangle" for marker in view.points.data["marker"]] == [False] * 4 + [True] * 2
    assert np.isnan(view.curves.data["ys"][0]).tolist() == [False] * 4 + [True] * 2, "no line leads there"
    assert view.corners.data["y"][0] == end / 2
    assert (view.floor.ticker.ticks[2], view.floor.names.args["names"][2]) == (end, BELOW_RANGE)
    assert "Errors of 0 or below the plot’s range are drawn as downward triangles" in study_text([shown], early=False)
    assert order_tables([shown])["errors"]()["error"].tolist() == error.tolist(), "numbers are told as they are"


def test_missing_errors_leave_gaps_and_no_fit():
    taus = np.array([0.1, 0.05, 0.025])
    row = Row("late", "late", np.array([np.nan, np.nan, 1e-3]), np.nan, (np.nan, np.nan))
    view = OrderView("error")
    view.show([one_curve(taus, row, 1e-14)])
    assert np.isfinite(view.curves.data["ys"][0]).tolist() == [False, False, True]
    assert len(view.points.data["x"]) == 1
    assert view.fits.data["xs"] == []
    assert view.curves.data["label"] == ["late: no slope"]


def test_of_errors_that_are_round_off_no_slopes_are_drawn_and_of_none_no_key():
    taus = np.array([0.1, 0.05, 0.025])
    flat = Row("after", "after", np.array([3e-16, 4e-16, 3e-16]), np.nan, (np.nan, np.nan))
    none = Row("before", "before", np.zeros(3), np.nan, (np.nan, np.nan))
    view = OrderView("error")
    view.show([Studied("rk2", 2, taus, [replace(row, fit_above=1e-14) for row in (none, flat)], "exact")])
    assert view.curves.data["label"] == ["after: no slope"]
    assert view.guides.data["xs"] == list(view.guide_names.data["text"]) == []
    assert not view._fit.visible
    view.show([one_curve(taus, Row("x", "x", taus**2, 2.0, (0.025, 0.1)), 1e-14)])
    assert view._fit.visible
    assert view.guide_names.data["text"] == ["slope 2"]


def test_errors_above_the_painted_line_are_those_that_a_fit_may_use():
    taus = np.geomspace(0.1, 0.01, 6)
    flat = Row("after", "after", np.linspace(8e-12, 1e-11, 6), np.nan, (np.nan, np.nan))
    exact = core.order_study(core.CATALOGUE["harmonic_oscillator"], taus, crossings=(1,))
    later = state_rows(exact)[1]
    lower = "(50 times accumulated round-off or the error of the reference, whichever is larger)"
    upper = "(0.3 times the largest |xᵢ| of the reference at these times)"
    for row, words in (
        (
            replace(flat, fit_above=3.5e-11, fit_below=0.7),
            f"errors lie between 3.5×10⁻¹¹ {lower} and 0.7 {upper}.",
        ),
        (later, f"to errors between {rounded(later.fit_above)} {lower} and {rounded(exact.fit_below)} {upper}."),
        (
            replace(later, window=(later.window[0], float(taus[2]))),
            f"{upper}. Only step sizes below the one at which the local slope changes are fitted.",
        ),
    ):
        view, (shown,) = OrderView("error"), studied([exact], lambda _, row=row: [row])
        view.show([shown])
        line = view.floor.ticker.ticks[0]
        assert words in study_text([shown], early=False)
        assert (row.error > line).any() == np.isfinite(row.slope)


def test_where_round_off_grows_the_least_and_the_greatest_limit_of_a_fit_are_told_and_drawn():
    taus, names = np.geomspace(0.1, 0.01, 6), ("before", "after 9", "after 20")
    for above, marked in (
        ((1e-13, 3e-11, 2e-9), {1e-13: "fits above:\nbefore", 2e-9: "fits above:\nafter 20"}),
        ((1e-13, 3e-13, 2e-13), {1e-13: "fits above"}),
    ):
        rows = [Row(name, name, taus**2, 2.0, (0.01, 0.1), limit) for name, limit in zip(names, above, strict=True)]
        view, shown = OrderView("error"), Studied("rk2", 2, taus, rows, "exact")
        view.show([shown])
        seen = dict(zip(view.floor.ticker.ticks, view.floor.names.args["names"], strict=True))
        seen.pop(NOWHERE)
        assert seen == marked, "each line has a name"
        told = study_text([shown], early=False)
        assert (
            f"fits to errors above a limit between {rounded(min(above))} and {rounded(max(above))}, depending on the "
            "curve (50 times accumulated"
        ) in told


def test_why_a_curve_has_no_slope_is_said_of_each_reason():
    taus, none = np.array([0.1, 0.05, 0.025]), (np.nan, (np.nan, np.nan))
    fitted = Row("after 9", "after 9", taus**2, 2.0, (0.025, 0.1))
    exact = Row("before", "before", np.zeros(3), *none, at_round_off=True)
    few = Row("after 20", "after 20", np.array([1.0, 0.1, 0.01]), *none)
    never = Row("after 30", "after 30", np.full(3, np.nan), *none)
    at_round_off = "all errors are near round-off, of the run or of the reference."
    words = study_text([Studied("rk2", 2, taus, [exact, fitted, few, never], "exact")], early=False)
    assert f"No slope is fitted before, as {at_round_off}" in words
    assert "No slope is fitted after 20, as too few errors lie between these limits." in words
    assert "No slope is fitted after 30, as no error is known." in words
    assert f"No slope is fitted, as {at_round_off}" in study_text([Studied("rk2", 2, taus, [exact], "exact")], False)
    both = study_text([Studied(name, 2, taus, [exact, fitted, few], "exact") for name in ("rk2", "dmm2")], early=False)
    assert "No slope is fitted to rk2 after 20 and to dmm2 after 20, as too few errors" in both
    assert "The errors of rk2 before and of dmm2 before are 0 and are not drawn." in both


def test_the_method_of_second_order_is_at_round_off_on_a_parabola():
    study = core.order_study("bouncing_ball", [0.1, 0.05, 0.025, 0.0125], crossings=(1, 2))
    assert np.isnan([*study.state_slope, *study.time_slope]).all()
    assert all(row.at_round_off for row in (*state_rows(study), *time_rows(study)))


def test_the_fitted_line_goes_through_a_power_law():
    taus = np.geomspace(1e-4, 1e-1, 10)
    ends, heights = fitted_line(taus, Row("x", "x", 5 * taus**3, 3.0, (1e-3, 1e-2)))
    assert np.allclose(heights, 5 * ends**3)
    assert 1e-3 <= ends[0] < ends[1] <= 1e-2 * (1 + 1e-9)


def test_the_slope_of_scattered_errors_has_its_standard_error_as_statistics_gives_it():
    taus = 0.1 * 2.0 ** -np.arange(0, 8, 0.5)
    for transition, scattered in (("mannshardt", False), ("none", True)):
        rows = state_rows(core.order_study("elliptic_curve", taus, transition=transition))
        assert [("±" in row.slope_text) for row in rows] == [False, *3 * [scattered]]
        row = rows[2]
        used = (taus >= row.window[0] * (1 - 1e-9)) & (taus <= row.window[1] * (1 + 1e-9))
        fit = linregress(np.log(taus[used]), np.log(row.error[used]))
        assert (row.slope, row.spread) == pytest.approx((fit.slope, fit.stderr), rel=1e-6)


def test_no_line_is_drawn_through_errors_that_scatter_about_it_and_that_is_said():
    taus = 0.1 * 2.0 ** -np.arange(0, 8, 0.5)
    rows = state_rows(core.order_study("harmonic_oscillator", taus, transition="none"))
    assert [row.is_off for row in rows] == [False, True, True, True]
    assert [fitted_line(taus, row) is None for row in rows] == [False, True, True, True]
    words = fit_rule([Studied("dmm2", 2, taus, rows, "exact")])
    assert "No line is drawn after 10 crossings, after 20 crossings and after 30 crossings, as the errors scat" in words


@pytest.mark.parametrize("slope", [1, 2, 6])
def test_lines_of_slopes_lie_apart_from_curves_that_are_about_as_steep_and_within_the_axes(slope):
    taus = np.geomspace(0.1, 1e-3, 12)
    error = np.minimum(0.5 * (taus / 0.02) ** slope, 0.5)  # it levels off where step sizes are large
    view = OrderView("error")
    row = Row("after", "after", error, float(slope), (1e-3, 0.019), 1e-14)
    view.show([Studied("rk2", slope, taus, [row], "exact")])
    names = view.guide_names.data["text"]
    for name, x, y in zip(names, view.guides.data["xs"], view.guides.data["ys"], strict=True):
        steep = int(name.removeprefix("slope "))
        assert np.log(y[1] / y[0]) / np.log(x[1] / x[0]) == pytest.approx(steep)
        assert y[1] <= view.corners.data["y"][1]
        beside = (taus <= 0.019) & (taus >= x[0])
        if steep == slope:
            assert (y[0] * (taus / x[0]) ** slope >= 2 * error * (1 - 1e-9))[beside].all()


def test_slopes_that_agree_are_told_once_with_where_they_were_measured():
    taus, alike = np.logspace(-3, -1, 5), (2.0, (1e-3, 1e-1))
    early = Row("before the first crossing", "before", taus**2, *alike)
    late = [Row(f"after {k} crossings", f"after {k}", taus**2, *alike, crossing=k) for k in (10, 20)]
    off = Row("after 30 crossings", "after 30", taus, 1.0, (1e-3, 1e-1), crossing=30)
    said = slopes_text([Studied("dmm2", 2, taus, [early, *late, off], "exact")])
    assert (
        said
        == "dmm2: slope 2.00 before the first crossing and after 10 and 20 crossings; slope 1.00 after 30 crossings."
    )
    times = [Row(f"crossing {k}", f"crossing {k}", taus**2, *alike, crossing=k) for k in (1, 2)]
    assert slopes_text([Studied("rk2", 2, taus, times[:1], "exact")]) == "rk2: slope 2.00 for crossing 1."
    assert slopes_text([Studied("rk2", 2, taus, times, "exact")]) == "rk2: slope 2.00 for crossings 1 and 2."
    once = Row("after 1 crossing", "after 1", taus**2, *alike, crossing=1)
    assert slopes_text([Studied("rk2", 2, taus, [once], "exact")]) == "rk2: slope 2.00 after 1 crossing."


def test_guides_have_the_orders_and_the_slopes_that_are_met_and_no_others():
    taus = np.logspace(-3, -1, 5)
    rows = [Row("x", "x", taus, slope, (1e-3, 1e-1)) for slope in (0.98, 2.02, np.nan)]
    assert guide_slopes([Studied("rk4", 4, taus, rows, "exact")]) == [1, 2, 4]
    assert guide_slopes([Studied("rk2", 2, taus, rows[1:], "exact")]) == [2]


def test_an_integrator_at_round_off_is_called_exact_only_beside_an_exact_solution():
    taus = np.array([0.1, 0.05, 0.025])
    row = Row("after 9", "after 9", np.full(3, 1e-16), np.nan, (np.nan, np.nan), at_round_off=True)
    known = Studied("dmm2", 2, taus, [row], "exact (linear flow)")
    assert exact_text([known]) == "dmm2 is exact to round-off here: no slope to fit."
    assert exact_text([known, known._replace(method="rk2")], drawn=False) == (
        "dmm2 and rk2 are exact to round-off for every τ: no error to draw."
    )
    assert exact_text([known._replace(reference="power series (linear flow), error 1.0e-12")]) == ""
    assert exact_text([known._replace(rows=[row, replace(row, at_round_off=False)])]) == ""


def test_of_a_curve_of_zeros_with_gaps_neither_triangles_nor_gaps_are_told():
    taus = np.array([0.1, 0.05, 0.025])
    none = np.nan, (np.nan, np.nan)
    early = Row("before", "before", np.array([np.nan, 0.0, 0.0]), *none, at_round_off=True)
    later = Row("after 9", "after 9", np.full(3, 3e-16), *none, at_round_off=True)
    shown = Studied("dmm2", 2, taus, [early, later], "exact (linear flow)")
    view = OrderView("error")
    view.show([shown])
    assert view.points.data["marker"].tolist() == ["circle"] * 3
    told = study_text([shown], early=False)
    assert "The errors before are 0 and are not drawn" in told
    assert not {"triangles", "missing"} & set(told.replace(".", "").split())


def test_the_reference_of_a_study_is_named_once_as_exact():
    assert compared_with("exact (Weierstrass ℘)") == "the exact solution (Weierstrass ℘)"
    assert compared_with("dop853, error 1e-12") == "the reference (dop853, error 1e-12)"
