"""What a run that could not go on says of what lies beside it."""

from __future__ import annotations

import math

import numpy as np
import pytest

import core
from core import Status

METHODS = ("rk2", "rk8", "gauss4", "taylor")


def steps(method: str, tau: float) -> dict[str, float]:
    return {} if method == "taylor" else {"tau": tau}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("term", ["1/sqrt(x)", "x**(-0.3)", "-log(x)"])
def test_a_field_that_is_not_bounded_at_the_surface_entered_is_told(term, method):
    system = core.PiecewiseSystem("enters", ("x", "y"), ("1", "1"), (f"2 + {term}", "1"), "x", x0=(-0.5, 0.0))
    run = core.integrate(system, (0.0, 2.0), method=method, **steps(method, 0.01))
    if run.status is Status.COMPLETED:  # a step from beside the surface, where rounding has put the state, is wrong
        assert run.warning
        return
    assert run.status is Status.SINGULAR, run.message
    assert run.t[-1] == pytest.approx(0.5, abs=1e-12)
    assert "the field is not bounded at the surface where this step begins" in run.message


@pytest.mark.parametrize("term", ["log((x - 1)**2)", "y*log((x - 1)**2)"])
def test_no_state_is_recorded_where_a_stage_of_the_step_to_the_surface_is_not_finite(term):
    system = core.PiecewiseSystem("log", ("x", "y"), ("1", f"0.2 + {term}"), ("1", "0.2"), "x - 1", x0=(0.3, 0.2))
    run = core.integrate(system, (0.0, 1.0), method="rk4", tau=0.01)  # its last stage is at the end
    assert run.status is Status.SINGULAR, run.message
    assert np.isfinite(run.x).all()


@pytest.mark.parametrize("method", METHODS)
def test_a_force_that_is_not_bounded_at_a_wall_is_told_and_no_smaller_step_is_advised(method):
    wall = core.PiecewiseSystem(
        "wall", ("x", "v"), surfaces=("x",), regions={"+": core.Region(("v", "-1 + 0.1/sqrt(x)"))},
        jumps={0: ("x", "-0.9*v")}, x0=(0.5, 0.0),
    )  # fmt: skip
    run = core.integrate(wall, (0.0, 2.0), method=method, **steps(method, 0.01))
    assert run.status is Status.SINGULAR, run.message
    assert "No step can begin there" in run.message
    assert "smaller step" not in run.message


@pytest.mark.parametrize("tau", [0.01, 0.3])
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("g", "place"), [("1/(x - 1)", 1.0), ("tan(x)", math.pi / 2), ("exp(1/(x - 1)) - 2", 1.0)])
def test_a_change_of_sign_that_is_no_zero_is_told_next_to_it(g, place, method, tau):
    system = core.PiecewiseSystem("pole", ("x", "y"), ("1", "-1"), ("1", "1"), g, x0=(0.1, 0.0))
    run = core.integrate(system, (0.0, 2.9), method=method, **steps(method, tau))
    assert run.status is not Status.COMPLETED
    assert "g changes its sign next to this place, but not by a zero" in run.message, run.message
    assert run.x[-1, 0] == pytest.approx(place, abs=1.01 * tau)


@pytest.mark.parametrize("method", METHODS)
def test_a_slide_to_where_the_surface_crosses_itself_says_so(method):
    # x = 0 attracts for y < 0 and repels for y > 0: from (0, 0) solutions leave to both sides.
    system = core.PiecewiseSystem(
        "double point", ("x", "y"), ("-0.566 - 0.05*cos(y)", "1.622"), ("0.566 - 0.05*cos(y)", "1.622 + 0.1*x"), "x*y",
        x0=(0.039, -1.481),
    )  # fmt: skip
    for y in (-1.481, -1.481 - 1e-9, -1.3, -0.7):
        run = core.integrate(system, (0.0, 3.0), (0.039, y), method=method, sliding="continue", **steps(method, 0.0777))
        assert run.status is not Status.COMPLETED
        assert run.x[-1] == pytest.approx((0.0, 0.0), abs=0.2)
        assert "crosses itself" in run.message or "both fields turn at once" in run.message, run.message
