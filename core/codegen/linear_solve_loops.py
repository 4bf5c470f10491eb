"""Solve linear systems of many unknowns in loops over arrays, like the unrolled lines of `linear_solve` for few.

Matrices are flat arrays in row-major order, and overwritten. `native` compiles these functions with the steps that call
them; in Python they run on numpy arrays.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# the types are inferred by `native`

from __future__ import annotations

import math

from core.codegen.linear_solve import DEPENDENT, LARGEST, NEARLY_DEPENDENT, OMIT_BELOW, SMALLEST

__all__ = ["change_along", "solve_with_pivots"]


def solve_with_pivots(a, r, s, n, d, first, state):
    """Solve a·e = r for n unknowns by Gaussian elimination, as `linear_solve.with_pivots` does.

    The unknowns from d on are multipliers of gradients; those of gradients that vanish, or depend on others, may be
    omitted.

    Parameters
    ----------
    a
        (n²,) matrix.
    r
        (n,) right-hand side, overwritten by the solution e.
    s
        (n,) scratch.
    n, d
        Number of unknowns, and how many of them are not multipliers.
    first
        Whether this is Newton's first correction.
    state
        Size of the state.

    Returns
    -------
    tuple
        Whether no gradient vanishes or nearly depends on others; the largest |r| of a ψ; the largest entry of a
        gradient.
    """
    residual, largest, independent, several = 0.0, 0.0, True, n - d > 1
    for k in range(d, n):
        s[k] = 0.0
        for i in range(d):
            s[k] = max(s[k], abs(a[i * n + k]))
        largest, residual = max(largest, s[k]), max(residual, abs(r[k]))
    for k in range(n):
        pivot_up(a, r, n, k, d)
        if k == d:
            for i in range(n - d):  # there are no more multipliers than other unknowns
                s[i] = abs(a[(d + i) * n + d + i])
        pivot = a[k * n + k]
        inverse = 1.0 / pivot if pivot != 0.0 else 0.0
        if k >= d and several:
            near = abs(pivot) <= NEARLY_DEPENDENT * s[k - d]
            independent = independent and not near
            if near and (first or abs(r[k]) <= OMIT_BELOW * s[k] * state or abs(pivot) <= DEPENDENT * s[k - d]):
                inverse = 0.0
        a[k * n + k] = inverse
        for i in range(k + 1, n):
            q = a[i * n + k] * inverse
            if q != 0.0:
                for c in range(k + 1, n):
                    a[i * n + c] -= q * a[k * n + c]
                r[i] -= q * r[k]
    substitute_back(a, r, n)
    return independent, residual, largest


def pivot_up(a, r, n, k, d):
    """Exchange row k with the one of rows k … d − 1 whose entry in column k is largest."""
    best = k
    for i in range(k + 1, d):
        if abs(a[i * n + k]) > abs(a[best * n + k]):
            best = i
    if best != k:
        for c in range(k, n):
            a[best * n + c], a[k * n + c] = a[k * n + c], a[best * n + c]
        r[best], r[k] = r[k], r[best]


def substitute_back(a, r, n):
    """Solve a triangular system whose diagonal holds the inverses of the pivots."""
    for k in range(n - 1, -1, -1):
        known = r[k]
        for c in range(k + 1, n):
            known -= a[k * n + c] * r[c]
        r[k] = known * a[k * n + k]


def change_along(a, b, r, j, e, m, d, state, least):
    """Find the v in the span of the rows of a with b·v = r, v = aᵀ(b aᵀ)⁻¹r, as `linear_solve.least_change` does.

    Rows that vanish, or depend on others, may impose no condition.

    Parameters
    ----------
    a, b
        (m·d,) rows.
    r
        (m,) right-hand side, overwritten.
    j
        (m²,) scratch.
    e
        (d,) the result v.
    m, d
        Numbers of rows and columns.
    state
        Size of the state.
    least
        Square of the sine to other rows below which a row imposes no condition.

    Returns
    -------
    bool
        Whether no row nearly depends on others.
    """
    multiply(a, b, j, m, d)
    usual = True
    for k in range(m):
        usual = usual and SMALLEST < abs(j[k * m + k]) < LARGEST
    if not usual:
        rescale(a, b, r, m, d)
        multiply(a, b, j, m, d)
    independent = True
    for k in range(m):
        e[k] = abs(j[k * m + k])  # there are more columns than rows
    for k in range(m):
        pivot = j[k * m + k]
        inverse = 1.0 / pivot if pivot != 0.0 else 0.0
        if k > 0 and abs(pivot) <= NEARLY_DEPENDENT * e[k]:
            independent = False
            if abs(r[k]) <= OMIT_BELOW * math.sqrt(e[k]) * state or abs(pivot) <= least * e[k]:
                inverse = 0.0
        j[k * m + k] = inverse
        for i in range(k + 1, m):
            q = j[i * m + k] * inverse
            for c in range(k + 1, m):
                j[i * m + c] -= q * j[k * m + c]
            r[i] -= q * r[k]
    substitute_back(j, r, m)
    for c in range(d):
        e[c] = 0.0
        for k in range(m):
            e[c] += a[k * d + c] * r[k]
    return independent


def multiply(a, b, j, m, d):
    """Write b·aᵀ to j."""
    for i in range(m):
        for k in range(m):
            total = 0.0
            for c in range(d):
                total += b[i * d + c] * a[k * d + c]
            j[i * m + k] = total


def rescale(a, b, r, m, d):
    """Divide every row, and its r, by its largest entry, lest its square overflow or underflow."""
    for k in range(m):
        q = 0.0
        for c in range(d):
            q = max(q, abs(a[k * d + c]))
        q = 1.0 / q if q > 0.0 else 0.0
        r[k] *= q
        for c in range(d):
            a[k * d + c] *= q
            b[k * d + c] *= q
