"""Parse text to sympy through a whitelist of syntax. Nothing a user writes is ever evaluated as code."""

from __future__ import annotations

import ast
import itertools
import keyword
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

import sympy
from sympy.printing.precedence import PRECEDENCE
from sympy.printing.str import StrPrinter

from core.symbolic.mistakes import mistake

__all__ = ["FUNCTIONS", "OPERATORS", "SWITCHING", "TIME", "check_name", "parse", "quoted", "to_text"]

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
#: Most digits of one number.
MAX_DIGITS = 40
#: Most bits of the numerator or denominator of an exact constant, intermediate ones included.
MAX_BITS = 8000
#: Most bits of an integer under a root; a longer one exceeds the range of a double.
MAX_ROOT_BITS = 1100
#: Most characters that a message quotes of a text.
_SHOWN = 78
#: Least size of a constant other than 0: a margin to the least double.
_SMALLEST = 1e-300
#: Largest size of a constant: a margin to the largest double.
_LARGEST = 1e300
#: A sum of constants smaller than this part of the sizes of its terms is round-off.
_CANCELS = 1e-12

#: A number and its fractional exponent.
Root = tuple[sympy.Rational, sympy.Rational]
#: An expression, and its value if it is constant.
Operand = tuple[sympy.Expr, float | None]

_NOT_REAL = "it contains a constant that is not a finite real number"
#: The operators of expressions, as messages list them.
OPERATORS = "+ - * / **"
_ALLOWED = f"numbers, the system's variables and parameters, t, pi, e, {OPERATORS}, and {' '.join(FUNCTIONS)}"


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


def quoted(text: str) -> str:
    """The text in quotes, for a message; a long one is cut."""
    return repr(text if len(text) <= _SHOWN else f"{text[: _SHOWN - 1]}…")


def to_text(expression: sympy.Expr) -> str:
    """Text that `parse` reads back as the same expression."""
    return str(_Text().doprint(expression))


class _Text(StrPrinter):
    """Print numbers as `parse` reads them: floats to the last digit, long integers with an exponent for final zeros."""

    def _print_Float(self, expr: sympy.Float) -> str:  # noqa: N802 - the name is sympy's
        return repr(float(expr))

    def _print_Integer(self, expr: sympy.Integer) -> str:  # noqa: N802
        if abs(expr.p) < 10**MAX_DIGITS:
            return str(expr.p)
        digits = str(sympy.sstr(expr))
        short = digits.rstrip("0")
        return f"{short}e{len(digits) - len(short)}"

    def _print_Rational(self, expr: sympy.Rational) -> str:  # noqa: N802
        return "/".join(self._print_Integer(sympy.Integer(n)) for n in (expr.p, expr.q))

    def _print_Mul(self, expr: sympy.Mul) -> str:  # noqa: N802
        """Put a number last where sympy, which reads 3*(x - y) as 3*x - 3*y, would multiply it into a sum."""
        factor, rest = expr.as_coeff_Mul()
        over, under = sympy.fraction(rest)
        first = over.as_ordered_factors()[0]
        if factor is sympy.S.One or not (first.is_Add or any(u.is_Add for u in sympy.Mul.make_args(under))):
            return str(super()._print_Mul(expr))
        return f"{self.parenthesize(rest, PRECEDENCE['Mul'])}*{self.parenthesize(factor, PRECEDENCE['Mul'])}"

    def _print_Exp1(self, expr: sympy.Expr) -> str:  # noqa: N802
        return "e"

    def _print_ImaginaryUnit(self, expr: sympy.Expr) -> str:  # noqa: N802 - for `parse` to refuse; I may be a variable
        return "sqrt(-1)"

    def _print_Infinity(self, expr: sympy.Expr) -> str:  # noqa: N802
        return "(1/0)"

    _print_NegativeInfinity = _print_ComplexInfinity = _print_NaN = _print_Infinity  # noqa: N815


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
            case ast.BinOp(op=op, left=left, right=right) if type(op) in _OPERATIONS:
                chain = type(op) is not ast.Pow  # a + b + c + …: a long sum is not a deep one
                first = self.visit(left, depth if chain else depth + 1)
                return self.combine(_OPERATIONS[type(op)], first, self.visit(right, depth + 1))
            case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in FUNCTIONS:
                if len(args) != 1 or isinstance(args[0], ast.Starred):
                    raise self.fail(f"{name} takes one argument, here it has {len(args)}")
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
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in self.symbols:
            return self.fail(f"{node.func.id} is no function; write a product as {node.func.id}*(…)")
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
        raise self.fail(f"unknown name {name!r}; known are {known}, pi, e")

    # Terms that switch -----------------------------------------------------------------------------------------------

    def switching(self, name: str, args: Sequence[ast.expr], depth: int) -> Operand:
        """The smooth law of a call of one of `SWITCHING`, for the signs that `sign_of` gives."""
        if name == "Piecewise":
            return self.piecewise(args, depth)
        if name in ("max", "min"):
            return self.extremum(name, args, depth)
        if len(args) != 1:
            why = ": its value at 0 never matters" if name == "Heaviside" else ""
            raise self.fail(f"{name} takes one argument, here it has {len(args)}{why}")
        inner = self.visit(args[0], depth)
        sign = self.sign(inner)
        if name == "abs":
            return self.combine(_OPERATIONS[ast.Mult], (sympy.Integer(sign), sign), inner)
        return (sympy.Integer(sign), sign) if name == "sign" else (sympy.Rational(1 + sign, 2), (1 + sign) / 2)

    def extremum(self, name: str, args: Sequence[ast.expr], depth: int) -> Operand:
        if len(args) < 2:
            raise self.fail(f"{name} takes two arguments or more, here it has {len(args)}")
        read = [self.visit(u, depth) for u in args]
        best, *others = sorted(read, key=lambda u: u[1] is None)  # numbers first: of these only one is compared
        for other in others:
            sign = self.sign(self.combine(_OPERATIONS[ast.Sub], other, best))
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
                    raise self.fail(f"{piece!r} is no pair; write Piecewise((value, condition), …, (value, True))")
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
                signs = [self.sign(self.combine(_OPERATIONS[ast.Sub], *pair)) for pair in itertools.pairwise(read)]
                return all(sign in _COMPARISONS[type(op)] for op, sign in zip(ops, signs, strict=True))
        piece = ast.get_source_segment(self.source, node)
        raise self.fail(f"{piece!r} is no condition; write comparisons with < <= > >=, joined by and, or, not or & | ~")

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
        if exact is _power:
            self.check_power(*operands)
        self.check_roots(_roots_made(exact, *(e for e, _ in operands)))
        if all(v is not None for _, v in operands):
            self.check_value(_attempt(real, *(v for _, v in operands)))
        expression = exact(*(e for e, _ in operands))
        if expression.has(sympy.zoo, sympy.nan, sympy.oo, -sympy.oo, sympy.I):
            raise self.fail(_NOT_REAL)
        # sympy rewrites tan(pi/2 - x) as cot(x), which is not in the whitelist.
        expression = expression.replace(sympy.cot, lambda u: 1 / sympy.tan(u))
        for term in sympy.Add.make_args(expression):
            if _bits(term) > MAX_BITS:
                raise self.fail("it contains a constant with too many digits")
        if expression.free_symbols:
            return expression, None
        value = _value(expression)  # anew: x - x + 3 is a constant too
        self.check_value(value, expression)
        return expression, value

    def check_power(self, base: Operand, exponent: Operand) -> None:
        """Refuse large powers before sympy computes them: nested ones such as (1.000000001**64)**64."""
        if exponent[1] is None:
            if base[1] is not None and base[1] <= 0:
                raise self.fail("the base of a power is negative or zero where its exponent is no number")
            return
        if abs(exponent[1]) > MAX_EXPONENT and (base[1] is None or base[0].is_Rational):
            raise self.fail(f"the exponent {exponent[1]:g} is beyond ±{MAX_EXPONENT}")
        if not exponent[0].is_Rational and abs(exponent[1] - round(exponent[1])) < _CANCELS:
            # sympy would compute the minimal polynomial of their difference to find its sign
            raise self.fail(f"an exponent cannot be told from {round(exponent[1])}; write {round(exponent[1])}")
        if abs(exponent[1]) * _bits(base[0]) > MAX_BITS:
            raise self.fail("it contains a constant with too many digits")

    def check_roots(self, roots: Sequence[Root]) -> None:
        """Refuse long roots before sympy computes them: it turns 12**0.7123457 into (2**4246914*3**7123457)**1e-7."""
        if any(bits > MAX_ROOT_BITS for bits in _root_bits(roots)):
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
                self.check_value(_value(node), node)
                nodes.skip()
            elif node.is_Pow and not node.exp.free_symbols and abs(_value(node.exp)) > MAX_EXPONENT:
                raise self.fail(f"the exponent {node.exp} is beyond ±{MAX_EXPONENT}")
            elif node.is_Mul:
                coefficient = node.as_independent(*node.free_symbols)[0]
                self.check_value(_value(coefficient), coefficient)


def _nesting(text: str) -> int:
    """Depth of parentheses, counted before Python's own parser recurses into them."""
    depth = deepest = 0
    for character in text:
        depth += (character == "(") - (character == ")")
        deepest = max(deepest, depth)
    return deepest


def _attempt(real: Callable[..., float], *values: Any) -> float:
    """`real(*values)`; nan where it is undefined or complex."""
    try:
        value = real(*values)
    except (ArithmeticError, ValueError):
        return math.nan
    return math.nan if isinstance(value, complex) else value


def _value(constant: sympy.Expr) -> float:
    """Value of an expression without symbols; nan where it is undefined, or where a sum cancels to round-off."""
    if constant.is_Rational:
        return _attempt(lambda: constant.p / constant.q)
    if constant.is_NumberSymbol:
        return float(constant)
    arguments = [_value(a) for a in constant.args]
    if constant.is_Mul:
        return math.prod(arguments)
    if constant.is_Pow:
        return _attempt(_OPERATIONS[ast.Pow][1], *arguments)
    if constant.is_Add:
        total = math.fsum(arguments)
        return total if abs(total) > _CANCELS * math.fsum(map(abs, arguments)) else math.nan
    return _attempt(FUNCTIONS[type(constant).__name__][1], *arguments)


def _bits(term: sympy.Expr) -> int:
    """Bits of the longer of numerator and denominator of a term's rational factor."""
    factor = term.as_coeff_Mul()[0]
    return max(factor.p.bit_length(), factor.q.bit_length()) if factor.is_Rational else 0


def _roots_made(exact: Callable[..., sympy.Expr], *operands: sympy.Expr) -> list[Root]:
    """Fractional powers of numbers that sympy would combine in an operation: in u**r, exp(r*log(u)), u*v."""
    if exact is _power and operands[0] is not sympy.E:
        return _roots(*operands) if operands[1].is_Rational else []
    if exact is sympy.sqrt:
        return _roots(operands[0], sympy.Rational(1, 2))
    if exact in (_power, sympy.exp):
        terms = (term.as_coeff_Mul() for term in sympy.Add.make_args(operands[-1]))
        return [root for factor, rest in terms if rest.func is sympy.log for root in _roots(rest.args[0], factor)]
    if exact in (_times, _over):
        left, right = (_roots(u, sympy.Integer(1)) for u in operands)
        both = left and right  # with one alone nothing is combined
        return [*left, *((base, -e if exact is _over else e) for base, e in right)] if both else []
    return []


def _roots(u: sympy.Expr, exponent: sympy.Rational) -> list[Root]:
    """The rational factors of u, each with its exponent in u**exponent where that is a fraction."""
    content, rest = u.primitive()
    factors = [(content, 1), *(factor.as_base_exp() for factor in sympy.Mul.make_args(rest))]
    numbers = [(abs(base), power * exponent) for base, power in factors if base.is_Rational and base not in (0, 1)]
    return [(base, power) for base, power in numbers if power.is_Rational and not power.is_Integer]


def _root_bits(roots: Sequence[Root]) -> Iterator[int]:
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
    return sum(power // common * prime.bit_length() for prime, power in powers.items())


def _power(base: sympy.Expr, exponent: sympy.Expr) -> sympy.Expr:
    return base**exponent


def _times(u: sympy.Expr, v: sympy.Expr) -> sympy.Expr:
    return u * v


def _over(u: sympy.Expr, v: sympy.Expr) -> sympy.Expr:
    return u / v


#: Node of the syntax tree -> (operation on sympy expressions, operation on floats).
_OPERATIONS: dict[type[ast.operator], tuple[Callable[..., sympy.Expr], Callable[..., float]]] = {
    ast.Add: (lambda a, b: a + b, lambda a, b: a + b),
    ast.Sub: (lambda a, b: a - b, lambda a, b: a - b),
    ast.Mult: (_times, lambda a, b: a * b),
    ast.Div: (_over, lambda a, b: a / b),
    ast.Pow: (_power, lambda a, b: a**b),
}
#: Comparison -> the signs of left − right for which it holds.
_COMPARISONS: dict[type[ast.cmpop], tuple[int, ...]] = {
    ast.Lt: (-1,),
    ast.LtE: (-1, 0),
    ast.Gt: (1,),
    ast.GtE: (0, 1),
}
