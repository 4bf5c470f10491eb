"""The first root of a polynomial on an interval: Descartes' rule of signs in the Bernstein basis, and bisection.

The coefficients b₀ … bₙ of p in the Bernstein basis of an interval change sign V times; p has V roots inside, or fewer
by an even number. V = 0: none. V = 1: one. Otherwise the interval is halved (de Casteljau), the earlier half first.

Where |bⱼ| ≤ `NOISE`·Σ|aₖ hᵏ|, round-off hides the sign of bⱼ. An interval with V ≥ 2 so short that all signs are hidden
holds two roots or a touch, which cannot be told apart. Two roots of a parabola near the middle of the
interval are separated if they are about 1e-7 h or more apart.

References: Collins, Akritas, SYMSAC (1976); Lane, Riesenfeld, BIT 21 (1981); Rouillier, Zimmermann, J. Comput. Appl.
Math. 162 (2004).
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# jitted: numba infers the types

from __future__ import annotations

import math

import numpy as np

from core.kernels.doubledouble.arithmetic import fma
from core.kernels.jit import always_inlined, jitted

__all__ = ["DEPTH", "DOUBLE", "NOISE", "NONE", "ROOT", "first_root", "scratch_shape"]

NONE, ROOT, DOUBLE = 0, 1, 2

#: Largest number of halvings. Two roots in an interval of 2⁻⁴⁰ h leave coefficients of n² 2⁻⁸¹ Σ|aₖ hᵏ|, far below
#: `NOISE`: this bound is only reached with coefficients that are not finite.
DEPTH = 40
#: Bound on the round-off of a Bernstein coefficient, relative to the sum of sizes Σ|aₖ hᵏ|.
NOISE = 2.0**-52
#: Half the width of the bracket around a root that has been found, relative to the root.
NARROW = 2.0**-8
#: Largest number of corrections of Halley's method.
_MAX_HALLEY = 4
#: Halley's method ends at a correction of this size relative to the root; its cube is the relative error that is left.
_CLOSE = 1e-4
#: A sum below zero by this much, relative to the sum of the sizes of its terms, is negative whatever the rounding.
_SURE = 1e-12

#: Type of indices known not to be negative: they need no test for counting from the end.
_u = np.uint64


def scratch_shape(order: int) -> tuple[int, int]:
    """Shape of the scratch array that `first_root` needs for polynomials up to this degree."""
    return DEPTH + 2, order + 3


@jitted
def first_root(row, order, h, leaving, scratch):
    """Find the first s of (0, h] at which a polynomial that starts above 0 is at or below 0.

    Parameters
    ----------
    row
        (> order,) coefficients of the height, a polynomial in s.
    h
        End of the interval, of either sign: s runs from 0 to h.
    leaving
        0: the height is positive at s = 0. 1: it is 0 there up to round-off; row[0] is ignored, and the roots of
        height/s are isolated.
    scratch
        float64, at least of the shape `scratch_shape(order)`.

    Returns
    -------
    kind, low, high
        `NONE`: no root. `ROOT`: from low to high the height changes once from positive to zero or negative; low =
        high = 0 if it is not positive at the start; low = 0 may also occur for leaving = 1, where the height is 0.
        `DOUBLE`: between low and high are two roots that round-off cannot separate, or a touch; or, with low = 0 and
        high = h, a coefficient is not finite and the roots are unknown.
    """
    shift = 1 if leaving != 0 else 0
    n = order - shift
    size, fall = _scale(row, n, shift, h, scratch)
    start = scratch[0, 0]
    if _least(scratch, n) > fall and size < math.inf:
        return NONE, 0.0, 0.0
    if not size < math.inf:
        return DOUBLE, 0.0, h
    if start <= 0.0:
        first = 0
        while first < n and scratch[0, _u(first)] == 0.0:
            first += 1
        if leaving == 0 or scratch[0, _u(first)] <= 0.0:
            return ROOT, 0.0, 0.0
        n -= first  # the height rises like s**(first + 1)
        for k in range(n + 1):
            scratch[0, k] = scratch[0, _u(k + first)]
    else:
        end = _sum(scratch, n)
        if end > _SURE * size and _falls_or_bends(scratch, n, 1.0, size):
            return NONE, 0.0, 0.0
        s = _plain_root(scratch, n, size, end) if end < -_SURE * size else math.nan
        if s == s:
            return ROOT, (s - NARROW * s) * h, min(s + NARROW * s, 1.0) * h
    _to_bernstein(scratch, n)
    return _search(scratch, n, NOISE * size, h)


@always_inlined
def _scale(row, n, shift, h, scratch):
    """Write the coefficients for s = h u, u in [0, 1], to scratch[0].

    Returns the sum of their sizes, and a bound on how far the terms from the third power on can lower the polynomial.
    """
    first = row[_u(shift)] * (h if shift == 1 else 1.0)
    scratch[0, 0] = first
    size, size_odd, fall, fall_odd = abs(first), 0.0, 0.0, 0.0
    square = h * h
    odd, even = (square, square * h) if shift == 1 else (h, square)
    # Even and odd powers are summed apart: two independent chains of half the length.
    for k in range(1, n, 2):
        a, b = row[_u(k + shift)] * odd, row[_u(k + 1 + shift)] * even
        scratch[0, _u(k)], scratch[0, _u(k + 1)] = a, b
        size_odd, size = size_odd + abs(a), size + abs(b)
        if k > 1:
            fall_odd, fall = fall_odd - min(a, 0.0), fall - min(b, 0.0)
        odd, even = odd * square, even * square
    if n & 1 == 1:
        a = row[_u(n + shift)] * odd
        scratch[0, _u(n)] = a
        size += abs(a)
        fall -= min(a, 0.0) if n > 2 else 0.0
    return size + size_odd, fall + fall_odd


@always_inlined
def _least(scratch, n):
    """Least value on [0, 1] of the terms up to the second power; of a Taylor polynomial the others are small."""
    a = scratch[0, 0]
    b = scratch[0, 1] if n > 0 else 0.0
    c = scratch[0, 2] if n > 1 else 0.0
    if b < 0.0 and -b < 2.0 * c:
        return a - b * b / (4.0 * c)
    return min(a, a + b + c)


@always_inlined
def _sum(scratch, n):
    """Value at u = 1."""
    value = 0.0
    for k in range(n + 1):
        value += scratch[0, k]
    return value


@always_inlined
def _plain_root(scratch, n, size, value):
    """The first root of a polynomial whose value at u = 1 is negative, by Halley's method; nan where it may be another.

    The root found is the first if the polynomial falls, or is concave, from the start to a little beyond it.
    """
    slope = 0.0
    for k in range(1, n + 1):
        slope += k * scratch[0, k]
    s = _first_guess(scratch, n, value, slope)
    for _ in range(_MAX_HALLEY):
        f, r, q = scratch[0, _u(n)], 0.0, 0.0  # value, derivative, half the second derivative
        for k in range(n - 1, -1, -1):
            q = fma(q, s, r)
            r = fma(r, s, f)
            f = fma(f, s, scratch[0, _u(k)])
        change = f * r / (r * r - f * q)
        s -= change
        if not 0.0 < s <= 1.0:
            return math.nan
        if abs(change) <= _CLOSE * s:
            return s if _falls_or_bends(scratch, n, min(s + NARROW * s, 1.0), size) else math.nan
    return math.nan


@always_inlined
def _first_guess(scratch, n, value, slope):
    """Root of the inverse cubic through the values and slopes of both ends; else of the parabola at the start."""
    start, rate, bend = scratch[0, 0], scratch[0, 1], scratch[0, 2] if n > 1 else 0.0
    if rate < 0.0 and slope < 0.0:
        drop = value - start
        z = -start / drop
        guess = z * z * (3.0 - 2.0 * z) + z * (1.0 - z) * ((1.0 - z) * drop / rate - z * drop / slope)
    else:
        guess = 2.0 * start / (math.sqrt(max(rate * rate - 4.0 * start * bend, 0.0)) - rate)
    return guess if 0.0 < guess < 1.0 else start / (start - value)


@always_inlined
def _falls_or_bends(scratch, n, s, size):
    """Whether the first or the second derivative is nowhere positive on [0, s], as far as the coefficients show it.

    Σ bₖ uᵏ with u in [0, 1] is a weighted mean of 0 and the partial sums of the bₖ (Abel); it is not positive if none
    of these is.
    """
    falls, bends, highest_fall, highest_bend, power = 0.0, 0.0, -math.inf, -math.inf, 1.0
    for k in range(1, n + 1):
        power *= s
        term = k * (scratch[0, k] * power)
        falls += term
        bends += (k - 1) * term
        highest_fall, highest_bend = max(highest_fall, falls), max(highest_bend, bends)
    noise = NOISE * size
    return (highest_fall <= noise and falls < -_SURE * size) or highest_bend <= noise


@always_inlined
def _to_bernstein(scratch, n):
    """Convert from powers to the Bernstein basis of [0, 1]: bⱼ = Σ C(j, i) / C(n, i) aᵢ, by sums of neighbours."""
    inverse = 1.0  # 1 / C(n, i)
    for i in range(1, n + 1):
        inverse *= i / (n - i + 1)
        scratch[0, i] *= inverse
    for level in range(1, n + 1):
        i = n
        while i >= level:
            scratch[0, _u(i)] += scratch[0, _u(i - 1)]
            i -= 1


@always_inlined
def _variations(scratch, slot, n):
    """Number of sign changes, zeros left out; the last coefficient, the value at the end, is negative if zero."""
    count = 0
    positive = True  # the polynomial is positive at the start of every interval searched
    for j in range(1, n + 1):
        b = scratch[slot, j]
        if (b < 0.0) if positive else (b > 0.0):
            positive = not positive
            count += 1
    if positive and scratch[slot, _u(n)] == 0.0:
        count += 1
    return count


@always_inlined
def _is_noise(scratch, slot, first, n, noise):
    """Whether round-off hides the signs of the coefficients first … n."""
    largest = 0.0
    for j in range(first, n + 1):
        largest = max(largest, abs(scratch[slot, j]))
    return largest <= noise


@always_inlined
def _halve(scratch, slot, n):
    """Halve an interval by de Casteljau's algorithm: the later half stays in its slot, the earlier goes to the next."""
    left = slot + 1
    scratch[left, 0] = scratch[slot, 0]
    for level in range(1, n + 1):
        for j in range(n - level + 1):
            scratch[slot, j] = 0.5 * (scratch[slot, j] + scratch[slot, _u(j + 1)])
        scratch[left, level] = scratch[slot, 0]
    low, width = scratch[slot, _u(n + 1)], 0.5 * scratch[slot, _u(n + 2)]
    scratch[slot, _u(n + 1)], scratch[slot, _u(n + 2)] = low + width, width
    scratch[left, _u(n + 1)], scratch[left, _u(n + 2)] = low, width


@always_inlined
def _search(scratch, n, noise, h):
    """Search the interval in slot 0, with a stack of intervals whose top is the earliest."""
    scratch[0, _u(n + 1)], scratch[0, _u(n + 2)] = 0.0, 1.0
    slot = 0
    while slot >= 0:
        count = _variations(scratch, slot, n)
        if count == 0:
            slot -= 1
            continue
        low = scratch[slot, _u(n + 1)]
        high = low + scratch[slot, _u(n + 2)]
        # Where round-off hides the signs of the last two coefficients, the root may be the first of two.
        if count == 1 and not _is_noise(scratch, slot, max(n - 1, 0), n, noise):
            return ROOT, low * h, high * h
        if slot > DEPTH or _is_noise(scratch, slot, 0, n, noise):
            return DOUBLE, low * h, high * h
        _halve(scratch, slot, n)
        slot += 1
    return NONE, 0.0, 0.0
