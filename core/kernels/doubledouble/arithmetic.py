"""Double-double arithmetic: a number is the unevaluated sum hi + lo of two doubles, about 106 bits.

Every function takes and returns such pairs as plain floats. With u = 2⁻⁵³ the relative errors are at most 15 u² for a
quotient and 4 u² for a square root, of pairs with |lo| ≤ ulp(hi)/2; both return such pairs. Sums and products, which
every step evaluates, do not normalise lo: the error of a sum of products is some eps² of its terms, as long as lo
stays small beside hi.

References: Joldes, Muller, Popescu: Tight and rigorous error bounds for basic building blocks of double-word
arithmetic, ACM Trans. Math. Softw. 44 (2017); the square root: Lefèvre, Louvet, Muller, Picot, Rideau, ibid. 49
(2023); sums and products: Lange, Rump: Faithfully rounded floating-point computations, ibid. 46 (2020).

The bounds hold as long as the products of high parts lie between 2⁻⁹⁶⁸, below which their rounding error is not a
double, and the largest double. A sum or product that overflows gives nan or inf, never a finite number.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# jitted: numba infers the types

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import sympy
from numba import njit, types
from numba.extending import intrinsic

from core.kernels.doubledouble.error_free import two_sum

__all__ = [
    "dd_div", "dd_sqrt", "fast_two_sum", "fma", "pair_add", "pair_mul", "pair_scale", "pair_square", "split",
    "two_product",
]  # fmt: skip

_inline = njit(error_model="numpy")

#: Decimal digits to which `split` evaluates irrational constants; a pair holds 32.
_DIGITS = 50


def _fma(typing_context, a, b, c):
    """a b + c, rounded once.

    This is one instruction where the processor has it. Elsewhere LLVM calls the C library's ``fma``, which rounds once
    too, but is slow where it works in software.
    """

    def generate(context, builder, signature, arguments):
        return builder.fma(*arguments)

    return types.float64(types.float64, types.float64, types.float64), generate


fma: Any = intrinsic(_fma)


@_inline
def fast_two_sum(a, b):
    """Rounded a + b and its rounding error, exactly, where |a| ≥ |b| or a = 0 (Dekker)."""
    total = a + b
    return total, b - (total - a)


@_inline
def two_product(a, b):
    """Rounded a b and its rounding error, exactly."""
    product = a * b
    return product, fma(a, b, -product)


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
    """a b, where b is a double."""
    high, lost = two_product(ah, b)
    return high, fma(al, b, lost)


@_inline
def dd_div(ah, al, bh, bl):
    """a / b; in double precision where that is 0 or not finite."""
    quotient = ah / bh
    if quotient == 0.0 or not math.isfinite(quotient):
        return quotient, 0.0
    high, low = pair_scale(bh, bl, quotient)
    return fast_two_sum(quotient, ((ah - high) + (al - low)) / bh)


@_inline
def dd_sqrt(ah, al):
    """√a; in double precision where that is 0 or not finite."""
    root = math.sqrt(ah)
    if root == 0.0 or not math.isfinite(root):
        return root, 0.0
    return fast_two_sum(root, (al + fma(-root, root, ah)) / (2.0 * root))


def split(value: sympy.Expr | Fraction) -> tuple[float, float]:
    """Split an exact constant into hi and lo.

    Parameters
    ----------
    value
        A real number: a ratio of integers, or an expression such as ``sqrt(2)`` or ``pi/3``.

    Returns
    -------
    tuple of float
        hi, the double nearest to the value, and lo, the double nearest to value − hi.

    Raises
    ------
    ValueError
        If it is not a real number, or too large for a double.
    """
    exact = sympy.sympify(value)
    number = exact if exact.is_Rational else sympy.N(exact, _DIGITS)
    if not (number.is_Rational or (number.is_Float and number.is_finite)):
        raise ValueError(f"{value} is not a real number: a constant such as 1/3 or sqrt(2) is needed")
    ratio = sympy.Rational(number)
    whole = Fraction(int(ratio.p), int(ratio.q))
    try:
        high = float(whole)
    except OverflowError:
        raise ValueError(f"{value} is too large for a double: at most 1.8e308 is possible") from None
    return high, float(whole - Fraction(high))
