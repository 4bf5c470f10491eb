"""Text to sympy through a whitelist of syntax. Nothing a user writes is ever evaluated as code."""

from __future__ import annotations

import ast
import keyword
import math
import re
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction

import sympy

__all__ = ["FUNCTIONS", "TIME", "check_name", "parse", "to_text"]

#: The symbol of time in every expression.
TIME = sympy.Symbol("t")

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
_CONSTANTS = {"pi": (sympy.pi, math.pi), "e": (sympy.E, math.e)}
_RESERVED = {"t", "nan", "inf", "oo", *_CONSTANTS, *FUNCTIONS}

MAX_LENGTH = 1000  #: characters of one expression
MAX_DEPTH = 40  #: nested operations
MAX_NODES = 400  #: operations and names
MAX_EXPONENT = 64  #: size of a number used as an exponent
MAX_DIGITS = 40  #: digits of one number
_SMALLEST, _LARGEST = 1e-300, 1e300

_ALLOWED = "numbers, the system's variables and parameters, t, pi, e, + - * / **, and " + " ".join(FUNCTIONS)


def check_name(name: str, role: str) -> str:
    """Return `name` if it can name a variable or a parameter.

    Raises
    ------
    ValueError
        If it is no plain ASCII identifier of at most 32 characters, or is reserved.
    """
    if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,31}", name):
        raise ValueError(
            f"{role} name {name!r} is not usable: take a letter followed by letters, digits or underscores, "
            "32 characters at most"
        )
    if name in _RESERVED or keyword.iskeyword(name):
        raise ValueError(f"{role} name {name!r} is reserved: choose another")
    return name


def parse(text: str | float | sympy.Expr, names: Iterable[str], what: str = "expression") -> sympy.Expr:
    """Read one scalar expression in the given names and time t.

    Parameters
    ----------
    text
        Text such as ``"3*x**2 + a"``, a number, or a sympy expression, which passes the same whitelist.
    names
        The variables and parameters it may contain.
    what
        What the expression is, for the error message: ``"f_plus[1]"``.

    Returns
    -------
    sympy.Expr
        With exact rational constants: ``0.1`` is one tenth.

    Raises
    ------
    ValueError
        Naming the text, what is wrong with it and what would do.
    """
    source = to_text(text) if isinstance(text, sympy.Basic) else str(text)
    if len(source) > MAX_LENGTH:
        raise ValueError(f"{what} is {len(source)} characters long: {MAX_LENGTH} at most")
    symbols = {name: sympy.Symbol(name) for name in names} | {"t": TIME}
    return _Reader(source, what, symbols).read()


def to_text(expression: sympy.Expr) -> str:
    """Text that `parse` reads back as the same expression."""
    text = str(sympy.sstr(expression, full_prec=False))
    return re.sub(r"\bE\b", "e", text)


class _Reader:
    """One pass over the syntax tree; each node becomes (sympy expression, its value if constant)."""

    def __init__(self, source: str, what: str, symbols: Mapping[str, sympy.Symbol]) -> None:
        self.source, self.what, self.symbols = source.strip(), what, symbols
        self.nodes = 0

    def fail(self, reason: str) -> ValueError:
        shown = self.source if len(self.source) <= 80 else self.source[:77] + "…"
        return ValueError(f"{self.what} = {shown!r}: {reason}")

    def read(self) -> sympy.Expr:
        if not self.source:
            raise self.fail("it is empty; write 0 for a zero")
        if not self.source.isascii():
            raise self.fail(f"only plain ASCII characters can be read; allowed are {_ALLOWED}")
        if max(_nesting(self.source), self.source.count("**") // 2) > MAX_DEPTH:
            raise self.fail(f"nested deeper than {MAX_DEPTH}")
        try:
            tree = ast.parse(self.source, mode="eval")
        except (SyntaxError, ValueError, MemoryError, RecursionError):
            hint = "write powers as **" if "^" in self.source else "write products with *, powers with **"
            raise self.fail(f"this is no expression; {hint}") from None
        expression, _ = self.visit(tree.body, 0)
        # sympy rewrites tan(pi/2 - x) as cot(x), which is no function of ours.
        expression = expression.replace(sympy.cot, lambda u: 1 / sympy.tan(u))
        self.check_powers(expression)
        return expression

    def visit(self, node: ast.expr, depth: int) -> tuple[sympy.Expr, float | None]:
        self.nodes += 1
        if depth > MAX_DEPTH:
            raise self.fail(f"nested deeper than {MAX_DEPTH}")
        if self.nodes > MAX_NODES:
            raise self.fail(f"more than {MAX_NODES} operations and names")
        match node:
            case ast.Constant(value=int() | float()) if not isinstance(node.value, bool):
                return self.number(node)
            case ast.Name(id=name):
                return self.name(name)
            case ast.UnaryOp(op=ast.USub() | ast.UAdd(), operand=operand):
                inner, value = self.visit(operand, depth + 1)
                return (inner, value) if isinstance(node.op, ast.UAdd) else (-inner, None if value is None else -value)
            case ast.BinOp(op=op, left=left, right=right) if type(op) in _OPERATIONS:
                return self.combine(_OPERATIONS[type(op)], self.visit(left, depth + 1), self.visit(right, depth + 1))
            case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in FUNCTIONS:
                if len(args) != 1 or isinstance(args[0], ast.Starred):
                    raise self.fail(f"{name} takes one argument, here it has {len(args)}")
                exact, real = FUNCTIONS[name]
                return self.combine((exact, real), self.visit(args[0], depth + 1))
        piece = ast.get_source_segment(self.source, node) or type(node).__name__
        hint = "; powers are written **" if isinstance(getattr(node, "op", None), ast.BitXor) else ""
        raise self.fail(f"{piece!r} is not allowed{hint}; allowed are {_ALLOWED}")

    def number(self, node: ast.Constant) -> tuple[sympy.Expr, float]:
        digits = (ast.get_source_segment(self.source, node) or "").replace("_", "")
        if len(digits) > MAX_DIGITS:
            raise self.fail(f"the number {digits[:12]}… has more than {MAX_DIGITS} digits")
        if not re.fullmatch(r"[0-9.]+(e[+-]?[0-9]+)?", digits.lower()):
            raise self.fail(f"the number {digits} is not written in decimals, as 16 or 1.6e1")
        value = float(digits)
        if value and not _SMALLEST <= abs(value) <= _LARGEST:
            raise self.fail(f"the number {digits} is outside {_SMALLEST:g} … {_LARGEST:g}")
        exact = Fraction(digits)
        return sympy.Rational(exact.numerator, exact.denominator), value

    def name(self, name: str) -> tuple[sympy.Expr, float | None]:
        if name in self.symbols:
            return self.symbols[name], None
        if name in _CONSTANTS:
            return _CONSTANTS[name]
        if name in FUNCTIONS:
            raise self.fail(f"{name} is a function and needs an argument: {name}(…)")
        known = ", ".join(self.symbols)
        raise self.fail(f"unknown name {name!r}; known are {known}, pi, e")

    def combine(
        self,
        operation: tuple[Callable[..., sympy.Expr], Callable[..., float]],
        *operands: tuple[sympy.Expr, float | None],
    ) -> tuple[sympy.Expr, float | None]:
        """Apply `operation`; where every operand is a number, in floating point first, so that none can explode."""
        exact, real = operation
        if exact is _power:
            self.check_exponent(*operands)
        value: float | None = None
        if all(v is not None for _, v in operands):
            try:
                value = real(*(v for _, v in operands))
            except (ArithmeticError, ValueError):
                value = math.nan
            if isinstance(value, complex) or not abs(value) <= _LARGEST:
                raise self.fail("it contains a constant that is not a finite real number")
        expression = exact(*(e for e, _ in operands))
        if expression.has(sympy.zoo, sympy.nan, sympy.oo, -sympy.oo, sympy.I):
            raise self.fail("it contains a constant that is not a finite real number")
        if value is not None and abs(value) < _SMALLEST and not expression.is_zero:
            raise self.fail(f"it contains a constant smaller than {_SMALLEST:g}")
        return expression, value

    def check_exponent(
        self, base: tuple[sympy.Expr, float | None], exponent: tuple[sympy.Expr, float | None]
    ) -> None:
        """Refuse large powers before sympy works them out: 1.000000001**64, and so on, nested."""
        if exponent[1] is None:
            return
        if abs(exponent[1]) > MAX_EXPONENT and (base[1] is None or base[0].is_Rational):
            raise self.fail(f"the exponent {exponent[1]:g} is beyond ±{MAX_EXPONENT}")
        if base[0].is_Rational and abs(exponent[1]) * max(int(base[0].p).bit_length(), base[0].q.bit_length()) > 8000:
            raise self.fail("it contains a constant with too many digits")

    def check_powers(self, expression: sympy.Expr) -> None:
        """Refuse exponents that sympy multiplied up, as in ((x**9)**9)**9."""
        for power in expression.atoms(sympy.Pow):
            if power.exp.is_number and abs(power.exp) > MAX_EXPONENT:
                raise self.fail(f"the exponent {power.exp} is beyond ±{MAX_EXPONENT}")


def _nesting(text: str) -> int:
    """Depth of parentheses, counted before Python's own parser recurses into them."""
    depth = deepest = 0
    for character in text:
        depth += (character == "(") - (character == ")")
        deepest = max(deepest, depth)
    return deepest


def _power(base: sympy.Expr, exponent: sympy.Expr) -> sympy.Expr:
    return base**exponent


_OPERATIONS: dict[type[ast.operator], tuple[Callable[..., sympy.Expr], Callable[..., float]]] = {
    ast.Add: (lambda a, b: a + b, lambda a, b: a + b),
    ast.Sub: (lambda a, b: a - b, lambda a, b: a - b),
    ast.Mult: (lambda a, b: a * b, lambda a, b: a * b),
    ast.Div: (lambda a, b: a / b, lambda a, b: a / b),
    ast.Pow: (_power, lambda a, b: a**b),
}
