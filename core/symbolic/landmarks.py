"""Sizes that expressions themselves name: 60 for y in tanh(2 (y − 60)), 300 for x and for y in x + y − 300.

A region, or a thin layer in it, may lie anywhere. Where it lies is written in its expressions: in a sum with a
constant, a coordinate is of the size at which its term balances the constant.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from sympy import Expr, Symbol

__all__ = ["at_landmarks", "landmarks"]

Array = NDArray[np.float64]

#: Most sizes that are kept for a symbol, in the order in which they are found.
_MOST = 12
#: A coordinate is drawn between plus and minus this multiple of a landmark.
_BEYOND = 2.0
#: Probability that a coordinate is drawn by a landmark, if it has one.
_SHARE = 0.7


def landmarks(
    nodes: Iterable[Expr], symbols: Sequence[Symbol], ranges: Mapping[Symbol, tuple[float, float]]
) -> dict[Symbol, tuple[float, ...]]:
    """Sizes of symbols at which a term of a sum balances the constant of the sum; a bounded symbol counts as constant.

    Parameters
    ----------
    nodes
        Expressions, with all parts of them that are to be looked at.
    ranges
        Bounds of the symbols that have them.
    """
    middles = {s: (low + high) / 2 for s, (low, high) in ranges.items()}
    found: dict[Symbol, dict[float, None]] = {}
    for node in nodes:
        if node.is_Add and node.free_symbols:
            for symbol, size in _balances(node, middles):
                found.setdefault(symbol, {})[size] = None
    return {s: tuple(found[s])[:_MOST] for s in symbols if s in found and s not in ranges}


def _balances(node: Expr, middles: Mapping[Symbol, float]) -> Iterator[tuple[Symbol, float]]:
    constant = sum(_number(term, middles) for term in node.args)
    if constant == 0 or not math.isfinite(constant):
        return
    for term in node.args:
        factor = abs(math.prod(_number(part, middles) or 1.0 for part in _factors(term)))
        for part in _factors(term):
            symbol, power = part.as_base_exp()
            if symbol.is_Symbol and symbol not in middles and power.is_Rational and power > 0:
                size = _root(abs(constant), factor, float(power))
                if 0 < size < math.inf:
                    yield symbol, size


def _root(constant: float, factor: float, power: float) -> float:
    try:
        return math.exp((math.log(constant) - math.log(factor)) / power)
    except (OverflowError, ValueError):
        return 0.0


def _factors(term: Expr) -> tuple[Expr, ...]:
    return term.args if term.is_Mul else (term,)


def _number(term: Expr, middles: Mapping[Symbol, float]) -> float:
    """Value of a term of numbers and bounded symbols, in the middle of the bounds; 0 for any other."""
    if not term.free_symbols <= middles.keys():
        return 0.0
    try:
        return float(term.subs({s: middles[s] for s in term.free_symbols}))
    except (OverflowError, TypeError, ValueError):
        return 0.0


def at_landmarks(
    points: Array, symbols: Sequence[Symbol], sizes: Mapping[Symbol, Sequence[float]], rng: np.random.Generator
) -> Array:
    """The points (m, n), with most of the coordinates that have landmarks drawn anew, up to about these sizes."""
    out = points.copy()
    for k, symbol in enumerate(symbols):
        if symbol in sizes:
            new = rng.choice(np.array(sizes[symbol]), size=len(points)) * rng.uniform(-_BEYOND, _BEYOND, len(points))
            out[:, k] = np.where(rng.random(len(points)) < _SHARE, new, points[:, k])
    return out
