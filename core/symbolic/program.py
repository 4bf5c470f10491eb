"""Expressions as straight-line programs, for arithmetics that numpy does not have: many digits, and intervals."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple, Protocol

import mpmath
import numpy as np
import sympy

__all__ = ["Arithmetic", "Constant", "Digits", "Doubles", "Node", "Program"]


class Constant:
    """A constant expression; compared by identity, as sympy's own comparison takes longer than the arithmetic."""

    def __init__(self, value: sympy.Expr) -> None:
        self.value = value
        self.integer = int(value) if value.is_Integer else None  #: the value if it is an integer, else None


class Arithmetic(Protocol):
    """The arithmetic in which a program is run; its values support + and *."""

    def number(self, constant: Constant) -> Any:
        """The value of a constant expression."""

    def power(self, base: Any, exponent: Constant) -> Any:
        """The base to a constant power."""

    def call(self, name: str, *arguments: Any) -> Any:
        """A function by its name: one of the whitelist, `near_zeros.magnitude` or `near_zeros.Choice`."""


class Node(NamedTuple):
    """One operation of a program: "number", "input", "add", "multiply", "power" or "call"."""

    operation: str
    detail: Any  # the Constant, the number of the input, the exponent as a Constant, or the name of the function
    arguments: tuple[int, ...]  # numbers of earlier nodes


class Program:
    """Straight-line program for expressions in some symbols; common parts are computed once.

    Parameters
    ----------
    expressions : sequence of m expressions
        In the symbols only, with the functions of the whitelist, `core.symbolic.expressions.FUNCTIONS`.
    symbols : sequence of symbols
    """

    def __init__(self, expressions: Sequence[sympy.Expr], symbols: Sequence[sympy.Symbol]) -> None:
        self.nodes: list[Node] = []
        self._symbols = {symbol: k for k, symbol in enumerate(symbols)}
        self._placed: dict[sympy.Expr, int] = {}
        self.outputs = [self._place(sympy.sympify(e)) for e in expressions]

    def run(self, arithmetic: Arithmetic, inputs: Sequence[Any]) -> list[Any]:
        """The values (m,) of the expressions, the symbols having the values `inputs`."""
        values: list[Any] = []
        for operation, detail, arguments in self.nodes:
            values.append(_ACTIONS[operation](arithmetic, inputs, detail, [values[k] for k in arguments]))
        return [values[k] for k in self.outputs]

    def _place(self, e: sympy.Expr) -> int:
        if e not in self._placed:
            operation, detail, arguments = self._take_apart(e)
            self.nodes.append(Node(operation, detail, tuple(map(self._place, arguments))))
            self._placed[e] = len(self.nodes) - 1
        return self._placed[e]

    def _take_apart(self, e: sympy.Expr) -> tuple[str, Any, Sequence[sympy.Expr]]:
        if not e.free_symbols:
            return "number", Constant(e), ()
        if e.is_Symbol:
            return "input", self._symbols[e], ()
        if e.is_Add or e.is_Mul:
            return "add" if e.is_Add else "multiply", None, e.args
        if e.is_Pow and not e.exp.free_symbols:
            return "power", Constant(e.exp), (e.base,)
        if e.is_Pow:
            return "call", "exp", (e.exp * sympy.log(e.base),)
        return "call", e.func.__name__, e.args


def _added(arithmetic: Arithmetic, inputs: Sequence[Any], detail: Any, values: list[Any]) -> Any:
    return sum(values[1:], values[0])


def _multiplied(arithmetic: Arithmetic, inputs: Sequence[Any], detail: Any, values: list[Any]) -> Any:
    product = values[0]
    for value in values[1:]:
        product = product * value
    return product


_ACTIONS: dict[str, Callable[[Arithmetic, Sequence[Any], Any, list[Any]], Any]] = {
    "number": lambda arithmetic, inputs, detail, values: arithmetic.number(detail),
    "input": lambda arithmetic, inputs, detail, values: inputs[detail],
    "add": _added,
    "multiply": _multiplied,
    "power": lambda arithmetic, inputs, detail, values: arithmetic.power(values[0], detail),
    "call": lambda arithmetic, inputs, detail, values: arithmetic.call(detail, *values),
}


class Digits:
    """Arithmetic of a given number of bits; nan stands for what is not real.

    Each has an mpmath context of its own, so that threads and precisions do not interfere.
    """

    def __init__(self, bits: int) -> None:
        self.context = mpmath.MPContext()
        self.context.prec = bits
        self._numbers: dict[Constant, Any] = {}
        self._ratios: dict[Constant, tuple[int, int]] = {}

    @classmethod
    @cache
    def of(cls, bits: int) -> Digits:
        """The arithmetic of `bits` bits, cached."""
        return cls(bits)

    def number(self, constant: Constant) -> Any:
        """The constant, correctly rounded; nan where it is not real."""
        if constant not in self._numbers:
            self._numbers[constant] = self._rounded(constant.value)
        return self._numbers[constant]

    def ratio(self, constant: Constant) -> tuple[int, int]:
        """The constant as p/q: exact where it is rational, else rounded to the precision."""
        if constant not in self._ratios:
            value, bits = constant.value, self.context.prec
            if not value.is_Rational:
                mantissa, exponent = self.context.frexp(self.number(constant))
                p = int(self.context.ldexp(mantissa, bits))
                value = sympy.Rational(p << max(0, exponent - bits), 1 << max(0, bits - exponent))
            self._ratios[constant] = int(value.p), int(value.q)
        return self._ratios[constant]

    def power(self, base: Any, exponent: Constant) -> Any:
        """A power; nan where it is not real or not finite."""
        power = self.number(exponent) if exponent.integer is None else exponent.integer
        return self.context.nan if base == 0 and power < 0 else self._real(base**power)

    def call(self, name: str, *arguments: Any) -> Any:
        """A function; nan where it is not real or not finite. Of a choice, what needs many digits only."""
        argument = arguments[-1]
        if name in ("Choice", "magnitude"):
            return argument if name == "Choice" else abs(argument)
        if name == "log" and argument == 0:
            return self.context.nan
        return self._real(getattr(self.context, name)(argument))

    def _rounded(self, value: sympy.Expr) -> Any:
        if value.is_Rational:
            return self.context.mpf(int(value.p)) / int(value.q)
        decimal = sympy.N(value, int(self.context.prec * 0.302) + 5)  # log₁₀ 2 digits a bit
        return self.context.mpf(decimal._mpf_) if decimal.is_real else self.context.nan

    def _real(self, value: Any) -> Any:
        return value if isinstance(value, self.context.mpf) else self.context.nan


class Doubles:
    """Arithmetic of numpy's doubles."""

    def __init__(self) -> None:
        self._numbers: dict[Constant, np.float64] = {}

    def number(self, constant: Constant) -> np.float64:
        """The constant, rounded; nan where it is not real."""
        if constant not in self._numbers:
            value = complex(constant.value)
            self._numbers[constant] = np.float64(np.nan if value.imag else value.real)
        return self._numbers[constant]

    def power(self, base: np.float64, exponent: Constant) -> np.float64:
        """A power; nan where it is not real."""
        return np.float64(base ** self.number(exponent))

    def call(self, name: str, *arguments: np.float64) -> np.float64:
        """A function."""
        if name == "Choice":
            far, near, other = arguments
            return near if far <= 0.0 else other
        return np.float64(abs(arguments[0]) if name == "magnitude" else getattr(np, name)(arguments[0]))
