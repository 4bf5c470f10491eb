"""Equations of the editor as MathML, with a plain-text version for screen readers."""

from __future__ import annotations

from html import escape

from sympy import Expr, Float, Rational, Symbol

from core.symbolic import to_text
from pwsviz.text.mathml import TOO_LONG, Names, markup, too_long
from pwsviz.text.numbers import shortest

__all__ = ["constant", "equation", "is_zero", "rate", "state_after"]


def constant(value: float) -> Expr:
    """Return a number as an expression that is typeset with the digits, or as the ratio, of its field on the page."""
    text = shortest(float(value))
    return Rational(text) if "/" in text else Float(text)


def equation(said: str, shown: str, right: Expr, names: Names | None = None, more: str = "") -> str:
    """Typeset an equation.

    Parameters
    ----------
    said, shown : str
        Its left-hand side, in plain characters and as markup.
    right : sympy.Expr
        Its right-hand side.
    names : mapping, optional
        LaTeX of symbols, as in `markup`.
    more : str
        Markup that follows.
    """
    told = escape(f"{said} = {TOO_LONG if too_long(right) else to_text(right)}")
    inside = f"{shown}<mo>=</mo>{markup(right, names)}{more}"
    return f'<math display="block" alttext="{told}" aria-label="{told}"><mrow>{inside}</mrow></math>'


def is_zero(left: Expr, names: Names | None = None) -> str:
    """Typeset the equation that an expression is zero."""
    told = escape(f"{TOO_LONG if too_long(left) else to_text(left)} = 0")
    inside = f"{markup(left, names)}<mo>=</mo><mn>0</mn>"
    return f'<math display="block" alttext="{told}" aria-label="{told}"><mrow>{inside}</mrow></math>'


def rate(variable: str) -> tuple[str, str]:
    """Return x′ in plain characters and as markup."""
    return f"{variable}′", f'<mrow>{markup(Symbol(variable))}<mo lspace="0" rspace="0">′</mo></mrow>'


def state_after(variable: str) -> tuple[str, str]:
    """Return x⁺, the value after a reset, in plain characters and as markup."""
    return f"{variable}⁺", f"<msup><mrow>{markup(Symbol(variable))}</mrow><mo>+</mo></msup>"
