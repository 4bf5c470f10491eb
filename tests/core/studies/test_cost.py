"""Run time against error: what is told is so, and what could not be measured is a gap with a reason."""

import math
import re
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import core
from core.studies import measure
from core.studies.cost import CANCELLED, DONE, WAITING, work_precision
from core.studies.external_solvers import EXTERNAL_SOLVERS, ScalarFunctions, external_arcs

HARMONIC = core.CATALOGUE["harmonic_oscillator"]
TURN = math.pi * (1 + 1 / math.sqrt(3))  # half a circle at rate 1, half at sqrt(3): back at the start
KNOWN = {"dmm2": (0.1, 0.05, 0.025), "rk4": (0.1, 0.05, 0.025), "taylor": (1e-6, 1e-12), "scipy": (1e-6, 1e-10)}


def measured(settings=KNOWN, system=HARMONIC, span=(0.0, 4 * TURN), **options):
    methods = [name for name in settings if name in core.METHODS]
    peers = [name for name in settings if name not in core.METHODS]
    return work_precision(system, span, methods=methods, peers=peers, settings=settings, **{"repeats": 1, **options})


@pytest.fixture(scope="module")
def study():
    return measured()


def curve(study, name):
    return next(one for one in study.curves if one.name == name)


def test_there_is_no_reference_where_its_own_error_leaves_crossings_in_doubt():
    from tests.core.studies.test_stability import CROSSINGS, LORENZ

    x0 = (2.94, 1.0, 20.0)
    assert measured({"rk8": (0.001,)}, LORENZ, (0.0, 20.0), x0=x0).crossings == CROSSINGS[2.94][0]
    for end in (40.0, 50.0):
        with pytest.raises(ValueError, match=f"no reference until t = {end:g}: its error.*take an earlier end time"):
            measured({"rk8": (0.001,)}, LORENZ, (0.0, end), x0=x0)


def test_a_reference_is_not_in_doubt_for_a_small_state_at_the_end_or_a_jump_there():
    swing = core.PiecewiseSystem("Swing", ("x",), ("cos(t)*(1 + x**2)",), ("cos(t)*(1 + x**2)",), "x - 0.5", x0=(0.0,))
    drag = core.PiecewiseSystem(
        "Drag", ("y", "v"), ("v", "-1 - 0.3*v**3"), ("v", "-1 - 0.3*v**3"), "y", jump=("0", "-0.6*v"), x0=(1.0, 0.0)
    )
    assert measured({"rk4": (0.01,)}, swing, (0.0, 2 * math.pi)).curves[0].status == (DONE,)
    impact = float(core.reference_solution(drag).crossing(1)[0])
    for end in (impact, np.nextafter(impact, 2.0), impact + 1e-14):
        measured({"rk4": (0.01,)}, drag, (0.0, float(end)))  # where the state is on either side of the jump


def test_the_state_error_is_the_distance_from_where_the_orbit_closes(study):
    for name, key in (("dmm2", "tau"), ("rk4", "tau"), ("taylor", "tolerance")):
        one = curve(study, name)
        ends = [core.integrate(HARMONIC, (0.0, 4 * TURN), method=name, **{key: v}).x[-1] for v in one.setting]
        apart = [np.hypot(*(x - HARMONIC.x0)) for x in ends]
        assert one.state_error == pytest.approx(apart, abs=1e-14)
    assert study.reference == "exact (linear flow)"


def test_the_time_error_is_that_of_the_last_crossing(study):
    assert study.crossings == 8
    # From (1, 1), clockwise, pi/4 before y = 0: the last crossing is 3 pi/4 before the start comes again.
    last = 4 * TURN - 3 * math.pi / 4
    run = core.integrate(HARMONIC, (0.0, 4 * TURN), method="dmm2", tau=0.1, record="crossings")
    assert curve(study, "dmm2").time_error[0] == pytest.approx(abs(run.crossings.t[-1] - last), abs=1e-13)


@pytest.mark.parametrize(("name", "order"), [("dmm2", 2), ("rk4", 4)])
def test_errors_fall_by_the_order_of_the_method(study, name, order):
    one = curve(study, name)
    for errors in (one.state_error, one.time_error):
        assert np.log2(errors[1:] / errors[:-1]) == pytest.approx(-order, abs=0.15)


def test_errors_fall_with_the_tolerance_of_those_who_take_one(study):
    for name in ("taylor", "scipy"):
        assert curve(study, name).state_error[1] < 1e-2 * curve(study, name).state_error[0]
        assert curve(study, name).setting_name == "tolerance"


def test_psi_is_kept_by_conservative_methods_and_by_no_others(study):
    assert curve(study, "dmm2").invariant_error.max() < study.floor["invariant"]
    assert curve(study, "taylor").invariant_error.max() < study.floor["invariant"]
    assert curve(study, "rk4").invariant_error.min() > 100 * study.floor["invariant"]


@pytest.mark.parametrize(("name", "most"), [("harmonic_oscillator", 60.0), ("pendulum", 30.0), ("bouncing_ball", 1.3)])
def test_the_error_of_psi_is_the_largest_change_since_the_start_over_all_steps(name, most):
    rng = np.random.default_rng(7)
    system, end = core.CATALOGUE[name], most * float(rng.uniform(0.5, 1.0))
    settings = {"rk4": tuple(rng.uniform(0.01, 0.1, 2)), "dmm2": (0.05,), "taylor": (1e-9,)}
    study = measured(settings, system, (0.0, end), sliding="continue")
    for one in study.curves:
        for value, found in zip(one.setting, one.invariant_error, strict=True):
            run = core.integrate(system, (0.0, end), method=one.name, sliding="continue", **{one.setting_name: value})
            assert found == np.fmax.reduce(run.change_of_psi()[~run.sliding]), (one.name, value, end)


def test_the_error_of_psi_of_an_external_solver_adds_up_over_the_pieces():
    study = measured({"scipy": (1e-5,)}, span=(0.0, 60.0))
    functions = ScalarFunctions(HARMONIC)
    prepared = EXTERNAL_SOLVERS["scipy"].prepare(functions, 1e-5, 1.0)
    arcs = external_arcs(functions, prepared, 0.0, 60.0, np.array(HARMONIC.x0), 999, lambda: None)
    ends = zip(arcs.side, arcs.entered, arcs.left, strict=True)
    lost = [np.subtract(*(HARMONIC.conserved(side, t, x)[0] for t, x in (b, a))) for side, a, b in ends]
    assert study.curves[0].invariant_error[0] >= 0.999 * np.abs(np.cumsum(lost)).max() > 3 * np.abs(lost).max()


def test_everything_that_was_measured_has_a_cost(study):
    assert study.complete
    for one in study.curves:
        assert one.status == (DONE,) * len(one.setting)
        assert (one.seconds > 0).all()
        assert (one.evaluations > 0).all()
        assert one.compile_seconds >= 0
    steps = 4 * TURN / curve(study, "rk4").setting
    assert (curve(study, "rk4").evaluations >= 4 * steps - 4).all()


def test_the_fastest_repeat_counts_and_no_more_are_made_than_the_budget_has_room_for(monkeypatch):
    clock = iter([0.0, 3.0, 10.0, 11.0, 20.0, 22.0])
    monkeypatch.setattr(measure.time, "thread_time", lambda: next(clock))
    calls = []
    assert measure._fastest(lambda: calls.append(1), repeats=9, budget=5.0) == 1.0
    assert len(calls) == 3


def test_a_run_over_the_budget_is_a_gap():
    study = measured({"rk4": (0.1, 1e-6), "scipy": (1e-12,)}, budget=1e-3)
    ours, other = study.curves
    assert ours.status == (DONE, "takes longer than the 0.001 s a run may take")
    assert np.isfinite(ours.seconds).tolist() == np.isfinite(ours.state_error).tolist() == [True, False]
    assert other.status == ours.status[1:]
    assert np.isnan(other.seconds).all()


def test_a_run_that_does_not_get_to_the_end_is_a_gap_that_says_why():
    study = measured({"rk2": (0.25, 1e-2)}, core.CATALOGUE["elliptic_curve"], (0.0, 60.0))
    (one,) = study.curves
    assert one.status[0] == core.Status.ESCAPED.reason  # off the oval, y**2 = x**3 + ... leads to infinity
    assert np.isfinite(one.seconds).tolist() == [False, True]


def test_another_number_of_crossings_leaves_the_last_one_without_an_error():
    study = measured({"rk2": (0.9, 1e-2)})
    (one,) = study.curves
    assert one.crossings[0] != 8 == one.crossings[1]
    assert one.status[0] == f"{one.crossings[0]:.0f} crossings instead of 8"
    assert np.isnan(one.time_error).tolist() == [True, False]
    assert np.isfinite(one.state_error).all()


def test_as_many_crossings_at_other_times_are_those_of_another_trajectory():
    # dmm2 turns at 2 atan(ωτ/2)/τ in place of ω: at the coarse step it is half a turn late after some.
    taus = tuple(np.linspace(0.3, 0.9, 25))
    study = measured({"dmm2": (*taus, 1e-2)}, HARMONIC, (0.0, 30.0))
    (one,) = study.curves
    swapped = (one.crossings == study.crossings) & ~one.correct_sequence
    assert swapped.any()
    assert one.correct_sequence[-1]
    assert np.isnan(one.time_error[swapped]).all()
    told = one.status[swapped.argmax()]
    assert re.fullmatch(r"crossing \d+ comes at .*, not .*, nearer to a different crossing of the reference", told)


def test_without_a_transition_the_methods_lose_their_order_and_external_solvers_do_not():
    ladder = {"rk4": (0.02, 0.01), "scipy": (1e-9,)}
    located, stepped = (measured(ladder, transition=how) for how in ("mannshardt", "none"))
    assert (curve(stepped, "rk4").state_error > 1e3 * curve(located, "rk4").state_error).all()
    assert np.array_equal(curve(stepped, "scipy").state_error, curve(located, "scipy").state_error)
    with pytest.raises(ValueError, match="transition = 'some'"):
        measured(ladder, transition="some")


def test_a_peer_that_is_not_installed_is_a_gap(monkeypatch):
    monkeypatch.setitem(sys.modules, "heyoka", None)
    study = measured({"rk4": (0.1,), "heyoka": (1e-6, 1e-9)})
    assert curve(study, "heyoka").status == ("heyoka is not installed",) * 2
    assert curve(study, "rk4").status == (DONE,)


def test_heyoka_is_measured_where_it_is_installed():
    pytest.importorskip("heyoka", reason="heyoka is an optional external solver, and is not installed")
    (one,) = measured({"heyoka": (1e-6, 1e-14)}).curves
    assert one.state_error[1] < 1e-12
    assert np.isnan(one.evaluations).all()


def test_progress_tells_every_point_and_what_was_told_stays_as_it_was():
    told = []
    study = measured(progress=lambda *news: told.append(news))
    total = sum(map(len, KNOWN.values()))
    assert [(done, all_) for done, all_, _ in told] == [(k, total) for k in range(1, total + 1)]
    for done, _, partial in told:
        states = [status for one in partial.curves for status in one.status]
        assert states.count(WAITING) == total - done
        assert partial.complete == (done == total)
        assert sum(np.isfinite(one.state_error).sum() for one in partial.curves) == done
    for a, b in zip(study.curves, told[-1][2].curves, strict=True):
        assert np.array_equal(a.seconds, b.seconds)


def test_cancelling_returns_what_there_is():
    told = []
    study = measured(
        progress=lambda *news: told.append(news), cancel=lambda: bool(told), executor=(pool := ThreadPoolExecutor(1))
    )
    pool.shutdown()
    states = [status for one in study.curves for status in one.status]
    assert not study.complete
    assert states.count(DONE) == len(told) >= 1
    assert set(states) == {DONE, CANCELLED}


def test_without_a_span_it_runs_over_ten_crossings():
    study = work_precision(HARMONIC, methods=("taylor",), peers=(), settings={"taylor": (1e-9,)}, repeats=1)
    assert study.crossings == 10
    assert 4.5 * TURN < study.t_span[1] < 5.5 * TURN


def test_settings_of_its_own_reach_from_coarse_to_fine():
    study = work_precision(HARMONIC, (0.0, 5.0), methods=("dmm4", "taylor"), peers=("scipy",), repeats=1, budget=0.5)
    for one in study.curves:
        assert len(one.setting) >= 5
        assert (np.diff(one.setting) < 0).all()
        assert np.nanmax(one.state_error) > 1e4 * np.nanmin(one.state_error)


def test_where_no_psi_is_known_only_methods_that_need_none_are_used():
    study = work_precision(core.CATALOGUE["gene_switch"], (0.0, 3.0), peers=(), settings={"rk4": (0.1,)}, repeats=1)
    assert [one.name for one in study.curves] == ["rk4", "taylor"]
    assert all(np.isnan(one.invariant_error).all() for one in study.curves)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"methods": ("euler",)}, "'euler'"),
        ({"methods": ("rk4", "rk4")}, "'rk4' stands twice"),
        ({"peers": ("matlab",)}, "'matlab' is not known: choose from scipy, heyoka"),
        ({"methods": (), "peers": ()}, "name at least one"),
        ({"t_span": (1.0, 1.0)}, "the end must be after the start"),
        ({"t_span": (0.0, math.inf)}, "both finite"),
        ({"t_span": 3.0}, "a start and an end time"),
        ({"x0": (1.0,)}, "2 needed"),
        ({"repeats": 0}, "repeats = 0"),
        ({"budget": math.nan}, "budget = nan"),
        ({"settings": {"dmm8": (0.1,)}}, "'dmm8', which is not among"),
        ({"settings": {"rk4": ()}}, "0 numbers: 1 to 64"),
        ({"settings": {"rk4": (-0.1,)}}, "tau = -0.1"),
        ({"settings": {"taylor": (1.0,)}}, "tolerance = 1.0"),
        ({"settings": {"scipy": (1e-16,)}}, "tolerance = 1e-16 of 'scipy' is outside 2.2e-14"),
    ],
)
def test_what_makes_no_sense_is_refused(options, words):
    with pytest.raises(ValueError, match=re.escape(words)):
        work_precision(HARMONIC, **{"t_span": (0.0, 1.0), **options})


def test_methods_that_keep_psi_are_refused_where_none_is_known():
    with pytest.raises(ValueError, match="has none: use one of"):
        work_precision(core.CATALOGUE["gene_switch"], (0.0, 1.0), methods=("dmm2",))


def test_an_end_after_that_of_the_solution_is_refused():
    # The impacts of a ball that loses half its speed accumulate at three times the first: 1.355.
    with pytest.raises(ValueError, match="take an earlier end"):
        work_precision(core.CATALOGUE["bouncing_ball"], (0.0, 2.0))
