"""Derivatives are those of sympy, and do not ask what takes it minutes to answer."""

import time

import pytest
import sympy

from core.symbolic.derivative import derivative
from core.symbolic.expressions import parse

NAMES = ("x", "y", "a", "b", "c", "d", "h")


@pytest.mark.parametrize(
    "text", ["5", "x", "2**x", "x*y*exp(-x*a)", "sinh(x*y) + sin(x)", "1/(x - y)**2", "sqrt(x)*log(y)*tanh(x)"]
)  # fmt: skip
def test_a_derivative_is_the_expression_that_sympy_writes(text):
    u = parse(text, NAMES)
    for name in ("x", "y", "t"):
        assert derivative(u, sympy.Symbol(name)) == u.diff(sympy.Symbol(name))


@pytest.mark.parametrize("text", ["(-x)**1.51", "(-2*x)**(7/4)", "y*(-x)**2.5"])
def test_a_derivative_has_a_value_where_that_of_the_power_has_one(text):
    u, x = parse(text, NAMES), sympy.Symbol("x")
    assert derivative(u, x).subs(x, 0) == 0
    assert u.diff(x).subs(x, 0) is sympy.nan
    assert derivative(u, x).subs(x, -2) == pytest.approx(u.diff(x).subs(x, -2))


@pytest.mark.parametrize("text", ["x**a", "b*x**a + y", "(-x)**a", "(2*x*y)**(a + 1)", "x**a*sin(x)"])
def test_a_derivative_of_a_power_has_that_value_where_the_exponent_is_a_symbol(text):
    u, x = parse(text, NAMES), sympy.Symbol("x")
    numbers = {sympy.Symbol("a"): 3, sympy.Symbol("b"): 0.7, sympy.Symbol("y"): 1.3}
    written = derivative(u, x).xreplace(numbers)
    assert written.subs(x, 0) == 0
    assert written.subs(x, -2).evalf() == pytest.approx(u.xreplace(numbers).diff(x).subs(x, -2).evalf())
    moving = derivative(parse("y**x", NAMES), x)
    assert moving == parse("y**x*log(y)", NAMES)


def test_a_stage_in_the_field_of_a_nested_tanh_is_differentiated_at_once():
    begun = time.process_time()
    x, y = (f"({v} + (c + h*({a}/4 + {b}*(1/4 - 0.28867513))))" for v, a, b in (("x", "a", "b"), ("y", "c", "d")))
    u = parse(f"a - h*(-2*{x} - 2*(1 - tanh((-{x} + {y})**(-2))**2)/(-{x} + {y})**3)", NAMES)
    for name in NAMES[2:6]:
        derivative(u, sympy.Symbol(name))
    assert time.process_time() - begun < 10
