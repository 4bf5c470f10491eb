"""The order study: the slopes that the theorem promises, against exact solutions."""

import numpy as np
import pytest

import core
from core.studies import order
from tests.levels import deep_but

SYSTEMS = [core.CATALOGUE["harmonic_oscillator"], core.CATALOGUE["elliptic_curve"]]
by_name = pytest.mark.parametrize("system", SYSTEMS, ids=lambda s: s.name)

# Errors from about 1e-2 down to 1e-9 and above: far from round-off (1e-13) and, with p = 1, from the method's own.
WINDOWS = {None: (3e-2, 1e-4), 1: (3e-3, 1e-5), 2: (3e-2, 1e-4), 3: (3e-2, 1e-4)}
ORDERS = {None: 2.0, 1: 1.0, 2: 2.0, 3: 2.0}


@by_name
@pytest.mark.parametrize("p", ORDERS)
def test_order_two_survives_thirty_crossings_unless_the_crossing_time_is_worse(system, p):
    study = core.order_study(system, np.geomspace(*WINDOWS[p], 9), perturbation_order=p)
    assert study.time_slope == pytest.approx([ORDERS[p]] * 3, abs=0.1)
    assert study.state_slope[1:] == pytest.approx([ORDERS[p]] * 3, abs=0.1)
    assert study.state_slope[0] == pytest.approx(2.0, abs=0.1)  # before the first crossing, p changes nothing
    assert "exact" in study.reference
    assert study.window[1:, 0] == pytest.approx([study.taus.min()] * 3)


@by_name
@pytest.mark.parametrize(("method", "coarsest", "finest"), [("rk2", 1e-2, 1e-4), ("rk4", 2e-2, 1e-3)])
def test_runge_kutta_methods_keep_their_order_too(system, method, coarsest, finest):
    # After more crossings the drift of psi, of the next order, shows at every step size above round-off.
    study = core.order_study(system, np.geomspace(coarsest, finest, 9), method=method, crossings=(5, 10))
    expected = core.METHODS[method].order
    assert study.state_slope == pytest.approx([expected] * 3, abs=0.1)
    assert study.time_slope == pytest.approx([expected] * 2, abs=0.1)


def test_without_a_further_crossing_states_are_compared_at_a_given_time():
    system = core.PiecewiseSystem("Once", ("x",), ("-x",), ("-2*x",), "t - 1", x0=(1.0,))
    taus = 2.0 ** -np.arange(4.0, 9.0)
    study = core.order_study(system, taus, method="rk2", crossings=(1,), until=2.0)
    assert study.times.tolist() == [0.5, 2.0]
    assert study.state_slope == pytest.approx([2.0, 2.0], abs=0.1)
    before = core.order_study(system, taus, method="rk2", crossings=(), until=0.5)
    assert before.times.tolist() == [0.5]
    assert np.array_equal(before.state_error, study.state_error[:1])
    assert "crossings none" in repr(before)
    for crossings, until, why in (
        ((), 2.0, "has 1 crossings until then, not 0"), ((1,), 0.5, "has 0 crossings until then, not 1"),
        ((), 0.0, "a time after t0"), ((), None, "increasing numbers from 1 are needed"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=why):
            core.order_study(system, taus, method="rk2", crossings=crossings, until=until)


def test_the_fit_leaves_out_step_sizes_that_are_not_yet_asymptotic():
    # Halving the error of a step size at a time is slope 1 from 0.1 down; above it the error is flat.
    taus = np.array([0.8, 0.4, 0.2, 0.1, 0.05, 0.025, 0.0125])
    errors = np.array([[0.1, 0.1, 0.1, 0.1, 0.05, 0.025, 0.0125], np.full(7, 1e-15)])
    slopes, windows = order._fits(taus, errors, np.full(2, 1e-14), size=1.0)
    assert slopes[0] == pytest.approx(1.0)
    assert windows[0].tolist() == [0.0125, 0.1]
    assert np.isnan(slopes[1])  # nothing but round-off


@by_name
@pytest.mark.parametrize(
    ("method", "coarsest", "finest"),
    [("dmm4", 1e-1, 3e-3), ("dmm6", 1.5e-1, 1e-2), ("dmm8", 2.5e-1, 4e-2), ("prk8", 3e-1, 4e-2)],
)
def test_conservative_methods_of_high_order_keep_it_across_crossings(system, method, coarsest, finest):
    # Errors from 1e-3 to 1e-12. High orders leave so short a window that their next term still shows: 0.2.
    study = core.order_study(system, np.geomspace(coarsest, finest, 9), method=method)
    expected = core.METHODS[method].order
    assert study.time_slope == pytest.approx([expected] * 3, abs=0.2)
    assert study.state_slope[1:] == pytest.approx([expected] * 3, abs=0.2)


def test_rk8_keeps_order_eight_where_its_drift_does_not_hide_it():
    # On the elliptic curve the drift of psi, of order nine, is all there is to see above round-off.
    study = core.order_study(SYSTEMS[0], np.geomspace(3e-1, 8e-2, 9), method="rk8")
    assert study.time_slope == pytest.approx([8.0] * 3, abs=0.2)
    assert study.state_slope[1:] == pytest.approx([8.0] * 3, abs=0.2)


@pytest.mark.parametrize(
    ("name", "method", "coarsest", "finest"),
    [
        ("rigid_body", "dmm2", 3e-2, 1e-3),
        pytest.param("rigid_body", "dmm6", 2e-1, 3e-2, marks=pytest.mark.deep),
        ("predator_prey", "dmm4", 1e-1, 1e-2),
        ("damped_oscillator", "dmm2", 3e-2, 1e-3),
        pytest.param("predator_prey", "prk8", 3e-1, 8e-2, marks=pytest.mark.deep),
        pytest.param("pendulum", "prk8", 3e-1, 5e-2, marks=pytest.mark.deep),
    ],
)
def test_order_survives_in_three_dimensions_with_logarithms_and_with_time_in_psi(name, method, coarsest, finest):
    study = core.order_study(core.CATALOGUE[name], np.geomspace(coarsest, finest, 9), method=method)
    assert study.state_slope[1:] == pytest.approx([core.METHODS[method].order] * 3, abs=0.2)


@pytest.mark.parametrize(
    ("name", "method", "coarsest", "finest"),
    deep_but(
        ["pendulum"],
        [
            ("pendulum", "dmm6", 0.35, 8e-3),
            ("pendulum", "dmm8", 0.6, 2e-2),
            ("rigid_body", "dmm8", 0.6, 2e-2),
            ("rigid_body", "prk8", 0.6, 2e-2),
            ("kepler", "dmm8", 0.6, 2e-2),
            ("kepler", "prk8", 0.6, 2e-2),
            ("damped_oscillator", "dmm8", 0.6, 2e-2),
        ],
    ),
)
def test_high_orders_show_from_the_catalogues_starts_from_coarse_steps_to_round_off(name, method, coarsest, finest):
    # Step sizes from far too coarse to far too fine: the fit finds the range between, here as in the benchmark.
    study = core.order_study(core.CATALOGUE[name], np.geomspace(coarsest, finest, 33), method=method)
    expected = core.METHODS[method].order
    assert study.time_slope == pytest.approx([expected] * 3, abs=0.2)
    assert study.state_slope[1:] == pytest.approx([expected] * 3, abs=0.2)


def test_a_method_that_chooses_its_steps_has_no_order_to_study():
    with pytest.raises(ValueError, match="no order to study"):
        core.order_study(SYSTEMS[0], [1e-2, 1e-3], method="taylor")


def test_a_state_that_fewer_than_four_steps_lead_to_says_nothing_of_the_order():
    study = core.order_study(core.CATALOGUE["rigid_body"], [0.2, 0.1, 0.05], crossings=(1,))
    assert np.isnan(study.state_error[0, :2]).all()  # compared at t = 0.333
    assert np.isfinite(study.state_error[0, 2])


def test_where_slopes_still_change_the_finest_of_them_count():
    # A coefficient that changes sign at 0.1: the finest step sizes, up to twice the least, have slopes about 5.84.
    taus = np.geomspace(0.5, 0.01, 40)
    errors = taus**6 * np.abs(1 - taus / 0.1)
    (slope,), (window,) = order._fits(taus, errors[None], np.array([1e-16]), size=1.0)
    assert slope == pytest.approx(6 - 0.014 / (0.1 - 0.014), abs=0.03)  # d log e / d log τ in the middle
    assert window[0] == taus.min()
    assert 0.018 < window[1] < 0.024


def test_where_slopes_scatter_all_points_count():
    taus = np.geomspace(1e-1, 1e-3, 30)
    errors = taus * np.where(np.arange(30) % 2, 3.0, 0.3)
    (slope,), (window,) = order._fits(taus, errors[None], np.array([1e-16]), size=10.0)
    assert slope == pytest.approx(1.0, abs=0.1)
    assert window == pytest.approx([1e-3, 1e-1])


@by_name
def test_without_a_transition_the_order_falls_to_one(system):
    # Irregular, as it depends on where in the step the surface lies: the mean over many step sizes is of order 1.
    study = core.order_study(system, np.geomspace(1e-2, 3e-5, 24), method="rk4", transition="none")
    assert study.state_slope[1:] == pytest.approx([1.0] * 3, abs=0.35)


def test_study_agrees_with_runs_of_integrate():
    system, tau = SYSTEMS[1], 2e-3
    study = core.order_study(system, [tau, tau / 2], crossings=(10,))
    run = core.integrate(system, (0.0, 12.0), tau=tau)
    assert study.time_error[0, 0] == pytest.approx(abs(run.crossings.t[9] - 9.190964308338805836), abs=1e-12)


def test_shapes_are_as_documented():
    study = core.order_study(SYSTEMS[0], [1e-2, 5e-3, 2e-3], crossings=(1, 2))
    assert study.time_error.shape == (2, 3)
    assert study.state_error.shape == (3, 3)
    assert study.time_slope.shape == (2,)
    assert study.state_slope.shape == (3,)
    assert study.window.shape == (3, 2)


def test_a_typed_system_with_a_closed_form_is_measured_exactly():
    system = core.PiecewiseSystem("Typed", ("q", "v"), ("v", "-2*q"), ("v", "-q/2"), "q - 0.1",
                                  ("v**2 + 2*q**2",), ("2*v**2 + q**2",), x0=(1.0, 0.0))  # fmt: skip
    study = core.order_study(system, np.geomspace(1e-2, 1e-3, 5), crossings=(4,))
    assert "exact" in study.reference
    assert study.state_slope == pytest.approx([2.0, 2.0], abs=0.1)


def test_any_other_system_is_measured_against_the_taylor_method():
    system = core.PiecewiseSystem("Duffing", ("q", "v"), ("v", "-q - q**3"), ("v", "-2*q - q**3"), "q", x0=(1.0, 0.0))
    study = core.order_study(system, np.geomspace(3e-2, 3e-3, 5), crossings=(5,))
    assert "Taylor" in study.reference
    assert study.state_slope == pytest.approx([2.0, 2.0], abs=0.1)
    assert study.time_slope == pytest.approx([2.0], abs=0.1)


def test_trajectories_with_too_few_crossings_are_refused_in_words():
    with pytest.raises(ValueError, match="but none is known"):
        core.order_study(SYSTEMS[1], [1e-2, 1e-3], x0=(2.0, 3.0))


@pytest.mark.parametrize(
    "change",
    [
        {"taus": [1e-2]},
        {"taus": [1e-2, 1e-2]},
        {"taus": [1e-2, -1e-3]},
        {"crossings": ()},
        {"crossings": (3, 2)},
        {"method": "x"},
    ],
)
def test_arguments_that_make_no_sense_are_refused(change):
    with pytest.raises(ValueError, match=r"."):
        core.order_study(**{"system": SYSTEMS[0], "taus": [1e-2, 1e-3], **change})


def test_cancelling_leaves_the_rest_out():
    study = core.order_study(SYSTEMS[0], [1e-2, 1e-3], cancel=lambda: True)
    assert np.isnan(study.state_error).all()


def test_progress_tells_the_study_so_far_after_each_step_size():
    seen = []
    study = core.order_study(SYSTEMS[0], [1e-2, 5e-3, 2.5e-3], crossings=(3,), progress=lambda *told: seen.append(told))
    assert [(done, total) for done, total, _ in seen] == [(1, 3), (2, 3), (3, 3)]
    assert [int(np.isfinite(partial.state_error[0]).sum()) for *_, partial in seen] == [1, 2, 3]
    np.testing.assert_array_equal(seen[-1][2].state_error, study.state_error)


def test_errors_of_a_fit_lie_between_its_limits():
    study = core.order_study(SYSTEMS[0], np.geomspace(1.0, 1e-3, 16), method="rk2", crossings=(1, 10))
    for errors, windows, limits, below in (
        (study.state_error, study.window, study.fit_above, study.fit_below),
        (study.time_error, study.time_window, study.time_fit_above, study.time_fit_below),
    ):
        assert (errors >= below).any(), "else the limit is not put to the test"
        for row, (least, greatest), above in zip(errors, windows, limits, strict=True):
            used = row[(study.taus >= least) & (study.taus <= greatest)]
            assert above < used.min() <= used.max() < below


# On its solution z = x; beside it, z − x grows at the rate r, and with it the round-off.
GROWING = core.PiecewiseSystem(
    "Growing", ("x", "y", "z"), ("y", "-k*x", "r*(z - x) + y"), ("y", "-l*x", "r*(z - x) + y"), "x - 1/10",
    ("k*x**2 + y**2",), ("l*x**2 + y**2",), x0=(1.0, 0.0, 1.0),
    parameters=(core.Parameter("k", 1.0), core.Parameter("l", 2.0), core.Parameter("r", 0.5)),
)  # fmt: skip
# The coarsest of these steps are short enough for the leading term of the error: only round-off can change a slope.
FITTED = {"rk2": 2.0 ** -np.arange(5, 12, 0.5), "rk4": 2.0 ** -np.arange(3.5, 11, 0.5)}
FITTED |= {"dmm2": FITTED["rk2"], "gauss4": FITTED["rk4"], "dmm4": FITTED["rk4"]}


def growing(draws, count, rates):
    for k, rng in enumerate(draws(count)):
        method = tuple(FITTED)[k % len(FITTED)]
        system = GROWING.with_parameters(k=rng.uniform(0.5, 2), l=rng.uniform(0.5, 2), r=rng.uniform(*rates))
        yield method, system, core.order_study(system, FITTED[method], method=method, crossings=(4, 8, 12))


def test_round_off_that_grows_along_the_orbit_does_not_enter_a_slope(draws):
    for method, system, study in growing(draws, 15, (0.3, 0.9)):
        slopes = np.append(study.state_slope, study.time_slope)
        known, expected = np.isfinite(slopes), core.METHODS[method].order
        assert slopes[known] == pytest.approx(expected, abs=0.1), (method, system.parameter_array)
        assert known[[0, 1]].all(), "round-off has not grown much yet"


def test_where_round_off_does_not_grow_no_slope_is_lost(draws):
    for method, system, study in growing(draws, 15, (-0.5, 0.0)):
        slopes = np.append(study.state_slope, study.time_slope)
        assert slopes == pytest.approx(core.METHODS[method].order, abs=0.1), (method, system.parameter_array)
        assert study.floor.max() < 64 * np.finfo(float).eps * study.size


def test_a_chaotic_orbit_shows_the_order_after_thirty_crossings():
    study = core.order_study("chua", 2.0 ** -np.arange(5, 13.5, 0.5), method="rk4")
    assert study.state_slope == pytest.approx([4.0] * 4, abs=0.1)
    assert study.time_slope == pytest.approx([4.0] * 3, abs=0.1)
    assert study.floor[-1] > 1e4 * study.floor[0]


def test_errors_below_those_that_a_fit_may_use_are_called_round_off_though_round_off_has_grown():
    """The ball flies along parabolas, which dmm2 follows exactly; the table multiplies each rounding."""
    study = core.order_study(core.CATALOGUE["vibrating_table"], np.geomspace(1e-1, 1e-3, 7), method="dmm2")
    assert study.state_error[-1].max() > study.floor[-1], "it is more than one rounding makes of the orbit"
    assert study.at_round_off.all()
    assert np.isnan(study.state_slope).all()
