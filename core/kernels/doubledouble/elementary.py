"""Elementary functions of double-double numbers; see `doubledouble.arithmetic`.

Each reduces its argument with a table, and sums a short Taylor series of the rest: the first terms in double-double,
the others, which count some 2⁻⁵³ times less, in double precision. Where a result overflows, underflows or is nan, it
is as in double precision, with lo = 0.

Relative errors as measured, at most, with u = 2⁻⁵³: exp 1.1 u², log 6 u² (near 1 too), sinh and cosh 3 u², tanh 7 u².
Sine and cosine have an absolute error of 1.5 u² up to |a| = 2⁴⁶, and up to 10⁵ a relative one of 4 u² (tangent: 6 u²).
The relative one grows beside the multiples of π/2: to 1900 u² at the doubles nearest to them, and without bound for
pairs nearer still. Beyond 2⁴⁶ the result is one of double precision. Results below 2⁻⁹⁶⁸ lose digits, as low parts
below 2⁻¹⁰²² do. The quick ones have an absolute error of 2⁻⁷⁸.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# jitted: numba infers the types

from __future__ import annotations

import math

from numba import njit

from core.kernels.doubledouble.arithmetic import (
    dd_add,
    dd_div,
    dd_mul,
    dd_scale,
    dd_square,
    fast_two_sum,
    fma,
    two_product,
)
from core.kernels.doubledouble.error_free import two_sum
from core.kernels.doubledouble.pair_arithmetic import pair_mul, pair_square
from core.kernels.doubledouble.tables import (
    EXP_HIGH,
    EXP_LOW,
    EXP_STEP,
    EXP_STEPS_PER_UNIT,
    FIFTH,
    INVERSE_FACTORIALS,
    LOG_2,
    LOG_C,
    LOG_FIRST,
    LOG_HIGH,
    LOG_LOW,
    SIN_HIGH,
    SIN_LOW,
    SIN_STEP,
    SIN_STEPS_PER_UNIT,
    THIRD,
)

__all__ = [
    "dd_cos", "dd_cosh", "dd_exp", "dd_log", "dd_pow", "dd_sin", "dd_sinh", "dd_tan", "dd_tanh",
    "quick_cos", "quick_sin",
]  # fmt: skip

_inline = njit(error_model="numpy")


@_inline
def _horner(rh, rl, ph, pl, ch, cl):
    """c + r p where |r p| ≤ |c|: a step of Horner's rule."""
    mh, ml = dd_mul(rh, rl, ph, pl)
    sh, sl = fast_two_sum(ch, mh)
    return fast_two_sum(sh, sl + (cl + ml))


@_inline
def _reduced(ah, al, n, step):
    """a − n step of a whole number n beside a/step; the step has three parts."""
    h, low = two_product(-n, step[0])
    h, lost = fast_two_sum(h, ah)  # exact where |ah| is the larger: then they are within a factor of two (Sterbenz)
    low, low_lost = two_sum(low, al)
    mh, ml = two_product(-n, step[1])
    low, rest = two_sum(low, mh)
    h, low = two_sum(h, low)
    return h, low + (lost + low_lost + rest + fma(-n, step[2], ml))


# Exponential and hyperbolic functions -------------------------------------------------------------------------------
# eᵃ = 2ᵏ (1 + m), m = 2^(j/128) eʳ − 1, −64 ≤ j < 64, r = a − (k + j/128) log 2, |r| ≤ log(2)/256.

_LARGEST_EXPONENT = 746.0  #: e⁷⁴⁶ overflows and e⁻⁷⁴⁶ is 0
_ONE_TERM = 40.0  #: from here e⁻²ᵃ is nothing beside 1


@_inline
def _exp_reduced(rh, rl):
    """eʳ − 1 of |r| ≤ log(2)/256."""
    tail = 1 / 720 + rh * (1 / 5040 + rh * (1 / 40320 + rh * (1 / 362880 + rh * (1 / 3628800))))
    h, low = fast_two_sum(INVERSE_FACTORIALS[5][0], INVERSE_FACTORIALS[5][1] + rh * tail)
    h, low = _horner(rh, rl, h, low, INVERSE_FACTORIALS[4][0], INVERSE_FACTORIALS[4][1])
    h, low = _horner(rh, rl, h, low, INVERSE_FACTORIALS[3][0], INVERSE_FACTORIALS[3][1])
    h, low = _horner(rh, rl, h, low, 0.5, 0.0)
    h, low = _horner(rh, rl, h, low, 1.0, 0.0)
    return dd_mul(rh, rl, h, low)


@_inline
def _exp_parts(ah, al):
    """k and m (high, low) of eᵃ = 2ᵏ (1 + m), |m| < 1/2, with small relative error of m; |a| ≤ 746."""
    n = math.floor(ah * EXP_STEPS_PER_UNIT + 0.5)
    rh, rl = _reduced(ah, al, float(n), EXP_STEP)
    k = (n + 64) >> 7
    j = n + 64 - (k << 7)
    qh, ql = _exp_reduced(rh, rl)
    th, tl = EXP_HIGH[j], EXP_LOW[j]
    mh, ml = _horner(qh, ql, th, tl, qh, ql)
    mh, ml = dd_add(th, tl, mh, ml)
    return k, mh, ml


@_inline
def _exp_scaled(ah, al, shift):
    """2^shift eᵃ."""
    if not abs(ah) <= _LARGEST_EXPONENT:
        return math.exp(ah), 0.0
    k, mh, ml = _exp_parts(ah, al)
    h, low = fast_two_sum(1.0, mh)
    h, low = fast_two_sum(h, low + ml)
    h = math.ldexp(h, k + shift)
    return h, (math.ldexp(low, k + shift) if math.isfinite(h) else 0.0)


@_inline
def _expm1(ah, al):
    """eᵃ − 1 of 0 ≤ a ≤ 746, with small relative error."""
    k, mh, ml = _exp_parts(ah, al)
    if k == 0:
        return mh, ml
    scale = math.ldexp(1.0, k)
    h, low = dd_add(1.0, 0.0, mh, ml)
    return dd_add(scale * h, scale * low, -1.0, 0.0)


@_inline
def dd_exp(ah, al):
    """eᵃ."""
    return _exp_scaled(ah, al, 0)


@_inline
def dd_sinh(ah, al):
    """Hyperbolic sine of a, (E + E/(E + 1))/2 with E = eᵃ − 1."""
    sign = -1.0 if ah < 0.0 else 1.0
    ah, al = sign * ah, sign * al
    if not ah <= _ONE_TERM:
        h, low = _exp_scaled(ah, al, -1)
        return sign * h, sign * low
    eh, el = _expm1(ah, al)
    h, low = dd_add(eh, el, 1.0, 0.0)
    h, low = dd_div(eh, el, h, low)
    h, low = dd_add(h, low, eh, el)
    return 0.5 * sign * h, 0.5 * sign * low


@_inline
def dd_cosh(ah, al):
    """Hyperbolic cosine of a."""
    sign = -1.0 if ah < 0.0 else 1.0
    if not sign * ah <= _ONE_TERM:
        return _exp_scaled(sign * ah, sign * al, -1)
    eh, el = _exp_scaled(sign * ah, sign * al, -1)
    h, low = dd_div(0.25, 0.0, eh, el)
    return dd_add(eh, el, h, low)


@_inline
def dd_tanh(ah, al):
    """Hyperbolic tangent of a, E/(E + 2) with E = e²ᵃ − 1."""
    sign = -1.0 if ah < 0.0 else 1.0
    if not sign * ah <= _ONE_TERM:
        return math.tanh(ah), 0.0
    eh, el = _expm1(2.0 * sign * ah, 2.0 * sign * al)
    h, low = dd_add(eh, el, 2.0, 0.0)
    h, low = dd_div(eh, el, h, low)
    return sign * h, sign * low


# Logarithm and real powers ------------------------------------------------------------------------------------------
# log a = k log 2 − log c + 2 artanh(s), a = 2ᵏ m, 1/√2 ≤ m < √2, c a double near 1/m, s = f/(2 + f), f = c m − 1.

_SQRT_HALF = math.sqrt(0.5)


@_inline
def _log_near_one(fh, fl):
    """log(1 + f) of |f| < 1/180."""
    sh, sl = dd_add(fh, fl, 2.0, 0.0)
    sh, sl = dd_div(fh, fl, sh, sl)
    zh, zl = dd_square(sh, sl)
    tail = 1 / 7 + zh * (1 / 9 + zh * (1 / 11))
    h, low = fast_two_sum(FIFTH[0], FIFTH[1] + zh * tail)
    h, low = _horner(zh, zl, h, low, THIRD[0], THIRD[1])
    h, low = _horner(zh, zl, h, low, 1.0, 0.0)
    return dd_mul(2.0 * sh, 2.0 * sl, h, low)


@_inline
def dd_log(ah, al):
    """Natural logarithm of a; its relative error is small near a = 1 too."""
    if not 0.0 < ah < math.inf:
        return math.log(ah), 0.0
    mh, k = math.frexp(ah)
    if mh < _SQRT_HALF:
        mh, k = 2.0 * mh, k - 1
    ml = math.ldexp(al, -k)
    i = math.floor(128.0 * mh + 0.5) - LOG_FIRST
    h, low = two_product(mh, LOG_C[i])
    fh, fl = two_product(ml, LOG_C[i])
    h, low = fast_two_sum(h - 1.0, low)
    fh, fl = dd_add(h, low, fh, fl)
    h, low = _log_near_one(fh, fl)
    h, low = dd_add(LOG_HIGH[i], LOG_LOW[i], h, low)
    th, tl = dd_scale(LOG_2[0], LOG_2[1], float(k))
    return dd_add(th, tl, h, low)


@_inline
def dd_pow(ah, al, bh, bl):
    """a^b of a real b through e^(b log a): relative error about 4 u² (1 + |b log a|).

    A negative a has powers of whole numbers b only, as in double precision.
    """
    if ah == 0.0 or not (math.isfinite(ah) and math.isfinite(bh)):
        return math.pow(ah, bh), 0.0
    sign = 1.0
    if ah < 0.0:
        if bh % 1.0 != 0.0 or bl % 1.0 != 0.0:
            return math.nan, 0.0
        sign = 1.0 if (bh % 2.0) == (bl % 2.0) else -1.0
        ah, al = -ah, -al
    h, low = dd_log(ah, al)
    if not abs(h * bh) <= _LARGEST_EXPONENT:
        return sign * math.exp(h * bh), 0.0
    h, low = dd_mul(h, low, bh, bl)
    h, low = dd_exp(h, low)
    return sign * h, sign * low


# Trigonometric functions --------------------------------------------------------------------------------------------
# a = n π/512 + r, |r| ≤ π/1024, and the functions of n π/512 from a table of the sine over a whole turn.

_QUARTER, _TURN = 256, 1023
#: Up to here three parts of π/512 are enough.
_LARGEST_ANGLE = 2.0**46
#: Beyond this the rounding of 512 a/π can make the n found another than the nearest, and leave more than π/1024.
_CERTAIN_ANGLE = 2.0**35


@_inline
def _sin_reduced(rh, rl, zh, zl):
    """Sine of |r| ≤ π/1024, z = r²."""
    tail = -1 / 5040 + zh * (1 / 362880 - zh * (1 / 39916800))
    h, low = fast_two_sum(INVERSE_FACTORIALS[5][0], INVERSE_FACTORIALS[5][1] + zh * tail)
    h, low = pair_mul(zh, zl, h, low)
    h, lost = fast_two_sum(-INVERSE_FACTORIALS[3][0], h)
    h, low = pair_mul(zh, zl, h, lost + (low - INVERSE_FACTORIALS[3][1]))
    h, low = pair_mul(rh, rl, h, low)
    h, lost = fast_two_sum(rh, h)
    return h, lost + (low + rl)


@_inline
def _cos_reduced(zh, zl):
    """Cosine of |r| ≤ π/1024, less 1; z = r²."""
    tail = -1 / 720 + zh * (1 / 40320 - zh * (1 / 3628800))
    h, low = fast_two_sum(INVERSE_FACTORIALS[4][0], INVERSE_FACTORIALS[4][1] + zh * tail)
    h, low = pair_mul(zh, zl, h, low)
    h, lost = fast_two_sum(-0.5, h)
    return pair_mul(zh, zl, h, lost + low)


@_inline
def _sin_parts(ah, al):
    """n, sin r and cos r − 1."""
    n = math.floor(ah * SIN_STEPS_PER_UNIT + 0.5)
    rh, rl = _reduced(ah, al, float(n), SIN_STEP)
    if abs(ah) > _CERTAIN_ANGLE:
        correction = math.floor(rh * SIN_STEPS_PER_UNIT + 0.5)
        rh, rl = _reduced(rh, rl, float(correction), SIN_STEP)
        n += correction
    zh, zl = pair_square(rh, rl)
    sh, sl = _sin_reduced(rh, rl, zh, zl)
    ch, cl = _cos_reduced(zh, zl)
    return n, sh, sl, ch, cl


@_inline
def _sin_turned(n, sh, sl, ch, cl):
    """Sine of n π/512 + r from sin r and cos r − 1."""
    i, j = n & _TURN, (n + _QUARTER) & _TURN
    ph, pl = pair_mul(SIN_HIGH[i], SIN_LOW[i], ch, cl)
    qh, ql = pair_mul(SIN_HIGH[j], SIN_LOW[j], sh, sl)
    # The table's sine is 0, or larger than that of r, which is larger than what cos r takes from it.
    h, lost = fast_two_sum(SIN_HIGH[i], qh)
    h, rest = fast_two_sum(h, ph)
    return fast_two_sum(h, lost + rest + (SIN_LOW[i] + (ql + pl)))


@_inline
def _sin_of_large(ah, al):
    return math.sin(ah) * math.cos(al) + math.cos(ah) * math.sin(al)


@_inline
def _cos_of_large(ah, al):
    return math.cos(ah) * math.cos(al) - math.sin(ah) * math.sin(al)


@_inline
def dd_sin(ah, al):
    """Sine of a; beyond |a| = 2⁴⁶ to double precision only."""
    if not abs(ah) <= _LARGEST_ANGLE:
        return _sin_of_large(ah, al), 0.0
    n, sh, sl, ch, cl = _sin_parts(ah, al)
    return _sin_turned(n, sh, sl, ch, cl)


@_inline
def dd_cos(ah, al):
    """Cosine of a; beyond |a| = 2⁴⁶ to double precision only."""
    if not abs(ah) <= _LARGEST_ANGLE:
        return _cos_of_large(ah, al), 0.0
    n, sh, sl, ch, cl = _sin_parts(ah, al)
    return _sin_turned(n + _QUARTER, sh, sl, ch, cl)


@_inline
def _quick_turned(ah, al, turn):
    """Sine of a + turn π/512: the terms beyond r and r²/2, which are below 2⁻²⁷, in double precision."""
    n = math.floor(ah * SIN_STEPS_PER_UNIT + 0.5)
    rh, rl = _reduced(ah, al, float(n), SIN_STEP)
    zh, zl = pair_square(rh, rl)
    sl = rl + rh * zh * (-1 / 6 + zh * (1 / 120 - zh * (1 / 5040)))
    cl = -0.5 * zl + zh * zh * (1 / 24 - zh * (1 / 720))
    return _sin_turned(n + turn, rh, sl, -0.5 * zh, cl)


@_inline
def quick_sin(ah, al):
    """Sine of a with an absolute error of 2⁻⁷⁸, in two thirds of the time."""
    return _quick_turned(ah, al, 0) if abs(ah) <= _CERTAIN_ANGLE else dd_sin(ah, al)


@_inline
def quick_cos(ah, al):
    """Cosine of a with an absolute error of 2⁻⁷⁸, in two thirds of the time."""
    return _quick_turned(ah, al, _QUARTER) if abs(ah) <= _CERTAIN_ANGLE else dd_cos(ah, al)


@_inline
def dd_tan(ah, al):
    """Tangent of a; beyond |a| = 2⁴⁶ to double precision only."""
    if not abs(ah) <= _LARGEST_ANGLE:
        return _sin_of_large(ah, al) / _cos_of_large(ah, al), 0.0
    n, sh, sl, ch, cl = _sin_parts(ah, al)
    yh, yl = _sin_turned(n, sh, sl, ch, cl)
    xh, xl = _sin_turned(n + _QUARTER, sh, sl, ch, cl)
    return dd_div(yh, yl, xh, xl)
