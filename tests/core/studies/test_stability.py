"""The stability study: limits that theory knows, outcomes, drift and tangencies with closed forms."""

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import fields, is_dataclass
from multiprocessing import get_context

import numpy as np
import pytest

import core
from core.studies.stability import (
    NO_START,
    NOT_YET,
    PARTS,
    UNCERTAIN,
    WENT_ON,
    WRONG_CROSSINGS,
    outcome_words,
    stability_study,
)
from core.studies.stability import verdict as verdicts
from core.studies.stability.verdict import expected_of, judge

ELLIPTIC = core.CATALOGUE["elliptic_curve"]
HARMONIC = core.CATALOGUE["harmonic_oscillator"]


def oscillator(surface: str, x0=(1.0, 0.0)) -> core.PiecewiseSystem:
    """x'' = −x on both sides of a surface."""
    field, energy = ("y", "-x"), ("(x**2 + y**2)/2",)
    return core.PiecewiseSystem("Oscillator", ("x", "y"), field, field, surface, energy, energy, x0=x0)


FAR = oscillator("x - 10")  # a wall that the motion reaches only if its amplitude grows tenfold
SMALL = {"taus": (0.05, 0.5, 1.0), "values": (-1.0, -0.5), "steps": 2000, "tau": 0.05}


#: Lorenz’ equations, with a constant more where x < 0.
LORENZ = core.PiecewiseSystem(
    "Lorenz", ("x", "y", "z"), ("10*(y - x)", "x*(28 - z) - y", "x*y - 8*z/3 + 1"),
    ("10*(y - x)", "x*(28 - z) - y", "x*y - 8*z/3"), "x", x0=(1.0, 1.0, 20.0),
)  # fmt: skip
#: x of the start -> crossings up to t = 20, 30, 35, 40 and 50: by Taylor series in 50 digits (mpmath).
CROSSINGS = {2.24: (13, 18, 21, 26, 31), 1.35: (12, 16, 19, 23, 29), 2.94: (14, 17, 18, 21, 25)}


@pytest.mark.parametrize("x", CROSSINGS)
@pytest.mark.parametrize("k", range(5))
def test_crossings_that_rounding_decides_are_not_taken_for_those_of_the_solution(x, k):
    end = (20.0, 30.0, 35.0, 40.0, 50.0)[k]
    found = stability_study(
        LORENZ, (0.0, end), (x, 1.0, 20.0), ("rk8",), taus=(0.001, 0.002), values=(x, 1.0), parts=("map", "largest_tau")
    )
    limits = found.largest_tau
    known = limits.expected == core.Status.COMPLETED
    assert known or limits.expected == UNCERTAIN
    assert known or end > 30, "errors grow a million times in 15 units of time"
    assert not known or end < 50
    assert not known or limits.expected_crossings == CROSSINGS[x][k]
    assert known or "rounding decides the crossings" in limits.reason[0]
    assert found.map.expected[0 if x < 1.0 else 1] == limits.expected
    assert known or not found.map.works[:, :, 1].any()


# The largest step size -----------------------------------------------------------------------------------------------


def test_rk4_is_stable_on_the_oscillator_up_to_two_root_two():
    # |R(iy)|² = 1 − y⁶/72 + y⁸/576 ≤ 1 for y ≤ 2√2 (Hairer, Wanner II, IV.2)
    study = stability_study(FAR, (0, 2000), methods=("rk4",), taus=(1.0, 2.0, 3.0), parts="largest_tau").largest_tau
    assert study.tau[0] == pytest.approx(2 * np.sqrt(2), rel=0.011)
    assert study.tau[0] < study.beyond[0] <= 1.01 * study.tau[0]
    assert study.reason[0]


def test_the_explicit_midpoint_rule_blows_up_at_the_step_size_that_its_growth_says():
    # |R(iy)|² = 1 + y⁴/4: from 1 to 10 in time T at y with T ln(1 + y⁴/4)/(2y) = ln 10, y = 0.18 for T = 3000.
    span, ladder = 3000.0, np.linspace(0.1, 0.2, 100_001)
    growth = span * np.log1p(ladder**4 / 4) / (2 * ladder)
    limit = ladder[np.searchsorted(growth, np.log(10))]
    study = stability_study(FAR, (0, span), methods=("rk2",), taus=(0.1, 0.3), parts="largest_tau").largest_tau
    assert study.tau[0] == pytest.approx(limit, rel=0.015)
    assert "instead of 0" in study.reason[0]  # it reaches the wall


def test_the_implicit_midpoint_rule_is_stable_at_any_step_size():
    study = stability_study(FAR, (0, 2000), methods=("dmm2",), taus=(1.0, 10.0, 100.0), parts="largest_tau").largest_tau
    assert study.tau[0] == 100.0
    assert np.isnan(study.beyond[0])
    assert not study.found[0], "the largest that was tried is no limit"
    assert study.reason == ("",)


def test_the_limit_separates_step_sizes_that_work_from_one_that_does_not():
    study = stability_study(ELLIPTIC, methods=("dmm2", "rk4"), parts=("largest_tau",)).largest_tau
    exact = core.reference_solution(ELLIPTIC)
    times = np.array([exact.crossing(k)[0] for k in range(1, 25)])
    assert np.count_nonzero(times <= study.horizon) == study.expected_crossings
    for method, tau, beyond in zip(("dmm2", "rk4"), study.tau, study.beyond, strict=True):
        runs = [core.integrate(ELLIPTIC, (0, study.horizon), tau=t, method=method) for t in (tau, beyond)]
        nearest = [np.abs(run.crossings.t[:, None] - times).argmin(axis=1).tolist() for run in runs]
        assert nearest[0] == list(range(study.expected_crossings)) != nearest[1]


def test_a_solution_that_stops_is_expected_to_stop():
    friction = core.CATALOGUE["coulomb_friction"]
    study = stability_study(friction, methods=("dmm2",), taus=(0.01, 0.1), parts="largest_tau").largest_tau
    assert study.expected is core.Status.SLIDING
    assert study.expected_crossings == 3  # turning points at 3, −2.2, 1.4, −0.6; it sticks at −0.2
    assert study.tau[0] == 0.1


# The map -------------------------------------------------------------------------------------------------------------


def test_expected_crossings_are_those_of_the_exact_solution():
    values = np.linspace(-1.4, 0.0, 5)
    found = stability_study(ELLIPTIC, (0, 15), methods=("dmm2",), taus=(0.1, 0.2), values=values, parts="map").map
    for value, count in zip(values, found.expected_crossings, strict=True):
        exact = core.reference_solution(ELLIPTIC, (value, -1.0))
        exact.state(15.0)
        times = np.array([exact.crossing(k)[0] for k in range(1, count + 2)])
        assert np.count_nonzero(times <= 15.0) == count
    assert (found.expected == core.Status.COMPLETED).all()


def test_dmm_keeps_psi_wherever_its_solve_converges():
    found = stability_study(ELLIPTIC, methods=("dmm2",), taus=np.geomspace(0.01, 2, 8), parts="map").map
    converged = found.outcome[0] == core.Status.COMPLETED
    assert 50 < np.count_nonzero(converged) < converged.size  # at large τ it does not
    assert found.error[0][converged].max() < 1e-13


def test_the_map_tells_wrong_numbers_of_crossings_and_blow_up_apart():
    found = stability_study(ELLIPTIC, methods=("rk2",), taus=(0.01, 0.11, 1.0), values=(-1.0, -0.9), parts="map").map
    assert found.works[0, 0].all()
    assert (found.outcome[0, 1] == WRONG_CROSSINGS).all()
    assert (found.outcome[0, 2] == core.Status.ESCAPED).all()
    assert np.isnan(found.error[0, 2]).all()
    for row in (0, 1):
        run = core.integrate(ELLIPTIC, (0, 20), (found.values[0], -1.0), found.taus[row], "rk2")
        assert abs(run.crossing_count - found.crossings[0, row, 0]) <= 1  # judged a little before or after t = 20
    assert found.error[0, 1, 0] > 1e-3 > found.error[0, 0, 0]


def test_errors_of_the_map_add_up_over_crossings():
    # With one ψ for both sides: E_n − E_0 of the explicit midpoint rule, but for shortened steps at crossings.
    found = stability_study(
        oscillator("y"), (0, 50), methods=("rk2",), taus=(0.01, 0.02), values=(1.0, 2.0), parts="map"
    )
    growth = np.expm1(50 / found.map.taus * np.log1p(found.map.taus**4 / 4))
    assert found.map.error[0] == pytest.approx(0.5 * growth[:, None] * found.map.values**2, rel=0.07)


def test_as_many_crossings_at_other_times_are_another_sequence():
    # The implicit midpoint rule turns by 2 atan(τ/2) a step. Where its last crossing, later than t = 55, is more than
    # half the time between two late, it may yet be the last before the end.
    system, taus = oscillator("y", (1.0, 0.5)), np.geomspace(0.05, 1.5, 25)
    found = stability_study(system, (0, 60), methods=("dmm2",), taus=taus, values=(1.0, 2.0), parts="map").map
    late = 55 * (taus / 2 / np.arctan(taus / 2) - 1) > np.pi / 2
    assert ((found.crossings[0] == found.expected_crossings) & late[:, None]).any()
    assert (found.outcome[0][late] == WRONG_CROSSINGS).all()


@pytest.mark.deep
def test_without_a_transition_every_part_steps_over_the_surface():
    options = {"methods": ("rk4",), "steps": 500, "tau": 0.05, "taus": (0.02, 0.2), "values": (-2.2, -1.0, 0.2)}
    located, stepped = (stability_study(ELLIPTIC, transition=how, **options) for how in ("mannshardt", "none"))
    assert (located.largest_tau.reason, stepped.largest_tau.reason) == (("",), ("20 crossings instead of 21",))
    for part in ("map", "drift", "grazing"):
        there, here = getattr(located, part).error, getattr(stepped, part).error
        assert np.isfinite(here).any()
        assert not np.array_equal(there, here, equal_nan=True)


def test_where_nothing_is_defined_the_map_says_so():
    pole = core.PiecewiseSystem("Pole", ("x", "y"), ("1", "1/x"), ("1", "1/x"), "y - 5", x0=(1.0, 0.0))
    found = stability_study(pole, (0, 1), methods=("rk4",), taus=(0.1, 0.2), values=(0.0, 1.0), parts="map").map
    assert found.expected[0] == NO_START
    assert (found.outcome[0, :, 0] == NO_START).all()
    assert found.works.tolist() == [[[False, True], [False, True]]]


def test_a_run_that_goes_on_where_the_solution_stops_is_told():
    friction = core.CATALOGUE["coulomb_friction"]
    found = stability_study(friction, methods=("rk2",), taus=(0.01, 2.0), values=(2.9, 3.0), parts="map").map
    assert (found.outcome[0, 0] == core.Status.SLIDING).all()
    assert (found.outcome[0, 1] != core.Status.SLIDING).all()
    assert WENT_ON in found.outcome[0, 1] or WRONG_CROSSINGS in found.outcome[0, 1]


@pytest.mark.parametrize("name", ["elliptic_curve", "bouncing_ball", "stick_slip", "kepler"])
def test_a_cell_of_the_map_is_what_integrate_gives(name):
    system, taus = core.CATALOGUE[name], (0.01, 0.1, 1.0)
    found = stability_study(system, (0, 9), methods=("rk2",), taus=taus, parts="map", sliding="continue").map
    for column in (0, 9, 18):
        start = (float(found.values[column]), *system.x0[1:])
        try:
            expected = expected_of(system, start, (0.0, 9.0), "continue")
        except ValueError:
            assert (found.outcome[0, :, column] == NO_START).all()
            continue
        for row, tau in enumerate(taus):
            run = core.integrate(system, (0.0, expected.horizon), start, tau, "rk2", sliding="continue")
            error = np.fmax.reduce(run.change_of_psi()[~run.sliding], initial=np.nan)
            error = np.nan if run.status.name in ("ESCAPED", "UNSTABLE") else error
            judged = (WRONG_CROSSINGS, WENT_ON, run.status)
            assert found.outcome[0, row, column] in judged
            assert tuple(found.met[0, row, column].tolist()) == run.tally
            assert np.array_equal(found.error[0, row, column], error, equal_nan=True)


def test_runs_of_the_map_do_without_a_call_of_integrate(monkeypatch):
    called = []
    monkeypatch.setattr(verdicts, "integrate", lambda *a, **b: called.append(a) or core.integrate(*a, **b))
    stability_study(HARMONIC, methods=("dmm2",), taus=(0.01, 0.1, 0.2), values=(1.0, 2.0), parts="map")
    assert len(called) == 2 * 2, "the references of each start"


def test_the_map_is_refined_from_a_coarse_one():
    seen = []
    stability_study(
        HARMONIC, methods=("rk2",), taus=(0.1, 0.2), values=np.linspace(1.0, 2.0, 9), parts="map",
        executor=ThreadPoolExecutor(1), progress=lambda done, total, study: seen.append(study.map.expected != NOT_YET),
    )  # fmt: skip
    assert [np.flatnonzero(seen[k - 1]).tolist() for k in (1, 2, 3, 5)] == [
        [0], [0, 8], [0, 4, 8], [0, 2, 4, 6, 8],
    ]  # fmt: skip
    assert seen[-1].all()


def test_a_verdict_and_the_run_that_it_is_about_tell_of_one_error():
    start, span = (1.0, 1.0), (0.0, 10.0)
    expected = expected_of(HARMONIC, start, span)
    (verdict,) = judge(HARMONIC, start, 0.0, expected, "rk2", [0.01], 10_000)
    run = core.integrate(HARMONIC, (0.0, expected.horizon), start, tau=0.01, method="rk2")
    assert verdict.error == np.abs(run.accumulated_error()).max()


def test_every_outcome_has_words():
    codes = [*map(int, core.Status), NOT_YET, WRONG_CROSSINGS, WENT_ON, NO_START]
    words = [outcome_words(code) for code in codes if code != core.Status.RUNNING]
    assert all(words)


# Drift ---------------------------------------------------------------------------------------------------------------


def test_the_energy_of_the_explicit_midpoint_rule_grows_as_its_amplification_says():
    # E_n = E_0 (1 + τ⁴/4)^n, through the pieces that the run is cut into
    tau = 0.02
    drift = stability_study(FAR, methods=("rk2", "dmm2"), tau=tau, steps=250_000, parts="drift").drift
    ended = np.floor(drift.t / tau + 1e-6)  # a step that ends where a part of the time does may count to either
    least, most = (0.5 * np.expm1((ended - k) * np.log1p(tau**4 / 4)) for k in (1, 0))
    assert (drift.error[0] > (1 - 1e-6) * least).all()
    assert (drift.error[0] < (1 + 1e-6) * most).all()
    assert drift.error[0, -1] == pytest.approx(most[-1], rel=1e-6)
    assert drift.error[1].max() < 1e-14
    assert drift.t[-1] == pytest.approx(tau * 250_000)
    assert drift.status == (core.Status.COMPLETED,) * 2


def test_drift_adds_up_over_crossings():
    # With one ψ for both sides the change of all visits is the change of ψ.
    system, tau, steps = oscillator("y"), 0.05, 30_000
    drift = stability_study(system, methods=("rk4",), tau=tau, steps=steps, parts="drift").drift
    x, y = core.integrate(system, (0, tau * steps), tau=tau, method="rk4").x[-1]
    assert drift.error[0, -1] == pytest.approx(abs((x**2 + y**2) / 2 - 0.5), rel=2e-3)
    assert drift.crossings == (round(tau * steps / np.pi),)


def test_a_run_that_stops_leaves_the_rest_of_its_drift_empty():
    drift = stability_study(
        core.CATALOGUE["coulomb_friction"], methods=("dmm2",), tau=0.01, steps=100_000, parts="drift"
    ).drift
    assert drift.status == (core.Status.SLIDING,)
    assert "12.56" in drift.message[0]  # 4π
    assert np.isfinite(drift.error[0, drift.t < 12.5]).all()
    assert np.isnan(drift.error[0, drift.t > 100]).all()


def test_drift_of_a_method_that_chooses_its_steps_reaches_the_same_time():
    drift = stability_study(ELLIPTIC, methods=("taylor",), tau=0.1, steps=20_000, parts="drift").drift
    assert drift.status == (core.Status.COMPLETED,)
    assert np.nanmax(drift.error) < 1e-13


@pytest.mark.parametrize("method", ["rk2", "rk8"])
def test_a_slide_that_goes_on_in_the_next_piece_of_a_long_run_counts_once(method):
    system = core.PiecewiseSystem(
        "Oblique relay", ("x", "y"), ("1 - 0.1*y", "0.2 - x"), ("-1 - 0.1*y", "0.2 - x - 0.5*y"),
        "x + 0.4*y - 0.1*sin(t)", x0=(0.1, 0.3),
    )  # fmt: skip
    for tau in (0.004, 0.005, 0.006, 0.007):
        drift = stability_study(
            system, methods=(method,), tau=tau, steps=1_500, parts="drift", sliding="continue"
        ).drift
        run = core.integrate(system, (0.0, 1_500 * tau), tau=tau, method=method, sliding="continue")
        assert run.sliding[[100, 1000]].all()  # where it is cut
        assert drift.crossings == (run.crossing_count,)


# Beside a tangency ---------------------------------------------------------------------------------------------------


def test_the_oscillator_touches_a_wall_at_its_amplitude():
    wall = oscillator("x - 1", x0=(-0.7, 0.0))
    found = stability_study(wall, (0, 6), methods=("dmm2", "rk2", "rk4"), values=np.linspace(-1.53, -0.51, 8),
                            tau=0.01, parts="grazing").grazing  # fmt: skip
    assert found.value == pytest.approx(-1.0, abs=4e-16)
    assert found.time == pytest.approx(np.pi, abs=1e-6)
    assert found.state == pytest.approx([1.0, 0.0], abs=1e-6)
    assert (found.expected[0] == 2).all()  # from farther left
    assert (found.expected[1] == 0).all()
    assert (found.missed[0, :, :13] == 0).all()  # dmm2 keeps the amplitude
    assert found.error[0].max() < 1e-14
    assert found.missed[1, 1, -1] == -2  # rk2 grows: it crosses where the solution does not
    assert found.missed[2, 0, -1] == 2  # rk4 shrinks


def test_the_pendulum_touches_the_line_at_the_angle_it_started_from():
    found = stability_study(core.CATALOGUE["pendulum"], methods=("dmm2",), parts="grazing").grazing
    assert found.value == pytest.approx(-0.5, abs=1e-15)
    assert found.state == pytest.approx([0.5, 0.0], abs=1e-6)
    assert (found.missed == 0).all()


def test_a_start_on_the_surface_is_no_touch():
    # At rest at the angle itself the pendulum starts tangentially; it comes back there, too.
    values = np.linspace(0.3, 0.7, 4)
    found = stability_study(core.CATALOGUE["pendulum"], methods=("dmm2",), values=values, parts="grazing").grazing
    assert not found.found


@pytest.mark.deep
def test_where_the_solution_stops_no_run_is_said_to_miss_a_crossing():
    relay = core.CATALOGUE["relay_feedback"]  # touches the line where it begins to chatter
    found = stability_study(relay, methods=("taylor",), values=np.linspace(3, 3.4, 4), parts="grazing").grazing
    assert found.found
    assert (found.expected == -1).any()
    assert (found.crossings >= 0).all()
    assert (found.missed == 0).all()


@pytest.mark.deep
def test_the_touch_is_where_the_field_is_tangent_to_the_surface():
    """Outside the circle the rate of g = x² + y² − 1 is 2y(3x² + 2x − 2)."""
    found = stability_study(ELLIPTIC, (0.0, 20.0), methods=("dmm2",), parts="grazing").grazing
    x = (28**0.5 - 2) / 6
    assert found.state == pytest.approx([x, (1 - x * x) ** 0.5], abs=1e-7)


def test_without_a_tangency_there_is_none():
    found = stability_study(HARMONIC, parts="grazing").grazing
    assert found.searched
    assert not found.found
    assert found.delta.size == 0


# Running it ----------------------------------------------------------------------------------------------------------


def same(a, b) -> bool:
    """Whether two results are the same in every bit; processor times apart."""
    if is_dataclass(a):
        return all(same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a) if f.name != "seconds")
    return np.array_equal(a, b, equal_nan=True) if isinstance(a, np.ndarray) else a == b or (a != a and b != b)


@pytest.mark.parametrize("executor", [lambda: ThreadPoolExecutor(3),
                                      lambda: ProcessPoolExecutor(1, get_context("spawn"))],
                         ids=["threads", "processes"])  # fmt: skip
def test_any_executor_gives_the_same_study(executor):
    here = stability_study(ELLIPTIC, **SMALL)
    with executor() as pool:
        there = stability_study(ELLIPTIC, **SMALL, executor=pool)
    assert here.complete
    assert same(here, there)


def test_partial_results_come_one_by_one_and_stay_as_they_were():
    seen = []
    study = stability_study(
        ELLIPTIC, **SMALL, progress=lambda done, total, partial: seen.append((done, total, partial))
    )
    totals = {total for _, total, _ in seen}
    assert totals == {2 + 2 * 2 + 2 * 3 + 29}
    assert [done for done, _, _ in seen] == sorted({done for done, _, _ in seen})
    empty = [np.count_nonzero(partial.map.outcome == NOT_YET) for _, _, partial in seen if partial.map is not None]
    assert empty[:4] == [9, 6, 3, 0]
    assert seen[0][2].map is None
    assert not seen[0][2].complete
    assert study.complete


def test_only_the_parts_asked_for_are_computed():
    study = stability_study(ELLIPTIC, **SMALL, parts=("drift",))
    assert study.drift is not None
    assert study.largest_tau is study.map is study.grazing is None


@pytest.mark.parametrize("part", PARTS)
def test_cancelling_returns_what_is_there(part):
    done = []
    study = stability_study(
        core.CATALOGUE["pendulum"], parts=(part,), progress=lambda *given: done.append(given), cancel=lambda: bool(done)
    )
    assert not study.complete
    assert len(done) == 1
    assert getattr(study, part) is getattr(done[-1][2], part)


def test_cancelling_before_the_start_computes_nothing():
    study = stability_study(ELLIPTIC, cancel=lambda: True)
    assert [getattr(study, part) for part in PARTS] == [None] * 4
    assert not study.complete


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"t_span": (1.0, 0.0)}, r"\(1.0, 0.0\).*later one second"),
        ({"t_span": 3.0}, r"3.0: a start and an end"),
        ({"t_span": (0.0, np.inf)}, "inf.*finite"),
        ({"methods": ()}, r"methods = \(\)"),
        ({"methods": ("dmm2", "dmm2")}, "different"),
        ({"methods": ("euler",)}, "'euler'; known are"),
        ({"taus": (0.1,)}, "taus.*2 to 400"),
        ({"taus": (0.1, -0.2)}, "-0.2.*positive"),
        ({"taus": (0.1, np.nan)}, "nan.*finite"),
        ({"taus": 0.1}, "taus = 0.1: numbers"),
        ({"values": (1.0, 1.0)}, "values.*different"),
        ({"coordinate": "z"}, "'z': one of x, y"),
        ({"coordinate": 2}, "2: one of x, y"),
        ({"parts": ("maps",)}, "'maps'.*largest_tau, map, drift, grazing"),
        ({"parts": ()}, "choose from"),
        ({"tau": -1.0}, "-1.0.*positive"),
        ({"steps": 0}, "steps = 0"),
        ({"x0": (1.0,)}, "2 needed"),
    ],
)
def test_arguments_that_make_no_sense_are_refused_with_what_would_do(change, told):
    with pytest.raises(ValueError, match=told):
        stability_study(ELLIPTIC, **change)


def test_a_conservative_method_needs_something_to_conserve():
    with pytest.raises(ValueError, match="has none: use one of"):
        stability_study(core.CATALOGUE["gene_switch"], methods=("dmm2",))


def test_a_coordinate_may_be_named_and_ranges_cover_the_orbit():
    study = stability_study(HARMONIC, methods=("rk4",), taus=(0.1, 0.2), coordinate="y", parts="map")
    assert (study.coordinate, study.coordinate_name) == (1, "y")
    orbit = core.integrate(HARMONIC, (0, 20)).x[:, 1]
    assert study.map.values[0] < orbit.min() < orbit.max() < study.map.values[-1]
    assert np.abs(study.map.values - orbit[0]).min() < 1e-15, "the start itself has a row"


def test_outcomes_that_are_no_status_have_codes_of_their_own():
    own = {NOT_YET, WRONG_CROSSINGS, WENT_ON, NO_START}
    assert len(own) == 4
    assert own & {int(status) for status in core.Status} == {
        int(core.Status.RUNNING)
    }  # a run not yet made is one that runs


def ranges(system, x0=None, coordinate=0):
    found = stability_study(
        system, (0, 20), x0, methods=("rk2",), taus=(0.5, 1.0), coordinate=coordinate, parts="map"
    ).map
    return found.values[0], found.values[-1], found


def test_values_are_of_the_size_of_a_trajectory_before_its_pole():
    low, high, found = ranges("elliptic_curve", (0.5, 1.1))
    assert -10.0 < low < 0.5 < high < 50.0
    assert core.Status.ESCAPED in found.expected


def test_values_are_those_of_starts_on_this_side_of_a_wall():
    low, high, found = ranges("bouncing_ball")
    assert 0.0 < low < 0.01
    assert high > 1.0
    assert (found.expected != core.Status.COMPLETED).all(), "a ball comes to rest"
    assert ranges("henon_heiles")[0] > -0.1
    assert ranges("bouncing_ball", coordinate="v")[0] < 0.0


def test_a_start_beyond_a_wall_has_a_warning_and_its_own_values():
    run = core.integrate("bouncing_ball", (0.0, 1.0), (-1.0, 0.0))
    assert "The start lies beyond a wall" in run.message
    assert "beyond a wall" not in core.integrate("bouncing_ball", (0.0, 1.0)).message
    assert ranges("bouncing_ball", (-1.0, 0.0))[0] < -1.0


def test_where_psi_is_not_defined_this_is_the_reason_that_there_is_no_reference():
    system = core.CATALOGUE["predator_prey"]
    study = core.stability_study(system, (0.0, 5.0), x0=(-1.0, 1.0), methods=("rk2",), parts=("largest_tau",))
    assert study.largest_tau is not None
    assert "ψ is not defined here" in study.largest_tau.reason[0]


def test_a_solution_that_touches_the_surface_ends_there_and_no_continuation_counts_as_correct():
    """It slides to a point at which the other field is tangent: the exact reference, in another way, ends there."""
    system = core.CATALOGUE["elliptic_curve"].with_parameters(radius=1.5)
    with pytest.raises(ValueError, match=r"ends at t = 0\.5696.*touches the surface"):
        core.reference_solution(system, sliding="continue").state(1.0)
    study = core.stability_study(
        system, (0.0, 19.2), methods=("dmm2", "taylor"), taus=(1e-3, 1e-2), coordinate="x", values=(-1.0, 0.3),
        sliding="continue")  # fmt: skip
    assert study.map.expected.tolist() == [core.Status.GRAZING, core.Status.COMPLETED]
    assert study.map.expected_crossings[1] == 14
    assert not study.map.works[:, :, 0].any()
    assert study.map.works[:, :, 1].all()


@pytest.mark.parametrize("first", ["up", "down"])
def test_a_long_run_with_hysteresis_stays_in_its_region_from_piece_to_piece(first):
    """The other region, which contains the state as well, would lead it off to infinity."""
    laws = {
        "up": core.Region(("v", "x + 1"), ("v**2 - (x + 1)**2",)),
        "down": core.Region(("v", "-(x + 0.5)"), ("v**2 + (x + 0.5)**2",)),
    }
    names = (first, *{"up", "down"} - {first})
    system = core.PiecewiseSystem(
        "relay", ("x", "v"), regions={name: laws[name] for name in names}, x0=(-0.7, 0.0),
        transitions=(core.Transition("up", "x + 0.6", "down"), core.Transition("down", "0.6 - x", "up")),
    )  # fmt: skip
    drift = stability_study(system, (0.0, 20.0), methods=("dmm2", "rk4"), tau=0.01, steps=50_000, parts="drift").drift
    assert drift.status == (core.Status.COMPLETED,) * 2
    assert drift.error[0].max() < 1e-13
