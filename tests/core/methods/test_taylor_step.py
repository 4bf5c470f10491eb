"""The Taylor method: steps by tolerance, crossings on polynomials, psi kept."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import core
from core import Status

EPS = np.finfo(float).eps
SEEDS = ["harmonic_oscillator", "elliptic_curve", "pendulum", "rigid_body"]


@pytest.mark.parametrize("name", SEEDS)
@pytest.mark.parametrize("tolerance", [1e-5, 1e-8, 1e-11])
def test_the_error_follows_the_tolerance_across_crossings(name, tolerance):
    system = core.CATALOGUE[name]
    exact = core.reference_solution(system)
    run = core.integrate(system, (0.0, 40.0), method="taylor", tolerance=tolerance)
    assert run.status is Status.COMPLETED
    for k in (1, 10):
        assert run.crossings.t[k - 1] == pytest.approx(exact.crossing(k)[0], abs=100 * tolerance)
    # Local errors of the size of the tolerance, in some hundred steps, carried on by the flow.
    assert np.abs(run.x[-1] - exact.state(40.0)).max() <= 1000 * tolerance


@pytest.mark.parametrize("name", SEEDS)
def test_at_its_tightest_it_is_exact_to_round_off(name):
    system = core.CATALOGUE[name]
    run = core.integrate(system, (0.0, 40.0), method="taylor", tolerance=1e-15)
    # Each of some forty crossings may cost an ulp of the time.
    assert np.abs(run.x[-1] - core.reference_solution(system).state(40.0)).max() <= 1000 * EPS


@pytest.mark.parametrize("tolerance", [1e-2, 1e-6, 1e-12])
def test_psi_is_kept_whatever_the_tolerance(tolerance):
    # Evaluating psi rounds by some eps of its largest terms, 3 here.
    run = core.integrate(core.CATALOGUE["elliptic_curve"], (0.0, 60.0), method="taylor", tolerance=tolerance)
    assert np.nanmax(np.abs(run.conserved_error())) <= 16 * EPS * 3


def test_tau_caps_its_steps():
    run = core.integrate(core.CATALOGUE["harmonic_oscillator"], (0.0, 5.0), method="taylor", tau=0.1)
    assert np.diff(run.t).max() <= 0.1 + 8 * EPS  # times round by eps
    assert run.tau <= 0.1


def test_run_tau_is_the_longest_step_it_took():
    run = core.integrate(core.CATALOGUE["elliptic_curve"], (0.0, 20.0), method="taylor")
    assert np.diff(run.t).max() == pytest.approx(run.tau, rel=0.5)  # a crossing may cut it
    assert np.diff(run.t).max() <= run.tau + 32 * EPS


def test_time_may_run_back():
    system = core.CATALOGUE["elliptic_curve"]
    forward = core.integrate(system, (0.0, 20.0), method="taylor", tolerance=1e-14)
    back = core.integrate(system, (20.0, 0.0), x0=forward.x[-1], method="taylor", tolerance=1e-14)
    assert len(back.crossings) == len(forward.crossings)
    assert np.abs(back.x[-1] - system.x0).max() <= 1e-12  # a hundred local errors of 1e-14


def test_it_stops_at_a_pole():
    # x' = x² from 1: the solution 1/(1 − t) is at infinity at t = 1.
    system = core.PiecewiseSystem("pole", ("x", "y"), ("x**2", "0"), ("x**2", "0"), "y - 1", x0=(1.0, 0.0))
    run = core.integrate(system, (0.0, 2.0), method="taylor")
    assert run.status is Status.ESCAPED
    assert run.t[-1] == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("scale", [1e-100, 1e-20, 1e20, 1e100])
def test_units_of_time_make_no_difference(scale):
    system = core.PiecewiseSystem("k", ("x", "y"), ("k*y", "-k*x"), ("k*y", "-k*x"), "y", ("x**2 + y**2",),
                                  ("x**2 + y**2",), {"k": 1.0}, (1.0, 1.0))  # fmt: skip
    plain = core.integrate(system, (0.0, 10.0), method="taylor")
    scaled = core.integrate(system.with_parameters(k=1 / scale), (0.0, 10.0 * scale), method="taylor")
    assert scaled.steps == plain.steps
    assert scaled.crossings.t / scale == pytest.approx(plain.crossings.t, rel=8 * EPS)


def test_a_tolerance_is_for_methods_that_choose_their_steps():
    system = core.CATALOGUE["harmonic_oscillator"]
    with pytest.raises(ValueError, match=r"takes steps of size tau"):
        core.integrate(system, (0.0, 1.0), method="dmm2", tolerance=1e-9)
    for wrong in (0.0, 1.0, 1e-17, math.nan):
        with pytest.raises(ValueError, match="tolerance"):
            core.integrate(system, (0.0, 1.0), method="taylor", tolerance=wrong)
    with pytest.raises(ValueError, match="perturbation_order"):
        core.integrate(system, (0.0, 1.0), method="taylor", perturbation_order=2)


@pytest.mark.parametrize("rate", ["-20*z", "-1e5*z"])
def test_solution_passes_the_surface_at_the_origin_beside_a_decayed_mode(rate):
    f = ("3*t**2 + 1", rate)
    system = core.PiecewiseSystem("decayed", ("x", "z"), f_minus=f, f_plus=f, g="x", x0=(-2.0, 1.0))
    assert core.reference_solution(system).state(2.0) == pytest.approx([8.0, 0.0], abs=1e-12)


def test_step_from_beside_the_origin_is_as_long_as_that_from_it():
    f = ("1 + x**2/4", "-z")
    system = core.PiecewiseSystem("beside", ("x", "z"), f_minus=f, f_plus=f, g="x - 9")
    runs = [core.integrate(system, (1.0, 2.0), (0.0, z), method="taylor") for z in (0.0, 1e-43)]
    assert [run.status for run in runs] == [core.Status.COMPLETED] * 2
    assert runs[1].x[-1][0] == pytest.approx(runs[0].x[-1][0], rel=1e-14)
    assert runs[1].steps <= runs[0].steps + 2


def half_circles(a, b, v, t):
    """State at t of x″ = −b·x where x > 0 and −a·x where x < 0, from x = 0 with velocity v > 0."""
    up, down = math.sqrt(b), math.sqrt(a)
    t %= math.pi / up + math.pi / down
    if t < math.pi / up:
        return np.array([v / up * math.sin(up * t), v * math.cos(up * t)])
    t -= math.pi / up
    return np.array([-v / down * math.sin(down * t), -v * math.cos(down * t)])


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("unit", [1e-9, 1e-5, 1e5, 1e9])
def test_the_unit_of_one_variable_makes_no_difference(unit, seed):
    a, b, v = np.random.default_rng(seed).uniform([0.5, 0.5, 0.1], [4.0, 4.0, 2.0])
    system = core.PiecewiseSystem(
        "Two springs", ("x", "v"), ("v/s", "-a*x*s"), ("v/s", "-b*x*s"), "x", parameters={"a": a, "b": b, "s": unit},
        x0=(0.0, v * unit))  # fmt: skip
    run = core.integrate(system, (0.0, 20.0), method="taylor")
    assert run.status is Status.COMPLETED
    assert run.conserved_error().shape[1] == 1, "the energy is found, and kept"
    # Some fifty steps, each off by the tolerance of 1e-12 and more.
    assert np.abs(run.x[-1] / [1.0, unit] - half_circles(a, b, v, 20.0)).max() <= 1e-9


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("unit", [1.0, 1e6])
@pytest.mark.parametrize("tilt", [0.3, 1e-3])
def test_keeping_psi_costs_no_accuracy_where_its_gradients_are_nearly_parallel(unit, tilt, tolerance):
    """A rigid body that turns almost about an axis: small errors of ψ are not made large ones of the small rates."""
    field = ("y*z/s**2", "-2*x*z", "x*y")
    psi = ("x**2 + (y**2 + z**2)/s**2", "x**2 - z**2/s**2")
    ends = []
    for kept, accuracy in ((psi, tolerance), ((), tolerance), ((), 1e-14)):
        system = core.PiecewiseSystem(
            "Body", ("x", "y", "z"), field, field, "x - 5", kept, kept, {"s": unit},
            x0=(1.0, tilt * unit, -0.7 * tilt * unit))  # fmt: skip
        run = core.integrate(system, (0.0, 8.0), method="taylor", tolerance=accuracy)
        ends.append(run.x[-1] / [1.0, unit, unit])
    with_psi, without, exact = ends
    assert np.abs(with_psi - exact).max() <= 10.0 * np.abs(without - exact).max() + 1e-14


def test_five_sheets_of_one_surface_are_met_one_by_one_though_a_long_step_hides_them():
    a, d, sheets = -0.0611, 3.18e-6, range(5)
    surface = "*".join(f"(x - a - {k}*d)" for k in sheets)
    system = core.PiecewiseSystem(
        "Sheets", ("x", "y"), ("y", "-x"), ("c*y", "-c*x"), surface, parameters={"a": a, "d": d, "c": 7.6},
        x0=(0.0, 1.0))  # fmt: skip
    run = core.integrate(system, (0.0, 2.0), method="taylor")
    # x = sin θ rises to 1 and falls: it comes to the sheets, which lie below 0, from above.
    assert run.crossings.x[:, 0] == pytest.approx([a + k * d for k in reversed(sheets)], abs=1e-13)
    assert not run.warning


def test_a_power_whose_exponent_is_a_parameter_that_is_zero_is_one_also_where_its_base_vanishes():
    rng = np.random.default_rng(0)
    for base in ("x", "y", "(x*y)", "(x**2 + y**2)", "sin(x)"):
        a, b = rng.uniform(0.5, 2.0, 2)
        field, plain = ((f"{a}*{u} - y", f"x + {b}*t") for u in (f"{base}**k", "1"))
        runs = [
            core.integrate(
                core.PiecewiseSystem("Power", ("x", "y"), f, f, "x + 100", parameters={"k": 0.0}, x0=(0.0, 0.0)),
                (0.0, 2.0), method="taylor",
            )
            for f in (field, plain)
        ]  # fmt: skip
        assert runs[0].status is core.Status.COMPLETED
        np.testing.assert_allclose(runs[0].x[-1], runs[1].x[-1], rtol=1e-12)


@pytest.mark.parametrize("beside", [1e-12, -1e-6, 1e-3])
def test_a_step_from_beside_the_pole_of_a_tangent_is_as_long_as_others_where_the_field_has_none(beside):
    f = ("1/tan(x) + tan(x)/(1 + tan(x)**2)",)
    system = core.PiecewiseSystem("Tangents", ("x",), f, f, "x - 100", x0=(np.pi / 2 + beside,))
    run = core.integrate(system, (0.0, 0.2), method="taylor")
    assert len(run.t) <= 3
    assert not run.warning
    exact = solve_ivp(
        lambda t, x: 1.0 / np.tan(x) + np.sin(x) * np.cos(x), (0.0, 0.2), system.x0, rtol=1e-12, atol=1e-15
    )
    assert abs(run.x[-1, 0] - exact.y[0, -1]) < 1e-12


def test_a_coordinate_that_falls_far_below_the_others_is_followed_to_where_it_grows_again():
    """While x' = x(1 − x), y falls to 10⁻¹³, where the tolerance times x is a tenth of it; then y' = y(1 − y).

    Each part has a closed form.
    """

    def logistic(u, s):
        return u / (u + (1.0 - u) * np.exp(-s))

    for half in (7.0, 8.0, 9.0):
        turn = np.pi * half
        system = core.PiecewiseSystem(
            "by turns", ("x", "y"), ("-x", "y*(1 - y)"), ("x*(1 - x)", "-y"), f"sin(t/{half!r})", x0=(0.5, 0.5)
        )
        run = core.integrate(system, (0.0, 2.0 * turn - 1.0), method="taylor")
        x, y = logistic(0.5, turn), 0.5 * np.exp(-turn)
        x, y = x * np.exp(-(turn - 1.0)), logistic(y, turn - 1.0)
        assert run.crossing_count == 1
        assert run.x[-1] == pytest.approx([x, y], rel=1e-7)
