"""No drift: round-off does not add up, in steps or in crossings."""

import mpmath as mp
import numpy as np
import pytest

import core
from core.integration.run_settings import Settings
from core.integration.runner import Runner
from tests.core.frames import levels

ELLIPTIC = core.CATALOGUE["elliptic_curve"]
EPS = np.finfo(float).eps
CONSERVATIVE = [m.name for m in core.METHODS.values() if m.conservative]


def runner(method, tau=0.1):
    chosen = core.METHODS[method]
    settings = Settings(np.inf, 1e-9) if chosen.adaptive else Settings(tau)
    return Runner(ELLIPTIC, chosen, 0.0, ELLIPTIC.x0, settings)


@pytest.mark.parametrize("method", CONSERVATIVE)
def test_levels_of_psi_are_exact_to_double_double_after_a_thousand_crossings(method):
    # psi is 0 outside the circle, and x* = 2 cos(4 pi/7) inside: for ever, but for round-off.
    run = runner(method)
    run.advance(1000.0, keep_hits=False)
    assert run.crossing_count > 1000
    with mp.workdps(40):
        exact = mp.mpf(0) if run.mode == 1 else 2 * mp.cos(4 * mp.pi / 7)
        (level,) = levels(run)
        # Every landing rounds at 2⁻¹⁰⁶ or so of terms up to 3.
        assert abs(level - exact) <= run.crossing_count * 8 * mp.mpf(2) ** -106 * 3


@pytest.mark.parametrize(("method", "t_end"), [("dmm2", 2e4), ("prk8", 2e4), ("taylor", 2e4), ("dmm4", 5e3)])
def test_psi_does_not_drift_in_ten_thousand_crossings(method, t_end):
    # Steps that round by 3 eps each would have wandered by a thousand eps; what is seen is one step's rounding.
    tau = None if core.METHODS[method].adaptive else 0.1
    run = core.integrate(ELLIPTIC, (0.0, t_end), tau=tau, method=method, record="end", envelope=10)
    assert run.crossing_count > 5000
    assert np.abs(run.envelope).max() <= 4 * EPS
    last = ELLIPTIC.conserved(run.side[-1], run.t[-1], run.x[-1])[0]
    exact = 0.0 if run.side[-1] > 0 else float(2 * mp.cos(4 * mp.pi / 7))
    assert abs(last - exact) <= 8 * EPS * 3  # rounding of the state and of psi itself


@pytest.mark.parametrize(("method", "steps"), [("dmm2", 10**6), ("dmm4", 10**6), ("dmm8", 10**5), ("prk8", 10**6)])
def test_psi_does_not_drift_where_no_crossing_sets_it_right(method, steps):
    # Measured: 0.7 eps at most. Without the correction of each step: dmm2 48, dmm4 511, dmm8 63 eps.
    one_side = (ELLIPTIC.f_plus, ELLIPTIC.f_plus, "x - 10", ELLIPTIC.psi_plus, ELLIPTIC.psi_plus, ELLIPTIC.parameters)
    system = core.PiecewiseSystem("smooth", ("x", "y"), *one_side, (-1.0, -0.5))
    run = core.integrate(system, (0.0, 0.1 * steps), tau=0.1, method=method, record="end", envelope=10)
    assert (run.crossing_count, run.steps) == (0, steps)
    assert np.abs(run.envelope).max() <= 4 * EPS  # one step's rounding of terms up to 3


def test_a_correction_that_is_small_by_chance_does_not_end_newtons_loop():
    # Steps of nearly a turn: in the ninth, the second of Newton's corrections is small, and the third was left out.
    run = core.integrate(core.CATALOGUE["pendulum"], (0.0, 20.0), x0=(1.5870064853819477, 0.0), tau=1.4570923537052198)
    assert run.status is core.Status.COMPLETED
    # One step's rounding of terms up to 13, and half an ulp of q = -78 times the force of 3.7. It was 12000 eps.
    assert np.abs(run.conserved_error()).max() <= (4 * 13 + 32 * 3.7) * EPS


def test_the_envelope_is_the_error_of_the_recorded_run():
    arguments = {"tau": 1e-2, "method": "rk4"}
    run = core.integrate(ELLIPTIC, (0.0, 50.0), **arguments)
    error = run.conserved_error()[1:, 0]
    kept = core.integrate(ELLIPTIC, (0.0, 50.0), record="end", envelope=5, **arguments).envelope
    columns = np.minimum((run.t[1:] / 10.0).astype(int), 4)
    for k in range(5):
        inside = error[columns == k]
        # Rounding of psi, with terms up to 3; a step at the border may be counted on either side.
        assert kept[k, 0] == pytest.approx([inside.min(), inside.max()], abs=1e-9)
    assert core.integrate(ELLIPTIC, (0.0, 1.0)).envelope is None


def test_sides_with_fewer_conserved_quantities_leave_the_envelope_to_the_other():
    system = core.PiecewiseSystem(
        "half", ("x", "y"), ("y", "-x"), ("y", "-x - y/10"), "x", ("x**2 + y**2",), (), x0=(1.0, 1.0)
    )
    envelope = core.integrate(system, (0.0, 20.0), tau=0.01, method="rk2", envelope=4).envelope
    assert envelope.shape == (4, 1, 2)
    assert np.isfinite(envelope).all()
    with pytest.raises(ValueError, match="envelope"):
        core.integrate(system, (0.0, 1.0), method="rk2", envelope=0)
