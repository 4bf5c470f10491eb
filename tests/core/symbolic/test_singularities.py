"""Zeros at which a field is not bounded, told from those at which it has a limit or cannot change sign."""

import pytest

import core


def zeros(f, variables=("x", "y"), g="y + 1000", **parameters):
    fields = (f, *(["1"] * (len(variables) - 1)))
    mode = core.PiecewiseSystem("Field", variables, fields, fields, g, parameters=parameters, x0=(0.7, 0.6)).laws.mode(
        0
    )
    return [str(singularity.zero) for singularity in mode.singularities]


@pytest.mark.parametrize(
    ("f", "expected"),
    [
        ("tan(t)", ["cos(t)"]), ("1/sin(2*x)", ["sin(2*x)"]), ("1/tan(x)", ["sin(x)"]), ("-1/x**3", ["x"]),
        ("1/(1 - t)**2", ["1 - t"]), ("1/(x**2 - 2*x + 1)", ["x - 1"]), ("x/(x**2)**1.5", ["x"]),
        ("log(x**2)", ["x"]), ("1/(1 + 1/x)", ["x + 1"]), ("1/(tan(x) + 2)", ["sin(x) + 2*cos(x)"]),
        ("1/(x - 1)**2/(y + 2)", ["x - 1", "y + 2"]), ("1/((x - 1)**2*(y + 2))**0.5", ["x - 1"]),
        ("a/(x - a)", ["-a + x"]),
    ],
)  # fmt: skip
def test_a_field_is_singular_where_it_is_not_bounded(f, expected):
    assert sorted(zeros(f, a=2.0)) == sorted(expected)


@pytest.mark.parametrize(
    "f",
    [
        "sin(a*x)/x",
        "(x**2 - a**2)/(x - a)",
        "x/(exp(x) - 1)",
        "(1 - cos(x))/x**2",
        "sqrt(x)/x",
        "x + 1/a",
        "x**2/(exp(x**2) - 1)",
    ],
)
def test_a_zero_at_which_the_field_stays_bounded_is_no_singularity(f):
    assert zeros(f, a=2.0) == []


@pytest.mark.parametrize(
    "f", [
        "x/(x**2 + y**2)**1.5", "1/(1 + x**2)", "1/(x**2 + exp(y))", "log(x)", "1/sqrt(x)", "1/((t - 1)**2 + 1e-16)**2",
        "x/((x - 3)**2 + 1e-20)", "1/(sin(t) + 2)", "1/(3 - 2*tanh(x)*1.5 + exp(y))",
    ],
)  # fmt: skip
def test_an_expression_without_a_change_of_sign_and_with_values_beyond_is_not_watched(f):
    assert zeros(f) == []


def test_a_zero_at_which_the_mode_ends_is_a_singularity_unless_the_field_can_be_integrated_up_to_it():
    assert zeros("1/x", g="2*x") == zeros("1/sqrt(x**2)", g="2*x") == ["x"]
    assert zeros("(x**2)**(-1/4)", g="2*x") == []
    assert zeros("log(x**2)", g="2*x") == []


@pytest.mark.parametrize("name", list(core.CATALOGUE))
def test_no_law_of_the_catalogue_has_singularities(name):
    laws = core.CATALOGUE[name].laws
    assert [laws.mode(k).singularities for k in range(laws.count)] == [()] * laws.count
