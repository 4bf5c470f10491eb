"""Where a real expression may become another function: its folds, and points on both sides of them.

A real expression is analytic but where what stands under a root, in a logarithm or under a real power is zero: on
either side of such a *fold* it may be another function. And functions such as tanh(1000 x) or exp(−1000 (x − 7)²) say
all they have to say near the zeros of their arguments. So these places are sought, along straight lines, and both sides
of them sampled.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np
import sympy
from numpy.typing import NDArray
from sympy import Expr, Symbol

from core.symbolic.tape import Floats, Tape

__all__ = ["folds", "near_folds", "signs_at_folds"]

Array = NDArray[np.float64]

_LINES, _PLACES = 48, 25  #: lines along which folds are sought, and places on each of them
_MOST_FOLDS, _MOST_MINIMA = 16, 12  #: folds that are sought, and places on each of them that are kept
_HALVINGS = 26  #: golden sections of a bracket: to 4e-6 of its length
_GOLDEN = (5**0.5 - 1) / 2
_OFFSETS = (0.0, 1e-4, -1e-4, 1e-2, -1e-2, 0.3, -0.3)  #: from a fold, in lengths of the bracket


def folds(tape: Tape) -> list[Expr]:
    """What stands under roots and real powers and in logarithms; then the arguments of functions that level off."""
    kinks = dict.fromkeys(u for node in tape.nodes if node.free_symbols for u in _kinks(node))
    steps = dict.fromkeys(u for node in tape.nodes if node.free_symbols for u in _steps(node))
    return list(kinks | steps)[:_MOST_FOLDS]


def _kinks(node: Expr) -> Iterator[Expr]:
    if node.is_Pow and not node.exp.is_Integer and node.base.free_symbols:
        yield node.base
    elif isinstance(node, sympy.log):
        yield node.args[0]


def _steps(node: Expr) -> Iterator[Expr]:
    if isinstance(node, sympy.exp | sympy.sinh | sympy.cosh | sympy.tanh):
        yield node.args[0]
    elif node.is_Pow and node.exp.free_symbols:
        yield node.exp


def signs_at_folds(found: Iterable[Expr]) -> list[Expr]:
    """Expressions whose signs tell the sides of folds apart: of (x − 1)² y that are x − 1 and y."""
    return list(dict.fromkeys(v for u in found for v in _factors(u)))


def _factors(u: Expr) -> Iterator[Expr]:
    if u.is_Mul:
        for factor in u.args:
            yield from _factors(factor)
    elif u.is_Pow and u.exp.is_Rational:
        yield from _factors(u.base)
    elif u.free_symbols:
        yield u


def near_folds(found: Sequence[Expr], symbols: Sequence[Symbol], points: Array, rng: np.random.Generator) -> Array:
    """Points on lines between given ones, at and beside the places where one of `found` is least in size.

    That is so at its zeros, whether it changes its sign there or only touches zero, as (x − 1)² does.
    """
    tape = Tape(found)
    places = [tape.place[u] for u in found]
    far = np.argsort(np.abs(points).max(axis=1))[len(points) // 2 :]  # a line is to lead past what is not near zero
    start, end = points[rng.integers(len(points), size=_LINES)], points[rng.choice(far, size=_LINES)]

    def sizes(origin: Array, step: Array) -> list[Array]:
        """|u| of every fold, at origin + step."""
        at = dict(zip(symbols, np.moveaxis(origin + step, -1, 0), strict=True))
        with np.errstate(all="ignore"):
            values = tape.run(Floats(), at)
        return [np.abs(np.broadcast_to(values[k], origin.shape[:-1])) for k in places]

    parts = np.linspace(0.0, 1.0, _PLACES)
    shape = (_LINES, _PLACES, len(symbols))
    along = sizes(np.broadcast_to(start[:, None], shape), parts[:, None] * (end - start)[:, None])
    brackets = [(k, *where) for k, u in enumerate(along) for where in _minima(u)]
    if not brackets:
        return points[:0]
    which, lines, middles = np.array(brackets).T
    origin, direction = start[lines], (end - start)[lines]
    rows = np.arange(len(which))

    def size(s: Array) -> Array:
        values: Array = np.stack(sizes(origin, s[:, None] * direction))[which, rows]
        return values

    width = parts[1]
    at = _least(size, parts[middles] - width, parts[middles] + width)
    sides = at[:, None] + width * np.array(_OFFSETS)
    beside: Array = origin[:, None] + np.clip(sides, 0.0, 1.0)[..., None] * direction[:, None]
    return beside.reshape(-1, len(symbols))


def _minima(sizes: Array) -> list[tuple[int, int]]:
    """Where, (line, place), a size is less than at both neighbours; not all of them."""
    left, middle, right = sizes[:, :-2], sizes[:, 1:-1], sizes[:, 2:]
    lines, places = np.nonzero((middle <= left) & (middle <= right) & np.isfinite(left + right))
    every = max(1, len(lines) // _MOST_MINIMA)
    return list(zip(lines[::every].tolist(), (places[::every] + 1).tolist(), strict=True))[:_MOST_MINIMA]


def _least(size: Callable[[Array], Array], low: Array, high: Array) -> Array:
    """Where a function is least between bounds, by golden sections, for many at once."""
    first, second = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    at_first, at_second = size(first), size(second)
    for _ in range(_HALVINGS):
        left = at_first <= at_second
        low, high = np.where(left, low, first), np.where(left, second, high)
        new = np.where(left, high - _GOLDEN * (high - low), low + _GOLDEN * (high - low))
        at_new = size(new)
        first, second = np.where(left, new, second), np.where(left, first, new)
        at_first, at_second = np.where(left, at_new, at_second), np.where(left, at_first, at_new)
    middle: Array = (low + high) / 2
    return middle
