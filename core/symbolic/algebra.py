"""Algebra of sympy on quotients and products, also of powers such as exp(0.123456789 x).

To sympy's polynomials this is the power 123456789 of exp(x/10⁹): they store as many coefficients, which takes hours and
all memory. Here such powers are symbols while sympy works, those of one base being powers of one symbol.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import sympy
from sympy import Dummy, Expr, Rational

__all__ = ["antiderivative", "cancel", "factor", "factor_list", "gcd", "simplify", "together"]

#: Highest degree that is left to sympy.
_MAX_DEGREE = 64


def cancel(u: Expr) -> Expr:
    """u as a quotient of polynomials without common factors; functions of variables are taken for further variables."""
    return _in_plain_powers(sympy.cancel, u)


def together(u: Expr) -> Expr:
    """u over one denominator."""
    return _in_plain_powers(sympy.together, u)


def factor(u: Expr) -> Expr:
    """u as a product over the rationals."""
    return _in_plain_powers(sympy.factor, u)


def factor_list(u: Expr) -> tuple[Expr, list[tuple[Expr, int]]]:
    """The constant factor of a polynomial, and the others with their powers; BasePolynomialError if it is none."""
    content, factors = _in_plain_powers(sympy.factor_list, u)
    return content, [(one, power) for one, power in factors]


def gcd(u: Expr, v: Expr) -> Expr:
    """The greatest common divisor; PolynomialError where there is none."""
    return _in_plain_powers(sympy.gcd, u, v)


def simplify(u: Expr) -> Expr:
    """u in what sympy holds for its simplest form."""
    return _in_plain_powers(sympy.simplify, u)


def antiderivative(u: Expr, variable: sympy.Symbol) -> Expr:
    """An antiderivative, or an expression with an unevaluated integral, or with cases."""
    symbols: dict[Rational, Dummy] = {}

    def plain(node: Expr) -> Expr:
        sizes = {r: abs(r) for r in node.atoms(Rational) if max(abs(r.p), r.q) > _MAX_DEGREE}
        symbols.update({size: Dummy(positive=True) for size in sizes.values() if size not in symbols})
        return node.xreplace({r: sympy.sign(r) * symbols[size] for r, size in sizes.items()})

    found = sympy.integrate(u.replace(lambda node: node.is_Function, plain), variable, manual=True)
    return found.xreplace({symbol: size for size, symbol in symbols.items()})


def _in_plain_powers(operation: Callable[..., Any], *expressions: Expr) -> Any:
    """The outcome of an operation of sympy on expressions, with symbols in place of powers of high degree."""
    there, back = _plain_powers(expressions)
    if not back:
        return operation(*expressions)
    return _replaced(operation(*(u.xreplace(there) for u in expressions)), back)


def _replaced(outcome: Any, back: dict[Dummy, Expr]) -> Any:
    if isinstance(outcome, (tuple, list)):
        return type(outcome)(_replaced(one, back) for one in outcome)
    return outcome.xreplace(back) if isinstance(outcome, sympy.Basic) else outcome


def _plain_powers(expressions: Sequence[Expr]) -> tuple[dict[Expr, Expr], dict[Dummy, Expr]]:
    """What replaces the powers of high degree, and which power each new symbol stands for."""
    powers = {node: _factors(node) for u in expressions for node in u.atoms(sympy.Pow, sympy.exp)}
    of_base: dict[tuple[Expr, Expr], set[Rational]] = {}
    for factors in powers.values():
        for base, exponent, coefficient in factors:
            of_base.setdefault((base, exponent), set()).add(coefficient)
    symbols: dict[tuple[Expr, Expr, Rational], Expr] = {}
    back: dict[Dummy, Expr] = {}
    for (base, exponent), coefficients in of_base.items():
        if max(abs(c.p) for c in coefficients) > _MAX_DEGREE:
            for unit, multiples in _by_unit(coefficients):
                symbol = Dummy(positive=base.is_positive)
                back[symbol] = base ** (unit * exponent)
                symbols |= {(base, exponent, c): symbol**n for c, n in multiples.items()}
    there = {
        node: sympy.Mul(*(symbols.get((b, e, c), b ** (c * e)) for b, e, c in factors))
        for node, factors in powers.items()
        if any(one in symbols for one in factors)
    }
    return there, back


def _factors(power: Expr) -> list[tuple[Expr, Expr, Rational]]:
    """Base, exponent and its rational coefficient of the factors of a power; none of one with an integer exponent."""
    base, exponent = power.as_base_exp()
    if exponent.is_Integer:
        return []
    parts = (part.as_coeff_Mul(rational=True) for part in sympy.Add.make_args(sympy.expand(exponent)))
    return [(base, rest, coefficient) for coefficient, rest in parts]


def _by_unit(coefficients: set[Rational]) -> list[tuple[Rational, dict[Rational, int]]]:
    """Units of which coefficients are small multiples, with these: one for all of them, else one for each size."""
    common = math.lcm(*(c.q for c in coefficients))
    unit = Rational(math.gcd(*(int(c * common) for c in coefficients)), common)
    multiples = {c: int(c / unit) for c in coefficients}
    if max(map(abs, multiples.values())) <= _MAX_DEGREE:
        return [(unit, multiples)]
    return [(size, {c: 1 if c > 0 else -1 for c in coefficients if abs(c) == size}) for size in map(abs, coefficients)]
