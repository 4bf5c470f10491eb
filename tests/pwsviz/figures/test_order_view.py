"""Order plots draw what a study says, with its fits."""

import numpy as np

from pwsviz.figures.order import OrderView, Row, fitted_line, state_rows, time_rows
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
