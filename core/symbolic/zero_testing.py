"""Is an expression identically zero? Decided by values, in high precision, at points of every kind.

An expression that is analytic, and vanishes at a random point, is zero with a probability that no user will live to see
fail (Schwartz-Zippel); unlike symbolic simplification this takes bounded time. What roots, logarithms and real powers
join together is analytic in pieces only, so points are taken in all of them (`sampling`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import islice
from math import comb
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray
from sympy import Expr, Symbol

from core.symbolic.sampling import Domain, Samples
from core.symbolic.tape import Tape

__all__ = [
    "EVERYWHERE", "Counterexample", "Domain", "counterexample", "has_values", "has_values_throughout", "independent",
    "is_larger", "is_zero", "size_expanded", "tidied",
]  # fmt: skip

_TIDIED_TERMS = 40  #: of a sum that is multiplied out
_TIDIED_NODES = 600

Array = NDArray[np.float64]

#: Of a value in 120 digits that is zero, in units of its terms: 70 of them may be lost on the way.
_ROUND_OFF = 1e-50
#: Two values that agree to this part of them are no round-off.
_AGREE = 1e-3
#: Relative to what its terms add up to without their signs, a value in floating point is round-off below the first of
#: these, and no round-off above the second.
_NOTHING, _SOMETHING = 1e-10, 1e-6
#: A value that changes by less than this part of it over some roundings of the point is no round-off.
_STEADY = 0.1
#: The part of a row that stands out of the others, relative to the row: of what is dependent, in 120 digits and in 480.
_DEPENDENT = (1e-40, 1e-160)
_PLAIN = 12  #: points that are tried for one that can be written in three digits

EVERYWHERE = Domain()


@dataclass(frozen=True)
class Counterexample:
    """A point at which an expression does not vanish."""

    point: Mapping[Symbol, float]
    value: float
    partly: bool
    """Whether it vanishes in other places."""
    where: str | None
    """The inequality that tells these places apart, if a simple one does: ``x > 0``."""

    @property
    def scope(self) -> str:
        """Where the expression vanishes, in words."""
        return f"where {self.where} only" if self.where else "in some places only"

    def at(self) -> str:
        """The point, in words: x = -1.2, y = 0.7."""
        return ", ".join(f"{symbol} = {value:.10g}" for symbol, value in self.point.items())


@lru_cache(maxsize=256)
def is_zero(expression: Expr, domain: Domain = EVERYWHERE) -> bool:
    """Whether `expression` vanishes wherever in a domain it has a real value.

    Where no such place is found only a symbolic zero counts.
    """
    if expression == 0:
        return True
    verdicts = _Residual(expression, domain).verdicts()
    first = next(verdicts, None)
    return first is not None and not first[1] and not any(fails for _, fails in verdicts)


@lru_cache(maxsize=256)  # the page asks, and then the system it makes
def counterexample(expression: Expr, domain: Domain = EVERYWHERE) -> Counterexample | None:
    """A point of a domain at which `expression` does not vanish; None where none is found."""
    return None if expression == 0 else _Residual(expression, domain).counterexample()


def has_values(expressions: Sequence[Expr], domain: Domain = EVERYWHERE) -> bool:
    """Whether expressions have real, finite values somewhere in a domain, if anything has."""
    samples = Samples(expressions, domain, thorough=False)
    return bool(len(samples.points)) or not samples.inside or next(samples.chosen(_NO_ROWS), None) is not None


def has_values_throughout(expression: Expr, domain: Domain = EVERYWHERE) -> bool:
    """Whether an expression is real wherever it was looked for in a domain."""
    return Samples((expression,), domain, thorough=False).unreal == 0


def independent(rows: sympy.Matrix, domain: Domain = EVERYWHERE) -> bool:
    """Whether the rows of a matrix of expressions are linearly independent in every piece of a domain."""
    samples = Samples(tuple(rows), domain)
    part = _standing_out(_scaled(rows, samples.tape, samples.nodes).astype(float))
    order = np.argsort(part, kind="stable")

    def dependent(values: Sequence[Any] | None, limit: float) -> bool:
        return values is not None and _rank_is_lost(_scaled(rows, samples.tape, values).tolist(), limit)

    return not any(
        dependent(values, _DEPENDENT[0]) and dependent(samples.in_digits(point, more=True), _DEPENDENT[1])
        for point, values in samples.chosen(order[part[order] < _SOMETHING])
    )


_NO_ROWS: NDArray[np.int64] = np.zeros(0, dtype=np.int64)


def _scaled(rows: sympy.Matrix, tape: Tape, values: Sequence[Any]) -> NDArray[Any]:
    """The values of a matrix, (points, rows, columns) or (rows, columns), rows in units of their terms.

    What is nothing but round-off is small then; what has no terms is zero.
    """
    with np.errstate(all="ignore"):
        entries = [[values[tape.place[u]] for u in rows.row(i)] for i in range(rows.rows)]
        sizes = [sum(tape.size(u, values) for u in rows.row(i)) for i in range(rows.rows)]
        scaled = [[u / size for u in row] if np.any(size) else row for row, size in zip(entries, sizes, strict=True)]
        return np.moveaxis(np.array(scaled), (0, 1), (-2, -1))


def _standing_out(matrices: Array) -> Array:
    """The least singular value of each matrix; 0 where it has none."""
    known = np.isfinite(matrices).all(axis=(-2, -1))
    out = np.zeros(len(matrices))
    out[known] = np.linalg.svd(matrices[known], compute_uv=False)[:, -1]
    return out


def _rank_is_lost(rows: list[list[Any]], limit: float) -> bool:
    """Whether Gram and Schmidt leave less than the limit of one of the rows."""
    kept: list[list[Any]] = []
    for row in rows:
        rest = row
        for _ in range(2):  # twice is enough
            for unit in kept:
                along = sum(a * b for a, b in zip(rest, unit, strict=True))
                rest = [a - along * b for a, b in zip(rest, unit, strict=True)]
        size = sum(a * a for a in rest)
        if size <= limit * limit:
            return True
        kept.append([a / size**0.5 for a in rest])
    return False


class _Residual:
    """An expression that ought to vanish, at the points of a domain."""

    def __init__(self, expression: Expr, domain: Domain) -> None:
        self.expression = expression
        self.samples = Samples((expression,), domain)
        self.place = self.samples.tape.place[expression]

    @cached_property
    def part(self) -> Array:
        """Its size at the points in floating point, relative to what its terms add up to without their signs.

        nan where the value is nothing but round-off.
        """
        value, beside = self.samples.nodes[self.place], self.samples.shaken()[self.place]
        with np.errstate(all="ignore"):
            part = np.abs(value) / self.samples.tape.size(self.expression, self.samples.nodes)
            steady = np.abs(beside - value) <= _STEADY * np.abs(value)
        return np.where(value == 0, 0.0, np.where(steady | (part < _NOTHING), part, np.nan))

    def verdicts(self) -> Iterator[tuple[dict[Symbol, float], bool]]:
        """Points, the doubtful first, and whether the expression fails to vanish there."""
        doubt = np.nan_to_num(self.part)
        order = np.argsort(-doubt, kind="stable")
        for point, values in self.samples.chosen(order[doubt[order] > _NOTHING]):
            yield point, self.fails(point, values)

    def fails(self, point: dict[Symbol, float], values: Sequence[Any]) -> bool:
        """Whether the value is no round-off: beyond its bounds, and the same in more digits."""
        value = values[self.place]
        if abs(value) <= _ROUND_OFF * self.samples.tape.size(self.expression, values):
            return False
        more = self.samples.in_digits(point, more=True)
        if more is None or more[self.place] == 0:
            return False
        return bool(abs(value / more[self.place] - 1) < _AGREE)

    def counterexample(self) -> Counterexample | None:
        failing = [point for point, fails in self.verdicts() if fails]
        if not failing:
            return None
        partly = bool((self.part < _NOTHING).any())
        where = self.separation() if partly else None
        for point in (*self.plain_points(), *failing):
            values = self.samples.in_digits(point)
            if values is not None and self.fails(point, values):
                return Counterexample(point, float(values[self.place]), partly, where)
        return None

    def plain_points(self) -> Iterator[dict[Symbol, float]]:
        """Points at which the expression is clearly not zero, of moderate size and in three digits."""
        rows = np.flatnonzero(self.part > _SOMETHING)
        with np.errstate(all="ignore"):
            far = np.abs(np.log(np.abs(self.samples.points[rows]))).sum(axis=1) - np.log(self.part[rows])
        for row in rows[np.argsort(far, kind="stable")[:_PLAIN]]:
            point = {symbol: float(f"{value:.3g}") for symbol, value in self.samples.point(row).items()}
            if self.samples.domain.contains(point):
                yield point

    def separation(self) -> str | None:
        """The inequality between where the expression vanishes and where it does not."""
        good, bad = self.part < _NOTHING, self.part > _SOMETHING
        for u, sign in self.samples.signs().items():
            for relation, s in ((">", 1.0), ("<", -1.0)):
                if good.any() and bad.any() and (sign[good] == s).all() and (sign[bad] != s).all():
                    return f"{u} {relation} 0"
        return None


def tidied(expression: sympy.Expr) -> sympy.Expr:
    """Return `expression` multiplied out where that makes it shorter; what is large is returned as it is.

    This is not `sympy.simplify`, which can take minutes for a line of text.
    """
    if is_larger(expression, _TIDIED_NODES) or size_expanded(expression) > _TIDIED_TERMS:
        return expression
    out = sympy.expand(expression)
    return out if sympy.count_ops(out) < sympy.count_ops(expression) else expression


def is_larger(expression: sympy.Basic, nodes: int) -> bool:
    """Whether the tree of an expression has more nodes than that; found without walking through all of it."""
    return next(islice(sympy.preorder_traversal(expression), nodes, None), None) is not None


def size_expanded(expression: sympy.Expr) -> int:
    """Bound the number of terms that `sympy.expand` would make of an expression or of any part of it."""
    sizes = [size_expanded(part) for part in expression.args]
    if expression.is_Add:
        return sum(sizes)
    if expression.is_Mul:
        return int(sympy.prod(sizes))
    if expression.is_Pow and expression.exp.is_Rational:
        power = abs(int(expression.exp))
        return max(sizes[0], comb(sizes[0] + power - 1, power))
    return max(sizes, default=1)
