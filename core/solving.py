"""Linear systems solved in loops over arrays: what `elimination` writes out for a few unknowns, for many.

Matrices are flat, row after row, and lost. `native` compiles these functions with the steps that call them; in Python
they run on arrays of numpy.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
# jitted: the types are found out

from __future__ import annotations

from core.elimination import DEPENDENT, LEAST, MOST

__all__ = ["change_along", "solve_with_pivots"]

_DEPENDENT_SINE = DEPENDENT**0.5


def solve_with_pivots(a, r, s, n, d):
    """Solve a·e = r of n unknowns by Gaussian elimination with partial pivoting, as `elimination.with_pivots` does.

    The unknowns from d on are multipliers of gradients. A pivot of zero, or one that is round-off beside the others,
    leaves its unknown alone.

    Parameters
    ----------
    a
        n² numbers.
    r
        n numbers; the solution e is left in them.
    s
        Room for n numbers.
    n, d
        How many unknowns there are, and how many of them are no multipliers.

    Returns
    -------
    tuple
        Whether every multiplier has been found; how much ψ was to change by, at most; the largest entry of a gradient.
    """
    least, excess, largest, bound = 1.0, 0.0, 0.0, True
    for k in range(d, n):
        s[k] = 0.0
        for i in range(d):
            s[k] = max(s[k], abs(a[i * n + k]))
        least, largest, excess = min(least, s[k]), max(largest, s[k]), max(excess, abs(r[k]))
    unit = DEPENDENT * least if n - d > 1 else 0.0
    for k in range(n):
        pivot_up(a, r, n, k)
        smallest = unit * s[k] if k >= d else 0.0
        pivot = a[k * n + k]
        inverse = 1.0 / pivot if not abs(pivot) <= smallest else 0.0
        bound = bound and (k < d or inverse != 0.0)
        a[k * n + k] = inverse
        for i in range(k + 1, n):
            q = a[i * n + k] * inverse
            if q != 0.0:
                for c in range(k + 1, n):
                    a[i * n + c] -= q * a[k * n + c]
                r[i] -= q * r[k]
    substitute_back(a, r, n)
    return bound, excess, largest


def pivot_up(a, r, n, k):
    """Exchange rows from k on so that the largest entry of column k comes first."""
    best = k
    for i in range(k + 1, n):
        if abs(a[i * n + k]) > abs(a[best * n + k]):
            best = i
    if best != k:
        for c in range(k, n):
            a[best * n + c], a[k * n + c] = a[k * n + c], a[best * n + c]
        r[best], r[k] = r[k], r[best]


def substitute_back(a, r, n):
    """Solve the triangular system that is left; the inverses of the pivots are in the diagonal."""
    for k in range(n - 1, -1, -1):
        known = r[k]
        for c in range(k + 1, n):
            known -= a[k * n + c] * r[c]
        r[k] = known * a[k * n + k]


def change_along(a, b, r, j, e, m, d):
    """The v along the rows of a with b·v = r, v = aᵀ(b aᵀ)⁻¹r, as `elimination.least_change` does.

    Rows that vanish, or depend on those before them but for round-off, bind nothing.

    Parameters
    ----------
    a, b
        m rows of d numbers.
    r
        m numbers, lost.
    j
        Room for m² numbers.
    e
        v, d numbers, is left here.
    m, d
        Rows and columns.
    """
    multiply(a, b, j, m, d)
    usual = True
    for k in range(m):
        usual = usual and LEAST < abs(j[k * m + k]) < MOST
    if not usual:
        rescale(a, b, r, m, d)
        multiply(a, b, j, m, d)
    for k in range(m):
        e[k] = abs(j[k * m + k])  # there are more columns than rows
    for k in range(m):
        least = _DEPENDENT_SINE * e[k] if k > 0 else 0.0
        pivot = j[k * m + k]
        inverse = 1.0 / pivot if abs(pivot) > least else 0.0
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


def multiply(a, b, j, m, d):
    """Leave b·aᵀ in j."""
    for i in range(m):
        for k in range(m):
            total = 0.0
            for c in range(d):
                total += b[i * d + c] * a[k * d + c]
            j[i * m + k] = total


def rescale(a, b, r, m, d):
    """Divide rows, and their r, by their largest entry: their squares may be beyond floating point."""
    for k in range(m):
        q = 0.0
        for c in range(d):
            q = max(q, abs(a[k * d + c]))
        q = 1.0 / q if q > 0.0 else 0.0
        r[k] *= q
        for c in range(d):
            a[k * d + c] *= q
            b[k * d + c] *= q
