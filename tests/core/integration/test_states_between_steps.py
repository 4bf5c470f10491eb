"""Dense output: run.at(t), and integrate(..., t_eval=...)."""

import math
import tracemalloc

import numpy as np
import pytest

import core
from core import Status

OSCILLATOR, ELLIPTIC = core.CATALOGUE["harmonic_oscillator"], core.CATALOGUE["elliptic_curve"]
BALL = core.CATALOGUE["bouncing_ball"]
TAUS = {2: (0.02, 0.01), 4: (0.1, 0.05), 6: (0.2, 0.1), 8: (0.25, 0.15)}


def oscillator_state(t):
    """From (1, 1): energy and phase in closed form, with ω² = 1 where y > 0 and 3 where y < 0."""
    t, side, x = t, 1, np.array([1.0, 1.0])
    while True:
        w = 1.0 if side > 0 else math.sqrt(3.0)
        until = (math.pi / 4 if (x == 1.0).all() else math.pi) / w
        s = min(t, until)
        x = np.array(
            [math.cos(w * s) * x[0] + math.sin(w * s) / w * x[1], math.cos(w * s) * x[1] - w * math.sin(w * s) * x[0]]
        )
        if t <= until:
            return x
        t, side = t - until, -side
        x[1] = 0.0


@pytest.mark.parametrize("method", [m for m in core.METHODS.values() if not m.adaptive], ids=lambda m: m.name)
def test_the_order_between_steps_is_that_of_the_method(method):
    times = np.random.default_rng(3).uniform(0.0, 12.0, 300)
    exact = np.array([oscillator_state(t) for t in times])
    coarse, fine = (
        np.sqrt(np.mean((core.integrate(OSCILLATOR, (0.0, 12.0), (1, 1), tau, method).at(times) - exact) ** 2))
        for tau in TAUS[method.order]
    )
    tau_ratio = TAUS[method.order][0] / TAUS[method.order][1]
    assert math.log(coarse / fine, tau_ratio) == pytest.approx(method.order, abs=0.3)


def test_taylor_is_as_accurate_between_steps_as_its_tolerance():
    times = np.random.default_rng(4).uniform(0.0, 12.0, 300)
    exact = np.array([oscillator_state(t) for t in times])
    for tolerance in (1e-6, 1e-12):
        run = core.integrate(OSCILLATOR, (0.0, 12.0), (1, 1), method="taylor", tolerance=tolerance)
        assert np.abs(run.at(times) - exact).max() < 300 * tolerance


@pytest.mark.parametrize("shape", [(), (0,), (3,), (2, 3), (2, 0, 4)])
def test_times_of_any_shape_give_states_of_that_shape(shape):
    run = core.integrate(ELLIPTIC, (0.0, 2.0))
    assert run.at(np.full(shape, 1.2345)).shape == (*shape, 2)
    assert run.at(1).shape == (2,)  # a whole number is a time


@pytest.mark.parametrize(
    ("t", "words"),
    [(-0.1, "-0.1 is outside the run"), (2.5, "2.5 is outside .* 0.0 … 2.0"), ([0.5, math.nan], "nan"),
     (math.inf, "inf"), ("1.0", "numbers are needed"), (1j, "numbers are needed"), (None, "None is not a number"),
     (True, "numbers are needed"), ([[1.0], [1.0, 2.0]], "array of numbers")],
)  # fmt: skip
def test_what_is_no_time_of_the_run_is_refused(t, words):
    run = core.integrate(ELLIPTIC, (0.0, 2.0))
    with pytest.raises(ValueError, match=words):
        run.at(t)


@pytest.mark.parametrize("record", ["crossings", "end"])
def test_a_run_without_its_steps_has_the_states_it_kept_and_says_how_to_have_more(record):
    run = core.integrate(ELLIPTIC, (0.0, 5.0), record=record)
    assert (run.at([0.0, 5.0]) == run.x).all()
    assert (run.at(run.crossings.t) == run.crossings.x_after).all()
    with pytest.raises(ValueError, match=r'record="steps", or with t_eval'):
        run.at(2.0)


def test_at_the_instant_of_a_jump_the_state_is_the_one_after_it_or_the_one_before():
    run = core.integrate(BALL, (0.0, 3.0), tau=0.05)
    assert len(run.crossings) > 1
    for hit in run.crossings[:2]:
        assert (run.at(hit.t) == hit.x_after).all()
        assert (run.at(hit.t, before=True) == hit.x).all()
        assert run.at(hit.t - 1e-9) == pytest.approx(hit.x, abs=1e-7)
        assert run.at(hit.t + 1e-9) == pytest.approx(hit.x_after, abs=1e-7)


def test_a_run_back_in_time_has_its_states_too():
    run = core.integrate(ELLIPTIC, (5.0, 0.0), tau=0.05, method="prk8")
    there = core.integrate(ELLIPTIC, (0.0, 5.0), run.x[-1], tau=0.05, method="prk8")
    times = np.linspace(0.0, 5.0, 77)
    assert np.abs(run.at(times) - there.at(times)).max() < 1e-7


@pytest.mark.parametrize("scale", [0.7, -0.7])
@pytest.mark.parametrize("order", [1, 2])
def test_with_a_perturbation_each_time_belongs_to_one_step_on_one_side(scale, order):
    moved = {"tau": 0.05, "perturbation_order": order, "perturbation_scale": scale}
    run = core.integrate(ELLIPTIC, (0.0, 8.0), **moved)
    assert run.status is Status.COMPLETED
    assert (run.at(run.t) == run.x).all()
    times = np.sort(np.random.default_rng(1).uniform(0.0, 8.0, 400))
    sampled = core.integrate(ELLIPTIC, (0.0, 8.0), **moved, t_eval=times)
    assert (sampled.at(times) == run.at(times)).all()
    assert np.abs(sampled.conserved_error()).max() < 1e-14
    assert (np.diff(sampled.segment) >= 0).all()
    # A shift of c·τᵖ in the time of crossings moves the orbit in time by as much, once a crossing.
    plain = core.integrate(ELLIPTIC, (0.0, 8.0), tau=0.05)
    assert np.abs(run.at(times) - plain.at(times)).max() < 8 * 8 * abs(scale) * 0.05**order


@pytest.mark.parametrize("scale", [0.7, -0.7])
def test_a_run_that_stops_at_a_perturbed_crossing_has_all_its_states(scale):
    for end in np.linspace(5.0, 20.0, 12):
        run = core.integrate(ELLIPTIC, (0.0, end), tau=0.1, perturbation_order=1, perturbation_scale=scale)
        assert (run.at(run.t) == run.x).all()
        limited = core.integrate(
            ELLIPTIC, (0.0, end), tau=0.1, perturbation_order=1, perturbation_scale=scale, max_crossings=3
        )
        assert (limited.at(limited.t) == limited.x).all()


def test_without_a_transition_the_side_changes_at_the_ends_of_steps():
    run = core.integrate(ELLIPTIC, (0.0, 5.0), tau=0.05, transition="none")
    sampled = core.integrate(ELLIPTIC, (0.0, 5.0), tau=0.05, transition="none", t_eval=np.linspace(0.0, 5.0, 997))
    assert (run.at(run.t) == run.x).all()
    steps = np.searchsorted(run.t, sampled.t, "right") - 1
    assert (sampled.side == run.side[steps]).all()


def test_a_run_that_cannot_begin_has_one_state():
    run = core.integrate(core.CATALOGUE["type_sliding"], (0.0, 1.0), (0.0, 0.0))
    assert run.status is Status.SLIDING
    assert (run.at(0.0) == run.x[0]).all()
    with pytest.raises(ValueError, match="outside the run"):
        run.at(0.5)


def test_a_step_whose_equations_fail_is_made_of_shorter_ones():
    # A stage falls where the field is 0 times −∞, if the time asked for is 0.5; its integral is u² (log|u| − 1/2).
    place = 0.5 * (0.5 - 3**0.5 / 6)
    f = ("1", f"(x - {place!r})*log((x - {place!r})**2)")
    system = core.PiecewiseSystem("limit", ("x", "y"), f, f, "y + 100", x0=(0.0, 0.0))
    assert core.integrate(system, (0.0, 1.0), tau=0.5, method="gauss4").status is core.Status.NO_CONVERGENCE
    run = core.integrate(system, (0.0, 1.0), tau=1.0, method="gauss4")
    y = [u * u * (np.log(abs(u)) - 0.5) for u in (-place, 0.5 - place)]
    assert run.at(0.5) == pytest.approx([0.5, y[1] - y[0]], abs=5e-3)  # the logarithm costs digits
    sampled = core.integrate(system, (0.0, 1.0), tau=1.0, method="gauss4", t_eval=[0.5])
    assert (sampled.at(0.5) == run.at(0.5)).all()


def test_the_states_stay_exact_to_round_off_whatever_the_method_keeps():
    for method in ("dmm2", "dmm4", "prk8", "taylor"):
        kind = {"tolerance": 1e-8} if method == "taylor" else {"tau": 0.1}
        times = np.random.default_rng(7).uniform(0.0, 60.0, 2000)
        run = core.integrate(ELLIPTIC, (0.0, 60.0), method=method, t_eval=times, **kind)
        assert np.abs(run.conserved_error()).max() < 16 * 3 * 2.0**-52


# t_eval --------------------------------------------------------------------------------------------------------------


def test_times_asked_for_are_recorded_in_the_order_of_the_run_between_its_first_and_last_state():
    for span, times in (((0.0, 5.0), [3.0, 1.0, 2.5, 1.0]), ((5.0, 0.0), [1.0, 2.5, 3.0])):
        run = core.integrate(ELLIPTIC, span, t_eval=times)
        assert run.t.tolist() == sorted({*span, *times}, reverse=span[0] > span[1])
        assert len(run.x) == len(run.side) == len(run.conserved_error()) == len(run.t)
        steps = core.integrate(ELLIPTIC, span)
        assert (run.steps, run.evaluations, run.status) == (steps.steps, steps.evaluations, steps.status)
        assert (run.x[1:-1] == steps.at(run.t[1:-1])).all()
        assert (run.x[-1] == steps.x[-1]).all()
        assert (run.crossings.t == steps.crossings.t).all()


def test_sampling_goes_on_across_calls_of_the_compiled_loop():
    times = np.random.default_rng(5).uniform(0.0, 400.0, 3000)
    steps = core.integrate(ELLIPTIC, (0.0, 400.0), tau=1e-3)
    assert steps.steps == 400_000
    for record in ("steps", "end"):
        run = core.integrate(ELLIPTIC, (0.0, 400.0), tau=1e-3, t_eval=times, record=record)
        assert (run.at(times) == steps.at(times)).all()
        assert np.nanmax(np.abs(run.conserved_error())) < 16 * 3 * 2.0**-52


def test_memory_does_not_grow_with_the_length_of_a_sampled_run():
    core.integrate(ELLIPTIC, (0.0, 1.0), t_eval=[0.5], record="end")  # compiles

    def peak(end):
        tracemalloc.start()
        run = core.integrate(ELLIPTIC, (0.0, end), tau=1e-3, t_eval=np.linspace(0.0, end, 50), record="end")
        assert len(run.t) == 50
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return most

    assert peak(3000.0) < 1.2 * peak(600.0)


def test_a_sampled_run_that_stops_early_leaves_out_what_comes_after():
    run = core.integrate(BALL, (0.0, 50.0), tau=0.01, t_eval=np.linspace(0.0, 50.0, 501))
    assert run.status in (Status.ZENO, Status.SLIDING)
    assert run.t[-1] < 10.0
    assert (np.diff(run.t) >= 0).all()
    limited = core.integrate(ELLIPTIC, (0.0, 50.0), max_steps=150, t_eval=[1.0, 2.0])
    assert (limited.status, limited.t.tolist()) == (Status.STEP_LIMIT, [0.0, 1.0, 1.5])
    crossed = core.integrate(ELLIPTIC, (0.0, 50.0), max_crossings=1, t_eval=[0.5, 2.0])
    assert crossed.t.tolist() == [0.0, 0.5, crossed.crossings.t[0]]


@pytest.mark.parametrize(
    ("times", "words"),
    [([6.0], r"6.0, which is outside t_span = \(0.0, 5.0\)"), ([1.0, math.nan], "nan"), ("1", "numbers are needed"),
     ([-1e-9], "outside t_span"), (["a"], "numbers are needed"), ({1.0}, "not a number")],
)  # fmt: skip
def test_times_that_the_run_does_not_pass_are_refused(times, words):
    with pytest.raises(ValueError, match=words):
        core.integrate(ELLIPTIC, (0.0, 5.0), t_eval=times)


def test_no_times_at_all_leave_the_ends():
    assert core.integrate(ELLIPTIC, (0.0, 5.0), t_eval=[]).t.tolist() == [0.0, 5.0]
    assert core.integrate(ELLIPTIC, (2.0, 2.0), t_eval=[2.0]).t.tolist() == [2.0]
