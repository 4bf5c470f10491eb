"""What people type is read as they mean it."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.symbolic import parse
from pwsviz.text.typed import as_python, rates, split


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("2q", "2*q"), ("x^2", "x**2"), ("2x^2 y", "2*x**2*y"),
        ("2e3x", "2e3*x"), ("2e", "2*e"), ("3exp(x)", "3*exp(x)"),
        ("1e-3", "1e-3"), ("x1", "x1"),
        ("x₁ + 2x₂", "x1 + 2*x2"), ("x1 + 2x1", "x1 + 2*x1"), ("2(x + 1)", "2*(x + 1)"), ("(a)(b)", "(a)*(b)"),
        ("sin(x)cos(x)", "sin(x)*cos(x)"), ("sqrt(2)/2", "sqrt(2)/2"), ("a_2(x)", "a_2(x)"), ("0.5k", "0.5*k"),
        ("2 pi", "2*pi"), ("−3·x × y", "-3*x * y"), (".5x", ".5*x"), ("10^-3", "10**-3"), ("1.e2x", "1.e2*x"),
        ("12x", "12*x"), ("x.5", "x.5"),
    ],
)  # fmt: skip
def test_products_and_powers_are_written_out(typed, meant):
    assert as_python(typed) == meant


@given(st.text("xyqe 0123.+-*/()", max_size=20))
def test_what_could_be_read_is_read_as_before(text):
    try:
        before = parse(text, ("x", "y", "q"))
    except ValueError:
        return
    assert parse(as_python(text), ("x", "y", "q")) == before


@pytest.mark.parametrize(
    ("text", "items"),
    [
        ("", []),
        ("x", ["x"]),
        ("x, y; z\nw", ["x", "y", "z", "w"]),
        ("y,\n-x,\n", ["y", "-x"]),
        ("f(x, y), [0.1, 10]; (a; b)", ["f(x, y)", "[0.1, 10]", "(a; b)"]),
        ("(x +\ny), z", ["(x + y)", "z"]),
        ("x)), y", ["x))", "y"]),
        ("x\r\ny\rz", ["x", "y", "z"]),
    ],
)
def test_lists_are_split_where_no_brackets_are_open(text, items):
    assert split(text) == items


@pytest.mark.parametrize(
    ("text", "laws"),
    [
        ("x' = v, v' = -x - mu*sign(v - 1)", ["v", "-x - mu*sign(v - 1)"]),
        ("v′ = -x\nx’=v", ["v", "-x"]),
        ("dx/dt = v; dv/dt = -max(x, 0)", ["v", "-max(x, 0)"]),
        ("v, -x", ["v", "-x"]),
        ("x' = v", ["x' = v"]),
        ("y' = v, v' = 2", ["y' = v", "v' = 2"]),
        ("x' = v, x' = 2", ["x' = v", "x' = 2"]),
    ],
)
def test_a_field_may_be_typed_as_equations_in_any_order(text, laws):
    assert rates(text, ("x", "v")) == laws
