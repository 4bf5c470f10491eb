"""Write a field so that it has its limit where numerator and denominator vanish together, as far as algebra can."""

from __future__ import annotations

from functools import lru_cache

import sympy
from sympy import Expr

from core.symbolic.algebra import cancel, gcd

__all__ = ["regular"]

#: Number of operations of a quotient beyond which it is left as it is, to save time.
_LONG = 200


@lru_cache(maxsize=4096)
def regular(f: Expr) -> Expr:
    """Return f with common factors of its quotients cancelled, and small differences in them as products.

    (t**2 − a**2)/(t − a) is t + a, which has a value at t = a and does not lose its digits beside it. Likewise
    (1 − cos(u))/u**2 is 2 sin(u/2)**2/u**2, and (exp(u) − 1)/u is (exp(u) + 1) tanh(u/2)/u, whose digits are all right
    where u is small.
    """
    return f.replace(lambda u: bool(u.is_Mul) and u.count_ops() <= _LONG, _written_out)


def _written_out(quotient: Expr) -> Expr:
    """A product with its negative powers, if any, as said above; as it is where nothing of this applies."""
    negative = [u for u in quotient.args if u.is_Pow and u.exp.is_Integer and u.exp < 0 and u.free_symbols]
    below = 1 / sympy.Mul(*negative)
    above = quotient * below
    if not below.free_symbols & above.free_symbols:
        return quotient
    common = _common_factor(above, below)
    if common.free_symbols:
        above, below = cancel(above / common), cancel(below / common)
    products = [u.replace(lambda v: bool(v.is_Add), _as_product) for u in (above, below)]
    return products[0] / products[1] if common.free_symbols or products != [above, below] else quotient


def _common_factor(above: Expr, below: Expr) -> Expr:
    try:
        return gcd(above, below)
    except sympy.PolynomialError:  # of expressions that are no polynomials, even in functions
        return sympy.S.One


def _as_product(u: Expr) -> Expr:
    """c − c cos(v), c − c cosh(v) and c exp(v) − c as products; other sums as they are."""
    constant, rest = u.as_coeff_Add()
    factor, term = rest.as_coeff_Mul()
    if constant != -factor:
        return u
    if isinstance(term, sympy.cos):
        return 2 * constant * sympy.sin(term.args[0] / 2) ** 2
    if isinstance(term, sympy.cosh):
        return -2 * constant * sympy.sinh(term.args[0] / 2) ** 2
    return factor * (term + 1) * sympy.tanh(term.args[0] / 2) if isinstance(term, sympy.exp) else u
