"""Jacobians of many expressions in many unknowns, by the chain rule from one shared subexpression to the next.

If the entries of a large Jacobian are differentiated one by one, they repeat each other's terms, and finding these
common subexpressions takes far longer than the differentiation.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from sympy import Add, Expr, Integer, Mul, Symbol

from core.codegen.printing import common, printed
from core.symbolic.derivative import derivative

__all__ = ["jacobian"]

Gradient = dict[int, Expr]  #: derivatives by the index of the unknown; those that vanish are left out


def jacobian(
    expressions: Sequence[Expr],
    unknowns: Sequence[Symbol],
    moves: Mapping[Symbol, Symbol],
    temporaries: Iterable[Symbol],
) -> tuple[list[str], list[str], dict[tuple[int, int], str]]:
    """Lines that evaluate expressions and their derivatives.

    Parameters
    ----------
    expressions
        (n) functions.
    unknowns
        Variables of differentiation.
    moves
        Other symbols, each with the unknown by which its derivative is 1.
    temporaries
        Names for shared subexpressions.

    Returns
    -------
    lines, values, entries
        Lines; texts of the n values; texts of the derivatives that do not vanish identically, by row and column.
    """
    places = {u: k for k, u in enumerate(unknowns)}
    known: dict[Symbol, Gradient] = {u: {k: Integer(1)} for u, k in places.items()}
    known |= {symbol: {places[u]: Integer(1)} for symbol, u in moves.items()}
    names = iter(temporaries)
    shared, final = common(expressions, names, thorough=False)
    lines: list[str] = []
    for name, expression in shared:
        lines.append(f"{name} = {printed(expression, ordered=False)}")
        known[name] = _named(_gradient(expression, known, lines, names), lines, names)
    rows = [_gradient(expression, known, lines, names) for expression in final]
    entries = {(i, k): printed(entry, ordered=False) for i, row in enumerate(rows) for k, entry in row.items()}
    return lines, [printed(expression, ordered=False) for expression in final], entries


def _gradient(
    expression: Expr, known: Mapping[Symbol, Gradient], lines: list[str], names: Iterable[Symbol]
) -> Gradient:
    """Gradient by the chain rule: Σ over the symbols of an expression of its derivative times the symbol's gradient."""
    parts: dict[int, list[Expr]] = {}
    for symbol, slope in _slopes(expression, known).items():
        inner = known[symbol]
        if len(inner) > 1:
            slope = _name(slope, lines, names)
        for k, factor in inner.items():
            parts.setdefault(k, []).append(slope * factor)
    return {k: Add(*terms) for k, terms in parts.items()}


def _slopes(u: Expr, known: Mapping[Symbol, Gradient]) -> dict[Symbol, Expr]:
    """Derivatives of an expression by its own symbols, in one pass over sums, products and powers.

    sympy differentiates once for every symbol, which takes d² steps for a sum of d terms.
    """
    if u.is_Atom:
        return {u: Integer(1)} if known.get(u) else {}
    parts = [_slopes(part, known) for part in u.args]
    if not any(parts):
        return {}
    if u.is_Add:
        return _sum(parts)
    if u.is_Mul:
        rest = [Mul(*u.args[:k], *u.args[k + 1 :]) if part else None for k, part in enumerate(parts)]
        return _sum([{s: r * e for s, e in part.items()} for r, part in zip(rest, parts, strict=True)])
    if u.is_Pow and not parts[1]:
        outer = u.exp * u.base ** (u.exp - 1)
        return {s: outer * e for s, e in parts[0].items()}
    return {s: derivative(u, s) for s in sorted({s for part in parts for s in part}, key=str)}


def _sum(parts: Sequence[Mapping[Symbol, Expr]]) -> dict[Symbol, Expr]:
    terms: dict[Symbol, list[Expr]] = {}
    for part in parts:
        for symbol, slope in part.items():
            terms.setdefault(symbol, []).append(slope)
    return {symbol: Add(*slopes) for symbol, slopes in terms.items()}


def _named(gradient: Gradient, lines: list[str], names: Iterable[Symbol]) -> Gradient:
    return {k: _name(entry, lines, names) for k, entry in gradient.items()}


def _name(entry: Expr, lines: list[str], names: Iterable[Symbol]) -> Expr:
    """Name an expression, unless it is ± a number or symbol."""
    if entry.is_Atom or (-entry).is_Atom:
        return entry
    name: Symbol = next(iter(names))
    lines.append(f"{name} = {printed(entry, ordered=False)}")
    return name
