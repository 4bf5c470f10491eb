"""Double-double arithmetic against rational numbers and mpmath."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath as mp
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

from core.kernels.doubledouble import arithmetic
from core.kernels.doubledouble.arithmetic import (
    dd_div,
    dd_sqrt,
    pair_add,
    pair_mul,
    pair_scale,
    pair_square,
    split,
    two_product,
)
from tests.core.doubles import DIGITS, Pair, error, exact, pairs, relative_error, sized
from tests.levels import deep_but

ROOT = Path(__file__).parents[3]
wide = pairs(sized(-200, 200))


@njit
def fma(a: float, b: float, c: float) -> Any:
    return arithmetic.fma(a, b, c)


@st.composite
def cancelling(draw: st.DrawFn) -> tuple[Pair, Pair]:
    """Two numbers, of which the second may be minus the first but for some of its digits."""
    a = draw(wide)
    moved = -a[0] * (1 + draw(st.sampled_from([-1, 0, 1])) * 2.0 ** -draw(st.integers(0, 53)))
    return a, draw(wide | pairs(st.just(moved)))


# u = 2⁻⁵³, so 1 in units of 2⁻¹⁰⁴ is 4 u². The bounds of quotient and root are those proved in the papers that the
# module names.


@given(cancelling())
def test_sum_is_accurate_relative_to_its_terms(ends: tuple[Pair, Pair]) -> None:
    a, b = ends
    with mp.workdps(200):  # the two may be 2⁴⁰⁰ apart
        first, second = (mp.mpf(high) + mp.mpf(low) for high, low in ends)
        total, difference = first + second, first - second
        assert error(pair_add(*a, *b), total) <= 0.5 * (abs(first) + abs(second))
        assert error(pair_add(*a, -b[0], -b[1]), difference) <= 0.5 * (abs(first) + abs(second))


@given(wide, wide)
def test_products_are_accurate(a: Pair, b: Pair) -> None:
    with mp.workdps(DIGITS):
        assert relative_error(pair_mul(*a, *b), exact(a) * exact(b)) <= 1.25
        assert relative_error(pair_square(*a), exact(a) ** 2) <= 1.25
        assert relative_error(pair_scale(*a, b[0]), exact(a) * mp.mpf(b[0])) <= 0.5


@given(wide, wide)
def test_quotient_and_root_are_accurate(a: Pair, b: Pair) -> None:
    with mp.workdps(DIGITS):
        assert relative_error(dd_div(*a, *b), exact(a) / exact(b)) <= 3.75
        positive = a if a[0] > 0 else (-a[0], -a[1])
        assert relative_error(dd_sqrt(*positive), mp.sqrt(exact(positive))) <= 0.79


@given(wide, wide)
def test_quotient_and_root_are_normalised(a: Pair, b: Pair) -> None:
    for high, low in (dd_div(*a, *b), dd_sqrt(abs(a[0]), a[1])):
        assert high + low == high


@given(sized(-400, 400), sized(-400, 400))
def test_two_product_is_exact(a: float, b: float) -> None:
    product, lost = two_product(a, b)
    assert Fraction(product) + Fraction(lost) == Fraction(a) * Fraction(b)


@given(sized(-540, 300), sized(-540, 300), sized(-1074, 600) | st.none())
def test_fma_rounds_once(a: float, b: float, c: float | None) -> None:
    c = -(a * b) if c is None else c  # all that is left is what rounding lost; below 2⁻¹⁰²² too
    assert fma(a, b, c) == float(Fraction(a) * Fraction(b) + Fraction(c))


_SCRIPT = """\
import sys
from numba import njit
from core.kernels.doubledouble.arithmetic import fma, pair_mul
@njit("UniTuple(float64, 3)(float64, float64, float64)", cache=True, error_model="numpy")
def both(a, b, c):
    high, low = pair_mul(a, b, c, a)
    return fma(a, b, c), high, low
if __name__ == "__main__":
    print([value.hex() for value in both(0.1, 10.0, -1.0)], len(both.stats.cache_hits))
"""


@pytest.mark.parametrize("processor", deep_but(["generic"], ["host", "generic"]))
def test_fma_is_inlined_into_cached_functions_with_and_without_the_instruction(tmp_path: Path, processor: str) -> None:
    script = tmp_path / "inlined.py"
    script.write_text(_SCRIPT, encoding="utf-8")
    named = {} if processor == "host" else {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    environment = {**os.environ, **named, "NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": str(ROOT)}
    command = [sys.executable, str(script)]
    runs = [subprocess.run(command, env=environment, check=True, capture_output=True, text=True) for _ in range(2)]
    product = pair_mul(0.1, 10.0, -1.0, 0.1)
    values = [v.hex() for v in (float(Fraction(0.1) * 10 - 1), *product)]
    assert [run.stdout.strip() for run in runs] == [f"{values} 0", f"{values} 1"]


def test_a_polynomial_on_its_level_set_is_found_there_to_106_bits() -> None:
    # y² = x³ + a x + ψ with all digits of y: ψ is what is left of numbers of size 10
    x, a, psi = Fraction(9, 4), Fraction(-2), Fraction(1, 8)
    with mp.workdps(DIGITS):
        y = mp.sqrt(mp.mpf(9) ** 3 / 64 - mp.mpf(9) / 2 + mp.mpf(1) / 8)
        y_pair = float(y), float(y - float(y))
    cube = pair_mul(*pair_square(*split(x)), *split(x))
    right = pair_add(*cube, *pair_scale(*split(x), float(a)))
    got = pair_add(*pair_square(*y_pair), -right[0], -right[1])
    assert abs(exact(got) - mp.mpf(psi.numerator) / psi.denominator) <= 2 * 12 * 2.0**-104


@pytest.mark.parametrize(
    ("got", "high"),
    [
        (dd_div(1.0, 0.0, 0.0, 0.0), math.inf),
        (dd_div(-1.0, 0.0, 0.0, 0.0), -math.inf),
        (dd_div(0.0, 0.0, 0.0, 0.0), math.nan),
        (dd_div(0.0, 0.0, 3.0, 0.0), 0.0),
        (dd_div(1.0, 0.0, math.inf, 0.0), 0.0),
        (dd_sqrt(0.0, 0.0), 0.0),
        (dd_sqrt(-1.0, 0.0), math.nan),
        (dd_sqrt(math.inf, 0.0), math.inf),
    ],
)
def test_special_values_are_those_of_double_precision(got: Pair, high: float) -> None:
    assert got[0] == high or (math.isnan(high) and math.isnan(got[0]))
    assert got[1] == 0.0


def test_overflow_of_a_sum_or_product_is_never_finite() -> None:
    largest = sys.float_info.max
    sums = pair_add(largest, 0.0, largest, 0.0), pair_mul(1e200, 1e180, -1e200, 0.0), pair_scale(1e300, 0.0, 1e9)
    for high, low in sums:
        assert not math.isfinite(high + low)


@pytest.mark.parametrize("value", [sympy.pi, sympy.sqrt(2) / 3, -sympy.exp(sympy.Rational(1, 7)), Fraction(1, 10)])
def test_split_keeps_106_bits_of_a_constant(value: Any) -> None:
    pair = split(value)
    with mp.workdps(DIGITS):
        wanted = mp.mpf(str(sympy.N(sympy.sympify(value), DIGITS)))
    assert relative_error(pair, wanted) <= 0.25  # half of the last digit of lo is 2⁻¹⁰⁷ at most
    assert pair[0] + pair[1] == pair[0]


def test_split_of_a_double_has_nothing_left() -> None:
    assert split(sympy.Rational(-3, 8)) == (-0.375, 0.0)
    assert split(Fraction(0)) == (0.0, 0.0)


@pytest.mark.parametrize("value", [sympy.Symbol("x"), sympy.I, sympy.oo, sympy.nan, sympy.zoo])
def test_split_refuses_what_is_no_real_number(value: Any) -> None:
    with pytest.raises(ValueError, match="not a real number"):
        split(value)


def test_split_refuses_what_no_double_can_hold() -> None:
    with pytest.raises(ValueError, match="too large"):
        split(sympy.Integer(10) ** 400)
