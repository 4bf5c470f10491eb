"""Parse text to sympy through a whitelist of syntax. Nothing a user writes is ever evaluated as code."""

from __future__ import annotations

import ast
import itertools
import keyword
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction

import sympy

from core.symbolic.constant_size import CANCELS, Root, attempt, bit_length, root_bits, roots_made, value_of
from core.symbolic.mistakes import meant, mistake, usual_name
from core.symbolic.operations import FUNCTIONS, OPERATIONS, power
from core.symbolic.source_text import MAX_DIGITS, quoted, to_text

__all__ = ["OPERATORS", "SWITCHING", "TIME", "check_name", "parse", "switching_name"]

#: The symbol of time in every expression.
TIME = sympy.Symbol("t")

#: Functions whose law switches; `parse` reads them only where it is told the sign of each switching function.
SWITCHING = ("sign", "abs", "max", "min", "Heaviside", "Piecewise")
#: Names that sympy gives to them in print.
_SYMPY_NAMES = {"Abs": "abs", "Max": "max", "Min": "min"}
#: Constants by name: name -> (sympy number, its value).
_CONSTANTS = {"pi": (sympy.pi, math.pi), "e": (sympy.E, math.e)}
#: Names that no variable or parameter may have.
_RESERVED = {"t", "nan", "inf", "oo", *_CONSTANTS, *FUNCTIONS}

#: Most characters of one expression.
MAX_LENGTH = 1000
#: Most operations nested in each other: parser and sympy recurse into them.
MAX_DEPTH = 40
#: Most operations and names of one expression.
MAX_NODES = 400
#: Largest size of a number used as an exponent.
MAX_EXPONENT = 64
#: Most bits of the numerator or denominator of an exact constant, intermediate ones included.
MAX_BITS = 8000
#: Most bits of an integer under a root; a longer one exceeds the range of a double.
MAX_ROOT_BITS = 1100
#: Least size of a constant other than 0: a margin to the least double.
_SMALLEST = 1e-300
#: Largest size of a constant: a margin to the largest double.
_LARGEST = 1e300
#: An expression, and its value if it is constant.
Operand = tuple[sympy.Expr, float | None]

_NOT_REAL = "it contains a constant that is not a finite real number"
#: The operators of expressions, as messages list them.
OPERATORS = "+ - * / **"
_ALLOWED = f"numbers, the system’s variables and parameters, t, pi, e, {OPERATORS}, and {' '.join(FUNCTIONS)}"


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


def switching_name(text: str) -> str:
    """Return the first function in a text that is one of `SWITCHING`, by its name there; empty if there is none."""
    called = (usual_name(name) for name in re.findall(r"\b([A-Za-z]+)\s*\(", text))
    return next((name for name in (_SYMPY_NAMES.get(name, name) for name in called) if name in SWITCHING), "")


def parse(
    text: str | float | sympy.Expr,
    names: Iterable[str],
    what: str = "expression",
    sign_of: Callable[[sympy.Expr], int] | None = None,
) -> sympy.Expr:
    """Read one scalar expression in the given names and time t.

    Parameters
    ----------
    text
        Text such as ``"3*x**2 + a"``, a number, or a sympy expression, which passes the same whitelist.
    names
        The variables and parameters it may contain.
    what
        What the expression is, for the error message: ``"f_plus[1]"``.
    sign_of
        The sign −1 or +1 of an expression, 0 only if it vanishes everywhere. Where given, text may also contain
        ``sign(u)``, ``abs(u)``, ``max(u, v, ...)``, ``min(u, v, ...)``, ``Heaviside(u)`` and
        ``Piecewise((u, condition), ..., (v, True))``, where a condition combines comparisons (< <= > >=) by ``and``,
        ``or``, ``not`` or & | ~. Each is read as the smooth law that it has for these signs. A second argument of
        Heaviside is refused: its value at 0 never matters.

    Returns
    -------
    sympy.Expr
        With exact rational constants: ``0.1`` is one tenth.

    Raises
    ------
    ValueError
        Naming the text, what is wrong with it and what would do.
    """
    try:
        source = to_text(text) if isinstance(text, sympy.Basic) else str(text)
    except RecursionError:
        raise ValueError(f"{what} is nested deeper than {MAX_DEPTH}") from None
    if len(source) > MAX_LENGTH:
        raise ValueError(f"{what} is {len(source)} characters long: {MAX_LENGTH} at most")
    symbols = {name: sympy.Symbol(name) for name in names} | {"t": TIME}
    return _Reader(source, what, symbols, sign_of).read()


class _Reader:
    """One pass over the syntax tree; each node becomes (sympy expression, its value if constant)."""

    def __init__(
        self,
        source: str,
        what: str,
        symbols: Mapping[str, sympy.Symbol],
        sign_of: Callable[[sympy.Expr], int] | None = None,
    ) -> None:
        self.source, self.what, self.symbols = source.strip(), what, symbols
        self.switches, self.sign_of = sign_of is not None, sign_of or (lambda _: 0)
        self.allowed = f"{_ALLOWED} {' '.join(SWITCHING)}" if self.switches else _ALLOWED
        self.nodes = 0

    def fail(self, reason: str) -> ValueError:
        return ValueError(f"{self.what} = {quoted(self.source)}: {reason}")

    def read(self) -> sympy.Expr:
        if not self.source:
            raise self.fail("it is empty; write 0 for a zero")
        if not self.source.isascii():
            raise self.fail(f"only plain ASCII characters can be read; allowed are {self.allowed}")
        if max(_nesting(self.source), self.source.count("**") // 2) > MAX_DEPTH:
            raise self.fail(f"nested deeper than {MAX_DEPTH}")
        try:
            tree = ast.parse(self.source, mode="eval")
        except (SyntaxError, ValueError, MemoryError, RecursionError):
            raise self.fail(f"this is not an expression; {mistake(self.source)}") from None
        expression, _ = self.visit(tree.body, 0)
        self.check_whole(expression)
        return expression

    def count(self, depth: int) -> None:
        """Count one more node of the syntax tree."""
        self.nodes += 1
        if depth > MAX_DEPTH:
            raise self.fail(f"nested deeper than {MAX_DEPTH}")
        if self.nodes > MAX_NODES:
            raise self.fail(f"more than {MAX_NODES} operations and names")

    def visit(self, node: ast.expr, depth: int) -> Operand:
        self.count(depth)
        match node:
            case ast.Constant(value=int() | float()) if not isinstance(node.value, bool):
                return self.number(node)
            case ast.Name(id=name):
                return self.name(name)
            case ast.UnaryOp(op=ast.USub() | ast.UAdd(), operand=operand):
                inner, value = self.visit(operand, depth + 1)
                return (inner, value) if isinstance(node.op, ast.UAdd) else (-inner, None if value is None else -value)
            case ast.BinOp(op=ast.Pow() | ast.BitXor(), left=ast.Name(id=name)) if name in FUNCTIONS:
                raise self.fail(f"{name} is a function and needs an argument: its square is {name}(…)**2")
            case ast.BinOp(op=op, left=left, right=right) if type(op) in OPERATIONS:
                chain = type(op) is not ast.Pow  # a + b + c + …: a long sum is not a deep one
                first = self.visit(left, depth if chain else depth + 1)
                return self.combine(OPERATIONS[type(op)], first, self.visit(right, depth + 1))
            case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in FUNCTIONS:
                if len(args) != 1 or isinstance(args[0], ast.Starred):
                    raise self.fail(f"{name} takes one argument, not {len(args)}")
                exact, real = FUNCTIONS[name]
                return self.combine((exact, real), self.visit(args[0], depth + 1))
            case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if self.switches:
                name = _SYMPY_NAMES.get(name, name)
                if name in SWITCHING:
                    return self.switching(name, args, depth + 1)
        raise self.refused(node)

    def refused(self, node: ast.expr) -> ValueError:
        """The error that a part of the text is not in the whitelist."""
        piece = ast.get_source_segment(self.source, node) or type(node).__name__
        hint = "; powers are written **" if isinstance(getattr(node, "op", None), ast.BitXor) else ""
        if isinstance(node, ast.Tuple):
            return self.fail("a comma has no meaning here; write decimals with a point, as 0.5")
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in self.symbols:
            return self.fail(f"{node.func.id} is not a function; write a product as {node.func.id}*(…)")
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            hint = meant(node.func.id, (*FUNCTIONS, *(SWITCHING if self.switches else ())))
        if self.switches and isinstance(getattr(node, "op", None), ast.BitAnd | ast.BitOr):
            hint = "; conditions are written as (x > 0) & (y > 0), with these parentheses"
        elif self.switches and isinstance(node, ast.Compare):
            hint = "; conditions are written in Piecewise((value, condition), …, (value, True))"
        return self.fail(f"{piece!r} is not allowed{hint}; allowed are {self.allowed}")

    def number(self, node: ast.Constant) -> tuple[sympy.Expr, float]:
        digits = (ast.get_source_segment(self.source, node) or "").replace("_", "")
        if len(digits) > MAX_DIGITS:
            raise self.fail(f"the number {digits[:12]}… has more than {MAX_DIGITS} digits")
        if not re.fullmatch(r"[0-9.]+(e[+-]?[0-9]+)?", digits.lower()):
            raise self.fail(f"the number {digits} is not written in decimals, as 16 or 1.6e1")
        value = float(digits)
        if not re.search("[1-9]", digits.lower().partition("e")[0]):
            return sympy.Integer(0), 0.0
        if not _SMALLEST <= value <= _LARGEST:  # before it is written out: 1e-99999999
            raise self.fail(f"the number {digits} is outside {_SMALLEST:g} … {_LARGEST:g}")
        exact = Fraction(digits)
        return sympy.Rational(exact.numerator, exact.denominator), value

    def name(self, name: str) -> Operand:
        if name in self.symbols:
            return self.symbols[name], None
        if name in _CONSTANTS:
            return _CONSTANTS[name]
        if name in FUNCTIONS or (self.switches and name in SWITCHING):
            raise self.fail(f"{name} is a function and needs an argument: {name}(…)")
        known = ", ".join(self.symbols)
        raise self.fail(f"unknown name {name!r}{meant(name, (*self.symbols, *_CONSTANTS))}; known are {known}, pi, e")

    # Terms that switch -----------------------------------------------------------------------------------------------

    def switching(self, name: str, args: Sequence[ast.expr], depth: int) -> Operand:
        """The smooth law of a call of one of `SWITCHING`, for the signs that `sign_of` gives."""
        if name == "Piecewise":
            return self.piecewise(args, depth)
        if name in ("max", "min"):
            return self.extremum(name, args, depth)
        if len(args) != 1:
            why = ": its value at 0 never matters" if name == "Heaviside" else ""
            raise self.fail(f"{name} takes one argument, not {len(args)}{why}")
        inner = self.visit(args[0], depth)
        sign = self.sign(inner)
        if name == "abs":
            return self.combine(OPERATIONS[ast.Mult], (sympy.Integer(sign), sign), inner)
        return (sympy.Integer(sign), sign) if name == "sign" else (sympy.Rational(1 + sign, 2), (1 + sign) / 2)

    def extremum(self, name: str, args: Sequence[ast.expr], depth: int) -> Operand:
        if len(args) < 2:
            raise self.fail(f"{name} takes two arguments or more, not {len(args)}")
        read = [self.visit(u, depth) for u in args]
        best, *others = sorted(read, key=lambda u: u[1] is None)  # numbers first: of these only one is compared
        for other in others:
            sign = self.sign(self.combine(OPERATIONS[ast.Sub], other, best))
            best = other if sign == (1 if name == "max" else -1) else best
        return best

    def piecewise(self, args: Sequence[ast.expr], depth: int) -> Operand:
        """The value of the first condition that holds; all are read, so that none escapes the whitelist."""
        chosen = []
        for pair in args:
            self.count(depth)
            match pair:
                case ast.Tuple(elts=[value, condition]):
                    read, holds = self.visit(value, depth + 1), self.holds(condition, depth + 1)
                    chosen += [read] if holds else []
                case _:
                    piece = ast.get_source_segment(self.source, pair)
                    raise self.fail(f"{piece!r} is not a pair; write Piecewise((value, condition), …, (value, True))")
        if not chosen:
            raise self.fail("Piecewise has no value where none of its conditions holds; end it with (value, True)")
        return chosen[0]

    def holds(self, node: ast.expr, depth: int) -> bool:
        """Whether a condition holds."""
        self.count(depth)
        match node:
            case ast.Constant(value=bool() as known):
                return known
            case ast.UnaryOp(op=ast.Not() | ast.Invert(), operand=operand):
                return not self.holds(operand, depth + 1)
            case ast.BoolOp(op=op, values=parts):
                found = [self.holds(part, depth + 1) for part in parts]
                return all(found) if isinstance(op, ast.And) else any(found)
            case ast.BinOp(op=ast.BitAnd() | ast.BitOr() as op, left=left, right=right):
                found = [self.holds(part, depth + 1) for part in (left, right)]
                return all(found) if isinstance(op, ast.BitAnd) else any(found)
            case ast.Compare(left=left, ops=ops, comparators=rest) if all(type(op) in _COMPARISONS for op in ops):
                read = [self.visit(part, depth + 1) for part in (left, *rest)]
                signs = [self.sign(self.combine(OPERATIONS[ast.Sub], *pair)) for pair in itertools.pairwise(read)]
                return all(sign in _COMPARISONS[type(op)] for op, sign in zip(ops, signs, strict=True))
        piece = ast.get_source_segment(self.source, node)
        raise self.fail(
            f"{piece!r} is not a condition; write comparisons with < <= > >=, joined by and, or, not, &, |, ~"
        )

    def sign(self, operand: Operand) -> int:
        """The sign of a switching function, or of a constant."""
        expression, value = operand
        if value is not None:
            return (value > 0) - (value < 0)
        self.check_whole(expression)
        return self.sign_of(expression)

    # Bounds ----------------------------------------------------------------------------------------------------------

    def combine(
        self,
        operation: tuple[Callable[..., sympy.Expr], Callable[..., float]],
        *operands: Operand,
    ) -> Operand:
        """Apply `operation`; to constants in floating point first, so that no exact result grows beyond bounds."""
        exact, real = operation
        if exact is power:
            self.check_power(*operands)
        self.check_roots(roots_made(exact, *(e for e, _ in operands)))
        if all(v is not None for _, v in operands):
            self.check_value(attempt(real, *(v for _, v in operands)))
        expression = exact(*(e for e, _ in operands))
        if expression.has(sympy.zoo, sympy.nan, sympy.oo, -sympy.oo, sympy.I):
            raise self.fail(_NOT_REAL)
        # sympy rewrites tan(pi/2 - x) as cot(x), which is not in the whitelist.
        expression = expression.replace(sympy.cot, lambda u: 1 / sympy.tan(u))
        for term in sympy.Add.make_args(expression):
            if bit_length(term) > MAX_BITS:
                raise self.fail("it contains a constant with too many digits")
        if expression.free_symbols:
            return expression, None
        value = value_of(expression)  # anew: x - x + 3 is a constant too
        self.check_value(value, expression)
        return expression, value

    def check_power(self, base: Operand, exponent: Operand) -> None:
        """Refuse large powers before sympy computes them: nested ones such as (1.000000001**64)**64."""
        if exponent[1] is None:
            if base[1] is not None and base[1] <= 0:
                raise self.fail("the base of a power is negative or zero where its exponent is not a number")
            return
        if abs(exponent[1]) > MAX_EXPONENT and (base[1] is None or base[0].is_Rational):
            raise self.fail(f"the exponent {exponent[1]:g} is beyond ±{MAX_EXPONENT}")
        if not exponent[0].is_Rational and abs(exponent[1] - round(exponent[1])) < CANCELS:
            # sympy would compute the minimal polynomial of their difference to find its sign
            raise self.fail(f"an exponent cannot be told from {round(exponent[1])}; write {round(exponent[1])}")
        if abs(exponent[1]) * bit_length(base[0]) > MAX_BITS:
            raise self.fail("it contains a constant with too many digits")

    def check_roots(self, roots: Sequence[Root]) -> None:
        """Refuse long roots before sympy computes them: it turns 12**0.7123457 into (2**4246914*3**7123457)**1e-7."""
        if any(bits > MAX_ROOT_BITS for bits in root_bits(roots)):
            raise self.fail(
                "a number to a fractional power is too long to work out exactly; write its value as a decimal number, "
                "or make the number a parameter"
            )

    def check_value(self, value: float, expression: sympy.Expr | None = None) -> None:
        """Refuse a constant that is no finite real number or, if given as an expression, too small to tell from 0."""
        if not abs(value) <= _LARGEST:
            raise self.fail(_NOT_REAL)
        if expression is not None and abs(value) < _SMALLEST and expression != 0:
            raise self.fail(f"it contains a constant smaller than {_SMALLEST:g}, or lost in round-off")

    def check_whole(self, expression: sympy.Expr) -> None:
        """Refuse what sympy combined from several places: ((x**9)**9)**9, x*1e200*1e200, exp(600)*x*exp(600)."""
        nodes = sympy.preorder_traversal(expression)
        for node in nodes:
            if not node.free_symbols:
                self.check_value(value_of(node), node)
                nodes.skip()
            elif node.is_Pow and not node.exp.free_symbols and abs(value_of(node.exp)) > MAX_EXPONENT:
                raise self.fail(f"the exponent {node.exp} is beyond ±{MAX_EXPONENT}")
            elif node.is_Mul:
                coefficient = node.as_independent(*node.free_symbols)[0]
                self.check_value(value_of(coefficient), coefficient)


def _nesting(text: str) -> int:
    """Depth of parentheses, counted before Python's own parser recurses into them."""
    depth = deepest = 0
    for character in text:
        depth += (character == "(") - (character == ")")
        deepest = max(deepest, depth)
    return deepest


#: Comparison -> the signs of left − right for which it holds.
_COMPARISONS: dict[type[ast.cmpop], tuple[int, ...]] = {
    ast.Lt: (-1,),
    ast.LtE: (-1, 0),
    ast.Gt: (1,),
    ast.GtE: (0, 1),
}
