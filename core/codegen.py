"""Expressions → the text of a straight-line function that numba compiles.

What is written here comes from sympy trees alone, in names of our own: no text of a user's gets in.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import sympy
from sympy import Expr, Symbol
from sympy.printing.pycode import PythonCodePrinter

from core.expressions import TIME
from core.laws import Laws, Side
from core.multiplier import DIFFERENCES, SECOND, DividedDifference, SecondDifference

__all__ = ["StepCode", "function_text", "module_text", "values_text"]

_DIVIDED = sorted(cls.__name__ for cls in (*DIFFERENCES.values(), *SECOND.values()))
_HEADER = f"""\
import math
from numba import njit
from core.arithmetic import two_sum
from core.divided import {", ".join(_DIVIDED)}
from core.signatures import JUMP, RATE, STEP, SWITCHING
"""

#: Newton's corrections: at most so many, and how large (relative to the state) one that no longer shrinks may be.
_MAX_CORRECTIONS = 30
_STAGNATION = 1e-10
#: A pivot of so many parts of its column is round-off.
_DEPENDENT = 4 * 2.0**-52
#: And so many parts of gradient times state are what ψ may change by when its multiplier has none.
_KEPT = 16 * 2.0**-52


class _Printer(PythonCodePrinter):
    """Python text in floating point: whole numbers and ratios as floats, roots as square roots."""

    def _print_Integer(self, expr: Any) -> str:
        return repr(float(expr))

    _print_Rational = _print_Half = _print_One = _print_Zero = _print_NegativeOne = _print_Integer
    _print_Pi = _print_Exp1 = _print_Integer

    def _print_Pow(self, expr: Any, rational: bool = False) -> str:
        base, exponent = self.parenthesize(expr.base, sympy.printing.precedence.PRECEDENCE["Pow"]), expr.exp
        if expr.base.is_Symbol and exponent in (2, 3):  # half the compile time of the general power
            return f"({'*'.join([base] * int(exponent))})"
        if exponent.is_Integer and exponent > 0:
            return f"{base}**{int(exponent)}"
        if exponent == sympy.Rational(1, 2):
            return f"math.sqrt({self._print(expr.base)})"
        if exponent.is_number and exponent < 0:
            return f"(1.0/{self._print_Pow(sympy.Pow(expr.base, -exponent, evaluate=False))})"
        return f"{base}**({self._print(exponent)})"

    def _print_Function(self, expr: Any) -> str:
        if isinstance(expr, DividedDifference | SecondDifference):
            return f"{type(expr).__name__}({', '.join(map(self._print, expr.args))})"
        return str(super()._print_Function(expr))


def _print(expression: Expr) -> str:
    return str(_Printer({"fully_qualified_modules": True}).doprint(expression))


def _named(stem: str, count: int) -> tuple[Symbol, ...]:
    return tuple(Symbol(f"{stem}{k}") for k in range(count))


def assignments(targets: Sequence[str], expressions: Sequence[Expr], temporaries: Iterable[Symbol]) -> list[str]:
    """Lines that give `targets` the values of `expressions`, common subexpressions worked out once."""
    shared, final = sympy.cse(list(expressions), symbols=iter(temporaries), order="none")
    pairs = [(str(name), value) for name, value in shared] + list(zip(targets, final, strict=True))
    return [f"{name} = {_print(value)}" for name, value in pairs]


def function_text(name: str, signature: str, arguments: str, lines: Sequence[str]) -> str:
    """Text of one jitted function, cached on disk by numba."""
    body = "\n".join(f"    {line}" for line in lines)
    options = "cache=True, nogil=True, error_model='numpy'"
    return f"@njit({signature}, {options})\ndef {name}({arguments}):\n{body}\n"


def module_text(functions: Iterable[str]) -> str:
    """Text of a module of such functions."""
    return "\n\n".join([_HEADER, *functions])


class _Canonical:
    """Names of ours for a system's symbols: state x0, x1, …; parameters p0, p1, …; time t."""

    def __init__(self, laws: Laws) -> None:
        self.x, self.p = _named("x", len(laws.x)), _named("p", len(laws.p))
        self.parameters = dict(zip(laws.p, self.p, strict=True))
        self.symbols = {**dict(zip(laws.x, self.x, strict=True)), **self.parameters, TIME: Symbol("t")}
        self.unpack = [f"{v} = {str(v)[0]}[{str(v)[1:]}]" for v in (*self.x, *self.p)]


def values_text(laws: Laws, expressions: Sequence[Expr], targets: Sequence[str], prefix: str = "v") -> list[str]:
    """Lines that unpack x and p and work out `expressions`."""
    names = _Canonical(laws)
    given = [e.xreplace(names.symbols) for e in expressions]
    return names.unpack + assignments(targets, given, sympy.numbered_symbols(prefix))


class StepCode:
    """The text of one step, written by a method's builder in terms of symbols.

    Attributes
    ----------
    t, h
        Start and length of the step.
    x
        The d coordinates of the state at its start.
    """

    def __init__(self, laws: Laws, side: Side) -> None:
        self._names = _Canonical(laws)
        self._side = side
        self._temporaries = sympy.numbered_symbols("v")
        self._lines = self._names.unpack + [f"c{k} = carry[{k}]" for k in range(len(laws.x))]
        self._evaluations: list[str] = []
        self.t, self.h = Symbol("t"), Symbol("h")
        self.x = self._names.x

    def let(self, expressions: Sequence[Expr]) -> list[Symbol]:
        """Work expressions out here; returns the names of their values."""
        names = [next(self._temporaries) for _ in expressions]
        self._lines += assignments([str(n) for n in names], expressions, self._temporaries)
        return names

    def field(self, t: Expr, x: Sequence[Expr]) -> list[Symbol]:
        """Work out f(t, x) here; returns the names of its d values."""
        at = {**self._names.symbols, **dict(zip(self._side.variables, x, strict=True)), TIME: t}
        self._evaluations.append("1")
        return self.let([f.xreplace(at) for f in self._side.field])

    def at_ends(self, expressions: Iterable[Expr]) -> list[Expr]:
        """Discrete expressions in this step's symbols: x at its start, ``y`` = x + increment at its end."""
        ends = self._side.discrete.ends
        names = {**dict(zip(ends.start, self.x, strict=True)), **dict(zip(ends.end, self.end, strict=True))}
        names |= {**self._names.parameters, ends.times[0]: self.t, ends.times[1]: Symbol("t1")}
        return [e.xreplace(names) for e in expressions]

    @property
    def end(self) -> tuple[Symbol, ...]:
        """The state at the end of the step, where `solve` is after its current increment."""
        return _named("y", len(self.x))

    @property
    def increment(self) -> tuple[Symbol, ...]:
        """The unknown increment of `solve`."""
        return _named("d", len(self.x))

    def solve(self, residuals: Sequence[Expr], multipliers: Sequence[Symbol] = ()) -> list[Symbol]:
        """Find the increment (and multipliers) at which the residuals vanish, by Newton's method from rest.

        In increment form, so that what is iterated is small and its round-off too; the last correction is the one
        after which quadratic convergence leaves less than half an ulp, or the one that no longer shrinks.
        """
        d = len(self.x)
        unknowns = [*self.increment, *multipliers]
        # The end of the step moves with the increment: y = x + d.
        moving = [
            [r.diff(u) + (r.diff(self.end[k]) if k < d else 0) for k, u in enumerate(unknowns)] for r in residuals
        ]
        n = len(unknowns)
        entries = [f"j{i}_{k}" for i in range(n) for k in range(n)]
        inner = [f"y{k} = x{k} + (c{k} + d{k})" for k in range(d)]
        inner += assignments(
            [*(f"r{i}" for i in range(n)), *entries],
            [*residuals, *(e for row in moving for e in row)],
            self._temporaries,
        )
        inner += _elimination(n, d)
        inner += [f"{u} -= r{k}" for k, u in enumerate(unknowns)]
        self._lines += ["t1 = t + h", *(f"{u} = 0.0" for u in unknowns), "last = math.inf", "corrections = 0"]
        self._lines += ["while True:", *(f"    {line}" for line in (*inner, *_verdict(n, d)))]
        self._evaluations.append("corrections")
        return list(self.increment)

    def compose(self, weights: Sequence[float], build: Callable[[], Sequence[Expr]]) -> list[Symbol]:
        """Steps of length weight·h one after another, in a loop of the compiled step; returns the whole increment.

        Between the steps, state and increment are kept with what rounding loses of them.
        """
        d = range(len(self.x))
        outer, self._lines, self._evaluations = self._lines, [], []
        part = build()
        inner = ["h = whole_h * weight", "t = whole_t + whole_h * passed", "passed += weight"]
        inner += [f"x{k}, c{k} = two_sum(x[{k}], carry[{k}] + (w{k} + z{k}))" for k in d]
        inner += self._lines + assignments([f"a{k}" for k in d], part, self._temporaries)
        for k in d:
            inner += [f"w{k}, q = two_sum(w{k}, a{k})", f"z{k} += q"]
        inner.append(f"count += {' + '.join(self._evaluations)}")
        self._lines = [*outer, "whole_t, whole_h, passed, count = t, h, 0.0, 0", *(f"w{k} = z{k} = 0.0" for k in d)]
        self._lines += [f"for weight in {tuple(weights)!r}:", *(f"    {line}" for line in inner)]
        self._evaluations = ["count"]
        return self.let([Symbol(f"w{k}") + Symbol(f"z{k}") for k in d])

    def text(self, name: str, increments: Sequence[Expr]) -> str:
        """The whole function, its increments being as given."""
        targets = [f"dx[{k}]" for k in range(len(self.x))]
        lines = self._lines + assignments(targets, increments, self._temporaries)
        lines.append(f"return {' + '.join(self._evaluations)}")
        return function_text(name, "STEP", "t, h, x, carry, p, dx", lines)


def _verdict(n: int, d: int) -> list[str]:
    """Lines that end Newton's loop: solved, or not to be solved."""
    state = ", ".join(f"abs(x{k})" for k in range(d))
    kept = ""
    check = []
    if n - d > 1:  # a ψ that has been left alone must be kept all the same
        check.append(
            f"kept = {' and '.join(f'j{k}_{k} != 0.0' for k in range(d, n))} or excess <= "
            f"{_KEPT} * max({', '.join(f's{k}' for k in range(d, n))}) * max(whole, {state})"
        )
        kept = "kept and "
    return [
        f"size = max({', '.join(f'abs(r{k})' for k in range(d))}, 0.0)",
        f"whole = max({', '.join(f'abs(d{k})' for k in range(d))}, 0.0)",
        "corrections += 1",
        "if not size < math.inf:",
        "    return -1",
        *check,
        f"if {kept}(size == 0.0 or (corrections > 1 and size * size * size < 1e-17 * whole * last * last)):",
        "    break",
        f"if {kept}size >= last and size <= {_STAGNATION} * max(whole, {state}):",
        "    break",
        f"if corrections >= {_MAX_CORRECTIONS}:",
        "    return -1",
        "last = size",
    ]


def _elimination(n: int, d: int) -> list[str]:
    """Lines that solve the n × n system j·e = r by Gaussian elimination with partial pivoting, e left in r.

    The unknowns from d on are multipliers of gradients. A pivot of zero leaves its unknown alone: gradients that
    vanish, as at an equilibrium, bind nothing. So does one that depends on the others but for round-off: the pivot is
    the square of its sine, and to that order its ψ is kept by keeping theirs.
    """
    several = n - d > 1
    lines = []
    if several:
        lines += [f"s{k} = max({', '.join(f'abs(j{i}_{k})' for i in range(d))})" for k in range(d, n)]
        lines.append(f"unit = {_DEPENDENT} * min(1.0, {', '.join(f's{k}' for k in range(d, n))})")
        lines.append(f"excess = max({', '.join(f'abs(r{k})' for k in range(d, n))})")
    for k in range(n):
        for i in range(k + 1, n):
            row, pivot = ([f"j{m}_{c}" for c in range(k, n)] + [f"r{m}"] for m in (i, k))
            swap = f"{', '.join(row + pivot)} = {', '.join(pivot + row)}"
            lines += [f"if abs(j{i}_{k}) > abs(j{k}_{k}):", f"    {swap}"]
        least = f"unit * s{k}" if several and k >= d else "0.0"
        lines.append(f"j{k}_{k} = 1.0 / j{k}_{k} if not abs(j{k}_{k}) <= {least} else 0.0")
        for i in range(k + 1, n):
            lines.append(f"q = j{i}_{k} * j{k}_{k}")
            lines += [f"j{i}_{c} -= q * j{k}_{c}" for c in range(k + 1, n)]
            lines.append(f"r{i} -= q * r{k}")
    for k in reversed(range(n)):
        known = "".join(f" - j{k}_{c} * r{c}" for c in range(k + 1, n))
        lines.append(f"r{k} = (r{k}{known}) * j{k}_{k}")
    return lines
