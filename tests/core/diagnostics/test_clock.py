"""What is said of runs whose clock does not resolve their steps."""

import pytest

import core
from core import Status


def spring(force="0", **given):
    """Two springs, one on each side of x = 0."""
    return core.PiecewiseSystem(
        "Springs", ("x", "v"), ("v", f"-3*x + {force}"), ("v", f"-x + {force}"), "x", x0=(0.5, 1.0), **given
    )


@pytest.mark.parametrize("t0", [1e13, 1e14, 4e15, -1e16])
@pytest.mark.parametrize("method", ["taylor", "rk8"])
def test_of_a_system_that_does_not_name_time_it_does_not_matter_when_a_run_begins(method, t0):
    tau = None if method == "taylor" else 0.01
    early, late = (core.integrate(spring(), (t, t + 20.0), tau=tau, method=method) for t in (0.0, t0))
    assert late.x[-1] == pytest.approx(early.x[-1], abs=1e-12)
    assert late.warning == early.warning == ""


def test_steps_that_are_too_long_are_told_whatever_the_clock_says():
    run = core.integrate(spring(), (1e14, 1e14 + 60.0), tau=1.0, method="rk4")
    assert run.status is Status.COMPLETED
    assert run.warning.startswith("Times counted from the start: ")
    assert run.warning.endswith(core.integrate(spring(), (0.0, 60.0), tau=1.0, method="rk4").warning)


@pytest.mark.parametrize("method", ["taylor", "rk8"])
def test_where_a_law_names_the_time_the_clock_is_blamed_and_not_the_steps(method):
    tau = None if method == "taylor" else 0.01
    run = core.integrate(spring("cos(t)"), (1e13, 1e13 + 20.0), tau=tau, method=method)
    assert run.warning.startswith("Times near t = 1e+13 are rounded to 0.002, and ")
    assert "no step size helps" in run.warning


@pytest.mark.parametrize(
    ("t0", "tau", "k", "m"),
    [(1.38751e9, 0.0229, 2.26, 0.47), (5.67026e9, 0.0832, 2.65, 0.31), (2.4474e8, 0.0088, 2.27, 0.3)],
)
def test_late_steps_that_the_clock_just_resolves_are_judged_as_early_ones(t0, tau, k, m):
    # Drawn at random: of the first two the order, of the last a step of 1e-5 beside a crossing was in doubt.
    field = ("y", "-k*sin(x)")
    system = core.PiecewiseSystem(
        "Late", ("x", "y"), field, field, "x - m", parameters={"k": k, "m": m}, x0=(1.0, 0.0)
    )  # fmt: skip
    for t in (0.0, t0):
        assert core.integrate(system, (t, t + 7.0), tau=tau, method="rk8").warning == ""


def test_an_event_function_names_the_time_as_a_law_does():
    run = core.integrate(spring(), (1e13, 1e13 + 20.0), tau=0.01, method="rk8", events=("sin(t)",))
    assert run.warning.startswith("Times near t = 1e+13 are rounded to 0.002, and tau is 0.01")


@pytest.mark.parametrize("t_end", [5e-324, 1e-320, 1e-310, 1e-300])
def test_over_times_that_hardly_differ_from_zero_no_errors_grow(t_end):
    run = core.integrate(spring(), (0.0, t_end), (1.0, 0.0), tau=0.02, method="rk8")
    assert run.warning == ""
