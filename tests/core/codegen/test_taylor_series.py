"""Taylor coefficients of whole systems against closed forms and mpmath's own derivatives."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import mpmath as mp
import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from core.codegen.functions import function_text, module_text
from core.codegen.taylor_series import series_code
from core.compilation.compiled import _load
from core.kernels.abi import ORDER as ORDER_SLOT
from core.kernels.abi import UNIT, Frame
from core.symbolic.expressions import parse
from core.symbolic.laws import Laws, RegionLaw, Way
from tests.core.exact import EPS
from tests.core.frames import pointer

ORDER, SPARE = 14, 3
FIXED = settings(derandomize=True, deadline=None, max_examples=12, database=None)
#: Where every path of these tests starts.
T, X, Y = 0.3, 0.6, 0.8


def laws_of(variables: str, field: tuple[str, ...], g: str, parameters: str = "") -> Laws:
    names = (*variables, *parameters)
    x, p = (tuple(map(sympy.Symbol, letters)) for letters in (variables, parameters))
    f = tuple(parse(text, names, "f") for text in field)
    sides = (RegionLaw(name, (sign,), f, (), (Way(0, sign, to),)) for name, sign, to in (("-", -1, 1), ("+", 1, 0)))
    return Laws(x, p, (parse(g, names, "g"),), tuple(sides))


@lru_cache(maxsize=64)
def compiled(laws: Laws) -> tuple[Callable[..., None], int]:
    """The jitted function of the text, and how many rows it needs."""
    code = series_code(laws, laws.modes[1])
    read = [f"order = int(w[{ORDER_SLOT}])", f"c = carray(scratch, ({code.rows}, order + {SPARE}))"]
    module = _load(
        module_text([function_text("series", [*read, "shrink = 1.0", *code.lines, f"w[{UNIT}] = unit", "return 0"])])
    )
    return module.series.ctypes, code.rows


def coefficients(laws: Laws, x: tuple[float, ...], p: tuple[float, ...] = (), order: int = ORDER, t: float = T) -> Any:
    """All rows, in an array whose other places stay 7."""
    function, rows = compiled(laws)
    c = np.full((rows, order + SPARE), 7.0)
    frame = Frame(len(x), 0)
    w = frame.empty()
    w[ORDER_SLOT], w[frame.x : frame.x + len(x)] = order, x
    function(t, 0.0, *(pointer(array) for array in (np.array([*p, 0.0]), w, c)))
    assert (c[: len(x) + 1, order + 1 :] == 7.0).all()
    assert math.frexp(w[UNIT])[0] == 0.5  # a power of two, which is divided out exactly
    c[:, : order + 1] /= w[UNIT] ** np.arange(order + 1.0)
    return c


def on_circle(expression: str) -> tuple[Any, list[Any]]:
    """Coefficients of g = expression while (x, y) turns on the unit circle: computed, and by mpmath.taylor."""
    laws = laws_of("xy", ("y", "-x"), expression)
    computed = coefficients(laws, (X, Y))[2]
    function = sympy.lambdify(sympy.symbols("t x y"), laws.g, "mpmath")

    def along(s: Any) -> Any:
        x, y = mp.mpf(X), mp.mpf(Y)
        return function(T + s, x * mp.cos(s) + y * mp.sin(s), y * mp.cos(s) - x * mp.sin(s))

    with mp.workdps(60):
        return computed, mp.taylor(along, 0, ORDER)


def assert_close(computed: Any, exact: list[Any], factor: float, least_rate: float = 2.0) -> None:
    """Errors up to factor·eps·rateᵏ, the rate being that at which the coefficients grow, or `least_rate`."""
    size = max(abs(exact[0]), 1.0)
    rate = max(least_rate, *(float(abs(u) / size) ** (1 / k) for k, u in enumerate(exact) if k))
    for k, u in enumerate(exact):
        assert abs(computed[k] - u) <= factor * EPS * size * rate**k, k


EXPRESSIONS = [
    "x*y", "x**2", "x**3", "y**-3", "x**7/y**2", "(x + 2*y)**4", "1/(x + y)", "(3*x - 1)/(2*y + t)", "x/y + y/x",
    "sqrt(x + y)", "x/sqrt(x**2 + 3*y**2)", "(x + 2)**(3/2)", "(x + 2)**(-5/3)", "y**0.3", "(x + 2)**pi",
    "exp(x)", "exp(-x*y)", "2**y", "(x + 2)**y", "log(x)", "log(1 + x**2)", "sin(x)", "cos(x*y)", "sin(x)*cos(x)",
    "tan(x)", "tan(x*y/2)", "sinh(x)", "cosh(x*y)", "tanh(x)", "tanh(5*x)", "sinh(x)/cosh(x)",
    "t", "t**2", "t**3*x", "x/t", "cos(3*t)", "exp(-t/2)*x", "tan(t)", "tanh(2*t + 1)", "sin(t**2)", "log(t)",
    "sqrt(t)", "sin(x + t)", "exp(sin(x))", "3", "x - y + 2*t - 1", "x*(x - 1)*(y - 2)", "sqrt(2)*x + pi",
]  # fmt: skip


@pytest.mark.parametrize("expression", EXPRESSIONS)
def test_every_function_has_the_derivatives_of_mpmath(expression: str) -> None:
    computed, exact = on_circle(expression)
    # Measured: 1.9 at most. Each coefficient gathers a few roundings from every operation and from those before it.
    assert_close(computed, exact, 6)


def combined(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    """Operations that stay of size 1 and analytic within a radius of about ½."""
    forms = ["sin({})", "cos(2*({}))", "tanh({})", "exp(-({})**2)", "sqrt(1 + ({})**2)", "log(2 + ({})**2)",
             "(2 + ({})**2)**(-3/2)", "sinh(sin({}))", "cosh(({})/2)", "tan(sin({})/2)", "({})**3"]  # fmt: skip
    pairs = ["({}) + ({})", "({}) - 3*({})/2", "({})*({})", "({})/(2 + ({})**2)"]
    single = st.builds(lambda form, u: form.format(u), st.sampled_from(forms), inner)
    return single | st.builds(lambda form, u, v: form.format(u, v), st.sampled_from(pairs), inner, inner)


@FIXED
@given(st.recursive(st.sampled_from(["x", "y", "t", "x*y", "0.7*x"]), combined, max_leaves=4))
def test_compositions_have_the_derivatives_of_mpmath(expression: str) -> None:
    computed, exact = on_circle(expression)
    assert_close(computed, exact, 6, least_rate=4.0)


def test_oscillator_has_the_coefficients_of_cosine_and_sine() -> None:
    laws = laws_of("xy", ("y", "-w*x"), "y", "w")
    c = coefficients(laws, (X, Y), (3.0,), 20)
    with mp.workdps(40):
        omega = mp.sqrt(3)
        x = mp.taylor(lambda s: X * mp.cos(omega * s) + Y / omega * mp.sin(omega * s), 0, 20)
    for k in range(21):  # two roundings, of 1/k and of the product, in each of k steps
        assert abs(c[0, k] - x[k]) <= (1.5 * k + 1) * EPS * abs(x[k])
    assert (c[2, :21] == c[1, :21]).all()


def elliptic_in_40_digits(x: Any, y: Any, a: Any, order: int) -> tuple[list[Any], list[Any]]:
    xs, ys = [mp.mpf(x)], [mp.mpf(y)]
    for k in range(order):
        square = mp.fsum(xs[j] * xs[k - j] for j in range(k + 1))
        xs.append(2 * ys[k] / (k + 1))
        ys.append((3 * square + (a if k == 0 else 0)) / (k + 1))
    return xs, ys


def test_elliptic_curve_agrees_with_a_recurrence_in_40_digits() -> None:
    laws = laws_of("xy", ("2*y", "3*x**2 + a"), "x**2 + y**2 - r**2", "ar")
    c = coefficients(laws, (-1.0, -0.9), (-2.0, 1.1), 24)
    with mp.workdps(40):
        xs, ys = elliptic_in_40_digits(-1.0, -0.9, -2.0, 24)
        g = [mp.fsum(xs[j] * xs[k - j] + ys[j] * ys[k - j] for j in range(k + 1)) for k in range(25)]
        g[0] -= mp.mpf(1.1) ** 2
    for row, exact in zip(c, (xs, ys, g), strict=True):
        assert_close(row, exact, 6)


def test_linear_equations_with_coefficients_in_time_are_solved() -> None:
    c = coefficients(laws_of("xy", ("x*cos(2*t)", "-t*y"), "x*y"), (X, Y))
    with mp.workdps(60):
        x = mp.taylor(lambda s: X * mp.exp((mp.sin(2 * (T + s)) - mp.sin(2 * mp.mpf(T))) / 2), 0, ORDER)
        y = mp.taylor(lambda s: Y * mp.exp(-((T + s) ** 2 - mp.mpf(T) ** 2) / 2), 0, ORDER)
    assert_close(c[0], x, 6)
    assert_close(c[1], y, 6)


def test_exponents_may_be_parameters() -> None:
    # x' = xⁿ is solved by (x₀^(1−n) − (n − 1) s)^(−1/(n−1)).
    c = coefficients(laws_of("x", ("x**n",), "a**x", "na"), (X,), (1.7, 2.5))
    with mp.workdps(60):
        n = mp.mpf(1.7)
        x = mp.taylor(lambda s: (mp.mpf(X) ** (1 - n) - (n - 1) * s) ** (-1 / (n - 1)), 0, ORDER)
    assert_close(c[0], x, 6)
    assert abs(c[1, 0] - 2.5**X) <= 4 * EPS * c[1, 0]


def test_whole_powers_work_at_zero_and_others_do_not_crash() -> None:
    c = coefficients(laws_of("xy", ("1", "x**5/(1 + x**2)"), "x**3*y**2"), (0.0, 1.0))
    assert list(c[1, :10]) == pytest.approx([1, 0, 0, 0, 0, 0, 1 / 6, 0, -1 / 8, 0], abs=EPS)
    assert list(c[2, :10]) == pytest.approx([0, 0, 0, 1, 0, 0, 0, 0, 0, 1 / 3], abs=2 * EPS)
    c = coefficients(laws_of("x", ("1",), "x**(3/2) + 1/x + log(x) + sqrt(x)"), (0.0,))
    assert not np.isfinite(c[1, : ORDER + 1]).all()


def test_lower_orders_are_the_beginning_of_higher_ones() -> None:
    laws = laws_of("xy", ("sin(x*y)", "y/x - t"), "exp(x)")
    high = coefficients(laws, (X, Y), order=20)
    for order in range(20):
        assert (coefficients(laws, (X, Y), order=order)[:3, : order + 1] == high[:3, : order + 1]).all()


@pytest.mark.parametrize(
    ("field", "g", "rows"),
    [
        (("y", "-a*x"), "y", 3),
        (("2*y", "3*x**2 + a"), "x**2 + y**2 - a**2", 3),
        (("x - 2*x*y*a", "x*y - y/a"), "x", 3),
        (("y", "-(2*x)**2 + 3*(a*x)*(y/7)"), "x", 3),
    ],
)
def test_scalar_multiples_and_sums_take_no_row(field: tuple[str, ...], g: str, rows: int) -> None:
    laws = laws_of("xy", field, g, "a")
    assert series_code(laws, laws.modes[1]).rows == rows


def test_a_shared_expression_is_worked_out_once() -> None:
    laws = laws_of("xy", ("x*y*sin(x)", "2*x*y + cos(x)"), "3*x*y")
    text = "\n".join(series_code(laws, laws.modes[1]).lines)
    assert text.count("math.sin") == text.count("math.cos") == 1
    assert text.count("_back = fma(") == 4  # x y, (x y) sin x, and one each for sine and cosine


def test_a_function_without_recurrence_is_refused_by_name() -> None:
    laws = laws_of("xy", ("y", "-x"), "y")
    side = dataclasses.replace(laws.modes[1], field=(sympy.erf(laws.x[0]), laws.x[1]))
    with pytest.raises(ValueError, match="no recurrence for erf"):
        series_code(laws, side)
