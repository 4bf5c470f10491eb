"""Bound the effect of rounding on the value of an expression: a running error bound, to first order."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import sympy
from sympy import Expr

from core.codegen.printing import magnitude
from core.symbolic.near_zeros import Choice

__all__ = ["rounding_bound", "with_roundings"]


@lru_cache(maxsize=400)
def rounding_bound(expression: Expr, of_symbols: bool = True) -> Expr:
    """Bound the error of an expression's value in floating point, in units of the machine epsilon.

    Every symbol (a coordinate, a parameter, the time), every constant that is not an integer, and the result of every
    operation is assumed to be rounded (Higham, Accuracy and Stability of Numerical Algorithms, 3.3); of symbols only if
    `of_symbols`.
    """
    if expression.is_Integer or (expression.is_Symbol and not of_symbols):
        return sympy.S.Zero
    if expression.is_Atom:
        return magnitude(expression)
    if isinstance(expression, magnitude):
        return rounding_bound(expression.args[0], of_symbols)
    if isinstance(expression, Choice):  # of two expressions with one value: it is no matter which is taken
        far, *both = expression.args
        return Choice(far, *(rounding_bound(u, of_symbols) for u in both))
    if expression.is_Add:
        return sympy.Add(*(rounding_bound(u, of_symbols) + magnitude(u) for u in expression.args))
    return _of_arguments(expression, of_symbols) + len(expression.args) * magnitude(expression)


def with_roundings(expressions: Sequence[Expr]) -> tuple[Expr, ...]:
    """Return expressions, and after them the `rounding_bound` of each: a value within it may as well be 0."""
    return (*expressions, *map(rounding_bound, expressions))


def _of_arguments(expression: Expr, of_symbols: bool) -> Expr:
    """Bound the effect of the errors of an operation's arguments u on its value: Σ |∂/∂u| times the error of u."""
    names = [sympy.Dummy() for _ in expression.args]
    value, at = expression.func(*names), dict(zip(names, expression.args, strict=True))
    if expression.is_Pow and expression.exp.is_number:  # its rounding is nearly that of the result
        del at[names[1]]
        value = names[0] ** expression.exp
    errors = {name: rounding_bound(u, of_symbols) for name, u in at.items()}
    moved = [magnitude(value.diff(u).xreplace(at)) * error for u, error in errors.items() if error != 0]
    return sympy.Add(*moved)
