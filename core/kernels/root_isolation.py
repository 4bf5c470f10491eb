"""The first root of a polynomial on an interval: Descartes' rule of signs in the Bernstein basis, and bisection.

The coefficients b₀ … bₙ of p in the Bernstein basis of an interval change sign V times; p has V roots inside, or fewer
by an even number. V = 0: none. V = 1: one. Otherwise the interval is halved (de Casteljau), the earlier half first.

Where |bⱼ| ≤ `NOISE`·Σ|aₖ hᵏ|, round-off hides the sign: an interval that is short enough for all its coefficients to be
so, and still has V ≥ 2, holds two roots or a touch, which cannot be told apart. Roots of a parabola near the middle of
the interval can be told apart from about 1e-7 h on.

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

#: Halvings at most. Two roots in an interval of 2⁻⁴⁰ h leave coefficients of n² 2⁻⁸¹ Σ|aₖ hᵏ|, far below `NOISE`: the
#: bound only ends what is not finite.
DEPTH = 40
NOISE = 2.0**-52
#: Half the width of the bracket around a root that has been found, in parts of it.
NARROW = 2.0**-8
#: Corrections of Halley's method at most; the last is so small in parts of the root, and leaves its cube as an error.
_MAX_HALLEY, _CLOSE = 4, 1e-4
#: What is below zero by so much of the sum of all terms is so whatever their rounding.
_SURE = 1e-12

#: Indices known not to be negative, which need no test for counting from the end.
_u = np.uint64


def scratch_shape(order: int) -> tuple[int, int]:
    """Shape of the scratch that `first_root` needs for polynomials of this degree at most."""
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
        0: the height is positive at s = 0. 1: it is 0 there but for round-off, row[0] is left out, and roots of
        height/s are looked for.
    scratch
        float64, at least `scratch_shape` of the order.

    Returns
    -------
    kind, low, high
        `NONE`. Or `ROOT`: on the way from low to high the height goes from positive to zero or less, once; low = high
        = 0 where it does so at once, and low = 0 is possible (where, leaving, the height is 0). Or `DOUBLE`: between
        low and high are two roots closer than round-off lets one see, or a touch; or, with low = 0 and high = h, a
        coefficient is not finite and nothing can be told.
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
        n -= first  # it rises like s**(first + 1)
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
    """Coefficients for s = h u, u in [0, 1], to scratch[0].

    Returns the sum of their sizes, and how far the terms from the third power on can pull the polynomial down.
    """
    first = row[_u(shift)] * (h if shift == 1 else 1.0)
    scratch[0, 0] = first
    size, size_odd, fall, fall_odd = abs(first), 0.0, 0.0, 0.0
    square = h * h
    odd, even = (square, square * h) if shift == 1 else (h, square)
    # Even and odd powers apart: two chains of half the length.
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
    """Least value on [0, 1] of the terms up to the second power; the others, of a Taylor polynomial, are small."""
    a = scratch[0, 0]
    b = scratch[0, 1] if n > 0 else 0.0
    c = scratch[0, 2] if n > 1 else 0.0
    if b < 0.0 and -b < 2.0 * c:
        return a - b * b / (4.0 * c)
    return min(a, a + b + c)


@always_inlined
def _sum(scratch, n):
    """Value at the end, u = 1."""
    value = 0.0
    for k in range(n + 1):
        value += scratch[0, k]
    return value


@always_inlined
def _plain_root(scratch, n, size, value):
    """The first root of what ends below zero, at this value, by Halley's method; nan where it is not plain to see.

    It is where the polynomial falls, or is concave, from the start to a little beyond the root.
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
    """Where the inverse cubic is 0 that has the values and slopes of both ends; or else the parabola at the start."""
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
    """Whether the first derivative is not above zero on [0, s], or the second one.

    Σ bₖ uᵏ with u in [0, 1] is an average of the partial sums of the bₖ, and of 0 (Abel): none of them may be above.
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
    """From powers to the Bernstein basis of [0, 1]: bⱼ = Σ C(j, i) / C(n, i) aᵢ, by sums of neighbours."""
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
    """Changes of sign, zeros left out; the last coefficient, the value at the end, counts as negative if zero."""
    count = 0
    positive = True  # every interval that is looked at starts above 0
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
    """Whether round-off hides the signs of coefficients first … n."""
    largest = 0.0
    for j in range(first, n + 1):
        largest = max(largest, abs(scratch[slot, j]))
    return largest <= noise


@always_inlined
def _halve(scratch, slot, n):
    """De Casteljau at the middle: the later half stays in its slot, the earlier goes to the next."""
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
    """Look through the interval in slot 0: a stack of intervals, the earliest on top."""
    scratch[0, _u(n + 1)], scratch[0, _u(n + 2)] = 0.0, 1.0
    slot = 0
    while slot >= 0:
        count = _variations(scratch, slot, n)
        if count == 0:
            slot -= 1
            continue
        low = scratch[slot, _u(n + 1)]
        high = low + scratch[slot, _u(n + 2)]
        # One that ends in noise, and level, may be the first of two.
        if count == 1 and not _is_noise(scratch, slot, max(n - 1, 0), n, noise):
            return ROOT, low * h, high * h
        if slot > DEPTH or _is_noise(scratch, slot, 0, n, noise):
            return DOUBLE, low * h, high * h
        _halve(scratch, slot, n)
        slot += 1
    return NONE, 0.0, 0.0
