"""A conserved quantity of a planar divergence-free field, found by integration: its stream function."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import sympy
from sympy import Expr, Symbol

from core.symbolic.algebra import antiderivative, simplify
from core.symbolic.expressions import TIME
from core.symbolic.operations import FUNCTIONS
from core.symbolic.origin import Origin
from core.symbolic.zero_testing import EVERYWHERE, Domain, has_values_throughout, is_zero, size_expanded

__all__ = ["stream_function"]

#: Most operations of one term that sympy is asked to integrate: a larger one could take minutes.
_MAX_OPERATIONS = 24
#: Most terms of an expanded component of a field whose antiderivatives sympy is asked for.
_MAX_TERMS = 60
#: Most factors, over all terms, that are not powers of the variable of integration.
_MAX_FACTORS = 3
#: Largest exponent in a term that has such a factor.
_MAX_POWER = 8
#: sympy functions that an antiderivative may contain.
_WHITELIST = tuple(exact for name, (exact, _) in FUNCTIONS.items() if name != "sqrt")


def stream_function(field: Sequence[Expr], variables: Sequence[Symbol], domain: Domain = EVERYWHERE) -> Expr | None:
    """ψ with (x', y') = (∂ψ/∂y, −∂ψ/∂x), or None where there is none, or none that is easily found.

    Parameters
    ----------
    field
        2 expressions in the variables; for any other number of them, or where they depend on t, None is returned.
    variables
        (x, y).
    domain
        Where ψ has to be real and these equations have to hold.
    """
    if len(variables) != 2 or any(f.has(TIME) for f in field):
        return None
    if not _is_easily_integrated(field, variables):
        return None
    (x, y), (u, v) = variables, field
    domain = replace(domain, defined=(u, v))
    if not is_zero(u.diff(x) + v.diff(y), domain):
        return None
    origin = Origin.of(field, variables)
    u_about, v_about = origin.about(field)
    sought = _potential(u_about, v_about, x, y)
    if sought is None:
        return None
    psi = _real_throughout(origin.back(sought), domain)
    if psi is None or not psi.free_symbols:
        return None
    return psi if is_zero(psi.diff(y) - u, domain) and is_zero(psi.diff(x) + v, domain) else None


def _potential(u: Expr, v: Expr, x: Symbol, y: Symbol) -> Expr | None:
    """ψ with (u, v) = (∂ψ/∂y, −∂ψ/∂x), if it is found."""
    part = _integral(u, y)
    if part is None:
        return None
    rest = sympy.expand(-v - part.diff(x))  # what depends on x alone
    if rest.has(y):
        rest = simplify(rest) if sympy.count_ops(rest) <= _MAX_OPERATIONS else rest
    other = None if rest.has(y) else _integral(rest, x)
    return None if other is None else part + other


def _real_throughout(psi: Expr, domain: Domain) -> Expr | None:
    """ψ, or ψ with log(u²)/2 for log(u), if real throughout the domain (on both sides of a pole of f), else None."""
    even = psi.replace(sympy.log, lambda u: sympy.log(u**2) / 2)
    return next((found for found in dict.fromkeys((psi, even)) if has_values_throughout(found, domain)), None)


def _integral(expression: Expr, variable: Symbol) -> Expr | None:
    """An antiderivative, term by term; None where one needs functions outside the whitelist."""
    total = sympy.Integer(0)
    for term in sympy.Add.make_args(sympy.expand(expression)):
        factor, rest = term.as_independent(variable, as_Add=False)
        if sympy.count_ops(rest) > _MAX_OPERATIONS:
            return None
        found = antiderivative(rest, variable)
        if not _is_plain(found):
            return None
        total += factor * found
    return total


def _is_plain(expression: Expr) -> bool:
    """Whether an expression consists of numbers, symbols, sums, products, powers and functions of the whitelist."""
    return all(
        node.is_Symbol or node.is_number or node.is_Add or node.is_Mul or node.is_Pow or node.func in _WHITELIST
        for node in sympy.preorder_traversal(expression)
    )


def _is_easily_integrated(field: Sequence[Expr], variables: Sequence[Symbol]) -> bool:
    """Whether sympy finds the antiderivatives of a planar field, or gives up, in a fraction of a second.

    It can spend minutes on a product of a few functions, or on high powers of one.
    """
    if any(size_expanded(f) > _MAX_TERMS for f in field):
        return False
    terms = [
        (term, v)
        for f, v in zip(field, reversed(variables), strict=True)
        for term in sympy.Add.make_args(sympy.expand(f))
    ]
    return sum(_effort(*term) for term in terms) <= _MAX_FACTORS


def _effort(term: Expr, variable: Symbol) -> float:
    """Number of factors of a term, with multiplicity, that are not powers of the variable; inf if too hard."""
    powers = [part.as_base_exp() for part in sympy.Mul.make_args(term) if part.has(variable)]
    others = [p for p in powers if p[0] != variable or not p[1].is_Integer]
    if others and any(abs(exponent) > _MAX_POWER for _, exponent in powers if exponent.is_Rational):
        return math.inf
    return sum(_effort_of_power(base, exponent, variable) for base, exponent in others)


def _effort_of_power(base: Expr, exponent: Expr, variable: Symbol) -> float:
    inner, most = (base.args[0], 2) if base.is_Function else (base, 4)
    if _degree(inner, variable) > most or _degree(exponent, variable) > 2:
        return math.inf
    return max(1.0, abs(float(exponent))) if exponent.is_Rational else 1.0


def _degree(expression: Expr, variable: Symbol) -> float:
    """Degree of a polynomial in a variable, infinite where it is none."""
    if not expression.has(variable):
        return 0
    if expression.is_Add or expression.is_Mul:
        return (max if expression.is_Add else sum)(_degree(part, variable) for part in expression.args)
    if expression.is_Pow and expression.exp.is_Integer and expression.exp > 0:
        return int(expression.exp) * _degree(expression.base, variable)
    return 1 if expression == variable else math.inf
