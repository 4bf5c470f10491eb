"""Typesetting of sympy expressions: presentation MathML, which needs nothing loaded from outside, and LaTeX to copy.

sympy's own MathML printer writes names as raw markup and drops the brackets of x − (y + z); this one builds on sympy's
plain `Printer` and escapes all names.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, TypeAlias

import sympy
from sympy import Expr, Symbol
from sympy.printing.latex import LatexPrinter
from sympy.printing.printer import Printer
from sympy.printing.str import StrPrinter

import core
from core.symbolic import TIME, DividedDifference
from pwsviz.text.math_names import default_name, name_markup, operator, plain_text, said_name

__all__ = [
    "TOO_LONG",
    "Names",
    "Shown",
    "equation",
    "formula",
    "latex",
    "markup",
    "names_of",
    "ordered",
    "too_long",
]

#: LaTeX of each symbol, as `sympy.latex` takes it for ``symbol_names``.
Names: TypeAlias = Mapping[Symbol, str]
#: The right-hand side of an equation: an expression, a matrix, or the components of a vector.
Shown: TypeAlias = Expr | sympy.MatrixBase | Sequence[Expr]

MAX_OPERATIONS = 400  #: operations of an expression that is typeset; more would fill the page
MAX_DEPTH = 60  #: nested operations of an expression that is typeset; the printer is recursive
MAX_DIGITS = 40  #: decimal digits of a whole number or of a part of a fraction; a longer number is rounded
TOO_LONG = "too long to typeset"  #: shown in place of an expression beyond these limits

_TIMES = "<mo>&#8290;</mo>"  #: invisible multiplication sign
_APPLY = "<mo>&#8289;</mo>"  #: invisible sign of function application
_DOT = "<mo>⋅</mo>"  #: visible multiplication sign


def markup(expression: Shown, names: Names | None = None) -> str:
    """Typeset an expression, a matrix or a vector.

    Parameters
    ----------
    expression
        What to typeset; a sequence becomes a column.
    names
        LaTeX of symbols, as from `names_of`; from the symbol's own name where not given.

    Returns
    -------
    str
        The inside of a ``<math>`` element; `TOO_LONG` for an expression of more than `MAX_OPERATIONS` operations.
    """
    return _Printer(dict(names or {})).doprint(_one(expression))


def equation(left: str | Expr, right: Shown, names: Names | None = None) -> str:
    """Typeset left = right as a ``<math>`` element, with a plain-text version for screen readers.

    Parameters
    ----------
    left
        An expression, or the LaTeX of a name such as ``f_{-}``.
    right
        The right-hand side.
    names
        As in `markup`.
    """
    shown = name_markup(left) if isinstance(left, str) else markup(left, names)
    said = said_name(left) if isinstance(left, str) else _said(left)
    return _whole(f"{shown}<mo>=</mo>{markup(right, names)}", f"{said} = {_said(right)}")


def formula(text: str) -> str:
    r"""Typeset a formula as a ``<math>`` element: names, signs and brackets, separated by spaces.

    For example ``x_{k+1} = x_{k} + \tau f^{\tau}``; each piece is typeset by `name_markup`.
    """
    return _whole("".join(map(name_markup, text.split())), said_name(text))


def _whole(inside: str, words: str) -> str:
    said = plain_text(words)
    return f'<math display="block" alttext="{said}" aria-label="{said}"><mrow>{inside}</mrow></math>'


def latex(expression: Shown, names: Names | None = None) -> str:
    """Return the LaTeX source of what `markup` typesets; escape it before it goes into a page."""
    shown = _one(expression)
    if any(map(too_long, _parts(shown))):
        return rf"\text{{{TOO_LONG}}}"
    written = {s: (names or {}).get(s, default_name(s.name)) for s in shown.free_symbols}
    return str(_LatexPrinter({"symbol_names": written, "fold_frac_powers": True}).doprint(_explicit(shown)))


def _one(shown: Shown) -> Any:
    """Return a sequence as a column, and anything else as it is."""
    return shown if isinstance(shown, Expr | sympy.MatrixBase) else sympy.Matrix(list(shown))


def _parts(shown: Any) -> list[Any]:
    """Return the parts to which `too_long` applies separately: the entries of a matrix, or the expression."""
    return list(shown) if isinstance(shown, sympy.MatrixBase) else [shown]


def names_of(system: core.PiecewiseSystem) -> Names:
    """Return the LaTeX of the symbols of a system: a₋ for ``a_minus``, ω for ``omega``, x₀ and x₁ for a step's ends.

    Returns
    -------
    Mapping
        Symbol -> LaTeX, for the variables, the parameters, and both ends of a step of the discrete multiplier method.
    """
    names = {Symbol(p.name): p.symbol for p in system.parameters}
    ends = system.laws.regions[-1].discrete.ends
    inputs = (*ends.variables, TIME)
    names |= {symbol: default_name(symbol.name) for symbol in inputs}
    for k, at in enumerate((ends.at_start, ends.at_end)):
        names |= {Symbol(str(at[symbol])): _indexed(names[symbol], k) for symbol in inputs}
    return names


def _indexed(name: str, k: int) -> str:
    """Return the LaTeX of a name at the start (0) or the end (1) of a step."""
    return f"{name[:-1]},{k}}}" if "_{" in name else f"{name}_{{{k}}}"


def too_long(expression: Expr | sympy.MatrixBase) -> bool:
    """Return whether an expression exceeds `MAX_OPERATIONS` or `MAX_DEPTH`; stops walking it once that is certain."""
    open_nodes: list[tuple[Any, int]] = [(expression, 0)]
    operations = 0
    while open_nodes:
        node, depth = open_nodes.pop()
        operations += max(1, len(node.args) - 1) if node.args else 0
        if operations > MAX_OPERATIONS or depth > MAX_DEPTH:
            return True
        open_nodes += [(arg, depth + 1) for arg in node.args]
    return False


def _said(shown: Shown) -> str:
    """Return an expression in plain characters, with ^ for powers."""
    parts = _parts(_one(shown))
    words = [TOO_LONG if too_long(p) else _TextPrinter({"full_prec": False}).doprint(_explicit(p)) for p in parts]
    said = said_name(", ".join(words).replace("**", "^").replace("*", " "))  # a symbol may be named in LaTeX
    return said if isinstance(shown, Expr) else f"({said})"


def _explicit(expression: Any) -> Any:
    """Expand divided differences by the identities that compute them, write means as (a + b)/2, round long numbers."""
    shown = expression.replace(lambda u: isinstance(u, DividedDifference), _identity)
    return shown.replace(_is_long, lambda u: u.evalf(15)).replace(_is_sum, _with_means)


def _is_long(u: Any) -> bool:
    return bool(u.is_Rational) and max(abs(u.p), u.q) >= 10**MAX_DIGITS


def _is_sum(u: Any) -> bool:
    return bool(u.is_Add)


def _with_means(total: Expr) -> Expr:
    """Write a/2 + b/2 as (a + b)/2, and likewise for every fractional coefficient that two terms share."""
    shared: dict[Expr, list[Expr]] = {}
    for term in total.args:
        number, rest = term.as_coeff_Mul()
        size = abs(number) if number.is_Rational and number.q > 1 else sympy.S.One
        shared.setdefault(size, []).append(term if size == 1 else rest * (number / size))
    parts = []
    for size, found in shared.items():
        if size == 1 or len(found) == 1:
            parts += [size * term for term in found]
            continue
        sign = -1 if all(map(_negative, found)) else 1
        parts.append(sympy.Mul(sign * size, sympy.Add(*(sign * term for term in found)), evaluate=False))
    return sympy.Add(*parts)


def _identity(difference: DividedDifference) -> Expr:
    a, b = difference.args
    mean, half, sinhc = (a + b) / 2, (b - a) / 2, sympy.Function("sinhc")
    found: dict[Any, Expr] = {
        sympy.sin: sympy.cos(mean) * sympy.sinc(half),
        sympy.cos: -sympy.sin(mean) * sympy.sinc(half),
        sympy.tan: sympy.sinc(b - a) / (sympy.cos(a) * sympy.cos(b)),
        sympy.exp: sympy.exp(mean) * sinhc(half),
        sympy.log: (sympy.log(b) - sympy.log(a)) / (b - a),
        sympy.sinh: sympy.cosh(mean) * sinhc(half),
        sympy.cosh: sympy.sinh(mean) * sinhc(half),
        sympy.tanh: sinhc(b - a) / (sympy.cosh(a) * sympy.cosh(b)),
    }
    return found[difference.phi]


class _TextPrinter(StrPrinter):
    """sympy's printer, with the terms of a sum in the order in which they are typeset."""

    def _as_ordered_terms(self, expr: Any, order: str | None = None) -> list[Any]:
        return ordered(expr)


class _LatexPrinter(LatexPrinter):
    """Likewise."""

    def _as_ordered_terms(self, expr: Any, order: str | None = None) -> list[Any]:
        return ordered(expr)


class _Printer(Printer):
    """The recursion of `markup`; every method returns one MathML element."""

    printmethod = "_mathml_text"
    emptyPrinter = staticmethod(lambda expr: f"<mtext>{plain_text(str(expr))}</mtext>")  # noqa: N815 - sympy's name

    def __init__(self, names: Names) -> None:
        super().__init__()
        self._names = names

    def doprint(self, expr: Any) -> str:
        if any(map(too_long, _parts(expr))):
            return f"<mtext>{TOO_LONG}</mtext>"
        return str(self._print(_explicit(expr)))

    # Leaves ----------------------------------------------------------------------------------------------------------

    def _print_Symbol(self, u: Symbol) -> str:  # noqa: N802 - sympy's names, here and below
        return name_markup(self._names.get(u, default_name(u.name)))

    def _print_Integer(self, u: Any) -> str:  # noqa: N802
        return _signed(str(u))

    def _print_Rational(self, u: Any) -> str:  # noqa: N802
        part = f"<mfrac>{self._print(sympy.Integer(abs(u.p)))}{self._print(sympy.Integer(u.q))}</mfrac>"
        return f"<mrow><mo>−</mo>{part}</mrow>" if u.p < 0 else part

    def _print_Float(self, u: Any) -> str:  # noqa: N802
        digits, _, power = sympy.sstr(u, full_prec=False).partition("e")
        if not power:
            return _signed(digits)
        raised = f"<msup><mn>10</mn>{_signed(str(int(power)))}</msup>"
        return f"<mrow>{_signed(digits)}{_DOT}{raised}</mrow>"

    def _print_Pi(self, u: Any) -> str:  # noqa: N802
        return "<mi>π</mi>"

    def _print_Exp1(self, u: Any) -> str:  # noqa: N802
        return "<mi>e</mi>"

    # Sums and products -----------------------------------------------------------------------------------------------

    def _print_Add(self, u: Any) -> str:  # noqa: N802
        text = ""
        for k, term in enumerate(ordered(u)):
            negative = _negative(term)
            shown = self._in_brackets(-term if negative else term, term.is_Add or (-term).is_Add)
            text += ("<mo>−</mo>" if negative else "<mo>+</mo>" * (k > 0)) + shown
        return f"<mrow>{text}</mrow>"

    def _print_Mul(self, u: Any) -> str:  # noqa: N802
        if _negative(u):
            return f"<mrow><mo>−</mo>{self._in_brackets(-u, (-u).is_Add)}</mrow>"
        above, below = sympy.fraction(u)
        if below != 1:
            return self._fraction(above, below)
        factors = sorted(u.as_ordered_factors(), key=lambda factor: bool(factor.is_Add))  # sums last
        text = self._factor(factors[0])
        for before, factor in pairwise(factors):
            text += self._sign_between(before, factor) + self._factor(factor)
        return f"<mrow>{text}</mrow>"

    def _fraction(self, above: Any, below: Any) -> str:
        return f"<mfrac>{self._print(above)}{self._print(below)}</mfrac>"

    def _factor(self, u: Any) -> str:
        return self._in_brackets(u, u.is_Add or u.is_Mul or _negative(u))

    def _sign_between(self, left: Any, right: Any) -> str:
        """Return an invisible sign, but a dot between numbers and beside names of several letters."""
        figures = left.is_Number and (right.is_Number or (right.is_Pow and right.base.is_Number))
        if figures or self._is_word(left) or self._is_word(right):
            return _DOT
        return _TIMES + '<mspace width="0.17em"/>' * bool(right.is_Function and right.func is not sympy.exp)

    def _is_word(self, u: Any) -> bool:
        symbol = u.base if u.is_Pow else u
        return bool(symbol.is_Symbol) and re.search(r"<mi>\w{2,}</mi>", self._print(symbol)) is not None

    def _in_brackets(self, u: Any, wanted: bool) -> str:
        inside = str(self._print(u))
        return _bracketed(inside) if wanted else inside

    # Powers and functions --------------------------------------------------------------------------------------------

    def _print_Pow(self, u: Any) -> str:  # noqa: N802
        base, exponent = u.base, u.exp
        if exponent.is_Rational and exponent < 0:
            return f"<mfrac><mn>1</mn>{self._print(sympy.Pow(base, -exponent, evaluate=False))}</mfrac>"
        if exponent == 1:
            return str(self._print(base))
        if exponent == sympy.Rational(1, 2):
            return f"<msqrt>{self._print(base)}</msqrt>"
        if exponent.is_Rational and exponent.p == 1:
            return f"<mroot>{self._print(base)}{self._print(sympy.Integer(exponent.q))}</mroot>"
        raised = self._print(exponent)
        if exponent.is_Rational and exponent.q > 1:
            raised = f"<mrow><mn>{exponent.p}</mn><mo>/</mo><mn>{exponent.q}</mn></mrow>"
        return f"<msup>{self._base(base)}{raised}</msup>"

    def _base(self, u: Any) -> str:
        """Typeset the base of a power, in brackets unless it is a number or a name without a superscript."""
        plain = (u.is_Symbol and "sup>" not in self._print(u)) or (u.is_Integer and u >= 0) or u == sympy.E
        return self._in_brackets(u, not plain)

    def _print_exp(self, u: Any) -> str:
        return f"<msup><mi>e</mi>{self._print(u.args[0])}</msup>"

    def _print_Function(self, u: Any) -> str:  # noqa: N802
        inside = "<mo>,</mo>".join(map(self._print, u.args))
        return f"<mrow><mi>{plain_text(u.func.__name__)}</mi>{_APPLY}{_bracketed(inside)}</mrow>"

    def _print_MatrixBase(self, u: Any) -> str:  # noqa: N802
        cells = [[f"<mtd>{self._print(u[i, j])}</mtd>" for j in range(u.cols)] for i in range(u.rows)]
        rows = "".join(f"<mtr>{''.join(row)}</mtr>" for row in cells)
        return f'<mrow><mo>[</mo><mtable displaystyle="true">{rows}</mtable><mo>]</mo></mrow>'


def _bracketed(inside: str) -> str:
    """Put round brackets around markup, no higher than a line of text unless it contains a fraction."""
    if "<mfrac>" in inside:
        return f"<mrow><mo>(</mo>{inside}<mo>)</mo></mrow>"
    return f"<mrow>{operator('(')}{inside}{operator(')')}</mrow>"


def _signed(digits: str) -> str:
    digits = digits.removesuffix(".0")
    number = f"<mn>{digits.lstrip('-')}</mn>"
    return f"<mrow><mo>−</mo>{number}</mrow>" if digits.startswith("-") else number


def _negative(u: Any) -> bool:
    """Return whether a term is written with a leading minus."""
    coefficient = u.as_coeff_Mul()[0]
    return bool(coefficient.is_number and coefficient.is_real and coefficient < 0)


def ordered(u: Any) -> list[Any]:
    """Return the terms by descending degree, within a degree those without a minus first; a positive one leads."""
    terms = sorted(u.as_ordered_terms(), key=lambda term: (-_degree(term), _negative(term)))  # stable
    first = next((k for k, term in enumerate(terms) if not _negative(term)), 0)
    return [terms[first], *terms[:first], *terms[first + 1 :]]


def _degree(term: Any) -> int:
    """Return the degree of a term: the number of its factors that contain symbols, counted with integer exponents."""
    return sum(int(f.exp) if f.is_Pow and f.exp.is_Integer else 1 for f in sympy.Mul.make_args(term) if f.free_symbols)
