"""The length of a step, and the unit of its time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from core.kernels.taylor_coefficients import (
    MAX_ORDER,
    correction_of_unit,
    order_of,
    power_near,
    power_of_two,
    step_length,
)


def rows(count: int = 4, length: int = 32) -> Any:
    return np.random.default_rng(20260102).uniform(-1, 1, (count, length))


def geometric(radius: float, size: float = 1.0) -> Any:
    """A state (1 row) of size/(1 − s/radius), and a row of something else."""
    return np.array([[size * radius**-k for k in range(32)], np.full(32, 1e9)])


def safety(order: int, tolerance: float) -> float:
    return math.exp(min(-math.log(2.0), math.log(tolerance) / order) - 0.7 / (order - 1))


@pytest.mark.parametrize("order", [2, 3, 8, 16, 30])
@pytest.mark.parametrize("radius", [1e-3, 1.0, 50.0])
@pytest.mark.parametrize("digits", [-0.2, -1.0, -2.0])
def test_reach_is_the_radius_of_convergence_times_a_factor(order: int, radius: float, digits: float) -> None:
    tolerance = math.exp(digits * order)
    # ‖x‖ and ‖x'‖ h are alike here, so that the state is the scale.
    assert step_length(geometric(radius), 1, order, tolerance) == pytest.approx(
        radius * safety(order, tolerance), rel=1e-2
    )


@pytest.mark.parametrize("scale", [2.0**-330, 2.0**330])
def test_reach_does_not_depend_on_units(scale: float) -> None:
    c = rows() * 0.7 ** np.arange(32)
    h = step_length(c, 3, 16, 1e-14)
    assert step_length(scale * c, 3, 16, 1e-14) == pytest.approx(h, rel=1e-12)
    shrunk = c * 2.0 ** (20 * np.arange(32))
    assert step_length(shrunk, 3, 16, 1e-14) == pytest.approx(h / 2**20, rel=1e-12)


def test_reach_passes_zero_and_starts_from_rest() -> None:
    order, tolerance = 16, 1e-14
    tangent = np.zeros((1, 32))  # of s: x = 0, radius π/2
    tangent[0, 1::2] = [2.0 * (2.0 / math.pi) ** (k + 1) for k in range(1, 32, 2)]
    for power in (0, 1, 3):  # times s**power: at rest
        moved = np.roll(tangent, power, axis=1)
        moved[0, :power] = 0.0
        assert 0.5 * safety(order, tolerance) * math.pi / 2 < step_length(moved, 1, order, tolerance) < math.pi / 2


def test_what_is_left_out_is_below_the_tolerance() -> None:
    for tolerance in (1e-4, 1e-8, 1e-12, 1e-15):
        order = order_of(tolerance)
        for other in (3, order, 24):  # a lower order takes shorter steps
            h = step_length(geometric(1.0), 1, other, tolerance)
            assert h ** (other + 1) / (1 - h) <= tolerance


def test_reach_is_unlimited_where_nothing_limits_it() -> None:
    c = np.zeros((3, 32))
    assert step_length(c, 2, 16, 1e-14) == math.inf
    c[0, 0] = 1.0
    assert step_length(c, 2, 16, 1e-14) == math.inf
    c[:2, :3] = [[1.0, 2.0, -4.9], [2.0, -9.8, 0.0]]  # a ball in flight
    assert step_length(c, 2, 16, 1e-14) == math.inf
    c[0, 9] = 1.0  # a gap at the end is not a polynomial yet
    assert step_length(c, 2, 16, 1e-14) < 1.0


@pytest.mark.parametrize("place", [(0, 0), (0, 16), (1, 15), (1, 16)])
def test_reach_of_what_is_not_finite_is_no_step(place: tuple[int, int]) -> None:
    c = rows()
    c[place] = math.nan
    assert math.isnan(step_length(c, 2, 16, 1e-14))
    c[place] = math.inf
    assert not 0.0 < step_length(c, 2, 16, 1e-14) < math.inf


def test_higher_orders_are_for_smaller_tolerances() -> None:
    orders = [order_of(tolerance) for tolerance in (1e-2, 1e-5, 1e-8, 1e-11)]
    assert orders == sorted(set(orders))
    assert order_of(1e-300) == MAX_ORDER


@pytest.mark.parametrize("u", [1.0, 1.5, 2.0**-30 * 1.99, 3e300, 5e-300])
def test_the_unit_is_the_power_of_two_below(u: float) -> None:
    assert power_of_two(u) == 2.0 ** math.floor(math.log2(u))


@pytest.mark.parametrize(("u", "v"), [(1.0, 1.9), (3e-200, 7e-190), (5.0, 1e300), (3e-308, 2e-10), (1.99, 1.0)])
def test_the_power_near_a_quotient_is_within_a_factor_of_two(u: float, v: float) -> None:
    power = power_near(u, v)
    assert math.frexp(power)[0] == 0.5
    assert 0.5 * u / v <= power <= 2.0 * u / v


@pytest.mark.parametrize(
    ("u", "v"), [(0.0, 1.0), (1.0, 0.0), (math.inf, 1.0), (1.0, math.nan), (1e300, 1e-300), (1e-310, 1)]
)
def test_no_power_is_near_what_is_no_quotient_of_the_usual_size(u: float, v: float) -> None:
    assert power_near(u, v) == 1.0


@pytest.mark.parametrize("u", [0.0, -2.0, math.inf, math.nan, 5e-324])
def test_what_gives_no_unit_gives_one(u: float) -> None:
    assert power_of_two(u) == 1.0


def test_a_unit_in_which_coefficients_overflow_becomes_as_short_as_the_longest_step_needs() -> None:
    assert correction_of_unit(math.nan, 2.0**300, 2.0**30) == 2.0**-270
    assert correction_of_unit(math.nan, 2.0**20, 2.0**30) == correction_of_unit(0.0, 1.0, 0.0) == 2.0**-40
    assert correction_of_unit(2.0**-50, 2.0**300, 2.0**30) == 2.0**-50


@pytest.mark.parametrize("order", [8, 16, 23])
def test_what_is_left_out_is_small_beside_a_coordinate_much_smaller_than_the_others(order: int) -> None:
    """1e-13/(1 − s) beside a constant 1: by their norms alone, a step of 3.4 would be allowed."""
    tolerance = 1e-12
    c = np.zeros((2, 32))
    c[0, 0], c[1] = 1.0, 1e-13
    h = step_length(c, 2, order, tolerance)
    assert h ** (order - 1) <= 2.0**10 * tolerance * (1.0 + 1e-9)
    assert h ** (order - 1) >= 2.0**9 * tolerance, "and not much shorter"
    alike = np.array([c[1], c[1]])
    assert step_length(alike, 2, order, tolerance) == step_length(alike[:1], 1, order, tolerance), "those alike rule"
