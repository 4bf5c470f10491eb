"""Elementary functions of double-double numbers against mpmath.

Bounds are in units of 2⁻¹⁰⁴ = 4 u², u = 2⁻⁵³: each is about twice what some 20,000 random arguments show at most.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.kernels.doubledouble import elementary, quick
from core.kernels.doubledouble.elementary import dd_cos, dd_log, dd_pow, dd_sin, dd_tan, quick_cos, quick_sin
from tests.core.doubles import DIGITS, Pair, error, exact, pairs, relative_error, sized

SMALL = sized(-100, 0)
#: Arguments, by function: sizes of every order, what is usual, all up to where a result nears the ends of the range.
ARGUMENTS = {
    "exp": SMALL | st.floats(-2, 2) | st.floats(-670, 709),
    "sinh": SMALL | st.floats(-2, 2) | st.floats(-45, 45) | st.floats(-710, 710),
    "cosh": SMALL | st.floats(-2, 2) | st.floats(-45, 45) | st.floats(-710, 710),
    "tanh": SMALL | st.floats(-2, 2) | st.floats(-45, 45) | st.floats(-710, 710),
    "log": st.floats(0.5, 2) | sized(-900, 1000).map(abs) | sized(-52, -5).map(lambda k: 1 + k),
}
BOUNDS = {"exp": 0.5, "sinh": 1.5, "cosh": 1.0, "tanh": 3.0, "log": 2.5}
ANGLES = SMALL | st.floats(-7, 7) | st.floats(-1e5, 1e5) | sized(0, 45.9)


def function(name: str, kind: str = "dd") -> Callable[..., Pair]:
    home = elementary if hasattr(elementary, f"{kind}_{name}") else quick
    found: Callable[..., Pair] = getattr(home, f"{kind}_{name}")
    return found


@pytest.mark.parametrize("name", BOUNDS)
def test_function_is_accurate_relative_to_its_value(name: str) -> None:
    @given(pairs(ARGUMENTS[name]))
    def check(a: Pair) -> None:
        with mp.workdps(DIGITS):
            assert relative_error(function(name)(*a), getattr(mp, name)(exact(a))) <= BOUNDS[name]

    check()


@given(pairs(ANGLES))
def test_sine_and_cosine_are_accurate_relative_to_one(a: Pair) -> None:
    with mp.workdps(DIGITS):
        assert error(dd_sin(*a), mp.sin(exact(a))) <= 1.0
        assert error(dd_cos(*a), mp.cos(exact(a))) <= 1.0


@given(pairs(ANGLES))
def test_the_quick_sine_and_cosine_are_good_to_78_bits(a: Pair) -> None:
    with mp.workdps(DIGITS):
        assert error(quick_sin(*a), mp.sin(exact(a))) <= 2.0**26
        assert error(quick_cos(*a), mp.cos(exact(a))) <= 2.0**26


@pytest.mark.parametrize("name", BOUNDS)
def test_quick_functions_are_good_to_76_bits(name: str) -> None:
    @given(pairs(ARGUMENTS[name]))
    def check(a: Pair) -> None:
        with mp.workdps(DIGITS):
            wanted = getattr(mp, name)(exact(a))
            found = getattr(quick, f"quick_{name}")(*a)
            assert error(found, wanted) <= 2.0**28 * max(1.0, abs(wanted))

    check()


@given(pairs(st.floats(-1.5, 1.5)))
def test_the_quick_tangent_is_good_to_76_bits(a: Pair) -> None:
    with mp.workdps(DIGITS):
        wanted = mp.tan(exact(a))
        assert error(quick.quick_tan(*a), wanted) <= 2.0**28 * (1.0 + wanted**2)


@given(pairs(sized(-100, 100).map(abs)), pairs(sized(-30, 3)))
def test_the_quick_power_is_good_to_76_bits(a: Pair, b: Pair) -> None:
    with mp.workdps(DIGITS):
        wanted = mp.exp(exact(b) * mp.log(exact(a)))
        bound = 2.0**28 * (1 + 100 * abs(exact(b)))
        assert relative_error(quick.quick_pow(*a, *b), wanted) <= bound


@given(pairs(sized(44.5, 45.9)))
def test_sine_and_cosine_are_accurate_where_an_angle_is_rounded_by_more_than_a_step_of_the_table(a: Pair) -> None:
    with mp.workdps(DIGITS):
        assert error(dd_sin(*a), mp.sin(exact(a))) <= 1.0
        assert error(dd_cos(*a), mp.cos(exact(a))) <= 1.0


@given(pairs(SMALL | st.floats(-1.5, 1.5)))
def test_sine_and_tangent_are_accurate_relative_to_their_values_up_to_a_right_angle(a: Pair) -> None:
    with mp.workdps(DIGITS):
        assert relative_error(dd_sin(*a), mp.sin(exact(a))) <= 2.0
        assert relative_error(dd_tan(*a), mp.tan(exact(a))) <= 3.0


@given(st.integers(1, 63_661))
def test_doubles_nearest_to_multiples_of_a_right_angle_keep_29_digits(k: int) -> None:
    with mp.workdps(DIGITS):
        a = float(k * mp.pi / 2)  # the worst of all k, 58285, shows 456
        assert relative_error(dd_sin(a, 0.0), mp.sin(a)) <= 500
        assert relative_error(dd_cos(a, 0.0), mp.cos(a)) <= 500
        assert relative_error(dd_tan(a, 0.0), mp.tan(a)) <= 500


@given(pairs(sized(46.1, 90)))
def test_large_angles_are_as_in_double_precision(a: Pair) -> None:
    with mp.workdps(DIGITS):
        # The low part, up to 2³⁶ here, is itself an angle: sin(hi + lo), not sin(hi).
        assert abs(exact(dd_sin(*a)) - mp.sin(exact(a))) <= 4 * 2.0**-53
        assert abs(exact(dd_cos(*a)) - mp.cos(exact(a))) <= 4 * 2.0**-53


@given(pairs(sized(-100, 100).map(abs)), pairs(sized(-30, 3)))
def test_real_power_is_accurate_to_its_exponent(a: Pair, b: Pair) -> None:
    with mp.workdps(DIGITS):
        exponent = exact(b) * mp.log(exact(a))
        assert relative_error(dd_pow(*a, *b), mp.exp(exponent)) <= 1.5 * (1 + abs(exponent))


@pytest.mark.parametrize("n", [-3, -2, 0, 1, 2, 7, 10])
def test_whole_powers_of_negative_numbers_have_their_sign(n: int) -> None:
    with mp.workdps(DIGITS):
        assert relative_error(dd_pow(-1.7, 1e-17, float(n), 0.0), (mp.mpf(-1.7) + mp.mpf(1e-17)) ** n) <= 1.5 * (
            1 + abs(n) * math.log(1.7)
        )


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
@pytest.mark.parametrize("kind", ["dd", "quick"])
def test_ends_of_the_range_are_those_of_double_precision(kind: str, name: str, a: float) -> None:
    high, low = function(name, kind)(a, 0.0)
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
    unit: Any = mp.mpf(2) ** -104
    for k in range(-300, 301, 7):
        a = (k / 3.0, k * 1e-18)
        back = dd_log(*elementary.dd_exp(*a))
        # exp's relative error is an absolute one of the logarithm
        assert abs(exact(back) - exact(a)) <= (0.5 + 2.5 * abs(a[0])) * unit
