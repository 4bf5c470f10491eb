"""Sizes of exact constants: bounds on what sympy would compute, before it does."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import sympy

from core.symbolic.operations import FUNCTIONS, OPERATIONS, over, power, times

__all__ = ["CANCELS", "Root", "attempt", "bit_length", "root_bits", "roots_made", "value_of"]

#: A sum of constants smaller than this part of the sizes of its terms is round-off.
CANCELS = 1e-12

#: A number and its fractional exponent.
Root = tuple[sympy.Rational, sympy.Rational]


def attempt(real: Callable[..., float], *values: Any) -> float:
    """`real(*values)`; nan where it is undefined or complex."""
    try:
        value = real(*values)
    except (ArithmeticError, ValueError):
        return math.nan
    return math.nan if isinstance(value, complex) else value


def value_of(constant: sympy.Expr) -> float:
    """Value of an expression without symbols; nan where it is undefined, or where a sum cancels to round-off."""
    if constant.is_Rational:
        return attempt(lambda: constant.p / constant.q)
    if constant.is_NumberSymbol:
        return float(constant)
    arguments = [value_of(a) for a in constant.args]
    if constant.is_Mul:
        return math.prod(arguments)
    if constant.is_Pow:
        return attempt(OPERATIONS[ast.Pow][1], *arguments)
    if constant.is_Add:
        total = math.fsum(arguments)
        return total if abs(total) > CANCELS * math.fsum(map(abs, arguments)) else math.nan
    return attempt(FUNCTIONS[type(constant).__name__][1], *arguments)


def bit_length(term: sympy.Expr) -> int:
    """Bits of the longer of numerator and denominator of a term's rational factor."""
    factor = term.as_coeff_Mul()[0]
    return max(factor.p.bit_length(), factor.q.bit_length()) if factor.is_Rational else 0


def roots_made(exact: Callable[..., sympy.Expr], *operands: sympy.Expr) -> list[Root]:
    """Fractional powers of numbers that sympy would combine in an operation: in u**r, exp(r*log(u)), u*v."""
    if exact is power and operands[0] is not sympy.E:
        return _roots(*operands) if operands[1].is_Rational else []
    if exact is sympy.sqrt:
        return _roots(operands[0], sympy.Rational(1, 2))
    if exact in (power, sympy.exp):
        terms = (term.as_coeff_Mul() for term in sympy.Add.make_args(operands[-1]))
        return [root for factor, rest in terms if rest.func is sympy.log for root in _roots(rest.args[0], factor)]
    if exact in (times, over):
        left, right = (_roots(u, sympy.Integer(1)) for u in operands)
        both = left and right  # with one alone nothing is combined
        return [*left, *((base, -e if exact is over else e) for base, e in right)] if both else []
    return []


def _roots(u: sympy.Expr, exponent: sympy.Rational) -> list[Root]:
    """The rational factors of u, each with its exponent in u**exponent where that is a fraction."""
    content, rest = u.primitive()
    factors = [(content, 1), *(factor.as_base_exp() for factor in sympy.Mul.make_args(rest))]
    numbers = [(abs(base), n * exponent) for base, n in factors if base.is_Rational and base not in (0, 1)]
    return [(base, n) for base, n in numbers if n.is_Rational and not n.is_Integer]


def root_bits(roots: Sequence[Root]) -> Iterator[int]:
    """Bounds on the bits of the integers that sympy puts under a root, and factors, for the given powers."""
    numbers = {base for base, _ in roots}
    if len(numbers) > 1:  # sympy extracts common factors, and merges powers of equal exponent
        longest = max(exponent.q for _, exponent in roots)
        yield longest * sum(max(n.p.bit_length(), n.q.bit_length()) for n in numbers) // 4
        return
    for base, exponent in roots:
        yield _bits_under(base.p, exponent.p % exponent.q, exponent.q)
        yield _bits_under(base.q, -exponent.p % exponent.q, exponent.q)


def _bits_under(number: int, p: int, q: int) -> int:
    """Bits under the root of number**(p/q) after whole powers are extracted: of 2**(2p mod q)*3**p for 12."""
    powers = {prime: k * p % q for prime, k in sympy.Integer(number).factors(limit=2**15).items()}
    common = math.gcd(*powers.values()) or 1
    return sum(n // common * prime.bit_length() for prime, n in powers.items())
