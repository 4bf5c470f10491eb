"""Where a real expression may change from one analytic function to another: its folds, and points on both sides.

A real expression is analytic except where the argument of a root, a logarithm or a real power is zero: on either side
of such a *fold* it may be another analytic function. Functions such as tanh(1000 x) or exp(−1000 (x − 7)²) vary only
near the zeros of their arguments. These zeros are sought along straight lines, and both sides of them are sampled: on
lines between any two points, and on lines along one coordinate, on which all others keep values that the whole has.
Some of the latter lead on to all sizes, as the region may lie anywhere.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

import numpy as np
import sympy
from numpy.typing import NDArray
from sympy import Expr, Symbol

from core.symbolic.tape import Floats, Tape

__all__ = ["folds", "layers", "near_folds", "signs_at_folds"]

Array = NDArray[np.float64]
#: Points and directions, (lines, n) each, and the multiples (lines, places) of these that lead to points on a line.
Lines = tuple[Array, Array, Array]

#: Number of straight lines in any direction along which folds are sought.
_LINES = 96
#: Number of lines along each coordinate of which a fold depends.
_LINES_ALONG = 96
#: Range of the size of both ends of such a line, whose logarithm is uniform; a symbol with bounds has these as ends.
_REACH = (2.0, 50.0)
#: Every so many of these lines is wide: it leads on to all sizes, with points ever farther from the given one.
_WIDE = 3
#: Range of the distances of the points on a wide line from the given one.
_DISTANCES = (1e-3, 1e6)
#: Number of points on each line, equally spaced unless it is wide.
_PLACES = 25
#: Most folds that are sought, in the order of `folds`.
_MOST_FOLDS = 16
#: Most denominators and factors in them whose minima are sought.
_MOST_LAYERS = 8
#: Most local minima of |u| that are kept for each fold u, over all lines.
_MOST_MINIMA = 24
#: Golden sections of a bracket: they narrow it to 1e-10 of its length, so that a narrow layer about a zero is met.
_SECTIONS = 48
#: Size given to u beyond the domain, where it is least at the surface.
_BEYOND = 1e200
#: Largest distance from the domain, as a value of g, that this size tells of.
_FARTHEST = 1e100
#: Part of a bracket that one golden section keeps.
_GOLDEN = (5**0.5 - 1) / 2
#: Points sampled at a fold and on both sides of it, as parts of half its bracket: a layer about it may be of any width.
_OFFSETS = (0.0, *(sign * 0.3 * 10.0**-k for k in range(11) for sign in (1, -1)))


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


def layers(tape: Tape) -> list[Expr]:
    """Factors of the terms of denominators, and these: 1/(1 + (1000 x)⁸) differs from 0 in a layer next to x = 0 only.

    The fraction is the same analytic function on both sides.
    """
    poles = dict.fromkeys(u.base for u in tape.nodes if u.is_Pow and u.exp.is_Integer and u.exp < 0)
    sums = [u for u in poles if u.is_Add and u.free_symbols]
    powers = [v for u in sums for term in u.args for v in _factors(term)]
    return list(dict.fromkeys([*(v for v in powers if v.is_Add), *sums]))[:_MOST_LAYERS]


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


def near_folds(
    found: Sequence[Expr],
    symbols: Sequence[Symbol],
    ranges: Mapping[Symbol, tuple[float, float]],
    positive: Sequence[Expr],
    points: Array,
    rng: np.random.Generator,
) -> Array:
    """Points on lines through given ones, at and on both sides of the local minima of |u| for each u in `found`.

    These include the zeros of u, whether its sign changes there or not, as with (x − 1)².

    Parameters
    ----------
    found
        Folds, as from `folds`.
    symbols
        n symbols, in the order of the coordinates.
    ranges
        Bounds of the symbols that have them.
    positive
        Expressions that should be positive: minima next to which they are not are taken only if there is no other.
    points
        (m, n) points with which lines begin, or which they pass along one coordinate.

    Returns
    -------
    (k, n) points.
    """
    tape = Tape((*found, *positive))
    places = [tape.place[u] for u in found]
    names = set().union(*(u.free_symbols for u in found))
    along = [_lines_along(k, ranges.get(s), points, rng) for k, s in enumerate(symbols) if s in names]
    start, direction, parts = _joined([_lines_between(points, rng), *along])

    def values(at: Array) -> list[Array]:
        """Values of all nodes at points (..., n)."""
        with np.errstate(all="ignore"):
            nodes = tape.run(Floats(), dict(zip(symbols, np.moveaxis(at, -1, 0), strict=True)))
        return [np.broadcast_to(v, at.shape[:-1]) for v in nodes]

    on_lines = values(start[:, None] + parts[..., None] * direction[:, None])
    inside = np.ones(parts.shape, dtype=bool)
    for u in positive:
        inside &= on_lines[tape.place[u]] > 0
    brackets = [(k, *where) for k in places for where in _minima(on_lines[k], inside)]
    if not brackets:
        return points[:0]
    which, lines, middles = np.array(brackets).T
    origin, direction = start[lines], direction[lines]
    rows = np.arange(len(which))

    def size(s: Array) -> Array:
        """|u|; beyond the domain a huge value, which leads back to it."""
        nodes = values(origin + s[:, None] * direction)
        found: Array = np.abs(np.stack(nodes)[which, rows])
        for u in positive:
            height = nodes[tape.place[u]]
            found = np.where(height <= 0, _BEYOND * (1.0 - np.clip(height, -_FARTHEST, 0.0)), found)
        return found

    low, high = parts[lines, middles - 1], parts[lines, middles + 1]
    at = _least(size, low, high)
    sides = at[:, None] + ((high - low) / 2)[:, None] * np.array(_OFFSETS)
    sides = np.clip(sides, parts[lines, :1], parts[lines, -1:])
    beside: Array = origin[:, None] + sides[..., None] * direction[:, None]
    return beside.reshape(-1, len(symbols))


def _joined(groups: Sequence[Lines]) -> Lines:
    start, direction, parts = (np.concatenate(arrays) for arrays in zip(*groups, strict=True))
    return start, direction, parts


def _lines_between(points: Array, rng: np.random.Generator) -> Lines:
    """Lines between two of the points, every other of which leads far from zero."""
    far = np.argsort(np.abs(points).max(axis=1))[len(points) // 2 :]  # so that a line passes folds that are not near 0
    any_two = rng.integers(len(points), size=(2, _LINES))  # so that there are values along a line
    ends = np.where(np.arange(_LINES) % 2 == 0, rng.choice(far, size=_LINES), any_two[1])
    return _from_ends(points[any_two[0]], points[ends])


def _from_ends(start: Array, end: Array) -> Lines:
    return start, end - start, np.tile(np.linspace(0.0, 1.0, _PLACES), (len(start), 1))


def _lines_along(k: int, bounds: tuple[float, float] | None, points: Array, rng: np.random.Generator) -> Lines:
    """Lines along coordinate k, through some of the points.

    A fold of few of many coordinates is met there at points where the rest of an expression is as ordinary as it is at
    the given ones. A line in any direction rarely does so: most of its length belongs to the farthest coordinate.
    """
    low, high = np.log(_REACH)
    sizes = np.exp(low + (high - low) * rng.random((2, _LINES_ALONG)))
    through = points[rng.integers(len(points), size=_LINES_ALONG)]
    ends = np.repeat(through[None], 2, axis=0)
    ends[..., k] = np.stack([-sizes[0], sizes[1]]) if bounds is None else np.array(bounds)[:, None]
    start, direction, parts = _from_ends(*ends)
    if bounds is None:
        wide = np.arange(_LINES_ALONG) % _WIDE == 0
        start[wide] = through[wide]
        direction[wide] = np.arange(points.shape[1]) == k
        parts[wide] = _distances(np.abs(through[wide, k]), rng)
    return start, direction, parts


def _distances(sizes: Array, rng: np.random.Generator) -> Array:
    """Distances (lines, places), before and behind, to points on wide lines; the farthest are beyond the sizes."""
    low, high = np.log(_DISTANCES[0]), np.log(np.maximum(_DISTANCES[1], _WIDE * sizes))
    count = _PLACES // 2
    steps = (np.arange(count) + rng.random((len(sizes), 1))) / count
    ahead = np.exp(low + (high[:, None] - low) * steps)
    return np.concatenate([-ahead[:, ::-1], np.zeros((len(sizes), 1)), ahead], axis=1)


def _minima(values: Array, inside: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """Yield indices (line, place) of local minima of |values|, at most `_MOST_MINIMA`; a constant has none.

    First come, in equal shares, those between places of use with a change of sign, those with a change of sign, and
    all. Each share is thinned evenly.

    Parameters
    ----------
    inside
        (lines, places) where a minimum is of use; those next to no such place are taken only if there is no other.
    """
    sizes = np.abs(values)
    left, middle, right = sizes[:, :-2], sizes[:, 1:-1], sizes[:, 2:]
    known = np.isfinite(left) & np.isfinite(right)
    least = (middle <= left) & (middle <= right) & ((middle < left) | (middle < right)) & known
    of_use = least & (inside[:, :-2] | inside[:, 1:-1] | inside[:, 2:])
    best = of_use if of_use.any() else least
    changes = (values[:, :-1] > 0) != (values[:, 1:] > 0)
    between = changes & inside[:, :-1] & inside[:, 1:]
    kept: dict[int, None] = {}
    for share, kind in enumerate((between[:, :-1] | between[:, 1:], changes[:, :-1] | changes[:, 1:], True)):
        found = np.flatnonzero(best & kind)
        count = min(len(found), _MOST_MINIMA * (share + 1) // 3 - len(kept))
        kept |= dict.fromkeys(found[np.linspace(0, len(found) - 1, count).astype(np.int64)].tolist())
    for k in kept:
        yield k // least.shape[1], k % least.shape[1] + 1


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
