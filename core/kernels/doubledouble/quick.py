"""Elementary functions of double-double numbers to some 2⁻⁷⁷, in a fraction of the time of `doubledouble.elementary`.

For what a step puts right, and the next step puts right again: of the Taylor series of the reduced argument only the
first terms are pairs, the others, which count some 2⁻²⁶ times less, are in double precision. Outside the usual range,
and where there is no finite result, they are the functions of `doubledouble.elementary`.

Errors as measured, at most, relative to the larger of the result and 1: exp, sinh, cosh, tanh 2⁻⁷⁸, log 2⁻⁷⁷, tangent
2⁻⁷⁶ up to |a| = 1.3; a^b 2⁻⁷⁷ (1 + |b|) relative, for 2⁻²⁰ ≤ a ≤ 2²⁰.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# jitted: numba infers the types

from __future__ import annotations

import math

import numpy as np
from numba import njit

from core.kernels.doubledouble.arithmetic import dd_div, fast_two_sum, two_product
from core.kernels.doubledouble.elementary import dd_cosh, dd_exp, dd_log, dd_pow, dd_sinh, dd_tanh, quick_cos, quick_sin
from core.kernels.doubledouble.error_free import two_sum
from core.kernels.doubledouble.pair_arithmetic import pair_add, pair_mul, pair_scale, pair_square
from core.kernels.doubledouble.tables import (
    EXP_HIGH,
    EXP_LOW,
    EXP_STEP,
    EXP_STEPS_PER_UNIT,
    LOG_2,
    LOG_C,
    LOG_FIRST,
    LOG_HIGH,
    LOG_LOW,
)

__all__ = ["quick_cosh", "quick_exp", "quick_log", "quick_pow", "quick_sinh", "quick_tan", "quick_tanh"]

_inline = njit(error_model="numpy")

#: Up to here eᵃ, e⁻ᵃ and their low parts are normal numbers.
_USUAL_EXPONENT = 600.0
#: Between this and its inverse so are a, and what scales it to near 1.
_LARGEST = 2.0**960
_SQRT_2 = math.sqrt(2.0)
#: Of a double: bits of the mantissa, how many they are, bits of the number 1, and the exponent's value for it.
_MANTISSA, _DIGITS, _ONE, _BIAS = 2**52 - 1, 52, 1023 << 52, 1023


@_inline
def _power_of_two(k):
    """2ᵏ, a normal number, without the call that `math.ldexp` is."""
    return np.int64((k + _BIAS) << _DIGITS).view(np.float64)


@_inline
def _exp(ah, al):
    """eᵃ of |a| ≤ 600: 2ᵏ T eʳ with T = 2^(j/128) from the table, |r| ≤ log(2)/256."""
    n = math.floor(ah * EXP_STEPS_PER_UNIT + 0.5)
    h, low = two_product(-float(n), EXP_STEP[0])
    rh, lost = fast_two_sum(h, ah)  # exact: they are within a factor of two of each other (Sterbenz), or n = 0
    rh, rl = two_sum(rh, lost + (low + (al - float(n) * EXP_STEP[1])))
    k = (n + 64) >> 7
    j = n + 64 - (k << 7)
    zh, zl = pair_square(rh, rl)
    tail = rh * zh * (1 / 6 + rh * (1 / 24 + rh * (1 / 120 + rh * (1 / 720 + rh * (1 / 5040)))))
    qh, lost = fast_two_sum(rh, 0.5 * zh)
    ql = lost + (rl + 0.5 * zl + tail)
    th, tl = fast_two_sum(1.0, EXP_HIGH[j])
    tl += EXP_LOW[j]
    mh, ml = pair_mul(qh, ql, th, tl)
    h, lost = fast_two_sum(th, mh)
    h, low = fast_two_sum(h, lost + (tl + ml))
    scale = _power_of_two(k)
    return scale * h, scale * low


@_inline
def quick_exp(ah, al):
    """eᵃ."""
    return _exp(ah, al) if abs(ah) <= _USUAL_EXPONENT else dd_exp(ah, al)


@_inline
def quick_sinh(ah, al):
    """Hyperbolic sine of a."""
    if not abs(ah) <= _USUAL_EXPONENT:
        return dd_sinh(ah, al)
    eh, el = _exp(ah, al)
    h, low = dd_div(-1.0, 0.0, eh, el)
    h, low = pair_add(eh, el, h, low)
    return fast_two_sum(0.5 * h, 0.5 * low)


@_inline
def quick_cosh(ah, al):
    """Hyperbolic cosine of a."""
    if not abs(ah) <= _USUAL_EXPONENT:
        return dd_cosh(ah, al)
    eh, el = _exp(ah, al)
    h, low = dd_div(1.0, 0.0, eh, el)
    h, low = pair_add(eh, el, h, low)
    return 0.5 * h, 0.5 * low


@_inline
def quick_tanh(ah, al):
    """Hyperbolic tangent of a, (e²ᵃ − 1)/(e²ᵃ + 1)."""
    if not abs(ah) <= 0.5 * _USUAL_EXPONENT:
        return dd_tanh(ah, al)
    eh, el = _exp(2.0 * ah, 2.0 * al)
    nh, nl = pair_add(eh, el, -1.0, 0.0)
    nh, nl = fast_two_sum(nh, nl)
    mh, ml = pair_add(eh, el, 1.0, 0.0)
    return dd_div(nh, nl, mh, ml)


@_inline
def quick_tan(ah, al):
    """Tangent of a."""
    sh, sl = quick_sin(ah, al)
    ch, cl = quick_cos(ah, al)
    return dd_div(sh, sl, ch, cl)


@_inline
def _log(ah, al):
    """log a = k log 2 − log c + 2 artanh(s) of 2⁻⁹⁶⁰ ≤ a ≤ 2⁹⁶⁰, as in `dd_log`."""
    bits = np.float64(ah).view(np.int64)
    k = (bits >> _DIGITS) - _BIAS
    mh = np.int64((bits & _MANTISSA) | _ONE).view(np.float64)
    if mh >= _SQRT_2:
        mh, k = 0.5 * mh, k + 1
    i = math.floor(128.0 * mh + 0.5) - LOG_FIRST
    h, low = two_product(mh, LOG_C[i])
    fh, fl = fast_two_sum(h - 1.0, low + al * _power_of_two(-k) * LOG_C[i])
    mh, ml = fast_two_sum(2.0, fh)
    sh, sl = dd_div(fh, fl, mh, ml + fl)
    z = sh * sh
    tail = sh * z * (2 / 3 + z * (2 / 5 + z * (2 / 7 + z * (2 / 9))))
    th, tl = pair_scale(LOG_2[0], LOG_2[1], float(k))
    th, tl = pair_add(th, tl, LOG_HIGH[i], LOG_LOW[i])
    h, low = pair_add(th, tl, 2.0 * sh, 2.0 * sl + tail)
    return fast_two_sum(h, low)


@_inline
def quick_log(ah, al):
    """Natural logarithm of a."""
    return _log(ah, al) if 1.0 / _LARGEST <= ah <= _LARGEST else dd_log(ah, al)


@_inline
def quick_pow(ah, al, bh, bl):
    """a^b of a real b, through e^(b log a)."""
    if not 1.0 / _LARGEST <= ah <= _LARGEST:
        return dd_pow(ah, al, bh, bl)
    h, low = _log(ah, al)
    h, low = pair_mul(h, low, bh, bl)
    return _exp(h, low) if abs(h) <= _USUAL_EXPONENT else dd_pow(ah, al, bh, bl)
