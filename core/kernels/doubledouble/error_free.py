"""Error-free sums, for compensated summation; and half-integer powers by products and one square root."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# jitted: numba infers the types

from __future__ import annotations

import math

from numba import njit

__all__ = ["half_power", "two_sum"]


@njit(error_model="numpy")
def two_sum(a, b):
    """Rounded a + b and its rounding error, exactly (Knuth)."""
    total = a + b
    back = total - a
    return total, (a - (total - back)) + (b - back)


@njit(error_model="numpy")
def half_power(u, n):
    """u to the power n + ½, for an integer n > 0, with n + 1 roundings."""
    power = math.sqrt(u)
    for _ in range(n):
        power *= u
    return power
