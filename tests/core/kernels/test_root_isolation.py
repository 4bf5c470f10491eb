"""The first root of a polynomial against mpmath.polyroots, and where roots cannot be told apart."""

from __future__ import annotations

import math
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.kernels.root_isolation import DOUBLE, NARROW, NONE, ROOT, first_root, scratch_shape


def search(row: Any, h: float = 1.0, leaving: int = 0) -> tuple[int, float, float]:
    row = np.array(row, dtype=float)
    order = len(row) - 1
    kind, low, high = first_root(row, order, h, leaving, np.full(scratch_shape(order), math.nan))
    return kind, low, high


def from_roots(roots: Any, others: Any = ()) -> Any:
    """Coefficients, lowest first, of Π (s − r) Π ((s − a)² + b²), made positive at 0."""
    row = np.polynomial.polynomial.polyfromroots(list(roots))
    for a, b in others:
        row = np.polynomial.polynomial.polymul(row, [a * a + b * b, -2 * a, 1.0])
    return row if row[0] > 0 else -row


def real_roots(row: Any, h: float) -> list[Any]:
    """Roots on the way from 0 to h, in order and in parts of h, by mpmath."""
    with mp.workdps(40):
        scaled = [mp.mpf(a) * mp.mpf(h) ** k for k, a in enumerate(np.trim_zeros(row, "b"))]
        roots = mp.polyroots(scaled[::-1], maxsteps=200, extraprec=80) if len(scaled) > 1 else []
        return sorted(mp.re(r) for r in roots if abs(mp.im(r)) < mp.mpf(10) ** -25 and 0 < mp.re(r) <= 1)


def assert_first(row: Any, h: float, found: tuple[int, float, float]) -> None:
    """The bracket holds the first root, and none before it or beside it."""
    kind, low, high = found
    roots = real_roots(row, h)
    if kind == NONE:
        assert not roots
    else:
        assert kind == ROOT
        assert 0 <= low / h < high / h <= 1
        assert [r for r in roots if r <= high / h] == roots[:1]
        assert low / h <= roots[0]


@given(
    st.lists(st.floats(-1, 1), min_size=1, max_size=20),
    st.floats(0.05, 3),
    st.sampled_from([0.3, 1.0, -0.4, 2.0, -3.0]),
    st.floats(0.2, 1.2),
)
def test_first_root_is_that_of_mpmath(tail: list[float], start: float, h: float, decay: float) -> None:
    row = np.array([start, *(round(a, 3) * decay**k for k, a in enumerate(tail))])
    assert_first(row, h, search(row, h))


@pytest.mark.parametrize("h", [1.0, -1.0, 2.0**-40, 2.0**60])
@pytest.mark.parametrize("count", range(1, 9))
def test_the_first_of_many_roots_is_isolated(count: int, h: float) -> None:
    generator = np.random.default_rng(20260103 + count)
    for _ in range(5):
        row = from_roots(generator.uniform(0.02, 1.5, count), [generator.uniform(0.01, 1, 2)])
        row = row / h ** np.arange(len(row))  # powers of two: exact
        assert_first(row, h, search(row, h))


@pytest.mark.parametrize("h", [1.0, -1.0, 0.125])
@pytest.mark.parametrize(
    ("row", "leaving"),
    [
        ([1.0, -1.5, 0.25, -0.125], 0),  # falls
        ([1.0, 0.5, -2.0, -0.25], 0),  # rises first, and is concave
        ([1.0, -3.0, 0.5, 0.7], 0),  # ends rising
        ([0.0, 1.0, 0.0, -1.5, 0.0, 0.6, 0.0, -0.2], 1),  # an arc
    ],
)
def test_where_a_root_is_plain_to_see_it_is_in_the_middle_of_its_bracket(row: Any, leaving: int, h: float) -> None:
    row = np.array(row) / h ** np.arange(len(row))
    kind, low, high = search(row, h, leaving)
    assert kind == ROOT
    assert high - low == pytest.approx(NARROW * (high + low))
    assert 0.5 * (low + high) / h == pytest.approx(float(real_roots(row, h)[0]), rel=1e-9)
    assert_first(row, h, (kind, low, high))


@pytest.mark.parametrize("gap", [2.0**-k for k in range(10, 24)])
@pytest.mark.parametrize("middle", [0.25, 0.3, 0.5, 0.8125])
def test_two_roots_close_together_are_told_apart(middle: float, gap: float) -> None:
    middle = round(middle * 2**10) / 2**10  # so that the coefficients are exact
    row = [middle**2 - (gap / 2) ** 2, -2 * middle, 1.0]
    kind, low, high = search(row)
    assert kind == ROOT
    assert low < middle - gap / 2 <= high < middle + gap / 2


@pytest.mark.parametrize("gap", [0.0, 1e-14, 1e-10])
@pytest.mark.parametrize("middle", [0.3, 0.7137, 0.99])
def test_a_touch_is_no_clear_root(middle: float, gap: float) -> None:
    row = from_roots([middle - gap / 2, middle + gap / 2], [(0.4, 1.0), (2.0, 0.3)])
    kind, low, high = search(row)
    assert kind in (DOUBLE, ROOT, NONE)
    if kind != NONE:  # of the last digits of the coefficients
        assert low - 1e-7 < middle < high + 1e-7
        assert high - low < 1e-6


def test_an_exact_touch_is_double() -> None:
    for middle in (0.25, 0.5, 0.3125, 0.75):
        kind, low, high = search([middle**2, -2 * middle, 1.0])
        assert kind == DOUBLE
        assert low <= middle <= high < low + 1e-7


def test_three_roots_that_fall_together_are_found() -> None:
    kind, low, high = search(from_roots([0.5, 0.5, 0.5]))
    assert kind != NONE
    assert low <= 0.5 <= high


def test_a_root_at_the_end_counts_and_one_behind_it_does_not() -> None:
    assert search([1.0, -1.0]) == (ROOT, 0.0, 1.0)
    assert search([1.0, -1.0 + 2.0**-50])[0] == NONE
    assert search([1.0, 0.0, 0.0, -1.0]) == (ROOT, 0.0, 1.0)
    assert search([3.0, 1.0], -3.0) == (ROOT, -0.0, -3.0)
    assert search([3.0, 1.0], -2.9)[0] == NONE


def test_a_cubic_with_three_roots_in_a_step_gives_the_first() -> None:
    # y = (t + 6)(t + 2)(t − 2), in one step from t = −10 to 10: below zero first, so its negative.
    kind, low, high = search(from_roots([4.0, 8.0, 12.0]), 20.0)
    assert kind == ROOT
    assert low < 4.0 <= high < 8.0


@pytest.mark.parametrize("h", [1.0, -1.0])
def test_leaving_the_surface_finds_the_return(h: float) -> None:
    arc = [1e-17, 1.0 * h, -1.5]  # s (1 − 1.5 s): back at 2/3, whatever is left of row[0]
    for first in (1e-17, -1e-17, 0.0):
        arc[0] = first
        kind, low, high = search(arc, h, leaving=1)
        assert kind == ROOT
        assert 0 <= low / h < 2 / 3 <= high / h
    assert search([0.0, h, -0.5], h, leaving=1)[0] == NONE


def test_leaving_the_wrong_way_is_a_root_at_once() -> None:
    assert search([0.0, -1.0, 5.0], 1.0, leaving=1) == (ROOT, 0.0, 0.0)
    assert search([0.0, 1.0, 5.0], -1.0, leaving=1) == (ROOT, 0.0, 0.0)
    assert search([0.0, 0.0, -1.0], 1.0, leaving=1) == (ROOT, 0.0, 0.0)
    assert search([0.0, 0.0, 0.0], 1.0, leaving=1) == (ROOT, 0.0, 0.0)
    assert search([-1.0, 3.0], 1.0) == (ROOT, 0.0, 0.0)


def test_leaving_tangentially_finds_the_return() -> None:
    kind, low, high = search([0.0, 0.0, 1.0, -2.0], 1.0, leaving=1)  # s² (1 − 2 s)
    assert kind == ROOT
    assert low < 0.5 <= high
    assert search([0.0, 0.0, 1.0, 2.0], 1.0, leaving=1)[0] == NONE


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("place", [0, 1, 2, 5])
def test_what_is_not_finite_is_not_taken_for_none(value: float, place: int) -> None:
    row = [1.0] * 8
    row[place] = value
    assert search(row, 0.5) == (DOUBLE, 0.0, 0.5)
