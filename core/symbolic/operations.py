"""Functions and operations of expressions: on sympy's expressions, and on floats."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable

import sympy

__all__ = ["FUNCTIONS", "OPERATIONS", "over", "power", "times"]

#: Functions an expression may call: name -> (sympy function, its value on a real number).
FUNCTIONS: dict[str, tuple[Callable[..., sympy.Expr], Callable[[float], float]]] = {
    "sin": (sympy.sin, math.sin),
    "cos": (sympy.cos, math.cos),
    "tan": (sympy.tan, math.tan),
    "exp": (sympy.exp, math.exp),
    "log": (sympy.log, math.log),
    "sqrt": (sympy.sqrt, math.sqrt),
    "sinh": (sympy.sinh, math.sinh),
    "cosh": (sympy.cosh, math.cosh),
    "tanh": (sympy.tanh, math.tanh),
}


def power(base: sympy.Expr, exponent: sympy.Expr) -> sympy.Expr:
    """base**exponent."""
    return base**exponent


def times(u: sympy.Expr, v: sympy.Expr) -> sympy.Expr:
    """u·v."""
    return u * v


def over(u: sympy.Expr, v: sympy.Expr) -> sympy.Expr:
    """u/v."""
    return u / v


#: Node of the syntax tree -> (operation on sympy expressions, operation on floats).
OPERATIONS: dict[type[ast.operator], tuple[Callable[..., sympy.Expr], Callable[..., float]]] = {
    ast.Add: (lambda a, b: a + b, lambda a, b: a + b),
    ast.Sub: (lambda a, b: a - b, lambda a, b: a - b),
    ast.Mult: (times, lambda a, b: a * b),
    ast.Div: (over, lambda a, b: a / b),
    ast.Pow: (power, lambda a, b: a**b),
}
