"""Order plots draw what a study says, with its fits."""

import numpy as np
import pytest

from pwsviz.figures.order import OrderView, Row, fitted_line, order_tables, state_rows, time_rows
from pwsviz.results.requests import study_inputs
from pwsviz.results.results import Results
from pwsviz.scene.scene import Scene


def test_order_plot_has_a_curve_and_a_fit_for_each_number_of_crossings():
    study = Results().study(study_inputs(Scene()))
    for rows, count in ((state_rows(study), 4), (time_rows(study), 3)):
        view = OrderView("error")
        view.show(study.taus, rows, study.floor, 2)
        assert len(view.curves.data["xs"]) == len(view.fits.data["xs"]) == count
        assert view.floor.ticker.ticks == [study.floor]
        assert all("slope 2.0" in label or "slope 1.9" in label for label in view.curves.data["label"])


def test_the_tables_hold_every_curve_and_fit_that_is_drawn():
    study = Results().study(study_inputs(Scene(methods=["rk2"])))
    for rows, errors, slopes in (
        (state_rows(study), study.state_error, study.state_slope),
        (time_rows(study), study.time_error, study.time_slope),
    ):
        tables = {name: table() for name, table in order_tables(study, rows).items()}
        assert tables["errors"]["error"].tolist() == pytest.approx(errors.ravel().tolist(), nan_ok=True, rel=0)
        assert tables["errors"]["tau"].reshape(len(rows), -1).tolist() == [study.taus.tolist()] * len(rows)
        assert tables["fits"]["slope"].tolist() == slopes.tolist()
        assert {name: len(set(map(len, table.values()))) for name, table in tables.items()} == {"errors": 1, "fits": 1}
        assert set(tables["errors"]["integrator"]) == {"rk2"}


def test_the_axes_end_where_the_data_do():
    taus = np.geomspace(1e-4, 1e-1, 10)
    error = np.where(taus < 1e-3, np.nan, taus**2)
    view = OrderView("error", "|t|")
    view.show(taus, [Row("x", "x", error, 2.0, (1e-3, 1e-1))], 1e-7, 2)
    assert view.corners.data["x"] == [taus[taus >= 1e-3].min(), taus.max()]
    assert all(guide.min() >= view.corners.data["x"][0] for guide in view.guides.data["xs"])
    assert view.figure.yaxis[0].axis_label == "error, |t|"


def test_missing_errors_leave_gaps_and_no_fit():
    taus = np.array([0.1, 0.05, 0.025])
    row = Row("late", "late", np.array([np.nan, np.nan, 1e-3]), np.nan, (np.nan, np.nan))
    view = OrderView("error")
    view.show(taus, [row], 1e-14, 2)
    assert np.isfinite(view.curves.data["ys"][0]).tolist() == [False, False, True]
    assert len(view.points.data["x"]) == 1
    assert view.fits.data["xs"] == []
    assert view.curves.data["label"] == ["late: no slope"]


def test_the_fitted_line_goes_through_a_power_law():
    taus = np.geomspace(1e-4, 1e-1, 10)
    ends, heights = fitted_line(taus, Row("x", "x", 5 * taus**3, 3.0, (1e-3, 1e-2)))
    assert np.allclose(heights, 5 * ends**3)
    assert 1e-3 <= ends[0] < ends[1] <= 1e-2 * (1 + 1e-9)
