"""Points at which expressions are evaluated: in every orthant, near zero and far out, on both sides of every fold."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice, zip_longest
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sympy import Expr, Symbol

from core.symbolic.folds import folds, layers, near_folds, signs_at_folds
from core.symbolic.landmarks import at_landmarks, landmarks
from core.symbolic.tape import Floats, Tape, digits, growing_argument

__all__ = ["Domain", "Samples"]

Array = NDArray[np.float64]
Rows = NDArray[np.int64]
Point = dict[Symbol, float]

#: Range of the size of an ordinary coordinate; in this and the following ranges its logarithm is uniform.
_ORDINARY = (0.3, 2.0)
#: Range of the size of a coordinate near 0.
_NEAR = (1e-6, 0.3)
#: Range of the size of a coordinate far from 0.
_FAR = (2.0, 50.0)
#: Range of the size of a coordinate very far from 0.
_FARTHEST = (50.0, 1e6)
#: Logarithms of these ranges, (4, 2).
_SIZES = np.log([_ORDINARY, _NEAR, _FAR, _FARTHEST])
#: Probabilities of the four ranges for a coordinate of a point of mixed sizes.
_SHARES = (0.5, 0.25, 0.2, 0.05)

#: Decimal digits in which an expression is evaluated.
_DIGITS = 120
#: Decimal digits in which a value is confirmed: a difference between the two is round-off.
_MORE_DIGITS = 480
#: Size of the arguments of exp, tanh, … up to which the points are preferred: there 1 − tanh(u) keeps digits.
_TELLING = 60.0
#: Largest size of such arguments where no preferred point of a piece has a value: beyond it evaluation takes too long.
_LARGEST = 1e6

#: Relative perturbation of a coordinate, 64 roundings: values that change much by it are round-off.
_PERTURBATION = 2.0**-46
#: Number of points drawn at a time.
_DRAWN = 384
#: Most times that points are drawn.
_ROUNDS = 4
#: Number of points with finite values after which no more are drawn.
_ENOUGH = 24
#: Least number of points that are evaluated in many digits, where long expressions allow it.
_FEW = 6
#: Largest number of such points.
_MOST = 40
#: Number of such points wanted in each piece of the domain.
_EACH = 2
#: Most operations in many digits: it bounds the number of such points for a long expression.
_EFFORT = 20_000
#: Number of such points for the longest expressions.
_LEAST = 3
#: Number of points tried in many digits where no point has a value in floating point.
_ATTEMPTS = 40
#: Number of operations beyond which the folds of an expression are not sought, to save time.
_LONG = 2000


@dataclass(frozen=True)
class Domain:
    """The set of points at which something has to hold: all that satisfy the conditions below."""

    ranges: Mapping[Symbol, tuple[float, float]] = field(default_factory=dict)
    """Bounds of the symbols that have them."""
    positive: tuple[Expr, ...] = ()
    """Expressions that are positive in the domain: −g or g, on a side of the surface."""
    defined: tuple[Expr, ...] = ()
    """Expressions that have real, finite values in the domain."""

    def __hash__(self) -> int:
        return hash((frozenset(self.ranges.items()), self.positive, self.defined))

    def contains(self, point: Point) -> bool:
        """Whether a point is within the ranges."""
        return all(self.ranges[s][0] <= v <= self.ranges[s][1] for s, v in point.items() if s in self.ranges)


class Samples:
    """Points of a domain at which some expressions have real, finite values.

    Parameters
    ----------
    thorough
        Whether to sample both sides of folds in any case; otherwise only if few points are found without.

    Attributes
    ----------
    points
        (n, number of symbols) points at which all values are finite in floating point.
    nodes
        Values of all nodes of the tape at the points, (n,) each.
    inside
        How many of the points tried lie in the domain.
    unreal
        At how many of these an expression has no real value, as log(−1).
    """

    def __init__(self, expressions: Sequence[Expr], domain: Domain, thorough: bool = True) -> None:
        self.domain = domain
        guards = [*domain.defined, *domain.positive]
        self.symbols = sorted(set().union(*(u.free_symbols for u in (*expressions, *guards))), key=str)
        self.tape = Tape(expressions)
        short = len(self.tape.nodes) <= _LONG
        self.folds = folds(self.tape) if short else []
        self._layers = layers(self.tape) if short else []
        self._wanted = [self.tape.place[u] for u in expressions]
        self._guards = [self.tape.add(u) for u in guards]
        self._landmarks = landmarks(self.tape.nodes, self.symbols, domain.ranges) if short else {}
        self._rng = np.random.default_rng(20260101)
        self._rng_at_landmarks = np.random.default_rng(20260102)
        self.inside = self.unreal = 0
        self.points, self.nodes = self._find(thorough)

    # In floating point -----------------------------------------------------------------------------------------------

    def _find(self, thorough: bool) -> tuple[Array, list[Array]]:
        tried = self._drawn()
        points, nodes = self._with_values(tried)
        for _ in range(_ROUNDS - 1):
            if len(points) >= _ENOUGH or not self.symbols:
                break
            tried = self._drawn()
            points, nodes = self._joined((points, nodes), self._with_values(tried))
        few = len(points) < _ENOUGH
        sought = [*signs_at_folds(self.folds), *self._layers] if thorough or few else []
        if few:
            sought = [*sought, *self.domain.positive]
        if sought and self.symbols:
            start = points if len(points) > 1 else tried
            near = near_folds(sought, self.symbols, self.domain.ranges, self.domain.positive, start, self._rng)
            points, nodes = self._joined((points, nodes), self._with_values(near))
        return points, nodes

    def _drawn(self) -> Array:
        """Points of all sizes, then as many whose coordinates are of the sizes that the expressions name."""
        points = drawn(_DRAWN, self.symbols, self.domain.ranges, self._rng)
        if not self._landmarks:
            return points
        return np.concatenate([points, at_landmarks(points, self.symbols, self._landmarks, self._rng_at_landmarks)])

    def _with_values(self, points: Array) -> tuple[Array, list[Array]]:
        """Those of the points that lie in the domain and have finite values, and the values of all nodes there."""
        with np.errstate(all="ignore"):
            found = self.tape.run(Floats(), dict(zip(self.symbols, points.T, strict=True)))
        nodes = [np.broadcast_to(v, len(points)) for v in found]
        inside = np.ones(len(points), dtype=bool)
        for k in self._guards:
            inside &= np.isfinite(nodes[k])
        for u in self.domain.positive:
            inside &= nodes[self.tape.place[u]] > 0
        self.inside += int(inside.sum())
        wanted = np.stack([nodes[k] for k in self._wanted])
        self.unreal += int((inside & np.isnan(wanted).any(axis=0)).sum())
        good = inside & np.isfinite(wanted).all(axis=0)
        return points[good], [v[good] for v in nodes]

    @staticmethod
    def _joined(a: tuple[Array, list[Array]], b: tuple[Array, list[Array]]) -> tuple[Array, list[Array]]:
        return np.concatenate([a[0], b[0]]), [np.concatenate(pair) for pair in zip(a[1], b[1], strict=True)]

    def signs(self) -> dict[Expr, Array]:
        """Signs, at the points, of the symbols and of the expressions that tell the sides of folds apart."""
        apart = signs_at_folds(self.folds)
        tape = Tape(apart)
        with np.errstate(all="ignore"):
            found = tape.run(Floats(), dict(zip(self.symbols, self.points.T, strict=True)))
        columns = dict(zip(self.symbols, self.points.T, strict=True)) | {u: found[tape.place[u]] for u in apart}
        return {u: np.sign(np.broadcast_to(v, len(self.points))) for u, v in columns.items()}

    def _arguments(self) -> Array:
        """At each point, the largest size of an argument of exp, sinh, cosh or tanh."""
        found = [np.zeros(len(self.points))]
        with np.errstate(all="ignore"):
            for u in self.tape.nodes:
                if (argument := growing_argument(u)) is not None:
                    values = [self.nodes[self.tape.place[a]] for a in argument]
                    found.append(np.abs(values[0] * np.log(values[1]) if len(values) == 2 else values[0]))
        largest: Array = np.max(found, axis=0)
        return largest

    def _pieces(self) -> Rows:
        """Number of the piece in which each point lies: pieces differ in signs of folds, or of symbols in these."""
        apart = signs_at_folds(self.folds)
        names = {s for u in apart for s in u.free_symbols}
        columns = [sign for u, sign in self.signs().items() if u in apart or u in names]
        if not columns:
            return np.zeros(len(self.points), dtype=int)
        return np.unique(np.stack(columns, axis=1), axis=0, return_inverse=True)[1].reshape(-1)

    # In many digits --------------------------------------------------------------------------------------------------

    def point(self, row: int) -> Point:
        """Symbol -> coordinate, for the point in a row of `points`."""
        return self._mapping(self.points[row])

    def _mapping(self, numbers: Array) -> Point:
        return dict(zip(self.symbols, numbers.tolist(), strict=True))

    def in_digits(self, point: Point, more: bool = False, largest: float = _LARGEST) -> list[Any] | None:
        """Values of all nodes of the tape at a point, in many digits; None where one is undefined."""
        arithmetic = digits(_MORE_DIGITS if more else _DIGITS, largest)
        at = {s: arithmetic.context.mpf(v) for s, v in point.items()}
        try:
            values = self.tape.run(arithmetic, at)
        except (ArithmeticError, ValueError):
            return None
        return values if all(values[self.tape.place[u]] > 0 for u in self.domain.positive) else None

    def chosen(self, first: Rows) -> Iterator[tuple[Point, list[Any]]]:
        """Yield a few points, from every piece in turn, with the values of all nodes there in many digits.

        Parameters
        ----------
        first
            Rows of `points` to begin with.
        """
        pieces = self._pieces()
        telling = self._arguments() <= _TELLING
        rest = np.setdiff1d(np.arange(len(self.points)), first)
        order = _alternating(first, rest)
        order = np.concatenate([order[telling[order]], order[~telling[order]]])
        queues = [[self.point(r) for r in order[pieces[order] == k]] for k in range(pieces.max(initial=-1) + 1)]
        if not queues:
            queues = [[self._mapping(p) for p in self._drawn()[:_ATTEMPTS]]]
        wanted = min(_MOST, max(_FEW, _EACH * len(queues)), max(_LEAST, _EFFORT // len(self.tape.nodes)))
        tries = max(2 * wanted, _EFFORT // len(self.tape.nodes)) // len(queues) + 1
        found = [self._with_digits(queue[:tries]) for queue in queues]
        in_turn = (pair for pairs in zip_longest(*found) for pair in pairs if pair is not None)
        yield from islice(in_turn, wanted)

    def _with_digits(self, points: Sequence[Point]) -> Iterator[tuple[Point, list[Any]]]:
        """Yield the preferred points of a piece that have values in many digits, else the others, with these values."""
        for largest in (_TELLING, _LARGEST):
            some = False
            for point in points:
                values = self.in_digits(point, largest=largest)
                if values is not None:
                    some = True
                    yield point, values
            if some:
                return

    def perturbed(self) -> list[Array]:
        """Values of all nodes at slightly perturbed points: `nodes` that differ much from them are round-off."""
        with np.errstate(all="ignore"):
            beside = (self.points * (1.0 + _PERTURBATION)).T
            found = self.tape.run(Floats(), dict(zip(self.symbols, beside, strict=True)))
        return [np.broadcast_to(v, len(self.points)) for v in found]


def _alternating(first: Rows, second: Rows) -> Rows:
    """The entries of two arrays in turn, then the rest of the longer."""
    both = min(len(first), len(second))
    return np.concatenate([np.stack([first[:both], second[:both]], axis=1).reshape(-1), first[both:], second[both:]])


def drawn(
    count: int, symbols: Sequence[Symbol], ranges: Mapping[Symbol, tuple[float, float]], rng: np.random.Generator
) -> Array:
    """Random points (count, len(symbols)) of six kinds in turn.

    The sizes of their coordinates are: ordinary, with positive signs; mixed; near 0; far; ordinary; ordinary except one
    that is far.

    Parameters
    ----------
    ranges
        Bounds of the symbols that have them.
    """
    kinds = np.arange(count) % 6
    sizes = rng.choice(len(_SIZES), p=_SHARES, size=(count, len(symbols)))
    sizes[(kinds == 0) | (kinds == 4) | (kinds == 5)] = 0
    sizes[kinds == 2] = 1
    lone = np.flatnonzero(kinds == 5)
    if symbols:
        sizes[lone, rng.integers(len(symbols), size=len(lone))] = 2
    sizes[kinds == 3] = rng.choice([2, 3], p=[0.7, 0.3], size=(np.sum(kinds == 3), len(symbols)))
    low, high = np.moveaxis(_SIZES[sizes], -1, 0)
    points: Array = np.exp(low + (high - low) * rng.random(sizes.shape))
    points *= np.where(kinds[:, None] == 0, 1.0, rng.choice([-1.0, 1.0], size=sizes.shape))
    for k, symbol in enumerate(symbols):
        if symbol in ranges:
            _redraw_outside(points[:, k], *ranges[symbol], rng)
    return points


def _redraw_outside(values: Array, low: float, high: float, rng: np.random.Generator) -> None:
    """Draw anew, in place, the values out of bounds: uniform, every other one uniform in its logarithm."""
    out = (values < low) | (values > high)
    parts = rng.random(values.size)
    even = low + (high - low) * parts
    if low * high > 0:
        even[::2] = np.clip(low * (high / low) ** parts[::2], low, high)
    values[out] = even[out]
