"""What a run that ends early advises."""

import re

import numpy as np
import pytest

import core
from core import Status
from core.integration.outcome import Cause, Ending, outcome
from core.integration.overflow import overflowing
from core.integration.recorded import Point


def oscillator_and_pendulum(unit):
    """Two systems that know nothing of each other; the velocity of the first is given in another unit."""
    force, energy = f"-{unit}*2*(q + 0.3*q**3)", f"v**2/(2*{unit}**2) + q**2 + 0.15*q**4"
    law = {"-": (f"v/{unit}", force, "w", "-sin(r)"), "+": (f"v/{unit}", force, "w", "-1.5*sin(r)")}
    psi = {"-": (energy, "w**2/2 - cos(r)"), "+": (energy, "w**2/2 - 1.5*cos(r)")}
    return core.PiecewiseSystem(
        "Both", ("q", "v", "r", "w"), law["-"], law["+"], "r - 0.1", psi_minus=psi["-"], psi_plus=psi["+"],
        x0=(0.9, 0.4 * unit, -0.5, 0.3),
    )  # fmt: skip


def test_a_step_that_fails_for_the_units_of_the_variables_says_so_and_names_methods_that_do_not():
    assert core.integrate(oscillator_and_pendulum(1.0), (0.0, 20.0), tau=0.01).status is Status.COMPLETED
    system = oscillator_and_pendulum(1e6)
    run = core.integrate(system, (0.0, 20.0), tau=0.01)
    assert run.status is Status.NO_CONVERGENCE
    assert re.search(r"v is about [12],000,000 times as large as [qrw]: write the system in units", run.message)
    others = re.search(r"another method that keeps psi \((.*?)\)", run.message)[1].split(", ")
    assert {core.integrate(system, (0.0, 20.0), method=name, tau=0.01).status for name in others} == {Status.COMPLETED}


def test_where_psi_fixes_the_orbit_units_make_no_difference_and_nothing_is_said_of_them():
    for unit in (1.0, 1e6):
        force, energy = f"-{unit}*2*(q + 0.3*q**3)", f"v**2/(2*{unit}**2) + q**2 + 0.15*q**4"
        law = (f"v/{unit}", force)
        system = core.PiecewiseSystem(
            "One", ("q", "v"), law, law, "q - 0.1", psi_minus=(energy,), psi_plus=(energy,), x0=(0.9, 0.4 * unit)
        )
        assert core.integrate(system, (0.0, 20.0), tau=0.01).status is Status.COMPLETED


def test_a_variable_that_is_zero_up_to_rounding_is_not_told_to_be_small():
    """A made-up end, since a step of variables of one size seldom fails."""
    last = Point(2.0, (0.9, 1e-17, -0.5, 0.3), 0)
    system, method = oscillator_and_pendulum(1.0), core.METHODS["dmm2"]
    for velocity, told in ((1e-16, False), (1e4, True)):
        end = Ending(system, method, Status.NO_CONVERGENCE, last, Cause(0.01), (0.9, velocity, 1.2, 0.9))
        assert ("times as large" in outcome(end)) is told


def test_bodies_whose_touches_are_moved_by_an_eighth_of_a_unit_are_followed():
    """In 20 units of time they touch often; a jump behind the surface leads back through it."""
    start = (
        0.8125756816199229, -0.0851382801066488, -0.5255467002115067, -0.039213845873828916, -0.03625384048465918,
        0.6900433623487354, 0.03442706978205977, 0.09687777360854886, -0.09662709873947736, -0.5453478434928178,
        -0.026951042541532928, 0.1228691653435544,
    )  # fmt: skip
    run = core.integrate("three_bodies", (0.0, -20.0), start, 0.1267061875152385, "rk4", perturbation_order=1)
    assert run.status is Status.COMPLETED


def test_a_perturbation_that_moves_the_state_beyond_a_surface_is_blamed_and_not_the_program():
    """A made-up end, since such a state seldom fails to lead back."""
    system, last = oscillator_and_pendulum(1.0), Point(2.0, (0.9, 0.1, -0.5, 0.3), 0)
    end = Ending(system, core.METHODS["rk4"], Status.CONTRADICTION, last, Cause(0.127, shift=0.127))
    assert "Perturb crossing times by less than 0.127" in outcome(end)
    assert "defect" not in outcome(end)


def test_a_region_without_a_law_into_which_a_perturbation_may_have_led_is_said_to_be_that():
    """The ball meets a wall at a speed of about 1; moved on by 2.2 from there, it is beyond the other wall."""
    run = core.integrate("two_walls", (0.0, 20.0), tau=1.0, perturbation_order=1, perturbation_scale=2.2)
    assert run.status is Status.UNDECLARED
    assert "perturbed crossing, by 2.2, has moved it there: perturb by less" in run.message


def test_steps_that_shorten_towards_where_a_law_ceases_to_be_defined_are_told_so():
    """x′ = √(1 − x) + 2 comes to x = 1 with rate 2, where the solution ends."""
    system = core.PiecewiseSystem("Root", ("x", "y"), ("sqrt(1 - x) + 2", "x - y"), ("1", "0"), "x - 5", x0=(0.0, 0.0))
    run = core.integrate(system, (0.0, 1.0), method="taylor", max_steps=1000)
    assert run.status is Status.STEP_LIMIT
    assert "f_minus is not defined a step ahead" in run.message


def _ended(f_minus, f_plus, g, x0, method="rk4"):
    system = core.PiecewiseSystem("Surface", ("x", "y"), f_minus, f_plus, g, x0=x0)
    return core.integrate(system, (0.0, 4.0), method=method, tau=None if method == "taylor" else 0.05)


@pytest.mark.parametrize("method", ["rk4", "taylor"])
@pytest.mark.parametrize(
    ("f_minus", "f_plus", "g", "x0"),
    [
        (("1", "0"), ("0", "-1"), "y", (1.0, 1.0)),
        (("1", "x - 1"), ("0", "-1"), "y", (1.0, 1.0)),
        (("0", "1"), ("1", "0"), "(x - 0.5)**2 + y**2 - 0.0004", (-1.0, 0.0)),
        (("0", "1"), ("1 + x", "0"), "y", (0.0, -1.0)),
    ],
)
def test_a_surface_that_is_met_for_certain_is_not_said_to_be_touched(method, f_minus, f_plus, g, x0):
    run = _ended(f_minus, f_plus, g, x0, method)
    assert run.status is Status.GRAZING
    assert "meets the surface where the field beyond is tangent to it, or vanishes" in run.message


@pytest.mark.parametrize(
    "g", ["(x - y**2 - 1)**3", "sin(x - 1)**5*(2 + y)", "(x - 1 - t**2/8)**3", "x**3 - 3*x**2 + 3*x - 1"]
)
@pytest.mark.parametrize("method", ["dmm2", "rk4", "rk8"])
def test_where_the_gradient_of_g_vanishes_on_the_surface_that_is_said_and_no_touch(g, method):
    run = _ended(("1", "0.3"), ("0.1", "-1"), g, (0.2, 0.1), method)
    assert run.status is Status.GRAZING
    assert "the gradient of g vanishes on the surface" in run.message
    assert "Write g such that it has a simple zero" in run.message


@pytest.mark.parametrize("g", ["x - 1", "1e12*(x - 1)*(2 + x)", "1 - x**3"])
def test_where_the_gradient_of_g_does_not_vanish_a_touch_is_said_to_be_one(g):
    run = _ended(("y", "-x"), ("y", "-x"), g, (0.0, 1.0), "rk8")
    assert run.status is Status.GRAZING
    assert "gradient" not in run.message


def test_what_rests_on_the_surface_or_begins_there_is_not_said_to_touch_it():
    rests = _ended(("y", "-x"), ("y", "-x"), "x", (0.0, 0.0))
    assert "on the surface, where all fields vanish, and rests there" in rests.message
    begins = _ended(("1", "0"), ("1", "0"), "y", (0.0, 0.0))
    assert "the initial value is on the surface, and a field is tangent to it there" in begins.message
    assert all("touches" not in run.message for run in (rests, begins))


@pytest.mark.parametrize("method", ["rk2", "rk4", "rk8", "gauss4", "taylor"])
@pytest.mark.parametrize(
    ("bend", "start", "tau"), [(1, -1.0, 0.01), (2, -2.0, 0.01), (0.5, -2.0, 1 / 3), (4, -0.5, 0.1)]
)
def test_a_touch_at_the_end_of_a_step_is_told_and_its_states_are_in_order(method, bend, start, tau):
    """rk4 and gauss4 meet the surface within rounding, and come back to it at once: that crossing is none."""
    law, level = ("1", f"-2*{bend}*x"), bend * start**2
    system = core.PiecewiseSystem("Parabola", ("x", "y"), law, law, f"y - {level}", x0=(start, 0.0))
    run = core.integrate(system, (0.0, 4.0), method=method, tau=None if method == "taylor" else tau)
    assert run.status is Status.GRAZING or "the run passes the surface at a distance below" in run.message
    assert (np.diff(run.segment) >= 0).all()
    assert run.segment.max() <= run.crossing_count


@pytest.mark.parametrize("law", ["sqrt(t - 0.3)", "(t - 0.3)**(4/3)"])
@pytest.mark.parametrize("method", ["rk8", "taylor"])
def test_a_law_that_begins_as_it_is_entered_is_told_so_and_the_advice_helps(method, law):
    """The surface y = 0 is met at t = 0.3, up to rounding, before which the law beyond it has no value."""
    run = _ended((law, "-1"), ("1", "-1"), "y", (0.0, 0.3), method)
    assert run.status is Status.NO_CONVERGENCE
    assert "f_minus has values on one side of this time only" in run.message
    assert "smaller step size" not in run.message
    assert ("take rk8" in run.message) is (method == "taylor")
    mended = {"sqrt(t - 0.3)": "((t - 0.3)**2)**0.25", "(t - 0.3)**(4/3)": "((t - 0.3)**2)**(2/3)"}[law]
    assert _ended((mended, "-1"), ("1", "-1"), "y", (0.0, 0.3), "rk8").status is Status.COMPLETED


@pytest.mark.parametrize(
    ("f", "method", "term"),
    [
        ("tanh(400*(x - 1))", "dmm2", "cosh(400*x - 400)"),  # of its ψ
        ("1/(1 + exp(-500*(x - 2)))", "taylor", "exp(1000 - 500*x)"),
        ("1/cosh(300*(x - 3))", "taylor", "cosh(300*x - 900)"),
    ],
)
def test_a_term_that_is_too_large_for_a_number_is_named(f, method, term):
    system = core.PiecewiseSystem("steep", ("x", "y"), ("1", f), ("1", f), "x - 5", x0=(0.0, 0.0))
    run = core.integrate(system, (0.0, 4.0), method=method, tau=None if method == "taylor" else 0.01)
    assert run.status is Status.NO_CONVERGENCE
    assert f"{term}, or a power of it, is too large for a floating-point number here" in run.message


@pytest.mark.parametrize(
    ("term", "named"), [("exp(-x)", ""), ("exp(x)", "exp(x)"), ("1/cosh(-x)", "cosh(x)"), ("1", "")]
)
def test_of_the_terms_of_a_law_only_one_that_is_large_is_named(term, named):
    system = core.PiecewiseSystem("terms", ("x",), (term,), (term,), "x - 900")
    assert overflowing(system, Point(0.0, (800.0,), 0), keeps_psi=False) == named
