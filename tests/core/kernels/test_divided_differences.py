"""Divided differences against mpmath, at any distance of the two ends."""

import math

import mpmath as mp
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.kernels import divided_differences
from tests.core.exact import EPS, FUNCTIONS, condition, differences

# Measured over 12,000 pairs: 2.1 eps at most where the value is well-conditioned everywhere, 1 eps of the
# condition bound for the trigonometric functions.
TOLERANCE = 4 * EPS
#: Where each function and its difference have values in double precision.
LARGEST = {"exp": 709.0, "sinh": 709.0, "cosh": 709.0, "tanh": 340.0, "sin": 1e3, "cos": 1e3, "tan": 1e3}
TINY = 5e-324  # the spacing of the denormal numbers, below which nothing can be told apart
names = pytest.mark.parametrize("name", FUNCTIONS)


@st.composite
def sizes(draw: st.DrawFn, name: str) -> float:
    """Numbers of every order of magnitude in the domain."""
    if name == "log":
        return 10.0 ** draw(st.floats(-300, 300) | st.floats(-2, 2))
    top = LARGEST[name]
    return draw(st.sampled_from([-1, 1])) * draw(
        st.floats(0, top) | st.floats(0, 3) | st.floats(-200, 0).map(lambda k: 10.0**k) | st.just(top)
    )


@st.composite
def pairs(draw: st.DrawFn, name: str) -> tuple[float, float]:
    """Two ends: the same, one ulp apart, 1e-200 apart, close, mirrored, anywhere."""
    a = draw(sizes(name))
    gap = draw(st.sampled_from([-1, 1])) * 10.0 ** draw(st.floats(-16, 0))
    others = (a, math.nextafter(a, 0.0), a + 1e-200, a * (1 + gap), a + gap, -a, draw(sizes(name)))
    b = draw(st.sampled_from(others))
    inside = b > 0 if name == "log" else abs(b) <= LARGEST[name]
    return a, b if inside else a


def of(name: str, suffix: str, a: float, b: float) -> float:
    return float(getattr(divided_differences, f"{name}_slope{suffix}")(a, b))


@names
def test_slope_is_accurate_to_a_few_eps_at_any_distance(name: str) -> None:
    @given(pairs(name))
    def check(ends: tuple[float, float]) -> None:
        slope = differences(name, *ends)[0]
        # Angles: as accurate as if each end were moved by eps of the larger. All others: relative to the value.
        size = condition(name, *ends) if name in ("sin", "cos", "tan") else abs(slope)
        if size < 1e307:
            assert abs(mp.mpf(of(name, "", *ends)) - slope) <= TOLERANCE * size + TINY

    check()


@names
def test_slope_is_symmetric_to_the_last_bit(name: str) -> None:
    @given(pairs(name))
    def check(ends: tuple[float, float]) -> None:
        a, b = ends
        assert of(name, "", a, b) == of(name, "", b, a)

    check()


@names
def test_slope_at_one_point_is_the_derivative(name: str) -> None:
    @given(sizes(name))
    def check(a: float) -> None:
        exact = FUNCTIONS[name][1](mp.mpf(a))
        if abs(exact) < 1e307:
            assert abs(mp.mpf(of(name, "", a, a)) - exact) <= TOLERANCE * abs(exact) + TINY

    # mpmath's working precision of 15 digits would be the larger error
    with mp.workdps(60):
        check()


@names
def test_derivative_of_slope_is_good_enough_for_newton_on_both_sides_of_its_switch_over(name: str) -> None:
    near = st.sampled_from([-1, 1]).flatmap(lambda s: st.floats(-6, -2).map(lambda k: s * 10.0**k))

    @given(st.floats(0.2, 1.4) | st.floats(2, 300), near | st.floats(0, 3))
    def check(a: float, gap: float) -> None:
        b = a * (1 + gap) if name == "log" else min(a + gap, LARGEST[name])
        if name == "tan" and (max(a, b) > 1.5 or min(a, b) < -1.5):
            return  # a pole between them
        exact = differences(name, a, b)[2]
        # Angles: φ'' vanishes somewhere, and 1e-6 of its largest value is what is wanted.
        size = max(abs(exact), 0.5) if name in ("sin", "cos") else abs(exact)
        assert abs(mp.mpf(of(name, "_b", a, b)) - exact) <= 1e-6 * size + 1e-300

    check()


@pytest.mark.parametrize(
    ("name", "a", "b"),
    [
        ("exp", -745.0, 709.0),  # from the last denormal to the last finite value
        ("exp", 709.5, 709.5),
        ("log", 1e-300, 1e300),
        ("log", 1e300, math.nextafter(1e300, math.inf)),
        ("tanh", 300.1, 1.7),  # the exponent 2 min(a, b) without the rounding of b − a − a − b
        ("tanh", 330.0, 331.0),
        ("tanh", -340.0, 340.0),
        ("cosh", -1e-200, 3e-200),
        ("sinh", 0.0, 1e-200),
    ],
)
def test_slope_at_the_ends_of_the_range(name: str, a: float, b: float) -> None:
    slope = differences(name, a, b)[0]
    assert abs(mp.mpf(of(name, "", a, b)) - slope) <= TOLERANCE * abs(slope)
