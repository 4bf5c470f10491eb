"""Events: zeros of functions along a run, which they do not change."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import core
from core import METHODS, Event, Status
from tests.levels import QUICK_METHODS, deep_but

TAYLOR = {"method": "taylor", "tolerance": 1e-13}
#: Of the harmonic oscillator from (0, 1): x' = y, y' = −x where y > 0 and −3x where y < 0.
HALVES = (math.pi, math.pi / math.sqrt(3.0))
#: x' = v, v' = 0: one step of the Taylor method is as long as the run.
FREE = core.PiecewiseSystem("free", ("x", "v"), g="x - 1e6", f_minus=("v", "0"), f_plus=("v", "0"), x0=(0.0, 1.0))


def settings_of(method):
    return TAYLOR if METHODS[method].adaptive else {"method": method, "tau": 0.05}


def zeros_of_x(t_end):
    """Times after 0 at which x = 0, and whether x rises there."""
    turns = range(1, int(2 * t_end / sum(HALVES)) + 1)
    times = [(k // 2) * sum(HALVES) + (HALVES[0] / 2 + HALVES[1] / 2 if k % 2 else 0.0) for k in turns]
    return [(t, k % 2 == 0) for t, k in zip(times, turns, strict=True) if t <= t_end]


def equal(a, b):
    """Whether two runs are the same, bit by bit."""
    parts = ("t", "x", "mode", "segment", "entered_t", "entered_x")
    same = all(np.array_equal(getattr(a, name), getattr(b, name)) for name in parts)
    same &= all(np.array_equal(getattr(a.crossings, n), getattr(b.crossings, n)) for n in ("t", "x_after", "mode", "g"))
    return same and (a.steps, a.evaluations, a.status) == (b.steps, b.evaluations, b.status)


@pytest.mark.parametrize("direction", [0, 1, -1])
def test_events_are_where_a_closed_form_vanishes_and_go_the_way_asked_for(direction):
    run = core.integrate("harmonic_oscillator", (0.0, 40.0), (0.0, 1.0), events=Event("x", direction), **TAYLOR)
    wanted = [(t, rises) for t, rises in zeros_of_x(40.0) if direction in (0, 1 if rises else -1)]
    assert len(wanted) > 5
    assert run.events.t == pytest.approx([t for t, _ in wanted], abs=1e-11)
    assert (run.events.direction == [1 if rises else -1 for _, rises in wanted]).all()
    assert np.abs(run.events.residual).max() < 1e-15
    assert np.array_equal(run.events.residual, run.events.x[:, 0])


def test_backwards_in_time_a_direction_is_still_that_of_time():
    forth = core.integrate("harmonic_oscillator", (0.0, 40.0), (0.0, 1.0), events=Event("x", 1), **TAYLOR)
    back = core.integrate("harmonic_oscillator", (forth.t[-1], 0.0), forth.x[-1], events=Event("x", 1), **TAYLOR)
    assert back.events.t[::-1][-len(forth.events) :] == pytest.approx(forth.events.t, abs=1e-10)


@pytest.mark.parametrize(("method", "taus"), [("dmm2", (0.02, 0.01)), ("dmm4", (0.1, 0.05)), ("rk4", (0.1, 0.05))])
def test_event_times_have_the_order_of_the_method(method, taus):
    wanted = [t for t, _ in zeros_of_x(20.0)]
    errors = []
    for tau in taus:
        run = core.integrate("harmonic_oscillator", (0.0, 20.0), (0.0, 1.0), tau=tau, method=method, events="x")
        errors.append(np.abs(run.events.t - wanted)[-1])
    assert abs(math.log2(errors[0] / errors[1]) - METHODS[method].order) < 0.25


@pytest.mark.parametrize("method", deep_but(QUICK_METHODS, METHODS))
@pytest.mark.parametrize("name", ["harmonic_oscillator", "two_walls", "thermostat", "stick_slip"])
def test_a_run_with_events_is_bit_by_bit_the_run_without(name, method):
    system = core.CATALOGUE[name]
    if METHODS[method].needs_conserved and not system.laws.most_conserved:
        pytest.skip("keeps a known quantity, and there is none")
    events = (f"{system.variables[0]} - 0.1", "sin(5*t)", f"exp({system.variables[-1]}) - 1.2")
    settings = {"sliding": "continue", **settings_of(method)}
    alone, found = (core.integrate(system, (0.0, 15.0), events=e, **settings) for e in ((), events))
    assert equal(alone, found)
    assert found.events.of(1).t == pytest.approx(np.arange(1, 24) * math.pi / 5, abs=1e-13)
    assert (np.diff(found.events.t) >= 0.0).all()
    for t, x in zip(found.events.t, found.events.x, strict=True):
        assert alone.at(t, before=True) == pytest.approx(x, abs=1e-12)


@pytest.mark.parametrize("method", QUICK_METHODS)
@pytest.mark.parametrize("name", ["elliptic_curve", "bouncing_ball", "moving_interface", "gene_switch"])
def test_events_of_the_surface_are_its_crossings(name, method):
    system = core.CATALOGUE[name]
    if METHODS[method].needs_conserved and not system.laws.most_conserved:
        pytest.skip("keeps a known quantity, and there is none")
    events = (system.g, f"-2*({system.g})")
    run = core.integrate(system, (0.0, 20.0), max_crossings=30, events=events, **settings_of(method))
    assert len(run.crossings) > 5
    for k in (0, 1):
        assert np.array_equal(run.events.of(k).t, run.crossings.t)
        assert np.array_equal(run.events.of(k).x, run.crossings.x)
    assert (run.events.of(0).direction == np.sign(run.crossings.rate_before)).all()


@pytest.mark.parametrize("method", QUICK_METHODS)
def test_a_ball_turns_between_its_bounces_and_a_jump_over_zero_is_no_event(method):
    ball = core.CATALOGUE["bouncing_ball"]
    gravity, part = (ball.values[name] for name in ("gravity", "restitution"))
    run = core.integrate(ball, (0.0, 1.15), (1.0, 0.0), events=("v", Event("y", -1)), **settings_of(method))
    first = math.sqrt(2.0 / gravity)
    bounces = first + 2.0 * first * np.cumsum([0.0, part, part**2])
    assert run.events.of(1).t == pytest.approx(bounces[bounces < 1.15], abs=1e-12)
    assert run.events.of(0).t == pytest.approx([bounces[0] + part * first, bounces[1] + part**2 * first], abs=1e-12)
    assert (run.events.of(0).direction == -1).all()


@pytest.mark.parametrize("method", QUICK_METHODS)
def test_a_terminal_event_ends_the_run_at_the_state_where_it_takes_place(method):
    settings = settings_of(method)
    events = (Event("x - y/3", 1, terminal=True), "x", "cos(t)")
    run = core.integrate("harmonic_oscillator", (0.0, 40.0), events=events, **settings)
    whole = core.integrate(
        "harmonic_oscillator", (0.0, 40.0), events=(Event("x - y/3", 1), "x", "cos(t)"), **settings
    )  # fmt: skip
    last = whole.events.of(0)[0]
    assert run.status is Status.EVENT
    assert "the event 'x - y/3' took place" in run.message
    assert (run.t[-1], *run.x[-1]) == (last.t[0], *last.x[0])
    before = whole.events.t <= last.t[0]
    assert np.array_equal(run.events.t, whole.events.t[before])
    assert np.array_equal(run.t[:-1], whole.t[: len(run.t) - 1])
    assert len(run.crossings) == (whole.crossings.t < last.t[0]).sum() > 0


@pytest.mark.parametrize("method", QUICK_METHODS)
def test_a_terminal_event_at_a_crossing_ends_the_run_before_it(method):
    run = core.integrate("bouncing_ball", (0.0, 3.0), events=Event("y", terminal=True), **settings_of(method))
    met = core.integrate("bouncing_ball", (0.0, 3.0), **settings_of(method)).crossings[0]
    assert run.status is Status.EVENT
    assert not len(run.crossings)
    assert (run.t[-1], *run.x[-1]) == (met.t, *met.x)


def test_the_run_ends_with_the_last_event_allowed():
    whole = core.integrate("harmonic_oscillator", (0.0, 40.0), tau=0.05, events=("x", "sin(t)"))
    run = core.integrate("harmonic_oscillator", (0.0, 40.0), tau=0.05, events=("x", "sin(t)"), max_events=7)
    assert run.status is Status.EVENT_LIMIT
    assert "max_events" in run.message
    assert np.array_equal(run.events.t, whole.events.t[:7])
    assert (run.t[-1], *run.x[-1]) == (whole.events.t[6], *whole.events.x[6])


def test_many_events_in_one_step_are_all_found():
    run = core.integrate(FREE, (0.0, 200.0), events=("sin(100*t)", "sin(100*x)"), **TAYLOR)
    assert run.steps == 1
    for k in (0, 1):
        wanted = np.arange(1, math.floor(200.0 * 100.0 / math.pi) + 1) * math.pi / 100.0
        assert run.events.of(k).t == pytest.approx(wanted, abs=1e-12)


@pytest.mark.parametrize("method", QUICK_METHODS)
def test_a_touch_is_no_event_and_two_zeros_beside_it_are_two(method):
    events = ("(x - 1)**2", "(x - 1)**2 - 1e-10", "(x - 1)**2 + 1e-13")
    settings = settings_of(method)
    run = core.integrate("harmonic_oscillator", (0.0, 10.0), (0.3, 2.0), events=(*events, "x - 1"), **settings)
    through = len(run.events.of(3))
    assert through >= 2
    assert run.events.counts.tolist() == [0, 2 * through, 0, through]


def test_an_event_at_the_start_counts_when_it_is_passed_later():
    run = core.integrate("harmonic_oscillator", (0.0, 10.0), (0.0, 1.0), tau=0.01, method="rk8", events="x")
    assert run.events.t[0] == pytest.approx(sum(HALVES) / 2, abs=1e-10)


@pytest.mark.parametrize("tau", [0.01, 0.1, 0.25])
@pytest.mark.parametrize("method", ["rk4", "gauss4", "taylor"])
def test_a_wall_met_at_the_end_of_a_step_is_one_event_and_so_is_a_terminal_zero(method, tau):
    ball = core.PiecewiseSystem(
        "ball", ("y", "v"), surfaces=("y",), regions={"+": core.Region(f=("v", "-1"))}, jumps={0: ("y", "-v")},
    )  # fmt: skip
    run = core.integrate(ball, (0.0, 10.0), (0.5, 0.0), tau=tau, method=method, events=("y", "v", "sin(pi*t)"))
    assert run.events.of(0).t == pytest.approx(run.crossings.t)
    assert run.events.of(1).t == pytest.approx([2.0, 4.0, 6.0, 8.0, 10.0][: len(run.events.of(1))])
    assert len(run.crossings) == 5
    assert len(run.events.of(1)) in (4, 5)
    assert run.events.of(2).t == pytest.approx(range(1, 10 if run.events.of(2).t[-1] < 9.5 else 11))
    ended = core.integrate(ball, (0.0, 10.0), (0.5, 0.0), tau=tau, method=method, events=Event("sin(pi*t)", 1, True))
    assert (ended.status, ended.t[-1], ended.x[-1, 0]) == (Status.EVENT, pytest.approx(2.0), pytest.approx(0.5))
    assert (np.diff(ended.t) > 0.0).all()


def test_a_stroboscopic_section_whose_step_divides_the_period_has_every_point():
    for n in (16, 50, 100):
        found = core.section(
            "harmonic_oscillator", (0.0, 100.0), (0.0, 1.0), of="sin(pi*t)", direction=1, points=40, tau=2.0 / n,
            method="rk4",
        )  # fmt: skip
        assert found.t == pytest.approx(np.arange(2, 82, 2))


@pytest.mark.parametrize("method", ["rk4", "taylor"])
def test_a_function_that_vanishes_along_the_run_has_no_events_and_is_told_of(method):
    run = core.integrate(FREE, (0.0, 50.0), events=("v - 1", "x - t"), **settings_of(method))
    assert not len(run.events)
    assert "'v - 1' is zero along" in run.message
    assert "'x - t' is zero along" in run.message


@pytest.mark.parametrize("method", ["rk4", "taylor"])
def test_poles_are_no_events_and_are_told_of(method):
    events = ("1/(x - 1)", "sqrt(x - 1)", "(x - 0.5)/(y - 0.3)", "x - 0.5")
    run = core.integrate("harmonic_oscillator", (0.0, 10.0), (0.1, 2.0), events=events, **settings_of(method))
    counts = run.events.counts
    assert counts[:2].tolist() == [0, 0]
    assert counts[2] == counts[3] > 3
    for text in events[:3]:
        assert f"{text!r} has a pole" in run.message
    assert f"{events[3]!r} has a pole" not in run.message


def test_events_while_sliding_are_those_of_scipy_along_the_surface():
    system = core.CATALOGUE["stick_slip"]
    run = core.integrate(system, (0.0, 60.0), events="sin(2*y) - 0.3", sliding="continue", **TAYLOR)
    slid = [k for k, mode in enumerate(run.events.mode) if mode == 2]
    assert len(slid) > 3
    field = system.laws.mode(2)
    for k in slid:
        before = int(np.searchsorted(run.crossings.t, run.events.t[k])) - 1
        t, x = run.crossings.t[before], run.crossings.x_after[before]

        def slope(s, y):
            return system.laws.numbers("slides", field.field, s, y.tolist(), system.parameter_array)

        found = solve_ivp(slope, (t, run.events.t[k] + 1e-3), x, "DOP853", events=lambda _, y: np.sin(2 * y[0]) - 0.3,
                          rtol=1e-12, atol=1e-13)  # fmt: skip
        assert np.abs(found.t_events[0] - run.events.t[k]).min() < 1e-10


def test_a_perturbation_moves_crossings_and_no_events():
    settings = {"tau": 0.01, "method": "prk8", "events": ("x - 0.5", "y")}
    exact = core.integrate("harmonic_oscillator", (0.0, 3.0), (0.0, 1.0), **settings)
    moved = core.integrate("harmonic_oscillator", (0.0, 3.0), (0.0, 1.0), perturbation_order=2, **settings)
    assert exact.crossings.t[0] != moved.crossings.t[0]
    assert exact.events.t[0] == moved.events.t[0]
    assert exact.events.t[1:] == pytest.approx(moved.events.t[1:], abs=1e-3)


@pytest.mark.parametrize("method", QUICK_METHODS)
def test_members_of_an_ensemble_have_the_events_of_their_runs(method):
    x0 = np.random.default_rng(2).uniform(-1.0, 1.0, (20, 2)) + np.array([0.0, 1.5])
    events = (Event("x - 0.2", 1), "y*x + 0.3", Event("x + y - 1.6", terminal=True))
    settings = {"max_events": 6, **settings_of(method)}
    many = core.ensemble("harmonic_oscillator", (0.0, 12.0), x0, events=events, record="events", **settings)
    for k, start in enumerate(x0):
        run = core.integrate("harmonic_oscillator", (0.0, 12.0), start, events=events, **settings)
        own = slice(many.events.offsets[k], many.events.offsets[k + 1])
        assert np.array_equal(many.events.t[own], run.events.t)
        assert np.array_equal(many.events.x[own], run.events.x)
        assert np.array_equal(many.events.number[own], run.events.number)
        assert (many.t[k], *many.x[k], many.status[k]) == (run.t[-1], *run.x[-1], run.status)
    assert {Status.EVENT, Status.EVENT_LIMIT} <= set(many.outcomes)


def test_events_are_a_sequence_and_columns_of_data_frames():
    run = core.integrate("harmonic_oscillator", (0.0, 20.0), tau=0.05, events=("x", "sin(t)"))
    assert [int(one.number[0]) for one in run.events] == run.events.number.tolist()
    assert list(run.events.columns(run.system.variables)) == [
        "t", "x", "y", "number", "direction", "mode", "rate", "residual",
    ]  # fmt: skip
    assert repr(run.events) == f"<Events: {run.events.counts[0]} of 'x', {run.events.counts[1]} of 'sin(t)'>"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"events": "x +"}, r"events\[0\]"),
        ({"events": ("x", "q")}, r"events\[1\]"),
        ({"events": ("x", 2)}, "depends neither on t nor on the state"),
        ({"events": 3}, "events = 3"),
        ({"events": Event("x", 2)}, "direction = 2"),
        ({"events": Event("x", terminal="yes")}, "terminal = 'yes'"),
        ({"events": "x", "max_events": 0}, "max_events = 0"),
        ({"cancel": 1}, "cancel = 1"),
        ({"progress": "loud"}, "progress = 'loud'"),
    ],
    ids=str,
)
def test_what_makes_no_sense_is_refused(arguments, words):
    with pytest.raises(ValueError, match=words):
        core.integrate("harmonic_oscillator", (0.0, 1.0), **arguments)


@pytest.mark.parametrize("hook", [{"executor": 4}, {"cancel": True}, {"progress": 1.0}], ids=str)
def test_hooks_that_are_none_are_refused_by_all_who_take_them(hook):
    calls = [
        lambda: core.ensemble("harmonic_oscillator", (0.0, 1.0), **hook),
        lambda: core.section("harmonic_oscillator", (0.0, 1.0), points=1, **hook),
        lambda: core.sweep("pendulum", (0.0, 1.0), "angle", [0.0], "q", points=1, **hook),
        lambda: core.stability_study("harmonic_oscillator", **hook),
        lambda: core.work_precision("harmonic_oscillator", **hook),
    ]
    calls += [] if "executor" in hook else [lambda: core.order_study("harmonic_oscillator", (0.1, 0.05), **hook)]
    for call in calls:
        with pytest.raises(ValueError, match=next(iter(hook))):
            call()


def test_steps_too_long_for_an_event_function_are_warned_of_and_others_not():
    for wave, warned in ((5, False), (20, True)):  # of 1 and 6 half-waves a step, at most
        run = core.integrate("harmonic_oscillator", (0.0, 6.0), method="rk8", tau=0.1, events=f"sin({wave}*y) + 0.071")
        assert ("too long for the event function" in run.message) == warned


@pytest.mark.parametrize("t_span", [(0.0, 3.0), (3.0, 0.0)])
@pytest.mark.parametrize("direction", [-1, 0, 1])
@pytest.mark.parametrize(
    ("h", "passed_over"),
    [("exp(-100*(t - 1.3)**2) - 0.5", True), ("tanh(100*(t - 1.3)) - tanh(100*(t - 1.31)) - 0.02", True),
     ("exp(-10*(t - 1.3)**2) - 0.5", False), ("sin(20*t + 0.1)", False)],
)  # fmt: skip
def test_events_that_a_taylor_step_passes_over_are_told(h, passed_over, direction, t_span):
    line = core.PiecewiseSystem("Line", ("x", "y"), ("1", "0"), ("1", "0"), "y - 100", x0=(0.0, 0.0))
    run = core.integrate(line, t_span, method="taylor", events=core.Event(h, direction=direction))
    assert (len(run.events) == 0) == passed_over
    assert ("too long for the event function" in run.message) == passed_over


def test_an_event_function_with_zeros_that_rounding_does_not_separate_does_not_hold_up_a_run():
    system = core.PiecewiseSystem(
        "Two frequencies", ("x", "y"), g="y", f_minus=("y", "-2.4127856825988854**2*x"),
        f_plus=("y", "-2.18327590670686**2*x"), x0=(0.634053681501844, -0.6839596160801352 * 0.9),
    )  # fmt: skip
    run = core.integrate(
        system, (5.2, 10.735320021573482), method="taylor", tolerance=1e-14, events="cos(40*x)*sin(3*y) - 0.01736",
        max_events=1000, max_steps=1000,
    )  # fmt: skip
    t = np.linspace(5.2, run.t[-1], 200_001)
    x, y = run.at(t).T
    signs = np.sign(np.cos(40 * x) * np.sin(3 * y) - 0.01736)
    assert abs(len(run.events) - np.count_nonzero(np.diff(signs))) <= (2 if "multiple zero" in run.message else 0)
