"""A run of a law, or with a ψ, whose terms cancel to few digits says so; no other one does."""

import numpy as np
import pytest
import sympy

import core
from core.diagnostics.cancellation import cancelled


def far(offset, **psi):
    """An oscillator about (offset, 0) of which the force is multiplied out, or has a ψ that is."""
    force = f"-(x - {offset}) - (x - {offset})**3"
    law = ("y", force if psi else str(sympy.expand(sympy.sympify(force))))
    return core.PiecewiseSystem("Far", ("x", "y"), law, law, "x + 10", x0=(offset + 1.0, 0.0), **psi)


def test_the_rate_that_is_rounding_is_named_and_by_how_much_it_is_off():
    run = core.integrate(far(10_000), (0.0, 5.0), method="rk8", tau=0.01)
    (said,) = cancelled(run)
    assert said.startswith("The terms of y' cancel, and their rounding changes it by 0.000")
    assert "write the field so that its terms do not cancel" in said
    assert run.warning == f"{said}."


def test_a_quantity_whose_gradient_is_rounding_is_told_of_methods_that_use_it():
    energy = str(sympy.expand(sympy.sympify("(x - 10000)**2/2 + (x - 10000)**4/4")))
    psi = (f"y**2/2 + {energy}",)
    system = far(10_000, psi_minus=psi, psi_plus=psi)
    for method, told in (("prk8", 1), ("dmm2", 1), ("rk8", 0)):
        run = core.integrate(system, (0.0, 5.0), method=method, tau=0.01)
        assert sum("terms of psi cancel" in said for said in cancelled(run)) == told


def test_a_reset_that_is_rounding_is_told():
    bounce = str(sympy.expand(sympy.sympify("10000 - (v - 10000)/2 - (v - 10000)**3/10")))
    fall = ("v - 10000", "-1")
    ball = core.PiecewiseSystem("Ball", ("x", "v"), fall, fall, "x", jump=("0", bounce), x0=(1.0, 10_000.0))
    (said,) = cancelled(core.integrate(ball, (0.0, 4.0), method="rk4", tau=0.01))
    assert said.startswith("The terms of v after a reset cancel, and their rounding changes it by ")
    assert "write the reset map so that" in said


@pytest.mark.parametrize("name", core.CATALOGUE)
def test_no_run_of_the_catalogue_is_warned(name):
    system = core.CATALOGUE[name]
    for method in ("rk4", "prk8", "taylor"):
        if system.laws.most_conserved or method != "prk8":
            run = core.integrate(system, (0.0, 40.0), method=method, tau=0.05, sliding="continue")
            assert not list(cancelled(run)), method


def test_what_rests_or_forgets_its_errors_is_not_warned():
    together = core.PiecewiseSystem("Together", ("x", "y"), ("y", "x"), ("y - x", "x - y"), "x - 1", x0=(1.5, 1.5))
    stiff = core.PiecewiseSystem("Stiff", ("x",), ("-1e9*(x - cos(t))",), ("-1e9*(x - cos(t))",), "x + 9", x0=(1.0,))
    assert not list(cancelled(core.integrate(together, (0.0, 1e4), method="rk4", tau=0.5)))
    assert not list(cancelled(core.integrate(stiff, (0.0, 1.0), method="gauss4", tau=0.01)))


def test_a_run_of_no_length_is_not_warned():
    run = core.integrate(far(10), (0.0, 0.0), method="rk4", tau=0.1)
    assert np.array_equal(run.t, [0.0])
    assert not list(cancelled(run))


@pytest.mark.parametrize("method", ["rk4", "rk8", "gauss4"])
@pytest.mark.parametrize(
    "after",
    ["1/(v + sqrt(2))", "-log((v + sqrt(2))**2)", "2 + tanh(1e18*(v + sqrt(2)))", "1 + ((sqrt(2) + v)**2)**(1/10)"],
)
def test_a_reset_map_that_varies_too_fast_where_the_state_meets_it_is_told(after, method):
    """The ball hits the ground with v = −√2, known to its last digit at best."""
    ball = core.PiecewiseSystem("ball", ("x", "v"), ("v", "-1"), ("v", "-1"), "x", jump=("x", after), x0=(1.0, 0.0))
    run = core.integrate(ball, (0.0, 1.5), tau=0.01, method=method)
    assert run.status is not core.Status.COMPLETED or run.warning, run.crossings.x_after
    smooth = core.PiecewiseSystem("ball", ("x", "v"), ("v", "-1"), ("v", "-1"), "x", jump=("x", "-v**3"), x0=(1.0, 0.0))
    assert not core.integrate(smooth, (0.0, 1.5), tau=0.01, method=method).warning
