"""Figures draw what the arrays say, within what an axis can show."""

import numpy as np

from pwsviz.inputs import run_inputs, study_inputs
from pwsviz.plane import Window
from pwsviz.results import Results
from pwsviz.scene import Scene
from pwsviz.views.conserved import FLOOR, ConservedView, drawable
from pwsviz.views.order import OrderView, Row, fitted_line, state_rows, time_rows
from pwsviz.views.portrait import extent


def test_zero_is_drawn_at_the_floor_and_overflow_not_at_all():
    shown = drawable(np.array([0.0, 1e-10, 1e250, np.nan]))
    assert list(shown[:2]) == [FLOOR, 1e-10]
    assert np.isnan(shown[2])
    assert np.isnan(shown[3])


def test_bands_are_the_visits_to_the_minus_side():
    results, scene, view = Results(), Scene(), ConservedView()
    inputs = run_inputs(scene)
    view.show(results.pictures(inputs, with_errors=True).errors)
    run = results.run(inputs[0])
    middles = (np.array(view.visits.data["start"]) + np.array(view.visits.data["end"])) / 2
    assert len(middles) == np.sum(run.crossings.side == -1)
    assert all(run.side[np.searchsorted(run.t, t) - 1] == -1 for t in middles)


def test_sides_are_those_of_the_run_where_it_comes_back_to_the_same():
    results, view = Results(), ConservedView()
    view.show(results.pictures(run_inputs(Scene(system="bouncing_ball")), with_errors=True).errors)
    assert len(view.visits.data["start"]) == 0, "the ball is never below the ground"
    assert len(view.instants.data["t"]) > 10


def test_a_run_with_very_many_crossings_has_no_bands():
    results, view = Results(), ConservedView()
    view.show(results.pictures(run_inputs(Scene(t_end=2000.0, tau=0.05)), with_errors=True).errors)
    assert len(view.visits.data["start"]) == len(view.instants.data["t"]) == 0


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


def test_the_view_holds_the_first_orbit():
    orbits = Results().pictures(run_inputs(Scene()), with_errors=False).orbits
    assert extent(orbits).covers(Window.around(orbits[0].path))
