"""What a run returns."""

import copy

import numpy as np
import pytest
import sympy

import core
from core import Status


def test_conserved_error_is_measured_from_where_each_side_was_entered():
    system = core.CATALOGUE["elliptic_curve"]
    run = core.integrate(system, (0.0, 10.0), tau=0.05, method="rk2")
    error = run.conserved_error()
    assert error.shape == (len(run.t), 1)
    for k in (0, 30, len(run.t) - 1):
        side = int(run.side[k])
        last = np.flatnonzero(run.crossings.t <= run.t[k])
        entered = run.crossings.x[last[-1]] if len(last) else run.x[0]
        expected = system.conserved(side, run.t[k], run.x[k]) - system.conserved(side, 0.0, entered)
        assert error[k] == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize("system", ["rigid_body", "damped_oscillator", "predator_prey", "bouncing_ball"])
def test_conserved_error_agrees_with_a_sum_of_fifty_digits(system):
    system = core.CATALOGUE[system]
    run = core.integrate(system, (0.0, 3.0), tau=0.05, method="rk4")
    names = [*system.laws.x, sympy.Symbol("t"), *system.laws.p]
    psi = {side: system.laws.modes[side].conserved for side in (-1, 1)}

    def exact(side, t, x):
        values = [sympy.Float(float(v), 50) for v in (*x, t, *system.parameter_array)]
        return [e.xreplace(dict(zip(names, values, strict=True))).evalf(50) for e in psi[side]]

    error = run.conserved_error(exits=False)
    for k in range(0, len(run.t), 7):
        side, s = int(run.side[k]), int(run.segment[k])
        here, there = exact(side, run.t[k], run.x[k]), exact(side, run.entered_t[s], run.entered_x[s])
        for found, a, b in zip(error[k], here, there, strict=True):
            assert found == pytest.approx(float(a - b), rel=1e-9, abs=1e-28)


def test_a_side_with_fewer_conserved_quantities_leaves_nan():
    system = core.PiecewiseSystem("half", ("x", "y"), ("y", "-x"), ("y", "-x - y/5"), "y",
                                  ("x**2 + y**2",), (), x0=(1.0, 0.0))  # fmt: skip
    run = core.integrate(system, (0.0, 10.0), tau=0.01)
    error = run.conserved_error()[:, 0]
    assert np.isnan(error[run.side == 1]).all()
    assert np.nanmax(np.abs(error[run.side == -1])) < 1e-14


@pytest.mark.parametrize("status", [s for s in Status if s not in (Status.RUNNING, Status.COMPLETED, Status.CANCELLED)])
def test_every_stop_has_a_reason_and_advice(status):
    assert status.reason
    assert status.advice.endswith(".")


def test_crossings_can_be_cut_short():
    run = core.integrate(core.CATALOGUE["elliptic_curve"], (0.0, 10.0))
    assert len(run.crossings.first(3)) == 3
    assert (run.crossings.first(3).x == run.crossings.x[:3]).all()


def every_kind_of_result():
    system = core.CATALOGUE["elliptic_curve"]
    run = core.integrate(system, (0.0, 10.0))
    study = core.stability_study(system, methods="rk2", taus=(0.1, 0.2), values=(-1.0, -0.9), steps=100)
    cost = core.work_precision(system, (0.0, 2.0), methods="rk2", settings={"rk2": (0.1,)}, peers=())
    order = core.order_study(system, (0.1, 0.05), crossings=(1,))
    return [system, run, run.crossings, run.crossings[0], order, cost, cost.curves[0], study, study.largest_tau,
            study.map, study.drift, study.grazing, core.diagnose(run), core.METHODS["dmm2"],
            core.reference_solution(system), system.parameters[0], run.status]  # fmt: skip


def test_whatever_the_library_returns_can_be_compared_hashed_and_shown_in_a_line():
    for result in every_kind_of_result():
        again = copy.copy(result)
        assert result == result
        assert (result == again) in (True, False)
        assert result in [again, result]
        assert isinstance(hash(result), int)
        for text in (repr(result), str(result)):
            assert "\n" not in text
            assert len(text) < 500, text


def test_a_run_says_in_a_line_what_it_is():
    run = core.integrate(core.CATALOGUE["elliptic_curve"], (0.0, 10.0))
    for fact in ("Elliptic curve", "dmm2", "tau = 0.01", "0 … 10", "states: 1001", "crossings: 10", "COMPLETED"):
        assert fact in repr(run)
    assert repr(run.crossings).startswith("<Crossings: 10, t = 0.975")
    assert "tolerance = 1e-09" in repr(core.integrate("elliptic_curve", (0.0, 1.0), method="taylor", tolerance=1e-9))


def test_crossings_are_a_sequence():
    crossings = core.integrate(core.CATALOGUE["elliptic_curve"], (0.0, 10.0)).crossings
    assert len(list(crossings)) == len(crossings) == 10
    for k, hit in enumerate(crossings):
        assert (hit.t, hit.side, hit.kind, hit.g) == (
            crossings.t[k], crossings.side[k], crossings.kind[k], crossings.g[k]
        )  # fmt: skip
        assert (hit.x == crossings.x[k]).all()
        assert [type(v) for v in (hit.t, hit.side, hit.kind)] == [float, int, str]
    assert crossings[-1].t == crossings.t[-1]
    assert crossings[np.int64(2)].t == crossings.t[2]
    assert crossings[2:5].t.tolist() == crossings.t[2:5].tolist()
    assert set(crossings[crossings.side == 1].side) == {1}
    assert crossings[[3, 1]].t.tolist() == crossings.t[[3, 1]].tolist()
    assert [hit.t for hit in reversed(crossings)] == crossings.t[::-1].tolist()
    with pytest.raises(IndexError):
        crossings[10]


def test_columns_are_what_data_frames_take():
    run = core.integrate(core.CATALOGUE["rigid_body"], (0.0, 3.0), tau=0.1)
    columns = run.columns()
    names = list(run.system.variables)
    assert list(columns) == ["t", *names, "side", "psi error 1", "psi error 2"]
    assert all(column.shape == run.t.shape for column in columns.values())
    assert (columns[names[1]] == run.x[:, 1]).all()
    hits = run.crossings.columns(run.system.variables)
    assert {"t", *names, *(f"{name} after" for name in names), "side", "kind"} <= set(hits)
    assert all(column.shape == run.crossings.t.shape for column in hits.values())
    assert list(run.crossings.columns())[1] == "x0"
    with pytest.raises(ValueError, match="3 names are needed"):
        run.crossings.columns(("x",))


def test_a_variable_keeps_its_column_where_it_is_named_like_another():
    system = core.PiecewiseSystem("names", ("side", "g"), ("g", "-side"), ("g", "-side"), "side", x0=(1.0, 0.0))
    run = core.integrate(system, (0.0, 2.0), tau=0.1)
    assert (run.columns()["side"] == run.x[:, 0]).all()
    assert (run.columns()["side_"] == run.side).all()
    assert (run.crossings.columns(system.variables)["g"] == run.crossings.x[:, 1]).all()


def test_a_run_that_stops_after_a_jump_has_no_error_of_psi_from_before_it():
    system = core.PiecewiseSystem(
        "caught", ("x", "y"), ("1", "0"), ("-1", "0"), "x", ("y",), ("y",), x0=(1.0, 0.0), jump=("0", "y + 1")
    )
    for record in ("steps", "crossings", "end"):
        run = core.integrate(system, (0.0, 3.0), tau=0.1, record=record)
        assert run.status is Status.SLIDING
        assert run.x[-1].tolist() == [0.0, 1.0]
        assert np.nanmax(np.abs(run.conserved_error())) < 1e-15


def test_the_size_of_psi_is_that_of_its_terms_and_not_of_their_difference():
    psi = ("x**2 - y**2",)
    hyperbola = core.PiecewiseSystem("saddle", ("x", "y"), ("y", "x"), ("y", "x"), "x - 1e9", psi, psi, x0=(1e4, 1e4))
    run = core.integrate(hyperbola, (0.0, 1e-3), tau=1e-3)
    assert run.psi_size() == pytest.approx(2 * (run.x**2).sum(axis=1).max(), rel=1e-12)


def test_without_a_conserved_quantity_there_is_no_change_and_no_size_of_it():
    run = core.integrate("relay_feedback", (0.0, 1.0), tau=1e-2, method="rk2")
    assert run.psi_size() == 0.0
    assert np.isnan(run.change_of_psi()).all()


def test_of_several_conserved_quantities_the_change_is_the_largest():
    run = core.integrate("kepler", (0.0, 20.0), tau=1e-2, method="rk2")
    assert run.accumulated_error().shape[1] == 2
    assert np.array_equal(run.change_of_psi(), np.abs(run.accumulated_error()).max(axis=1))


def test_a_crossing_at_which_a_run_stops_is_not_passed():
    run = core.integrate("coulomb_friction", (0.0, 20.0), tau=1e-2)
    assert run.status is Status.SLIDING
    assert len(run.crossings.passed) == len(run.crossings) - 1


@pytest.mark.parametrize(
    "wanted",
    [lambda run: run.tally, lambda run: run.accumulated_error(), lambda run: run.change_of_psi()],
    ids=["tally", "accumulated_error", "change_of_psi"],
)
def test_what_needs_the_crossings_is_refused_of_a_run_that_has_not_kept_them(wanted):
    run = core.integrate("harmonic_oscillator", (0.0, 20.0), record="end")
    assert run.crossing_count > 0
    with pytest.raises(ValueError, match=rf"0 of its {run.crossing_count} crossings: integrate with record="):
        wanted(run)
