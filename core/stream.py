"""A conserved quantity of a planar divergence-free field, found by integration: its stream function."""

from __future__ import annotations

from collections.abc import Sequence

import sympy
from sympy import Expr, Symbol

from core.expressions import FUNCTIONS, TIME
from core.identities import is_zero

__all__ = ["stream_function"]

#: Operations of one term that sympy is asked to integrate: what is larger could take it for ever.
_MAX_OPERATIONS = 24
_WHITELIST = tuple(exact for name, (exact, _) in FUNCTIONS.items() if name != "sqrt")


def stream_function(field: Sequence[Expr], variables: Sequence[Symbol]) -> Expr | None:
    """ψ with (x', y') = (∂ψ/∂y, −∂ψ/∂x), or None where there is none, or none that is easily found.

    Parameters
    ----------
    field
        2 expressions in the variables; None is returned for any other number of them, and where they name t.
    variables
        (x, y).
    """
    if len(variables) != 2 or any(f.has(TIME) for f in field):
        return None
    (x, y), (u, v) = variables, field
    if not is_zero(u.diff(x) + v.diff(y)):
        return None
    part = _integral(u, y)
    if part is None:
        return None
    rest = sympy.expand(-v - part.diff(x))  # what depends on x alone
    if rest.has(y):
        rest = sympy.simplify(rest) if sympy.count_ops(rest) <= _MAX_OPERATIONS else rest
    other = None if rest.has(y) else _integral(rest, x)
    if other is None:
        return None
    psi = part + other
    exact = psi.free_symbols and is_zero(psi.diff(y) - u) and is_zero(psi.diff(x) + v)
    return psi if exact else None


def _integral(expression: Expr, variable: Symbol) -> Expr | None:
    """An antiderivative, term by term, in functions of the whitelist."""
    total = sympy.Integer(0)
    for term in sympy.Add.make_args(sympy.expand(expression)):
        factor, rest = term.as_independent(variable, as_Add=False)
        if sympy.count_ops(rest) > _MAX_OPERATIONS:
            return None
        found = sympy.integrate(rest, variable, manual=True)
        if not _is_plain(found):
            return None
        total += factor * found
    return total


def _is_plain(expression: Expr) -> bool:
    """Whether an expression holds nothing but numbers, symbols, sums, products, powers and functions we know."""
    return all(
        node.is_Symbol or node.is_number or node.is_Add or node.is_Mul or node.is_Pow or node.func in _WHITELIST
        for node in sympy.preorder_traversal(expression)
    )
