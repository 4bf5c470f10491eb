"""Power series of expressions, against Taylor coefficients that mpmath finds."""

import mpmath
import pytest
import sympy

from core.symbolic.power_series import NoSeries, SeriesIn

W, B = sympy.symbols("w b")


@pytest.mark.parametrize(
    ("text", "first"),
    [
        ("sin(w)", 1), ("cos(2*w) - 1", 2), ("exp(3 + w)*tan(w/2)", 1), ("tanh(1 + w**2)", 0), ("log(2 + w)", 0),
        ("log(1 + w)**2/w", 1), ("(sinh(w) - w)/w**3", 0), ("1/(cosh(w) - 1)", -2), ("sqrt(4 + w)/w", -1),
        ("(1 + w)**(2/3)", 0), ("1/w - 1/tan(w)", 1), ("exp(sin(w)) - exp(w)", 3),
    ],
)  # fmt: skip
def test_a_series_has_the_taylor_coefficients(text, first):
    u = sympy.sympify(text, {"w": W})
    series = SeriesIn(W, 14).of(u)
    with mpmath.workdps(60):
        right = mpmath.taylor(sympy.lambdify(W, u * W**-first, "mpmath"), mpmath.mpf("0.05"), 9)
        found = [mpmath.mpf(sympy.N(c, 60)) for c in series.coefficients[:8]]
        shifted = [
            sum(mpmath.binomial(j, k) * c * mpmath.mpf("0.05") ** (j - k) for j, c in enumerate(found)) for k in (0, 1)
        ]
    assert series.first == first
    assert found[0] != 0
    assert shifted[0] == pytest.approx(right[0], rel=1e-7)
    assert shifted[1] == pytest.approx(right[1], rel=1e-5, abs=1e-6)


def test_coefficients_are_expressions_in_the_other_symbols():
    series = SeriesIn(W, 6).of((sympy.sin(B * W) - B * W) / W**3)
    assert series.first == 0
    assert series.coefficients[:3] == [-(B**3) / 6, 0, B**5 / 120]


@pytest.mark.parametrize("u", [sympy.sqrt(W), sympy.log(W), sympy.exp(1 / W), sympy.Abs(W)])
def test_what_has_no_power_series_is_said_to_have_none(u):
    with pytest.raises(NoSeries):
        SeriesIn(W, 6).of(u)
