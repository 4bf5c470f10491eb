"""Elementary functions of double-double numbers, accurate to about 2⁻⁷⁷, for the levels of ψ and its residuals.

Each reduces its argument with a table and sums a short Taylor series of the remainder. The first terms are pairs; the
others are some 2⁻²⁶ times smaller and in double precision. The levels are set anew at every crossing: after 2²⁵
crossings, errors of 2⁻⁷⁷ of the same sign move a level by one eps.

Largest errors measured, relative to the larger of |result| and 1: sin, cos, exp, sinh, cosh, tanh 2⁻⁷⁸, log 2⁻⁷⁷,
tangent 2⁻⁷⁶ up to |a| = 1.3; a^b 2⁻⁷⁷ (1 + |b|) relative, for 2⁻²⁰ ≤ a ≤ 2²⁰. Results
are in double precision, with lo = 0, for angles beyond 2³⁵, exponents beyond 600, logarithms and powers of numbers not
between 2⁻⁹⁶⁰ and 2⁹⁶⁰, and arguments that are not finite.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# jitted: numba infers the types

from __future__ import annotations

import math

import numpy as np
from numba import njit

from core.kernels.doubledouble.arithmetic import (
    dd_div,
    fast_two_sum,
    fma,
    pair_add,
    pair_mul,
    pair_scale,
    pair_square,
    two_product,
)
from core.kernels.doubledouble.error_free import two_sum
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
    SIN_HIGH,
    SIN_LOW,
    SIN_STEP,
    SIN_STEPS_PER_UNIT,
)

__all__ = ["dd_cos", "dd_cosh", "dd_exp", "dd_log", "dd_pow", "dd_sin", "dd_sinh", "dd_tan", "dd_tanh"]

_inline = njit(error_model="numpy")

#: Number of bits of the mantissa of a double.
_DIGITS = 52
#: Mask of the mantissa of a double.
_MANTISSA = 2**52 - 1
#: Bits of the double 1.
_ONE = 1023 << 52
#: Biased exponent of the double 1.
_BIAS = 1023


@_inline
def _power_of_two(k):
    """2ᵏ, if normal, without a call of `math.ldexp`."""
    return np.int64((k + _BIAS) << _DIGITS).view(np.float64)


# Exponential and hyperbolic functions -------------------------------------------------------------------------------
# eᵃ = 2ᵏ T eʳ, T = 2^(j/128) from a table, −64 ≤ j < 64, r = a − (k + j/128) log 2, |r| ≤ log(2)/256.

#: Up to this |a|, eᵃ, e⁻ᵃ and their low parts are normal numbers.
_LARGEST_EXPONENT = 600.0


@_inline
def _exp(ah, al):
    """eᵃ for |a| ≤ 600."""
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
def dd_exp(ah, al):
    """eᵃ."""
    if not abs(ah) <= _LARGEST_EXPONENT:
        return math.exp(ah), 0.0
    return _exp(ah, al)


@_inline
def dd_sinh(ah, al):
    """Hyperbolic sine of a."""
    if not abs(ah) <= _LARGEST_EXPONENT:
        return math.sinh(ah), 0.0
    eh, el = _exp(ah, al)
    h, low = dd_div(-1.0, 0.0, eh, el)
    h, low = pair_add(eh, el, h, low)
    return fast_two_sum(0.5 * h, 0.5 * low)


@_inline
def dd_cosh(ah, al):
    """Hyperbolic cosine of a."""
    if not abs(ah) <= _LARGEST_EXPONENT:
        return math.cosh(ah), 0.0
    eh, el = _exp(ah, al)
    h, low = dd_div(1.0, 0.0, eh, el)
    h, low = pair_add(eh, el, h, low)
    return 0.5 * h, 0.5 * low


@_inline
def dd_tanh(ah, al):
    """Hyperbolic tangent of a, (e²ᵃ − 1)/(e²ᵃ + 1)."""
    if not abs(ah) <= 0.5 * _LARGEST_EXPONENT:
        return math.tanh(ah), 0.0
    eh, el = _exp(2.0 * ah, 2.0 * al)
    nh, nl = pair_add(eh, el, -1.0, 0.0)
    nh, nl = fast_two_sum(nh, nl)
    mh, ml = pair_add(eh, el, 1.0, 0.0)
    return dd_div(nh, nl, mh, ml)


# Logarithm and real powers ------------------------------------------------------------------------------------------
# log a = k log 2 − log c + 2 artanh(s), a = 2ᵏ m, 1/√2 ≤ m < √2, c a double near 1/m, s = f/(2 + f), f = c m − 1.

#: Between the inverse of this and this, a, the power of two that scales it to near 1, and their low parts are normal.
_LARGEST = 2.0**960
_SQRT_2 = math.sqrt(2.0)


@_inline
def _log(ah, al):
    """log a for 2⁻⁹⁶⁰ ≤ a ≤ 2⁹⁶⁰."""
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
def dd_log(ah, al):
    """Natural logarithm of a."""
    if not 1.0 / _LARGEST <= ah <= _LARGEST:
        return math.log(ah), 0.0
    return _log(ah, al)


@_inline
def dd_pow(ah, al, bh, bl):
    """a^b for real b, as e^(b log a); for negative a, nan unless b is an integer, as in double precision."""
    if not (1.0 / _LARGEST <= abs(ah) <= _LARGEST and math.isfinite(bh)):
        return math.pow(ah, bh), 0.0
    sign = 1.0
    if ah < 0.0:
        if bh % 1.0 != 0.0 or bl % 1.0 != 0.0:
            return math.nan, 0.0
        sign = 1.0 if (bh % 2.0) == (bl % 2.0) else -1.0
        ah, al = -ah, -al
    h, low = _log(ah, al)
    h, low = pair_mul(h, low, bh, bl)
    h, low = dd_exp(h, low)
    return sign * h, sign * low


# Trigonometric functions --------------------------------------------------------------------------------------------
# a = n π/512 + r, |r| ≤ π/1024, and the functions of n π/512 from a table of the sine over a whole turn.

#: A quarter turn, in units of π/512.
_QUARTER = 256
#: Mask that reduces multiples of π/512 modulo a whole turn.
_TURN = 1023
#: Beyond this |a|, rounding 512 a/π may give an n that is not the nearest, and leave |r| > π/1024.
_LARGEST_ANGLE = 2.0**35


@_inline
def _reduced(ah, al, n):
    """a − n π/512, where n is the integer nearest to 512 a/π."""
    h, low = two_product(-n, SIN_STEP[0])
    h, lost = fast_two_sum(h, ah)  # exact where |ah| is the larger: then they are within a factor of two (Sterbenz)
    low, low_lost = two_sum(low, al)
    mh, ml = two_product(-n, SIN_STEP[1])
    low, rest = two_sum(low, mh)
    h, low = two_sum(h, low)
    return h, low + (lost + low_lost + rest + fma(-n, SIN_STEP[2], ml))


@_inline
def _turned(ah, al, turn):
    """sin(a + turn π/512) for |a| ≤ 2³⁵."""
    n = math.floor(ah * SIN_STEPS_PER_UNIT + 0.5)
    rh, rl = _reduced(ah, al, float(n))
    zh, zl = pair_square(rh, rl)
    sl = rl + rh * zh * (-1 / 6 + zh * (1 / 120 - zh * (1 / 5040)))
    ch, cl = -0.5 * zh, -0.5 * zl + zh * zh * (1 / 24 - zh * (1 / 720))  # cos r − 1
    i, j = (n + turn) & _TURN, (n + turn + _QUARTER) & _TURN
    ph, pl = pair_mul(SIN_HIGH[i], SIN_LOW[i], ch, cl)
    qh, ql = pair_mul(SIN_HIGH[j], SIN_LOW[j], rh, sl)
    # In decreasing order of size: the table's sine (unless 0), the term with sin r, the term with cos r − 1.
    h, lost = fast_two_sum(SIN_HIGH[i], qh)
    h, rest = fast_two_sum(h, ph)
    return fast_two_sum(h, lost + rest + (SIN_LOW[i] + (ql + pl)))


@_inline
def dd_sin(ah, al):
    """Sine of a."""
    if not abs(ah) <= _LARGEST_ANGLE:
        return math.sin(ah) * math.cos(al) + math.cos(ah) * math.sin(al), 0.0
    return _turned(ah, al, 0)


@_inline
def dd_cos(ah, al):
    """Cosine of a."""
    if not abs(ah) <= _LARGEST_ANGLE:
        return math.cos(ah) * math.cos(al) - math.sin(ah) * math.sin(al), 0.0
    return _turned(ah, al, _QUARTER)


@_inline
def dd_tan(ah, al):
    """Tangent of a."""
    sh, sl = dd_sin(ah, al)
    ch, cl = dd_cos(ah, al)
    return dd_div(sh, sl, ch, cl)
