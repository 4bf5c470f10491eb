"""Print expressions as lines of Python that are compiled: in floating point, or in double-double.

The lines are generated from sympy trees, with names chosen here: no text of a user enters them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import sympy
from sympy import Expr, Integer, Symbol
from sympy.printing.precedence import PRECEDENCE
from sympy.printing.pycode import PythonCodePrinter
from sympy.simplify.cse_main import tree_cse

from core.kernels.doubledouble.arithmetic import split
from core.symbolic.multiplier import DividedDifference, SecondDifference
from core.symbolic.near_zeros import Choice, magnitude

__all__ = ["assignments", "common", "doubled_assignments", "fma", "magnitude", "named", "printed"]


class fma(sympy.Function):  # noqa: N801 - printed under this name
    """a b + c, rounded once (`doubledouble.arithmetic.fma`)."""

    nargs = 3


class _Printer(PythonCodePrinter):
    """Prints Python text in floating point: integers and ratios as floats, half-integer powers by square roots."""

    def _print_Integer(self, expr: Any) -> str:
        return repr(float(expr))

    _print_Rational = _print_Half = _print_One = _print_Zero = _print_NegativeOne = _print_Integer
    _print_Pi = _print_Exp1 = _print_Integer

    def _print_Float(self, expr: Any) -> str:
        return repr(float(expr))  # sympy would print 15 digits

    def _print_Pow(self, expr: Any, rational: bool = False) -> str:
        base, exponent = self.parenthesize(expr.base, PRECEDENCE["Pow"]), expr.exp
        if expr.base.is_Symbol and exponent in (2, 3):  # compiles in half the time of a general power
            return f"({'*'.join([base] * int(exponent))})"
        if exponent.is_Integer and exponent > 0:
            return f"{base}**{int(exponent)}"
        if exponent == sympy.Rational(1, 2):
            return f"math.sqrt({self._print(expr.base)})"
        if (
            exponent.is_Rational and exponent.q == 2 and 1 < exponent < 5
        ):  # as r⁻³ = (x² + y²)**(-3/2): in half the time
            return f"half_power({self._print(expr.base)}, {exponent.p // 2})"
        if exponent.is_number and exponent < 0:
            return f"(1.0/{self._print_Pow(sympy.Pow(expr.base, -exponent, evaluate=False))})"
        return f"{base}**({self._print(exponent)})"

    def _print_Function(self, expr: Any) -> str:
        if isinstance(expr, magnitude):
            return f"abs({self._print(expr.args[0])})"
        if isinstance(expr, Choice):
            far, near, other = map(self._print, expr.args)
            return f"({near} if {far} <= 0.0 else {other})"
        if isinstance(expr, DividedDifference | SecondDifference | fma):
            return f"{type(expr).__name__}({', '.join(map(self._print, expr.args))})"
        return str(super()._print_Function(expr))


def printed(expression: Expr, ordered: bool = True) -> str:
    """Text of an expression in floating point; its terms are in sympy's display order or, faster, in storage order."""
    settings = {"fully_qualified_modules": True} if ordered else {"fully_qualified_modules": True, "order": "none"}
    return str(_Printer(settings).doprint(expression))


def named(stem: str, count: int) -> tuple[Symbol, ...]:
    """Symbols stem0, stem1 and so on."""
    return tuple(Symbol(f"{stem}{k}") for k in range(count))


def assignments(
    targets: Sequence[str], expressions: Sequence[Expr], temporaries: Iterable[Symbol], thorough: bool = True
) -> list[str]:
    """Lines that assign the values of `expressions` to `targets`; common subexpressions are evaluated once.

    If `thorough`, terms common to several sums or products are shared, too; finding them takes a time that grows with
    the square of the length of the text.
    """
    shared, final = common(expressions, temporaries, thorough)
    pairs = [(str(name), value) for name, value in shared] + list(zip(targets, final, strict=True))
    return [f"{name} = {printed(value, thorough)}" for name, value in pairs]


def common(
    expressions: Sequence[Expr], temporaries: Iterable[Symbol], thorough: bool = True
) -> tuple[list[tuple[Symbol, Expr]], list[Expr]]:
    """Common subexpressions, named in their order of evaluation, and the expressions written with these names."""
    if thorough:
        return sympy.cse(list(expressions), symbols=iter(temporaries), order="none")  # type: ignore[no-any-return]
    return tree_cse(list(expressions), iter(temporaries), order="none")  # type: ignore[no-any-return]


#: A double-double number: names (or literals) of its high and low part; the latter is None if it is zero.
Pair = tuple[str, str | None]


def doubled_assignments(
    targets: Sequence[str],
    expressions: Sequence[Expr],
    known: Mapping[Symbol, Pair],
    temporaries: Iterable[Symbol],
) -> list[str]:
    """Lines that assign the values of `expressions` in double-double to ``target``, ``target_low``."""
    writer = _Doubled(known, temporaries)
    for target, expression in zip(targets, expressions, strict=True):
        high, low = writer.pair(expression)
        writer.lines.append(f"{target}, {target}_low = {high}, {low or '0.0'}")
    return writer.lines


class _Doubled:
    """The recursion of `doubled_assignments`, in which every shared subexpression is evaluated once."""

    def __init__(self, known: Mapping[Symbol, Pair], temporaries: Iterable[Symbol]) -> None:
        self.known: dict[Expr, Pair] = dict(known)
        self.temporaries = iter(temporaries)
        self.lines: list[str] = []

    def pair(self, u: Expr) -> Pair:
        if u not in self.known:
            self.known[u] = self.work_out(u)
        return self.known[u]

    def call(self, function: str, *operands: Pair | str) -> Pair:
        """Append a line that calls a function of `doubledouble`; returns its result."""
        name = next(self.temporaries)
        parts = [part for o in operands for part in ((o,) if isinstance(o, str) else (o[0], o[1] or "0.0"))]
        self.lines.append(f"{name}, {name}_low = {function}({', '.join(parts)})")
        return str(name), f"{name}_low"

    def let(self, high: str, low: str) -> Pair:
        """Append a line that names a pair."""
        name = next(self.temporaries)
        self.lines.append(f"{name}, {name}_low = {high}, {low}")
        return str(name), f"{name}_low"

    def work_out(self, u: Expr) -> Pair:
        if not u.free_symbols:
            constant = split(u)
            return repr(constant[0]), repr(constant[1]) if constant[1] else None
        if u.is_Add:
            total = self.pair(u.args[0])
            for term in u.args[1:]:
                minus = term.could_extract_minus_sign()
                high, low = self.pair(-term if minus else term)
                term_pair = (f"-{high}", f"-{low}" if low else None) if minus else (high, low)
                total = self.call("pair_add", total, term_pair)
            return total
        if u.is_Mul:
            number, rest = u.as_coeff_Mul()
            if number.is_Rational and number != 1 and abs(number.p) == 1 and (number.q & (number.q - 1)) == 0:
                high, low = self.pair(rest)  # a power of two scales exactly
                factor = repr(float(number))
                return self.let(f"{factor} * {high}", f"{factor} * {low}" if low else "0.0")
            above, below = sympy.fraction(u)
            return self.product(above) if below == 1 else self.call("dd_div", self.product(above), self.product(below))
        if u.is_Pow:
            return self.power(u.base, u.exp)
        if isinstance(u, magnitude):
            return self.where(self.pair(u.args[0]), self.pair(-u.args[0]), self.pair(u.args[0]))
        if isinstance(u, Choice):
            return self.where(*map(self.pair, u.args))
        name = type(u).__name__
        return self.call(f"dd_{name}", self.pair(u.args[0]))

    def where(self, far: Pair, near: Pair, other: Pair) -> Pair:
        """One of two numbers where another is not positive, else the other one."""
        condition = f"if {far[0]} <= 0.0 else"
        return self.let(f"({near[0]} {condition} {other[0]})", f"({near[1] or 0.0} {condition} {other[1] or 0.0})")

    def product(self, u: Expr) -> Pair:
        total, *others = map(self.pair, sympy.Mul.make_args(u))
        for factor in others:
            if total[1] is None and factor[1] is None:
                total = self.call("two_product", total[0], factor[0])
            elif factor[1] is None:
                total = self.call("pair_scale", total, factor[0])
            elif total[1] is None:
                total = self.call("pair_scale", factor, total[0])
            else:
                total = self.call("pair_mul", total, factor)
        return total

    def power(self, base: Expr, exponent: Expr) -> Pair:
        if exponent.is_Integer and exponent > 0:
            half = self.pair(base ** (exponent // 2))
            square = self.call("pair_square", half)
            return square if exponent % 2 == 0 else self.call("pair_mul", square, self.pair(base))
        if exponent.is_Integer:
            return self.call("dd_div", ("1.0", None), self.pair(base**-exponent))
        if exponent.is_Rational and exponent.q == 2:
            root = self.call("dd_sqrt", self.pair(base))
            if exponent.p == 1:
                return root
            name = Symbol(root[0])
            self.known[name] = root
            return self.power(name, Integer(exponent.p))
        if base == sympy.E:
            return self.call("dd_exp", self.pair(exponent))
        return self.call("dd_pow", self.pair(base), self.pair(exponent))
