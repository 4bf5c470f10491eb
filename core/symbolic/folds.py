"""Where a real expression may change from one analytic function to another: its folds, and points on both sides.

A real expression is analytic except where the argument of a root, a logarithm or a real power is zero: on either side
of such a *fold* it may be another analytic function. Functions such as tanh(1000 x) or exp(−1000 (x − 7)²) vary only
near the zeros of their arguments. These zeros are sought along straight lines, and both sides of them are sampled.
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

#: Number of straight lines along which folds are sought.
_LINES = 96
#: Number of equally spaced points on each line.
_PLACES = 25
#: Most folds that are sought, in the order of `folds`.
_MOST_FOLDS = 16
#: Most local minima of |u| that are kept for each fold u, over all lines.
_MOST_MINIMA = 24
#: Golden sections of a bracket: they narrow it to 1e-10 of its length, so that a narrow layer about a zero is met.
_SECTIONS = 48
#: Part of a bracket that one golden section keeps.
_GOLDEN = (5**0.5 - 1) / 2
#: Points sampled at a fold and on both sides of it, as distances in units of the spacing of points on a line.
_OFFSETS = (0.0, 1e-4, -1e-4, 1e-2, -1e-2, 0.3, -0.3)


def folds(tape: Tape) -> list[Expr]:
    """Arguments of roots, real powers and logarithms; then those of exponentials and hyperbolic functions."""
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
    """Expressions whose signs tell the sides of folds apart: x − 1 and y for (x − 1)² y."""
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
    """Points on lines between given ones, at and on both sides of the local minima of |u| for each u in `found`.

    These include the zeros of u, whether its sign changes there or not, as with (x − 1)².

    Parameters
    ----------
    found
        Folds, as from `folds`.
    symbols
        n symbols, in the order of the coordinates.
    points
        (m, n) points; half of the lines lead from any of them to those far from zero, half to any others.

    Returns
    -------
    (k, n) points.
    """
    tape = Tape(found)
    places = [tape.place[u] for u in found]
    far = np.argsort(np.abs(points).max(axis=1))[len(points) // 2 :]  # so that a line passes folds that are not near 0
    any_two = rng.integers(len(points), size=(2, _LINES))  # so that there are values along a line
    ends = np.where(np.arange(_LINES) % 2 == 0, rng.choice(far, size=_LINES), any_two[1])
    start, end = points[any_two[0]], points[ends]

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
    """Indices (line, place) of local minima, evenly thinned to `_MOST_MINIMA`."""
    left, middle, right = sizes[:, :-2], sizes[:, 1:-1], sizes[:, 2:]
    lines, places = np.nonzero((middle <= left) & (middle <= right) & np.isfinite(left + right))
    every = max(1, len(lines) // _MOST_MINIMA)
    return list(zip(lines[::every].tolist(), (places[::every] + 1).tolist(), strict=True))[:_MOST_MINIMA]


def _least(size: Callable[[Array], Array], low: Array, high: Array) -> Array:
    """Minima of many functions at once between bounds, by golden section search."""
    first, second = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    at_first, at_second = size(first), size(second)
    for _ in range(_SECTIONS):
        left = at_first <= at_second
        low, high = np.where(left, low, first), np.where(left, second, high)
        new = np.where(left, high - _GOLDEN * (high - low), low + _GOLDEN * (high - low))
        at_new = size(new)
        first, second = np.where(left, new, second), np.where(left, first, new)
        at_first, at_second = np.where(left, at_new, at_second), np.where(left, at_first, at_new)
    middle: Array = (low + high) / 2
    return middle
