"""Identically zero or not, and independent or not, decided by values."""

import numpy as np
import pytest
import sympy

from core.symbolic.sampling import Samples
from core.symbolic.zero_testing import (
    Domain,
    counterexample,
    has_values,
    independent,
    is_larger,
    is_zero,
    size_expanded,
    tidied,
)
from tests.bounds import bounded_time

X, Y, A = sympy.symbols("x y a")


@pytest.mark.parametrize(
    "text",
    [
        "0",
        "sin(x)**2 + cos(x)**2 - 1",
        "exp(x + y) - exp(x)*exp(y)",
        "(x + y)**12 - expand((x + y)**12)",
        "log(x*y) - log(x) - log(y)",
        "1e9*(cosh(x)**2 - sinh(x)**2 - 1)",
        "sqrt(x - 1)**2 - x + 1",  # real in some places only
        "x**a*x**(-a) - 1",
        "y*(sin(x)**2 + cos(x)**2 - 1)",  # a product, whose terms do not tell its size
        "log(x**2) - 2*log(x)",
        "sqrt(x**2 - 1) - sqrt(x - 1)*sqrt(x + 1)",
        "log(cosh(x)**2 - sinh(x)**2)*y",  # round-off under the logarithm
    ],
)
def test_zeros_are_recognised_without_simplification(text: str) -> None:
    assert is_zero(sympy.sympify(text, rational=True))


@pytest.mark.parametrize("text", ["1", "x", "1e-20*x", "x - y", "sin(x) - x", "sin(x)**2 + cos(x)**2 - 1 + 1e-25*x"])
def test_what_is_small_is_not_zero(text: str) -> None:
    assert not is_zero(sympy.sympify(text, rational=True))


@pytest.mark.parametrize(
    "text",
    [
        "sqrt(x**2) - x",
        "sqrt(a**2) + a",
        "(x**4)**(1/4) - x",
        "y*(sqrt(x**2)/x - 1)",
        "sqrt((x - 1)**2) - x + 1",
        "sqrt(x**2 - 2*x + 1) - x + 1",
        "sqrt((x - a)**2) - x + a",
        "sqrt((x - 1000)**2) + x - 1000",
        "sqrt((x + 1e-4)**2) - x - 1e-4",
        "sqrt((x**2 + y**2 - 1)**2) - x**2 - y**2 + 1",
        "(sqrt(x**2) - x)*(sqrt(y**2) - y)",
        "sqrt(x**2 - 1) - x*sqrt(1 - 1/x**2)",
        "sqrt(exp(2*x) - 2*exp(x) + 1) - exp(x) + 1",
        "sqrt(1 + cos(2*x)) - sqrt(2)*cos(x)",
        "1 - tanh(1000*x)",
        "tanh(1e6*(x - 7)) - 1",
        "exp(-1000*(x - 7)**2)",
    ],
)
def test_what_vanishes_in_a_part_only_is_not_zero_and_a_place_is_shown_where_it_is_not(text: str) -> None:
    expression = sympy.sympify(text, rational=True)
    assert not is_zero(expression)
    found = counterexample(expression)
    assert found is not None
    exact = {symbol: sympy.Rational(value) for symbol, value in found.point.items()}
    assert float(expression.subs(exact).evalf(50)) == pytest.approx(found.value, rel=1e-9)
    assert found.value != 0


@pytest.mark.parametrize(
    ("layer", "positive"),
    [
        ("tanh(2*(y - 60))", "y - 50"),
        ("exp(-((y - 60)/2)**2)", "y - 50"),
        ("tanh(10*(x**2 + y**2/2 - 1800))", "y - x/10 - 50"),
        ("1/cosh(2*(x - 150))", "x + y - 300"),
        ("1/(1 + (100000*(x + y - 310))**8)", "x + y - 300"),
        ("tanh(2*(x**2 + y**2/2 - 34000))", "x + y - 300"),
        ("1/(1 + (1000000*(x - 9/20))**16)", "y"),
        ("1/(1 + (100000000*(x + 885.159932))**32)", "x + y + 1000"),
    ],
)
def test_a_layer_is_met_wherever_its_region_lies(layer: str, positive: str) -> None:
    psi = (X**2 + Y**2) / 2 + sympy.sympify(layer, rational=True)
    rate = sympy.Add(Y * psi.diff(X), -X * psi.diff(Y))
    domain = Domain(positive=(sympy.sympify(positive, rational=True),))
    assert not is_zero(rate, domain)
    found = counterexample(rate, domain)
    assert found is not None
    assert domain.positive[0].subs(dict(found.point)) > 0


@pytest.mark.parametrize("name", "akqtxyz")
@pytest.mark.parametrize("layer", [3.0, -20.0, 0.5])
def test_a_thin_layer_in_one_of_many_coordinates_is_met_on_many_lines(name: str, layer: float) -> None:
    names = sympy.symbols("a k q t x y z")
    a, _, q, t, x, y, z = names
    thin = sympy.tanh(80000 * (sympy.Symbol(name) - sympy.Rational(layer)))
    rest = sympy.exp(a * q) + sympy.exp(t / 3) * sympy.log(y**2) + sum(u**2 for u in names)
    samples = Samples((thin.diff(sympy.Symbol(name)) + rest,), Domain(positive=(sympy.cos(t) - x / 4 - y / 8 - z / 9,)))
    within = np.abs(samples.points[:, "akqtxyz".index(name)] - layer) < 1e-6
    assert within.sum() >= 10


@pytest.mark.parametrize(
    ("domain", "expected"),
    [
        (Domain(), "x > 0"),
        (Domain(positive=(-X - 5,)), None),  # zero nowhere
        (Domain(positive=(Y - X,)), "x > 0"),
        (Domain(defined=(sympy.sqrt(2 - X),)), "x > 0"),
    ],
)
def test_the_part_in_which_it_vanishes_is_said(domain: Domain, expected: str | None) -> None:
    found = counterexample(sympy.sqrt(X**2) - X, domain)
    assert found is not None
    assert found.where == expected
    assert found.partly == (expected is not None)


@pytest.mark.parametrize("domain", [Domain(positive=(X,)), Domain(defined=(sympy.log(X),)), Domain({X: (0.0, 9.0)})])
def test_what_vanishes_all_over_the_domain_is_zero_there(domain: Domain) -> None:
    assert is_zero(sympy.sqrt(X**2) - X, domain)
    assert counterexample(sympy.sqrt(X**2) - X, domain) is None


def test_values_are_found_where_there_are_any() -> None:
    assert has_values((sympy.log(X),), Domain(positive=(Y,)))
    assert not has_values((sympy.log(X),), Domain(positive=(-X,)))
    assert has_values((sympy.sqrt(X - 300),))
    assert not has_values((sympy.sqrt(-1 - X**2),))


def test_points_are_taken_in_the_given_ranges() -> None:
    # Zero for negative a only.
    identity = sympy.sqrt(A**2) + A
    assert not is_zero(identity)
    assert is_zero(identity, Domain({A: (-2.0, -1.0)}))


def test_without_a_finite_value_only_a_symbolic_zero_counts() -> None:
    pole = 1 / sympy.Add(sympy.sin(1) ** 2, sympy.cos(1) ** 2, -1) * X
    assert not is_zero(pole)


@pytest.mark.parametrize(
    ("rows", "expected"),
    [
        ([[X, Y]], True),
        ([[0, 0]], False),
        ([[X, Y, 1], [Y, X, 1]], True),
        ([[X, Y, 1], [2 * X, 2 * Y, 2]], False),
        ([[X, Y, 1], [X**2, X * Y, X]], False),
        ([[X, 1, 0], [0, X, 1], [X**2, 2 * X, 1]], False),
        ([[X**20, Y**20]], True),
        ([[X**30, 0], [0, Y**30]], True),
        ([[1 + sympy.sqrt(X**2) / X, 0]], False),  # zero where x < 0
        ([[sympy.sqrt(X**2), 1], [X, 1]], False),
        ([[sympy.sin(X) ** 2 + sympy.cos(X) ** 2 - 1]], False),
        ([[1 - sympy.tanh(1000 * (Y - X**2)) ** 2]], True),  # below 1e-480 in most places
    ],
)
def test_rows_are_independent_or_not(rows: list[list[sympy.Expr]], expected: bool) -> None:
    assert independent(sympy.Matrix(rows)) is expected


def test_the_verdict_is_the_same_every_time_and_quick() -> None:
    expression = sympy.sympify("tan(exp(x)*sin(y))**40 - cosh(x*y)**30 + 1")
    with bounded_time():
        assert {is_zero(expression) for _ in range(20)} == {False}


@pytest.mark.parametrize(
    "text",
    [
        "x**" * 18 + "x",
        "exp(exp(exp(exp(exp(1e9*x)))))",
        "sin(exp(exp(exp(exp(x*1e50)))))",
        "(x**2 + y**2)**((x**2 + y**2)**((x**2 + y**2)**(x**2*1e9)))",
    ],
)
def test_values_too_large_to_work_out_are_passed_over_in_bounded_time(text: str) -> None:
    # mpmath runs out of memory, or takes minutes, on each of them.
    with bounded_time():
        assert not is_zero(sympy.sympify(text, rational=True))


@pytest.mark.parametrize("text", ["2**x*4**y - 2**(x + 2*y)", "x**(a*y) - exp(a*y*log(x))", "(x*y)**a - x**a*y**a"])
def test_zeros_of_powers_with_names_in_the_exponent_are_recognised(text: str) -> None:
    assert is_zero(sympy.sympify(text))
    assert not is_zero(sympy.sympify(text) + sympy.Rational(1, 10**20) * X)


@pytest.mark.parametrize(
    "text", ["x", "x*(y + a)", "(x + y + a)**5", "(x + y)**3*(x - a)**2", "sin((x + y)**4)", "1/(x + y)**3", "x*y"]
)
def test_no_more_terms_come_of_expanding_than_was_said(text: str) -> None:
    expression = sympy.sympify(text)
    expanded = sympy.expand(expression)
    parts = [expanded, *(sympy.denom(expanded),), *(inner for inner in expanded.args if inner.is_Function)]
    assert max(len(sympy.Add.make_args(part)) for part in parts) <= size_expanded(expression)


def test_what_multiplies_out_to_less_is_shown_so_and_what_is_large_is_left_alone() -> None:
    assert tidied((X + Y) ** 2 - X**2 - Y**2) == 2 * X * Y
    assert tidied(X * (Y + A)) == X * (Y + A)
    huge = (X + Y + A + sum(sympy.symbols("p q r")) + 1) ** 64 - X**64  # more than 10⁸ terms
    assert tidied(huge) is huge


def test_sizes_of_trees_are_told_apart() -> None:
    assert is_larger(X + Y, 2)
    assert not is_larger(X + Y, 3)
