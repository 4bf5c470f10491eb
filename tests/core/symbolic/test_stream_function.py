"""Conserved quantities found by integration."""

import math

import numpy as np
import pytest
import sympy

import core
from core.symbolic.expressions import TIME
from core.symbolic.stream_function import stream_function
from tests.bounds import bounded_time

X, Y, K = sympy.symbols("x y k")


@pytest.mark.parametrize(
    ("field", "psi"),
    [
        ((Y, -X), (X**2 + Y**2) / 2),
        ((2 * Y, 3 * X**2 + K), Y**2 - X**3 - K * X),
        ((Y, -K * sympy.sin(X)), Y**2 / 2 - K * sympy.cos(X)),
        ((X * sympy.exp(Y), -sympy.exp(Y)), X * sympy.exp(Y)),
        ((X / Y, -sympy.log(Y)), X * sympy.log(Y)),
        ((1, 0), Y),
        ((X**2 * sympy.cos(2 * Y), -X * sympy.sin(2 * Y)), X**2 * sympy.sin(2 * Y) / 2),
    ],
    ids=str,
)
def test_stream_functions_of_known_fields_are_found(field, psi):
    found = stream_function(tuple(map(sympy.sympify, field)), (X, Y))
    assert found is not None
    assert not (found - psi).diff(X).simplify()
    assert not (found - psi).diff(Y).simplify()


@pytest.mark.parametrize(
    "field",
    [
        (Y, -X - Y / 10),  # divergence
        (Y, -X + sympy.sin(TIME)),  # forced
        (sympy.exp(Y**2), X),  # no antiderivative in our functions
        (sympy.cos(K * Y), X),  # one that has no value where k = 0
        (sympy.Integer(0), sympy.Integer(0)),  # every ψ will do, and none says anything
    ],
    ids=str,
)
def test_where_there_is_none_none_is_made_up(field):
    assert stream_function(field, (X, Y)) is None


@pytest.mark.parametrize(
    "law",
    [
        "sin(y)**20*cos(y)**20",
        "sin(k*y)**3*cos(k*y)**3",
        "(k + y + k**2 + 1/k)**64",
        "sin(exp(y))*exp(y)*log(y)",
        "y**60*exp(y)",
        "log(y)**40",
        "+".join(f"y**{n}/{12345678 + n}" for n in range(2, 60)),
    ],
)
def test_a_quantity_that_takes_long_to_find_or_to_write_is_not_sought(law):
    # sympy takes minutes over some of these integrals; others are longer than a declaration may be.
    fields = ("y", "-k*x"), (law, "-x")
    with bounded_time():
        assert core.PiecewiseSystem("own", ("x", "y"), *fields, "y", parameters={"k": 3.0}).psi_plus == ()


def test_only_the_plane_has_a_stream_function():
    assert stream_function((Y, -X, sympy.Integer(0)), (X, Y, K)) is None


def test_a_system_declared_without_psi_is_integrated_conservatively():
    system = core.PiecewiseSystem(
        "Pendulum", ("q", "p"), ("p", "-a*sin(q)"), ("p", "-sin(q)"), "q", parameters={"a": 2.0}, x0=(0.5, 1.0)
    )
    run = core.integrate(system, (0.0, 50.0), tau=0.05)
    assert len(run.crossings) > 10
    # Terms of ψ up to 3, each with a rounding or two.
    assert np.nanmax(np.abs(run.conserved_error())) <= 16 * 2.0**-52 * 3
    assert system.with_parameters(a=3.0).psi_minus == system.psi_minus


def test_a_psi_that_was_given_is_kept():
    system = core.PiecewiseSystem("own", ("x", "y"), ("y", "-x"), ("y", "-x"), "x", ("exp(x**2 + y**2)",), ())
    assert system.psi_minus == ("exp(x**2 + y**2)",)
    assert math.isclose(float(system.conserved(1, 0.0, (3.0, 4.0))[0]), 12.5)


def test_what_is_found_but_could_not_be_declared_is_left_out():
    system = core.PiecewiseSystem("own", ("x", "y"), ("sqrt(y**2) + y", "0"), ("y", "-x"), "x - 5")
    assert system.psi_minus == ()  # its gradient vanishes where y < 0
    assert system.psi_plus == ("x**2/2 + y**2/2",)
    assert system.with_parameters() == system
