"""Elementary functions of double-double numbers against mpmath.

Errors are in units of 2⁻¹⁰⁴: 2²⁶ of them are 2⁻⁷⁸.
"""

from __future__ import annotations

import math
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.kernels.doubledouble import elementary
from core.kernels.doubledouble.elementary import dd_cos, dd_exp, dd_log, dd_pow, dd_sin, dd_tan
from tests.core.doubles import DIGITS, Pair, error, exact, pairs, relative_error, sized

SMALL = sized(-100, 0)
#: Arguments, by function: sizes of every order, what is usual, all up to where a result nears the ends of the range.
ARGUMENTS = {
    "exp": SMALL | st.floats(-2, 2) | st.floats(-600, 600),
    "sinh": SMALL | st.floats(-2, 2) | st.floats(-45, 45) | st.floats(-600, 600),
    "cosh": SMALL | st.floats(-2, 2) | st.floats(-45, 45) | st.floats(-600, 600),
    "tanh": SMALL | st.floats(-2, 2) | st.floats(-45, 45) | st.floats(-600, 600),
    "log": st.floats(0.5, 2) | sized(-900, 959.9).map(abs) | sized(-52, -5).map(lambda k: 1 + k),
}
ANGLES = SMALL | st.floats(-7, 7) | st.floats(-1e5, 1e5) | sized(0, 34.9)


def function(name: str) -> Any:
    return getattr(elementary, f"dd_{name}")


@pytest.mark.parametrize("name", ARGUMENTS)
def test_functions_are_good_to_76_bits(name: str) -> None:
    @given(pairs(ARGUMENTS[name]))
    def check(a: Pair) -> None:
        with mp.workdps(DIGITS):
            wanted = getattr(mp, name)(exact(a))
            assert abs(exact(function(name)(*a)) - wanted) <= 2.0**-76 * max(1.0, abs(wanted))

    check()


@given(pairs(ANGLES))
def test_sine_and_cosine_are_good_to_78_bits(a: Pair) -> None:
    with mp.workdps(DIGITS):
        assert error(dd_sin(*a), mp.sin(exact(a))) <= 2.0**26
        assert error(dd_cos(*a), mp.cos(exact(a))) <= 2.0**26


@given(pairs(st.floats(-1.5, 1.5)))
def test_the_tangent_is_good_to_76_bits(a: Pair) -> None:
    with mp.workdps(DIGITS):
        wanted = mp.tan(exact(a))
        assert error(dd_tan(*a), wanted) <= 2.0**28 * (1.0 + wanted**2)


@given(pairs(sized(-100, 100).map(abs)), pairs(sized(-30, 3)))
def test_the_real_power_is_good_to_76_bits(a: Pair, b: Pair) -> None:
    with mp.workdps(DIGITS):
        wanted = mp.exp(exact(b) * mp.log(exact(a)))
        assert relative_error(dd_pow(*a, *b), wanted) <= 2.0**28 * (1 + 100 * abs(exact(b)))


@given(pairs(sized(35.1, 90)))
def test_large_angles_are_as_in_double_precision(a: Pair) -> None:
    with mp.workdps(DIGITS):
        # The low part, up to 2³⁶ here, is itself an angle: sin(hi + lo), not sin(hi).
        assert abs(exact(dd_sin(*a)) - mp.sin(exact(a))) <= 4 * 2.0**-53
        assert abs(exact(dd_cos(*a)) - mp.cos(exact(a))) <= 4 * 2.0**-53


@pytest.mark.parametrize("n", [-3, -2, 0, 1, 2, 7, 10])
def test_whole_powers_of_negative_numbers_have_their_sign(n: int) -> None:
    with mp.workdps(DIGITS):
        wanted = (mp.mpf(-1.7) + mp.mpf(1e-17)) ** n
        assert relative_error(dd_pow(-1.7, 1e-17, float(n), 0.0), wanted) <= 2.0**28 * (1 + abs(n))


VALUES = [0.0, math.inf, -math.inf, math.nan, 1e308, -1e308]
ENDS = {
    "exp": [710.0, 709.7, -745.0, -750.0],
    "sinh": [710.4, -710.4, 711.0, -711.0],
    "cosh": [710.4, -710.4, 711.0, -711.0],
    "tanh": [50.0, -50.0],
    "log": [-1.0, 5e-324, -5e-324],
    "sin": [],
    "cos": [],
    "tan": [],
}


@pytest.mark.parametrize(("name", "a"), [(name, a) for name, ends in ENDS.items() for a in VALUES + ends])
def test_ends_of_the_range_are_those_of_double_precision(name: str, a: float) -> None:
    high, low = function(name)(a, 0.0)
    with np.errstate(all="ignore"):
        wanted = float(getattr(np, name)(a))
    if math.isfinite(wanted):
        assert abs(high - wanted) <= 2 * math.ulp(wanted)  # NumPy's own last digit
        assert abs(low) <= 0.5 * math.ulp(high)
    else:
        assert high == wanted or (math.isnan(wanted) and math.isnan(high))
        assert low == 0.0


SPECIAL_POWERS = [
    (0.0, 2.0), (0.0, -1.0), (0.0, 0.0), (2.0, 0.0), (-2.0, 0.5), (-2.0, 1e20), (2.0, 1e6), (2.0, -1e6),
    (-2.0, 1025.0), (-2.0, -1e6 - 1), (math.inf, 2.0), (-math.inf, 3.0), (2.0, math.inf), (-2.0, math.inf),
    (0.5, math.inf), (1.0, math.nan), (math.nan, 0.0), (math.nan, 1.0), (1e300, 1e306), (1e-300, 1e306),
]  # fmt: skip


@pytest.mark.parametrize(("a", "b"), SPECIAL_POWERS)
def test_special_powers_are_those_of_double_precision(a: float, b: float) -> None:
    high, low = dd_pow(a, 0.0, b, 0.0)
    with np.errstate(all="ignore"):
        wanted = float(np.power(a, b))
    assert high == wanted or (math.isnan(wanted) and math.isnan(high))
    assert low == 0.0


def test_a_low_part_makes_an_exponent_no_whole_number() -> None:
    assert math.isnan(dd_pow(-2.0, 0.0, 3.0, 1e-20)[0])


def test_logarithm_undoes_the_exponential() -> None:
    for k in range(-300, 301, 7):
        a = (k / 3.0, k * 1e-18)
        assert (
            error(dd_log(*dd_exp(*a)), exact(a)) <= 2.0**28
        )  # exp's relative error is an absolute one of the logarithm
