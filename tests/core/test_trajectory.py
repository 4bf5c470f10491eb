"""What a run returns."""

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
    psi = {side: system.laws.sides[side].conserved for side in (-1, 1)}

    def exact(side, t, x):
        values = [sympy.Float(float(v), 50) for v in (*x, t, *system.parameter_array)]
        return [e.xreplace(dict(zip(names, values, strict=True))).evalf(50) for e in psi[side]]

    error = run.conserved_error()
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
