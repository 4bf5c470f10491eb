"""Sums that lose nothing: what compensated summation is made of."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# jitted: numba infers the types

from __future__ import annotations

from numba import njit

__all__ = ["two_sum"]


@njit(error_model="numpy")
def two_sum(a, b):
    """a + b and what rounding lost of it, exactly (Knuth)."""
    total = a + b
    back = total - a
    return total, (a - (total - back)) + (b - back)
