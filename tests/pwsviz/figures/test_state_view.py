"""The plot of the state has a panel for each coordinate, and marks what the run does."""

import numpy as np

import core
from pwsviz.figures.state import MOST_PANELS, WIDEST, StateView, state_text
from pwsviz.geometry.plane import XY
from pwsviz.results.states import state_curves


def shown(system="kepler", methods=("dmm2",), view=None, t_end=20.0, tau=0.01):
    view = view or StateView()
    system = core.CATALOGUE[system] if isinstance(system, str) else system
    runs = [core.integrate(system, (0.0, t_end), tau=tau, method=method) for method in methods]
    curves = [state_curves(run) for run in runs]
    view.show(curves, system.variables, runs[0], XY.points(runs[0].crossings.x))
    return view, curves, runs[0]


def test_each_coordinate_has_a_panel_with_a_curve_for_each_integrator():
    view, curves, _ = shown(methods=("dmm2", "rk2"))
    assert [panel.figure.yaxis.axis_label for panel in view.panels] == ["x", "y", "u", "v"]
    for k, panel in enumerate(view.panels):
        assert panel.curves.data["method"] == ["dmm2", "rk2"]
        np.testing.assert_array_equal(panel.curves.data["ys"][1], curves[1].curves[k][1])
        assert panel.figure.legend.visible == (k == 3), "one legend is enough"


def test_crossings_are_marked_on_the_curves_and_sides_shaded_as_in_the_run():
    view, _, run = shown()
    marks = view.shared.instants.data
    np.testing.assert_array_equal(marks["t"], run.crossings.t)
    for k in range(4):
        np.testing.assert_array_equal(marks[f"state{k}"], run.crossings.x[:, k])
    for side, source in view.shared.segments.items():
        middles = 0.5 * (np.array(source.data["start"]) + np.array(source.data["end"]))
        assert all(run.side[np.searchsorted(run.t, t) - 1] == side for t in middles)
        assert len(middles) > 3 or side not in (-1, 1)


def test_panels_are_used_again_for_a_system_with_fewer_coordinates():
    view, _, _ = shown()
    shown("relay_feedback", methods=("rk2",), view=view)
    assert [panel.figure.yaxis.axis_label for panel in view.panels[:2]] == ["x", "v"]
    assert view.panels[1].figure.legend.visible


def test_a_panel_that_comes_back_has_the_range_of_what_it_shows_then():
    view, _, _ = shown("vibrating_table", methods=("rk2",))
    for panel in view.panels:
        panel.up.update(start=-2.8, end=3.2)  # as the browser reports them
    shown("relay_feedback", methods=("rk2",), view=view)
    shown("gene_switch", methods=("rk2",), view=view)
    # The ends that a model is sent with stay; of a panel that was there all along the browser moves them.
    assert np.isnan([view.panels[2].up.start, view.panels[2].up.end]).all()
    assert view.panels[1].up.start == -2.8


def test_a_run_that_leaves_does_not_flatten_the_first_one():
    view, curves, _ = shown("elliptic_curve", methods=("dmm2", "rk2"), tau=0.6, t_end=60.0)
    size = np.ptp(curves[0].bounds[0])
    assert np.ptp(view.panels[0].corners.data["y"]) <= WIDEST * size * (1 + 1e-12)


def test_a_curve_that_runs_off_ends_some_heights_beyond_its_panel():
    """Of a dashed line that is millions of pixels long browsers draw no dashes."""
    view, curves, _ = shown("elliptic_curve", methods=("dmm2", "rk2"), tau=0.2)
    assert np.abs(curves[1].curves[1][1]).max() > 1e7
    low, high = view.panels[1].corners.data["y"]
    assert np.abs(view.panels[1].curves.data["ys"][1]).max() <= 101 * (high - low)


def test_of_many_coordinates_the_first_are_drawn_and_it_is_said():
    names = tuple(f"z{k}" for k in range(8))
    system = core.PiecewiseSystem("Many", names, ("1",) * 8, ("1",) * 8, "z0 - 1", x0=(0.0,) * 8)
    view, curves, _ = shown(system, methods=("rk2",), t_end=2.0)
    assert len(view.panels) == MOST_PANELS
    assert "first 6 of 8" in state_text(names, curves)


def test_what_is_not_marked_of_a_long_run_is_told():
    # Crossings of the oscillator are π/2 (1 + 1/√3) apart on average, so that 1000 take 1240 units of time.
    view, curves, run = shown("harmonic_oscillator", t_end=1300.0)
    count = len(run.crossings)
    assert abs(count - 1300.0 / (np.pi / 2 * (1 + 1 / np.sqrt(3)))) < 2
    assert len(view.shared.instants.data["t"]) == 400
    told = state_text(run.system.variables, curves, count)
    assert f"the first 400 of {count:,} crossings" in told
    assert "Marked" not in state_text(run.system.variables, curves, 400)


def test_the_range_of_a_run_that_runs_off_begins_where_it_starts_and_ends_where_the_picture_does():
    system = core.PiecewiseSystem("Own", ("x", "y"), ("1", "x**2 + y**2 + 1"), ("1", "x**2 + y**2"), "y", x0=(0, -1))
    view, curves, run = shown(system, methods=("rk2",))
    assert run.status is core.Status.ESCAPED
    x, y = (panel.corners.data["y"] for panel in view.panels)
    assert x[0] < 0.0 < run.t[-1] < x[1], "x = t is drawn whole"
    assert y[0] < -1.0
    assert y[1] < run.x[:, 1].max()
    told = state_text(run.system.variables, curves)
    assert f"x from 0 to {run.t[-1]:.4g}, y from -1, drawn up to y = {y[1]:.4g}." in told


def test_what_is_round_off_of_the_size_of_a_coordinate_is_told_as_zero():
    _, curves, run = shown("bouncing_ball")
    assert 0.0 < abs(curves[0].bounds[0, 0]) < 1e-15, "a bounce takes the ball to the floor but for round-off"
    assert "y from 0 to 1," in state_text(run.system.variables, curves)


def test_dots_at_steps_do_not_hide_the_curve_of_another_integrator():
    view, _, _ = shown(methods=("dmm2", "rk2"), t_end=0.5)
    for panel in view.panels:
        assert len(panel.steps.data["t"]) > 100
        sources = [renderer.data_source for renderer in panel.figure.renderers]
        assert sources.index(panel.steps) < sources.index(panel.curves)
