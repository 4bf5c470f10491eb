"""Sums and products in twice the working precision: pairs hi + lo that are not renormalised after each operation.

Half the operations of `arithmetic`, for what is worked out at every step. The relative error of a sum of products is
some eps², as long as lo stays small beside hi: Lange, Rump, Faithfully rounded floating-point computations, ACM Trans.
Math. Softw. 46 (2020).
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# jitted: numba infers the types

from __future__ import annotations

from numba import njit

from core.kernels.doubledouble.arithmetic import fma, two_product
from core.kernels.doubledouble.error_free import two_sum

__all__ = ["pair_add", "pair_mul", "pair_scale", "pair_square"]

_inline = njit(error_model="numpy")


@_inline
def pair_add(ah, al, bh, bl):
    """a + b."""
    high, lost = two_sum(ah, bh)
    return high, lost + (al + bl)


@_inline
def pair_mul(ah, al, bh, bl):
    """a b."""
    high, lost = two_product(ah, bh)
    return high, fma(ah, bl, fma(al, bh, lost))


@_inline
def pair_square(ah, al):
    """a²."""
    high, lost = two_product(ah, ah)
    return high, fma(2.0 * ah, al, lost)


@_inline
def pair_scale(ah, al, b):
    """a b of a double b."""
    high, lost = two_product(ah, b)
    return high, fma(al, b, lost)
