"""Is an expression identically zero? Decided by values, in high precision, at random points."""

from __future__ import annotations

import random
from collections.abc import Mapping

import mpmath
import sympy

__all__ = ["independent", "is_zero"]

_DIGITS = 40
_POINTS = 4
_ATTEMPTS = 40


def is_zero(expression: sympy.Expr, ranges: Mapping[sympy.Symbol, tuple[float, float]] | None = None) -> bool:
    """Whether `expression` vanishes identically.

    It is evaluated to 40 digits at random points and compared with the size of its own terms: an analytic expression
    that vanishes there is zero with a probability that no user will live to see fail (Schwartz-Zippel), and unlike
    symbolic simplification this takes bounded time. Points where it has no finite value are passed over.

    Parameters
    ----------
    ranges
        Where to take a symbol's values; (0.3, 2) for every other.
    """
    terms = sympy.Add.make_args(expression)
    values = [v for v in _sample(terms, expression.free_symbols, ranges or {}) if v is not None]
    if not values:  # nowhere finite where we looked: only a symbolic zero counts
        return bool(expression == 0)
    return all(abs(mpmath.fsum(v)) <= mpmath.mpf(10) ** (10 - _DIGITS) * mpmath.fsum(map(abs, v)) for v in values)


def independent(rows: sympy.Matrix, ranges: Mapping[sympy.Symbol, tuple[float, float]] | None = None) -> bool:
    """Whether the rows of a matrix of expressions are linearly independent at a random point."""
    for values in _sample(tuple(rows), rows.free_symbols, ranges or {}):
        if values is not None:
            with mpmath.workdps(_DIGITS):
                matrix = mpmath.matrix(rows.rows, rows.cols)
                for k, value in enumerate(values):
                    matrix[divmod(k, rows.cols)] = value
                singular = mpmath.svd_c(matrix, compute_uv=False)
                return bool(singular[rows.rows - 1] > mpmath.mpf(10) ** -15 * singular[0])
    return True


def _sample(
    terms: tuple[sympy.Expr, ...],
    symbols: set[sympy.Symbol],
    ranges: Mapping[sympy.Symbol, tuple[float, float]],
) -> list[list[mpmath.mpc] | None]:
    """Values of every term at a few random points, None for a point where one of them is not finite."""
    ordered = sorted(symbols, key=str)
    function = sympy.lambdify(ordered, list(terms), "mpmath", dummify=True)
    generator = random.Random(20260101)  # noqa: S311 - test points, not secrets
    found: list[list[mpmath.mpc] | None] = []
    with mpmath.workdps(_DIGITS):
        for _ in range(_ATTEMPTS):
            point = [mpmath.mpf(generator.uniform(*ranges.get(s, (0.3, 2.0)))) for s in ordered]
            try:
                values = [mpmath.mpmathify(v) for v in function(*point)]
            except (ArithmeticError, ValueError):
                continue
            if all(mpmath.isfinite(v) for v in values):
                found.append(values)
            if len(found) == _POINTS:
                break
    return found
