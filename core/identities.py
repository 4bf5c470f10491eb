"""Is an expression identically zero? Decided by values, in high precision, at random points."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from functools import partial
from itertools import islice
from math import comb
from typing import Any

import mpmath
import sympy

from core.expressions import FUNCTIONS

__all__ = ["independent", "is_larger", "is_zero", "size_expanded", "tidied"]

_DIGITS = 40
_POINTS = 4
_ATTEMPTS = 40
_LARGEST_ARGUMENT = 1e6  #: of exp, sin and the like; for more, mpmath needs a digit of π or log 2 for each of its bits
_TIDIED_TERMS = 40  #: of a sum that is multiplied out
_TIDIED_NODES = 600


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


def tidied(expression: sympy.Expr) -> sympy.Expr:
    """Return `expression` multiplied out where that makes it shorter; what is large is returned as it is.

    This is not `sympy.simplify`, which can take minutes for a line of text.
    """
    if is_larger(expression, _TIDIED_NODES) or size_expanded(expression) > _TIDIED_TERMS:
        return expression
    out = sympy.expand(expression)
    return out if sympy.count_ops(out) < sympy.count_ops(expression) else expression


def is_larger(expression: sympy.Basic, nodes: int) -> bool:
    """Whether the tree of an expression has more nodes than that; found without walking through all of it."""
    return next(islice(sympy.preorder_traversal(expression), nodes, None), None) is not None


def size_expanded(expression: sympy.Expr) -> int:
    """Bound the number of terms that `sympy.expand` would make of an expression or of any part of it."""
    sizes = [size_expanded(part) for part in expression.args]
    if expression.is_Add:
        return sum(sizes)
    if expression.is_Mul:
        return int(sympy.prod(sizes))
    if expression.is_Pow and expression.exp.is_Rational:
        power = abs(int(expression.exp))
        return max(sizes[0], comb(sizes[0] + power - 1, power))
    return max(sizes, default=1)


def _sample(
    terms: tuple[sympy.Expr, ...],
    symbols: set[sympy.Symbol],
    ranges: Mapping[sympy.Symbol, tuple[float, float]],
) -> list[list[mpmath.mpc] | None]:
    """Values of every term at a few random points, None for a point where one of them is not finite."""
    ordered = sorted(symbols, key=str)
    guarded = [term.replace(_is_general_power, lambda u: _GUARDED_POWER(u.base, u.exp)) for term in terms]
    function = sympy.lambdify(ordered, guarded, [_GUARDED, "mpmath"], dummify=True, cse=True)
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


def _is_general_power(node: sympy.Expr) -> bool:
    return bool(node.is_Pow and not node.exp.is_Rational and node.base is not sympy.E)


def _moderate(function: Callable[..., Any], argument: Any) -> Any:
    """Value of a function where that is soon worked out."""
    if abs(argument) > _LARGEST_ARGUMENT:
        raise OverflowError
    return function(argument)


def _power(base: Any, exponent: Any) -> Any:
    if base == 0:
        return mpmath.power(base, exponent)
    return _moderate(mpmath.exp, exponent * mpmath.log(base))


_GUARDED_POWER = sympy.Function("guarded_power")
_GUARDED: dict[str, Callable[..., Any]] = {
    name: partial(_moderate, getattr(mpmath, name)) for name in FUNCTIONS if name not in ("log", "sqrt")
} | {"guarded_power": _power}
