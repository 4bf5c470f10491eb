"""Equations, paragraphs and tables as HTML, with the LaTeX source of the equations."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from sympy import Expr, Symbol

from pwsviz.figures.constants import prose, table
from pwsviz.text.mathml import Names, Shown, equation, formula, latex

__all__ = ["EquationSheet"]


class EquationSheet:
    """A sequence of equations and paragraphs, with the LaTeX source of the equations."""

    def __init__(self, names: Names) -> None:
        self.names = names
        self.source: list[str] = []
        self._parts: list[str] = []

    @property
    def text(self) -> str:
        """All of it as HTML."""
        return "".join(self._parts)

    def equate(self, left: str, right: Shown) -> None:
        """Add the equation of a left side in LaTeX and an expression."""
        self._show(equation(left, right, self.names))
        self.source.append(f"{left} = {latex(right, self.names)}")

    def rate(self, variable: str, right: Expr) -> None:
        """Add the equation Δx/τ = … of one component of a step."""
        change = Symbol(f"change of {variable}")
        left = change / Symbol(r"\tau")
        names = {**self.names, change: rf"\Delta {self.names[Symbol(variable)]}"}
        self._show(equation(left, right, names))
        self.source.append(f"{latex(left, names)} = {latex(right, names)}")

    def formula(self, text: str) -> None:
        """Add a formula in LaTeX."""
        self._show(formula(text))
        self.source.append(text)

    def _show(self, typeset: str) -> None:
        self._parts.append(f'<div class="formula">{typeset}</div>')

    def say(self, words: str) -> None:
        """Add a paragraph."""
        self._parts.append(f"<p>{prose(words)}</p>")

    def head(self, words: str) -> None:
        """Add a heading."""
        self._parts.append(f"<h3>{escape(words)}</h3>")

    def table(self, head: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
        """Add a table."""
        self._parts.append(table(head, rows))
