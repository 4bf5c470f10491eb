"""Write sympy's expressions as text that `parse` reads back, and quote text in messages."""

from __future__ import annotations

import sympy
from sympy.printing.precedence import PRECEDENCE
from sympy.printing.str import StrPrinter

__all__ = ["MAX_DIGITS", "quoted", "to_text"]

#: Most digits of one number.
MAX_DIGITS = 40
#: Most characters that a message quotes of a text.
_SHOWN = 78


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

    def _as_ordered_terms(self, expr: sympy.Add, order: str | None = None) -> list[sympy.Expr]:
        """A term without a minus first, as people write: x - d, not -d + x."""
        terms: list[sympy.Expr] = super()._as_ordered_terms(expr, order)
        return sorted(terms, key=lambda term: term is not _leading(terms))

    def _print_Exp1(self, expr: sympy.Expr) -> str:  # noqa: N802
        return "e"

    def _print_ImaginaryUnit(self, expr: sympy.Expr) -> str:  # noqa: N802 - for `parse` to refuse; I may be a variable
        return "sqrt(-1)"

    def _print_Infinity(self, expr: sympy.Expr) -> str:  # noqa: N802
        return "(1/0)"

    _print_NegativeInfinity = _print_ComplexInfinity = _print_NaN = _print_Infinity  # noqa: N815


def _leading(terms: list[sympy.Expr]) -> sympy.Expr:
    """The first of the terms without a minus, or the first of all."""
    return next((term for term in terms if not term.as_coeff_Mul()[0].is_negative), terms[0])
