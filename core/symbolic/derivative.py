"""Derivatives as sympy writes them, but for products by the zero derivative of what does not move, and for powers.

For each of these products sympy asks whether the other factors are finite; where one is tanh of a sum of symbols, of
which it does not know that they are real, it may take minutes to answer. And the derivatives of (−x)ᵖ, and of xᵏ where
k is a symbol, it writes as p (−x)ᵖ/x and k xᵏ/x, which are not numbers at x = 0.
"""

from __future__ import annotations

from sympy import Add, Expr, Function, Integer, Mul, Symbol, log

__all__ = ["derivative"]


def derivative(u: Expr, symbol: Symbol) -> Expr:
    """The derivative of u: ``u.diff(symbol)``, but with a value wherever the derivative of each power has one.

    Parameters
    ----------
    u
        Expression.
    symbol
        Variable of differentiation.
    """
    known: dict[Expr, Expr] = {symbol: Integer(1)}

    def slope(u: Expr) -> Expr:
        if u not in known:
            known[u] = _slope(u, [slope(part) for part in u.args]) if _is_plain(u) else u.diff(symbol)
        return known[u]

    return slope(u)


def _is_plain(u: Expr) -> bool:
    """Whether u is a number, a symbol, a sum, a product, a power, or a function with derivatives by its arguments."""
    if isinstance(u, Function):
        return type(u)._eval_derivative is Function._eval_derivative
    return bool(u.is_Atom or u.is_Add or u.is_Mul or u.is_Pow)


def _slope(u: Expr, parts: list[Expr]) -> Expr:
    """The derivative of u, given those of its arguments; terms in which a factor vanishes are not even written."""
    moving = [(k, part) for k, part in enumerate(parts) if part != 0]
    if not moving:
        return Integer(0)
    if u.is_Add:
        return Add(*parts)
    if u.is_Mul:
        return Add(*(Mul(*u.args[:k], part, *u.args[k + 1 :]) for k, part in moving))
    if u.is_Pow:
        base, exponent = u.args
        # The powers of another base sympy itself combines, if the exponent is a number.
        if parts[1] == 0 and (base.is_Mul or exponent.free_symbols):
            return exponent * base ** (exponent - 1) * parts[0]
        return u * Add(*(part * log(base) if k else part * exponent / base for k, part in moving))
    return Add(*(u.fdiff(k + 1) * part for k, part in moving))
