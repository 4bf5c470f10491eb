"""Expressions taken apart once, then evaluated at many points: in floating point, or in any number of digits.

Only real values count: a root, logarithm or real power of a negative number is undefined, as it is to compiled code.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache
from typing import Any, Protocol

import mpmath
import numpy as np
import sympy
from sympy import Expr, Symbol

from core.symbolic.operations import FUNCTIONS

__all__ = ["Arithmetic", "Digits", "Floats", "Tape", "digits", "growing_argument"]

_HALF = sympy.Rational(1, 2)
#: Functions whose values, or whose distance from a limit, vary exponentially with the argument.
_GROWING = ("exp", "sinh", "cosh", "tanh")
#: Largest argument of sin, cos and tan: to reduce a larger one, mpmath needs as many digits of π as it has.
_LARGEST_ANGLE = 1e6


class Arithmetic(Protocol):
    """The arithmetic in which a tape is evaluated."""

    @property
    def functions(self) -> Mapping[str, Callable[..., Any]]:
        """The functions of expressions, by name."""

    def constant(self, number: Expr) -> Any:
        """Value of a rational number, π or e."""

    def power(self, base: Any, exponent: Any) -> Any:
        """Real power of a number that is not negative."""


class Floats:
    """Floating point, at many points at once: nan where there is no real value."""

    functions: Mapping[str, Callable[..., Any]] = {
        **{name: getattr(np, name) for name in FUNCTIONS},
        "magnitude": np.abs,
        "Choice": lambda far, near, other: np.where(far <= 0.0, near, other),
    }

    def constant(self, number: Expr) -> float:
        """Value of a rational number, π or e."""
        if not number.is_Rational:
            return float(number) if number.is_NumberSymbol else math.nan
        try:
            return float(number.p / number.q)
        except OverflowError:
            return math.copysign(math.inf, number.p)

    def power(self, base: Any, exponent: Any) -> Any:
        """Real power of numbers that are not negative."""
        return np.where(base >= 0, np.power(np.abs(base), exponent), np.nan)


class Digits:
    """A given number of decimal digits, at one point; ArithmeticError where there is no real value.

    An argument of exp, sinh, cosh or tanh beyond ±`largest` raises it too: 1 − tanh(1000) has no digits left, and
    exp(exp(100)) would take for ever.
    """

    def __init__(self, digits: int, largest: float) -> None:
        self.context = mpmath.MPContext()
        self.context.dps = digits
        self.largest = largest
        angles = {name: self._moderate(name, _LARGEST_ANGLE) for name in ("sin", "cos", "tan")}
        growing = {name: self._moderate(name, largest) for name in _GROWING}
        # Of a choice, the alternative to a series is exact.
        rewritten: dict[str, Callable[..., Any]] = {"magnitude": abs, "Choice": lambda far, near, other: other}
        self.functions = {**angles, **growing, **rewritten, "sqrt": self._root, "log": self._logarithm}

    def constant(self, number: Expr) -> Any:
        """Value of a rational number, π or e."""
        if number.is_Rational:
            return self.context.mpf(int(number.p)) / int(number.q)
        if not number.is_NumberSymbol:
            raise ArithmeticError
        return +(self.context.pi if number is sympy.pi else self.context.e)

    def power(self, base: Any, exponent: Any) -> Any:
        """Real power of a number that is not negative."""
        if base == 0 and exponent > 0:
            return base
        return self.functions["exp"](exponent * self._logarithm(base))

    def _moderate(self, name: str, largest: float) -> Callable[[Any], Any]:
        function = getattr(self.context, name)

        def value(u: Any) -> Any:
            if abs(u) > largest:
                raise OverflowError
            return function(u)

        return value

    def _root(self, u: Any) -> Any:
        if u < 0:
            raise ArithmeticError
        return self.context.sqrt(u)

    def _logarithm(self, u: Any) -> Any:
        if u <= 0:
            raise ArithmeticError
        return self.context.log(u)


@lru_cache(maxsize=8)
def digits(count: int, largest: float) -> Digits:
    """The arithmetic of `count` decimal digits, cached."""
    return Digits(count, largest)


class Tape:
    """The operations of some expressions, each once, operands before what uses them.

    Attributes
    ----------
    nodes
        The expression of each operation.
    """

    def __init__(self, expressions: Iterable[Expr]) -> None:
        self.nodes: list[Expr] = []
        self.place: dict[Expr, int] = {}
        self._operands: list[tuple[int, ...]] = []
        for u in expressions:
            self.add(u)

    def add(self, u: Expr) -> int:
        """Put an expression on the tape if it is not there; return its place."""
        known = self.place.get(u)
        if known is not None:
            return known
        operands = () if _is_leaf(u) else tuple(self.add(a) for a in _operands(u))
        self.nodes.append(u)
        self._operands.append(operands)
        return self.place.setdefault(u, len(self.nodes) - 1)

    def run(self, arithmetic: Arithmetic, point: Mapping[Symbol, Any]) -> list[Any]:
        """Values of all nodes, in their order.

        Raises
        ------
        ArithmeticError
            Where the arithmetic raises it.
        """
        values: list[Any] = []
        for u, operands in zip(self.nodes, self._operands, strict=True):
            if u.is_Symbol:
                values.append(point[u])
            elif not operands:
                values.append(arithmetic.constant(u))
            else:
                values.append(_value(u, [values[k] for k in operands], arithmetic))
        return values

    def size(self, u: Expr, values: Sequence[Any]) -> Any:
        """|u| if nothing cancelled in its sums: the scale of its round-off."""
        if u.is_Add:
            return sum(self.size(a, values) for a in u.args)
        if u.is_Mul:
            return math.prod(self.size(a, values) for a in u.args)
        if u.is_Pow and u.exp.is_Integer and u.exp > 0:
            return self.size(u.base, values) ** int(u.exp)
        return abs(values[self.place[u]])


def growing_argument(u: Expr) -> tuple[Expr, ...] | None:
    """(v,) for exp(v), sinh(v), cosh(v) and tanh(v), (v, b) for b**v; None for any other operation."""
    if type(u).__name__ in _GROWING:
        return (u.args[0],)
    return (u.exp, u.base) if u.is_Pow and len(_operands(u)) == 2 else None


def _is_leaf(u: Expr) -> bool:
    return bool(u.is_Symbol or u.is_Rational or u.is_NumberSymbol)


def _operands(u: Expr) -> tuple[Expr, ...]:
    """The operands of an operation; an integer exponent, or that of a square root, does not count as one."""
    return (u.base,) if u.is_Pow and (u.exp.is_Integer or u.exp == _HALF) else u.args


def _value(u: Expr, operands: Sequence[Any], arithmetic: Arithmetic) -> Any:
    if u.is_Add:
        return sum(operands[1:], operands[0])
    if u.is_Mul:
        return math.prod(operands[1:], start=operands[0])
    if not u.is_Pow:
        return arithmetic.functions[type(u).__name__](*operands)
    if u.exp.is_Integer:
        power = operands[0] ** abs(int(u.exp))
        return power if u.exp > 0 else 1 / power
    return arithmetic.functions["sqrt"](operands[0]) if u.exp == _HALF else arithmetic.power(*operands)
