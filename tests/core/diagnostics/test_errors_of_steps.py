"""What is said of errors of the steps that have grown, and of those that only shift the time."""

from __future__ import annotations

import pytest

import core

FORCED = "-0.26116104*x - 2.11652528*x**3 + 2.11652528*cos(1.83296709*t)"


def forced() -> core.PiecewiseSystem:
    """A driven hardening spring, of which errors grow 300-fold until t = 15.65, where x = 1.15 (DOP853)."""
    return core.PiecewiseSystem("Forced", ("x", "v"), ("v", FORCED), ("v", FORCED), "x - 1e6", x0=(0.0, 0.0))


@pytest.mark.parametrize("record", ["steps", "end"])
@pytest.mark.parametrize(("tau", "told"), [(0.158725, True), (0.0396812, False)])
def test_errors_that_grow_to_the_size_of_the_state_are_told_whatever_is_recorded(record, tau, told):
    run = core.integrate(forced(), (0.0, 15.6544), tau=tau, method="rk4", record=record)
    assert ("have grown to a tenth" in run.warning) is told, run.warning


@pytest.mark.parametrize("until", [3.5, 3.598])
def test_a_run_led_off_an_unstable_orbit_is_told_though_one_in_half_steps_is_led_off_likewise(until):
    # The solution is (cos t, sin t). Errors grow like exp(69 t) along one direction: in a step the finer run comes past
    # the state of the other, from which it is a quarter of the range away at the same time.
    u, v = "(x - cos(t))", "(y - sin(t))"
    along, aside = f"69*(0.683*{u} + 0.73*{v})", f"0.66*(0.683*{v} - 0.73*{u})"
    law = (f"0.683*{along} - 0.73*{aside} - sin(t)", f"0.73*{along} + 0.683*{aside} + cos(t)")
    unstable = core.PiecewiseSystem("unstable", ("x", "y"), law, law, "x + 0.44", x0=(1.0, 0.0))
    run = core.integrate(unstable, (0.0, until), tau=0.0213, method="rk4")
    assert "have grown to a tenth" in run.warning, run.message


@pytest.mark.parametrize("key", ["harmonic_oscillator", "bouncing_ball", "elliptic_curve", "moving_interface"])
def test_a_shift_in_time_along_the_orbit_is_not_told(key):
    # Elliptic curve: the state is a fifth of the range from that at the same time, on the orbit all the same.
    run = core.integrate(core.CATALOGUE[key], (0.0, 20.0), tau=0.1, method="dmm2")
    assert "errors of the steps" not in run.warning


@pytest.mark.parametrize("until", [1500.0, 2000.0])
def test_a_shift_in_time_by_several_periods_is_not_told_up_to_the_end(until):
    # The run is early: at its end it is where the run in half steps comes after the end.
    run = core.integrate(core.CATALOGUE["elliptic_curve"], (0.0, until), (-1.0, -1.0), tau=0.08, method="dmm2")
    assert "errors of the steps" not in run.warning


def test_a_run_off_the_orbit_is_told_also_where_nothing_depends_on_time():
    # x runs over the top with rk2, and swings back with small steps (energy 0.99 of that at the top).
    pendulum = core.PiecewiseSystem("Pendulum", ("x", "v"), ("v", "-sin(x)"), ("v", "-sin(x)"), "x - 100")
    for tau, told in ((0.2, True), (0.01, False)):
        run = core.integrate(pendulum, (0.0, 40.0), (3.0, 0.0), tau=tau, method="rk2")
        assert ("the errors of its steps decide where it goes on" in run.warning) is told, run.warning


@pytest.mark.parametrize(("method", "tau", "until"), [("rk4", 0.005, 20.0), ("taylor", 9.0, 20.0), ("rk8", 0.01, 14.0)])
def test_runs_of_a_chaotic_system_are_told_from_when_on_they_part_from_the_solution(method, tau, until):
    # On a thin attractor some other state is always near. rk8 is right up to 14 (DOP853), the others are not up to 20.
    law = ("10*(y - x)", "x*(28 - z) - y", "x*y - 2.67*z"), ("10*(y - x)", "x*(30 - z) - y", "x*y - 2.5*z")
    lorenz = core.PiecewiseSystem("Lorenz", ("x", "y", "z"), *law, "x", x0=(1.0, 1.0, 20.0))
    settings = {"tolerance": 1e-5} if method == "taylor" else {}
    run = core.integrate(lorenz, (0.0, until), tau=tau, method=method, **settings)
    assert ("errors of the steps" in run.warning) is (until > 14.0), run.warning


def test_two_phases_that_drift_apart_are_told():
    # rk2 is off by 0.24 of the range from every state of the solution around that time.
    torus = core.PiecewiseSystem(
        "Torus", ("x", "u", "y", "v"), *[("u", "-x", "v", "-2*y")] * 2, "x - 50", x0=(1, 0, 1, 0)
    )
    assert "not counting a shift in time" in core.integrate(torus, (0.0, 2400.0), tau=0.05, method="rk2").warning


def test_a_finer_run_that_fails_tells_nothing_beyond():
    # With ψ whose coordinates differ by 1e6 in size, a smaller tolerance finds no landing; the run is right to 1e-8.
    law = ("v/S", "-0.5140988522256524*x*S"), ("v/S", "-3.552619199946898*x*S")
    system = core.PiecewiseSystem("Scales", ("x", "v"), *law, "x", parameters={"S": 3.60935e06}, x0=(1.0, 2.02561e06))
    assert "errors of the steps" not in core.integrate(system, (0.0, 20.0), method="taylor").warning


def test_a_run_that_leaves_a_closed_orbit_and_blows_up_is_told_and_one_that_meets_a_pole_is_not():
    # rk2 spirals outwards, to an orbit that is unbounded; the solution is periodic.
    left = core.integrate(core.CATALOGUE["elliptic_curve"], (0.0, 200.0), (-1.0, -1.0), tau=0.08, method="rk2")
    assert left.status is core.Status.ESCAPED
    assert "errors of the steps" in left.warning
    for tau in (0.05, 0.001):  # x = 1/(1 - t)
        pole = core.PiecewiseSystem("Pole", ("x", "y"), ("x**2", "1"), ("x**2", "1"), "x - 1000", x0=(1.0, 0.0))
        assert not core.integrate(pole, (0.0, 2.0), tau=tau, method="rk4").warning


def test_a_perturbation_of_crossings_is_no_error_of_the_steps():
    run = core.integrate(
        core.CATALOGUE["harmonic_oscillator"],
        (0.0, 20.0),
        tau=0.01,
        method="rk4",
        perturbation_order=1,
        perturbation_scale=20.0,
    )
    assert "errors of the steps" not in run.warning


def test_runs_of_a_single_step_are_judged():
    assert core.integrate(forced(), (0.0, 1e-3), tau=0.01, method="rk4").warning == ""
    ends = core.Event("t - 2", terminal=True)  # within the first step of a run: no step has been taken whole
    run = core.integrate(core.CATALOGUE["harmonic_oscillator"], (0.0, 20.0), method="taylor", events=ends)
    assert (run.t[-1], run.warning) == (2.0, "")


def test_a_phase_of_a_driven_system_is_told():
    # The stiffness changes with sin t: x is off by 0.3 of its range at t = 400 (closed form), in phase alone.
    driven = core.PiecewiseSystem("Clock", ("x", "v"), ("v", "-4*x"), ("v", "-x"), "sin(t) + 1e-12*x", x0=(1.0, 0.0))
    assert "errors of the steps" in core.integrate(driven, (0.1, 400.0), tau=0.3, method="rk4").warning


def test_an_error_of_a_state_that_hardly_moves_yet_is_not_told():
    pushed = ("v", "-400*x - 0.6*v + 1200*exp(-400*(t - 131.1)**2)")  # up to t = 130, |x| < 1e-200
    system = core.PiecewiseSystem("Pushed", ("x", "v"), pushed, pushed, "x - 50", x0=(0.0, 0.0))
    assert core.integrate(system, (0.0, 300.0), tau=0.05, method="rk8").warning == ""


def test_a_coarse_tolerance_is_told_and_a_fine_one_is_not():
    for tolerance, told in ((1e-3, True), (1e-10, False)):
        run = core.integrate(forced(), (0.0, 80.0), method="taylor", tolerance=tolerance)
        assert ("take a smaller tolerance" in run.warning) is told, run.warning


@pytest.mark.parametrize(
    ("law", "start", "end"),
    [
        ("3*t**2*cos(t**3)", 0.0, 8.0), ("2*t*cos(t**2)", 0.0, 40.0), ("exp(t)*cos(exp(t))", 0.8414709848078965, 6.0),
        ("1000*x*(1 - x)", 1e-300, 2.0), ("1000*x*(1 - x)", 1e-200, 2.0),
    ],
)  # fmt: skip
def test_long_curved_steps_and_states_that_hardly_move_are_no_errors(law, start, end):
    """Chirps in steps of half a period, which are right to 1e-11, and a state that rests at 0 for most of its time."""
    system = core.PiecewiseSystem("Curved", ("x",), (law,), (law,), "x - 1e9", x0=(start,))
    assert core.integrate(system, (0.0, end), method="taylor").warning == ""


def test_a_finer_run_that_is_not_known_within_each_of_its_steps_raises_no_error():
    # Beside the surface that moves, where the field is 0/0, some shorter step of the finer run has no solution.
    g = "x - 0.83*sin(t)"
    law = f"-x + 0.3*((exp({g}) - 1)/({g}))"
    system = core.PiecewiseSystem("moving", ("x", "y"), ("y", "-x"), ("y", law), g, x0=(1.3, 0.2))
    assert core.integrate(system, (0.0, 5.0), tau=0.005, method="rk8").message
