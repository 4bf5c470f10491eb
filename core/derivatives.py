"""Jacobians of many expressions in many unknowns, by the chain rule from one shared subexpression to the next.

Differentiated one by one, the entries of a large system repeat each other's terms, and to find these again takes far
longer than to derive them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from sympy import Add, Expr, Integer, Symbol

from core.printing import common, printed

__all__ = ["jacobian"]

Gradient = dict[int, Expr]  #: by the number of the unknown; 0 where it has none


def jacobian(
    expressions: Sequence[Expr],
    unknowns: Sequence[Symbol],
    moves: Mapping[Symbol, Symbol],
    temporaries: Iterable[Symbol],
) -> tuple[list[str], list[str], dict[tuple[int, int], str]]:
    """Lines that work out values and derivatives of expressions.

    Parameters
    ----------
    expressions
        What is differentiated.
    unknowns
        By which it is.
    moves
        Symbols that move with an unknown: their derivative by it is 1.
    temporaries
        Names for what is shared.

    Returns
    -------
    lines, values, entries
        Lines, and what stands after them for the values (n), and for the derivatives that are not 0 by nature.
    """
    places = {u: k for k, u in enumerate(unknowns)}
    known: dict[Symbol, Gradient] = {u: {k: Integer(1)} for u, k in places.items()}
    known |= {symbol: {places[u]: Integer(1)} for symbol, u in moves.items()}
    names = iter(temporaries)
    shared, final = common(expressions, names, thorough=False)
    lines: list[str] = []
    for name, expression in shared:
        lines.append(f"{name} = {printed(expression)}")
        known[name] = _named(_gradient(expression, known, lines, names), lines, names)
    rows = [_gradient(expression, known, lines, names) for expression in final]
    entries = {(i, k): printed(entry) for i, row in enumerate(rows) for k, entry in row.items()}
    return lines, [printed(expression) for expression in final], entries


def _gradient(
    expression: Expr, known: Mapping[Symbol, Gradient], lines: list[str], names: Iterable[Symbol]
) -> Gradient:
    """Chain rule: the sum over the symbols of an expression of its derivative by each times that one's gradient."""
    parts: dict[int, list[Expr]] = {}
    for symbol, slope in _slopes(expression, known).items():
        inner = known[symbol]
        if len(inner) > 1:
            slope = _name(slope, lines, names)
        for k, factor in inner.items():
            parts.setdefault(k, []).append(slope * factor)
    return {k: Add(*terms) for k, terms in parts.items()}


def _slopes(expression: Expr, known: Mapping[Symbol, Gradient]) -> dict[Symbol, Expr]:
    """Derivatives of an expression by its own symbols, term by term."""
    slopes: dict[Symbol, list[Expr]] = {}
    for term in Add.make_args(expression):
        for symbol in sorted(term.free_symbols & known.keys(), key=str):
            if known[symbol]:
                slopes.setdefault(symbol, []).append(term.diff(symbol))
    return {symbol: Add(*terms) for symbol, terms in slopes.items()}


def _named(gradient: Gradient, lines: list[str], names: Iterable[Symbol]) -> Gradient:
    return {k: _name(entry, lines, names) for k, entry in gradient.items()}


def _name(entry: Expr, lines: list[str], names: Iterable[Symbol]) -> Expr:
    """A name for what is more than a number or a name."""
    if entry.is_Atom or (-entry).is_Atom:
        return entry
    name: Symbol = next(iter(names))
    lines.append(f"{name} = {printed(entry)}")
    return name
