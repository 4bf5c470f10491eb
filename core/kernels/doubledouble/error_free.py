"""Sums that lose nothing, what compensated summation is made of; and powers that are cheaper than others."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# jitted: numba infers the types

from __future__ import annotations

import math

from numba import njit

__all__ = ["half_power", "two_sum"]


@njit(error_model="numpy")
def two_sum(a, b):
    """a + b and what rounding lost of it, exactly (Knuth)."""
    total = a + b
    back = total - a
    return total, (a - (total - back)) + (b - back)


@njit(error_model="numpy")
def half_power(u, n):
    """u to the power n + ½ of a whole number n > 0, to n + 1 roundings."""
    power = math.sqrt(u)
    for _ in range(n):
        power *= u
    return power
