"""Sums that lose nothing: what compensated summation is made of."""

from __future__ import annotations

from numba import njit

__all__ = ["two_sum"]


@njit(error_model="numpy")
def two_sum(a, b):  # type: ignore[no-untyped-def]  # jitted: numba infers the types
    """a + b and what rounding lost of it, exactly (Knuth)."""
    total = a + b
    back = total - a
    return total, (a - (total - back)) + (b - back)
