"""Divided differences φ[a, b] = (φ(b) − φ(a)) / (b − a) of the elementary functions, to round-off at any distance.

None is evaluated as a quotient of small differences, but by an identity that stays accurate as b → a, where
φ[a, a] = φ'(a). Each comes with its derivative in b, φ[a, b, b], which Newton's method needs and which may be less
accurate. Generated code calls them by these names: ``sin_slope``, ``sin_slope_b``, and so on.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# jitted: numba infers the types

from __future__ import annotations

import math

from numba import njit

from core.kernels.doubledouble.arithmetic import fma

__all__ = [
    "cos_slope", "cos_slope_b", "cosh_slope", "cosh_slope_b", "exp_slope", "exp_slope_b", "log_slope", "log_slope_b",
    "sin_slope", "sin_slope_b", "sinh_slope", "sinh_slope_b", "tan_slope", "tan_slope_b", "tanh_slope", "tanh_slope_b",
]  # fmt: skip

_inline = njit(error_model="numpy")

#: Below this distance (in units of the length over which φ'' changes) φ[a, b, b] is φ''((a + 2b)/3)/2, whose error is
#: of second order in the distance; above, it is a quotient of differences, whose round-off is eps over the distance.
_NEAR = 1e-4
#: Up to this |a| and |b|, the rounding of b − a has a negligible effect on sinh(b − a).
_MODERATE = 1.0
#: Below this argument twelve terms of the series of artanh suffice: 0.18²⁴/25 is 2⁻⁶⁴.
_SMALL_PART = 0.18

_FACTORIAL = tuple(float(math.factorial(n)) for n in range(20))


@_inline
def _half_series(s):
    """Σ s²ʲ/(4j + 1)! and Σ s²ʲ/(4j + 3)!, s = z² ≤ 1: two independent sums, each half as long as that of sin z / z."""
    q = s * s
    even = fma(fma(fma(fma(1 / _FACTORIAL[17], q, 1 / _FACTORIAL[13]), q, 1 / _FACTORIAL[9]), q, 1 / 120), q, 1.0)
    odd = fma(fma(fma(fma(1 / _FACTORIAL[19], q, 1 / _FACTORIAL[15]), q, 1 / _FACTORIAL[11]), q, 1 / 5040), q, 1 / 6)
    return even, odd


@_inline
def sinc(z):
    """Return sin z / z; up to |z| = 1 by its Taylor series, which takes half the time."""
    if abs(z) > 1.0:
        return math.sin(z) / z
    even, odd = _half_series(z * z)
    return fma(-odd, z * z, even)


@_inline
def sinhc(z):
    """Return sinh z / z; up to |z| = 1 by its Taylor series, likewise."""
    if abs(z) > 1.0:
        return math.sinh(z) / z
    even, odd = _half_series(z * z)
    return fma(odd, z * z, even)


@_inline
def decay(z):
    """(1 − e⁻ᶻ)/z for z ≥ 0; up to z = 1 by its Taylor series, likewise.

    Written without a loop, so that `llvm` compiles it: numba takes twenty times as long.
    """
    if z > 1.0:
        return -math.expm1(-z) / z
    q = z * z
    even, odd = 1 / _FACTORIAL[17], 1 / _FACTORIAL[18]
    even, odd = fma(even, q, 1 / _FACTORIAL[15]), fma(odd, q, 1 / _FACTORIAL[16])
    even, odd = fma(even, q, 1 / _FACTORIAL[13]), fma(odd, q, 1 / _FACTORIAL[14])
    even, odd = fma(even, q, 1 / _FACTORIAL[11]), fma(odd, q, 1 / _FACTORIAL[12])
    even, odd = fma(even, q, 1 / _FACTORIAL[9]), fma(odd, q, 1 / _FACTORIAL[10])
    even, odd = fma(even, q, 1 / _FACTORIAL[7]), fma(odd, q, 1 / _FACTORIAL[8])
    even, odd = fma(even, q, 1 / _FACTORIAL[5]), fma(odd, q, 1 / _FACTORIAL[6])
    even, odd = fma(even, q, 1 / _FACTORIAL[3]), fma(odd, q, 1 / _FACTORIAL[4])
    even, odd = fma(even, q, 1 / _FACTORIAL[1]), fma(odd, q, 1 / _FACTORIAL[2])
    return fma(-odd, z, even)


@_inline
def _second(first, slope, curvature, a, b, scale):
    """Give φ[a, b, b] from φ'(b), φ[a, b] and φ''((a + 2b)/3)."""
    return (first - slope) / (b - a) if abs(b - a) > _NEAR * scale else 0.5 * curvature


@_inline
def sin_slope(a, b):
    return math.cos(0.5 * (a + b)) * sinc(0.5 * (b - a))


@_inline
def sin_slope_b(a, b):
    return _second(math.cos(b), sin_slope(a, b), -math.sin((a + 2.0 * b) / 3.0), a, b, 1.0)


@_inline
def cos_slope(a, b):
    return -math.sin(0.5 * (a + b)) * sinc(0.5 * (b - a))


@_inline
def cos_slope_b(a, b):
    return _second(-math.sin(b), cos_slope(a, b), -math.cos((a + 2.0 * b) / 3.0), a, b, 1.0)


@_inline
def tan_slope(a, b):
    return sinc(b - a) / (math.cos(a) * math.cos(b))


@_inline
def tan_slope_b(a, b):
    u = (a + 2.0 * b) / 3.0
    first = 1.0 / math.cos(b) ** 2
    return _second(first, tan_slope(a, b), 2.0 * math.tan(u) / math.cos(u) ** 2, a, b, abs(math.cos(b)))


@_inline
def exp_slope(a, b):
    # Factor out the larger exponential, to avoid overflow and the rounding of a mean.
    gap = abs(b - a)
    return math.exp(max(a, b)) * decay(gap)


@_inline
def exp_slope_b(a, b):
    return _second(math.exp(b), exp_slope(a, b), math.exp((a + 2.0 * b) / 3.0), a, b, 1.0)


@_inline
def log_slope(a, b):
    low, high = min(a, b), max(a, b)
    gap = high - low
    if gap == 0.0:
        return 1.0 / low
    mean = 0.5 * low + 0.5 * high
    part = 0.5 * gap / mean
    if part < _SMALL_PART:  # 2 artanh(part)/gap, by its Taylor series
        s = part * part
        series = 1 / 23
        for n in range(21, 0, -2):  # unrolled
            series = fma(series, s, 1 / n)
        return series / mean
    if gap < low:
        return math.log1p(gap / low) / gap
    ratio = high / low
    return (math.log(ratio) if ratio < math.inf else math.log(high) - math.log(low)) / gap


@_inline
def log_slope_b(a, b):
    u = (a + 2.0 * b) / 3.0
    return _second(1.0 / b, log_slope(a, b), -1.0 / (u * u), a, b, abs(b))


@_inline
def sinh_slope(a, b):
    return 0.5 * (exp_slope(a, b) + exp_slope(-a, -b))


@_inline
def sinh_slope_b(a, b):
    return _second(math.cosh(b), sinh_slope(a, b), math.sinh((a + 2.0 * b) / 3.0), a, b, 1.0)


@_inline
def cosh_slope(a, b):
    mean = 0.5 * (a + b)
    if abs(mean) < 1.0:  # the two exponentials would cancel
        return math.sinh(mean) * sinhc(0.5 * (b - a))
    return 0.5 * (exp_slope(a, b) - exp_slope(-a, -b))


@_inline
def cosh_slope_b(a, b):
    return _second(math.sinh(b), cosh_slope(a, b), math.cosh((a + 2.0 * b) / 3.0), a, b, 1.0)


@_inline
def tanh_slope(a, b):
    if max(abs(a), abs(b)) < _MODERATE:
        p, q = math.exp(a), math.exp(b)
        return 4.0 * sinhc(b - a) * (p * q) / (fma(p, p, 1.0) * fma(q, q, 1.0))
    # sinhc(b − a) / (cosh a cosh b) with the growing exponentials divided out.
    gap = abs(b - a)
    relative = -math.expm1(-2.0 * gap) / (2.0 * gap) if gap != 0.0 else 1.0
    tails = (1.0 + math.exp(-2.0 * abs(a))) * (1.0 + math.exp(-2.0 * abs(b)))
    same = -2.0 * min(abs(a), abs(b)) if (a > 0.0) == (b > 0.0) else 0.0
    return 4.0 * math.exp(same) * relative / tails


@_inline
def tanh_slope_b(a, b):
    u = (a + 2.0 * b) / 3.0
    first = 1.0 / math.cosh(b) ** 2
    return _second(first, tanh_slope(a, b), -2.0 * math.tanh(u) / math.cosh(u) ** 2, a, b, 1.0)
