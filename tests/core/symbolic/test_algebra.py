"""Algebra keeps the values of expressions, whatever powers are in them, and takes no time over high ones."""

import numpy as np
import pytest
import sympy

from core.symbolic import algebra

X, Y = sympy.symbols("x y")
LONG, OTHER = sympy.Rational("1.94196018472"), sympy.Rational("0.7413388120")
E = sympy.exp

EXPRESSIONS = [
    (E(-2 * LONG * (X - OTHER)) - E(-LONG * (X - OTHER))) / E(-LONG * X),
    (E(LONG * X) ** 2 - 1) / (E(LONG * X) - 1),
    Y * E(OTHER * X) / (1 + E(LONG * X + OTHER * Y)) + X / Y,
    (Y**LONG - Y ** (-LONG)) / (Y ** (2 * LONG) - 1),
    sympy.sqrt(Y) * E(-LONG * X**2 + OTHER * X) / (Y - 1),
    (X**2 - Y**2) / (X - Y),
    2 ** (LONG * X) / (2 ** (LONG * X) + 1),
]


def value(u, x, y):
    return complex(u.subs({X: x, Y: y}).evalf(30))


@pytest.mark.parametrize("u", EXPRESSIONS)
@pytest.mark.parametrize("operation", [algebra.cancel, algebra.together, algebra.factor, algebra.simplify])
def test_an_expression_keeps_its_values(u, operation):
    found = operation(u)
    for x, y in ((0.37, 1.61), (-0.52, 0.83)):
        assert value(found, x, y) == pytest.approx(value(u, x, y), rel=1e-13)


def test_what_cancels_is_cancelled_in_high_powers_too():
    assert algebra.cancel(EXPRESSIONS[1]) == E(LONG * X) + 1
    assert sympy.expand(algebra.gcd(E(LONG * X) ** 2 - 1, E(LONG * X) - 1) - E(LONG * X) + 1) == 0
    content, factors = algebra.factor_list(E(2 * LONG * X) - 2 * E(LONG * X) - 3)
    assert content == 1
    assert {one for one, _ in factors} == {E(LONG * X) - 3, E(LONG * X) + 1}


def test_small_powers_are_left_to_sympy():
    for u in (EXPRESSIONS[5], (E(2 * X) - 1) / (E(X) - 1), sympy.sqrt(X) / (X + 1)):
        assert algebra.cancel(u) == sympy.cancel(u)


@pytest.mark.parametrize("u", [E(-LONG * X + OTHER), X * E(LONG * X), sympy.cos(LONG * X) * Y, 1 / (1 + OTHER * X**2)])
def test_an_antiderivative_has_the_integrand_as_its_derivative(u):
    found = algebra.antiderivative(u, X)
    assert not found.has(sympy.Integral, sympy.Piecewise)
    for x in np.linspace(-0.9, 0.8, 3):
        assert value(found.diff(X), x, 1.3) == pytest.approx(value(u, x, 1.3), rel=1e-13)
