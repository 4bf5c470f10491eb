"""Test whether an expression is identically zero: by its values, in high precision, at points of every kind.

An analytic expression that vanishes at a random point is zero, with a probability of error that can be neglected
(Schwartz-Zippel); unlike symbolic simplification, the test takes bounded time. Expressions with roots, logarithms or
real powers are only piecewise analytic, so points are taken in every piece (`sampling`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import islice
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray
from sympy import Expr, Symbol

from core.symbolic.sampling import Domain, Samples
from core.symbolic.tape import Tape

__all__ = [
    "EVERYWHERE", "Counterexample", "Domain", "counterexample", "definite_sign", "has_values", "has_values_throughout",
    "independent", "is_larger", "is_zero", "size_expanded", "tidied",
]  # fmt: skip

Array = NDArray[np.float64]

#: Most terms of an expanded sum that `tidied` multiplies out.
_TIDIED_TERMS = 40
#: Most nodes of the tree of an expression that `tidied` multiplies out.
_TIDIED_NODES = 600
#: A value in 120 digits below this part of its terms is round-off; any other has to show in 480, too.
_ROUND_OFF = 1e-100
#: Values in 120 and in 480 digits whose relative difference is below this are not round-off.
_AGREE = 1e-3
#: A value in floating point below this part of the sizes of its terms is round-off.
_NOTHING = 1e-10
#: A value in floating point above this part of the sizes of its terms is not round-off.
_SOMETHING = 1e-6
#: A value whose relative change by a perturbation of some roundings is below this is not round-off.
_STEADY = 0.1
#: A row is dependent on others if its part orthogonal to them is below this part of the row: in 120 digits, in 480.
_DEPENDENT = (1e-40, 1e-160)
#: Largest argument of exp, tanh, … where a row counts as dependent: beyond it 480 digits may not show 1 − tanh(u)².
_SHOWN = 150.0
#: Number of points at which an expression seems to vanish that are looked at in more digits.
_CONFIRMED = 24
#: Number of points tried for a counterexample whose coordinates have three digits.
_PLAIN = 12

#: The domain without conditions.
EVERYWHERE = Domain()


@dataclass(frozen=True)
class Counterexample:
    """A point at which an expression does not vanish."""

    point: Mapping[Symbol, float]
    value: float
    partly: bool
    """Whether the expression vanishes elsewhere."""
    where: str | None
    """The inequality that holds exactly where it vanishes, if a simple one is found: ``x > 0``."""

    @property
    def scope(self) -> str:
        """Where the expression vanishes, in words."""
        return f"where {self.where} only" if self.where else "in some places only"

    def at(self) -> str:
        """The point, in words: x = -1.2, y = 0.7."""
        return ", ".join(f"{symbol} = {value:.10g}" for symbol, value in self.point.items())


@lru_cache(maxsize=256)
def is_zero(expression: Expr, domain: Domain = EVERYWHERE) -> bool:
    """Whether `expression` vanishes wherever it has a real value in a domain.

    Where no such point is found, only a symbolic zero counts.
    """
    if expression == 0:
        return True
    verdicts = _Residual(expression, domain).verdicts()
    first = next(verdicts, None)
    return first is not None and not first[1] and not any(fails for _, fails in verdicts)


@lru_cache(maxsize=256)  # the page asks first, and then the system that it makes
def counterexample(expression: Expr, domain: Domain = EVERYWHERE) -> Counterexample | None:
    """A point of a domain at which `expression` does not vanish; None where none is found."""
    return None if expression == 0 else _Residual(expression, domain).counterexample()


def has_values(expressions: Sequence[Expr], domain: Domain = EVERYWHERE) -> bool:
    """Whether expressions have real, finite values somewhere in a domain; True if no point of the domain is found."""
    samples = Samples(expressions, domain, thorough=False)
    return bool(len(samples.points)) or not samples.inside or next(samples.chosen(_NO_ROWS), None) is not None


def has_values_throughout(expression: Expr, domain: Domain = EVERYWHERE) -> bool:
    """Whether an expression is real at all points sampled in a domain."""
    return Samples((expression,), domain, thorough=False).unreal == 0


def independent(rows: sympy.Matrix, domain: Domain = EVERYWHERE) -> bool:
    """Whether the rows of a matrix of expressions are linearly independent in every piece of a domain."""
    samples = Samples(tuple(rows), domain)
    part = _least_singular_values(_scaled(rows, samples.tape, samples.nodes).astype(float))
    order = np.argsort(part, kind="stable")

    def dependent(values: Sequence[Any] | None, limit: float) -> bool:
        return values is not None and _rank_is_lost(_scaled(rows, samples.tape, values).tolist(), limit)

    def confirmed(point: Mapping[Symbol, float]) -> bool:
        return dependent(samples.in_digits(dict(point), more=True, largest=_SHOWN), _DEPENDENT[1])

    return not any(
        dependent(values, _DEPENDENT[0]) and confirmed(point)
        for point, values in samples.chosen(order[part[order] < _SOMETHING])
    )


_NO_ROWS: NDArray[np.int64] = np.zeros(0, dtype=np.int64)


def _scaled(rows: sympy.Matrix, tape: Tape, values: Sequence[Any]) -> NDArray[Any]:
    """The values of a matrix, (points, rows, columns) or (rows, columns), each row divided by the size of its terms.

    A row of round-off is then small; a row without terms is zero.
    """
    with np.errstate(all="ignore"):
        entries = [[values[tape.place[u]] for u in rows.row(i)] for i in range(rows.rows)]
        sizes = [sum(tape.size(u, values) for u in rows.row(i)) for i in range(rows.rows)]
        scaled = [[u / size for u in row] if np.any(size) else row for row, size in zip(entries, sizes, strict=True)]
        return np.moveaxis(np.array(scaled), (0, 1), (-2, -1))


def _least_singular_values(matrices: Array) -> Array:
    """The least singular value of each matrix; 0 where it has entries that are not finite."""
    known = np.isfinite(matrices).all(axis=(-2, -1))
    out = np.zeros(len(matrices))
    out[known] = np.linalg.svd(matrices[known], compute_uv=False)[:, -1]
    return out


def _rank_is_lost(rows: list[list[Any]], limit: float) -> bool:
    """Whether Gram-Schmidt orthogonalisation leaves a row shorter than the limit; rows are of size about 1."""
    kept: list[list[Any]] = []
    for row in rows:
        rest = row
        for _ in range(2):  # reorthogonalised once: "twice is enough" (Kahan, in Parlett 1980)
            for unit in kept:
                along = sum(a * b for a, b in zip(rest, unit, strict=True))
                rest = [a - along * b for a, b in zip(rest, unit, strict=True)]
        size = sum(a * a for a in rest)
        if size <= limit * limit:
            return True
        kept.append([a / size**0.5 for a in rest])
    return False


def _part_left(u: Expr, tape: Tape, values: Sequence[Any]) -> Any:
    """|u| relative to the sum of the absolute values of its terms; for a product, the product over its factors."""
    if u.is_Mul:
        return math.prod(_part_left(factor, tape, values) for factor in u.args)
    if not u.is_Add:
        return 1.0
    return abs(values[tape.place[u]]) / sum(abs(values[tape.place[term]]) for term in u.args)


class _Residual:
    """An expression that should vanish, and its values at the points of a domain."""

    def __init__(self, expression: Expr, domain: Domain) -> None:
        self.expression = expression
        self.samples = Samples((expression,), domain)
        self.place = self.samples.tape.place[expression]

    @cached_property
    def relative_size(self) -> Array:
        """|expression| at the points in floating point, relative to the sum of the sizes of its terms.

        nan where the value may be round-off: it is neither steady nor very small.
        """
        value = self.samples.nodes[self.place]
        with np.errstate(all="ignore"):
            part = np.abs(value) / self.samples.tape.size(self.expression, self.samples.nodes)
        return np.where(value == 0, 0.0, np.where(self.steady | (part < _NOTHING), part, np.nan))

    @cached_property
    def steady(self) -> NDArray[np.bool_]:
        """Whether the value at each point in floating point hardly changes by a perturbation of some roundings."""
        value, beside = self.samples.nodes[self.place], self.samples.perturbed()[self.place]
        with np.errstate(all="ignore"):
            steady: NDArray[np.bool_] = np.abs(beside - value) <= _STEADY * np.abs(value)
        return steady

    def doubt(self) -> Array:
        """How far the value at each point in floating point seems to be from zero, relative to its terms: 0 to 1.

        The sizes of terms bound round-off, and far too high where a power such as (1e6 x − 4e5)¹⁵ is of a difference:
        a steady value counts relative to the values of the terms.
        """
        with np.errstate(all="ignore"):
            part = _part_left(self.expression, self.samples.tape, self.samples.nodes)
            part = np.where(self.steady & (self.samples.nodes[self.place] != 0), part, 0.0)
        doubt: Array = np.fmax(np.nan_to_num(self.relative_size), np.nan_to_num(part))
        return doubt

    def verdicts(self) -> Iterator[tuple[dict[Symbol, float], bool]]:
        """Yield points, the largest residuals first, and whether the expression fails to vanish there."""
        doubt = self.doubt()
        order = np.argsort(-doubt, kind="stable")
        for point, values in self.samples.chosen(order[doubt[order] > _NOTHING]):
            yield point, self.fails(point, values)

    def fails(self, point: dict[Symbol, float], values: Sequence[Any]) -> bool:
        """Whether the value is not round-off: beyond the bound on that, and the same in more digits."""
        value = values[self.place]
        if value == 0 or _part_left(self.expression, self.samples.tape, values) <= _ROUND_OFF:
            return False
        more = self.samples.in_digits(point, more=True)
        if more is None or more[self.place] == 0:
            return False
        return bool(abs(value / more[self.place] - 1) < _AGREE)

    def counterexample(self) -> Counterexample | None:
        failing = [point for point, fails in self.verdicts() if fails]
        if not failing:
            return None
        partly = self.vanishes_somewhere()
        where = self.separation() if partly else None
        for point in (*self.plain_points(), *failing):
            values = self.samples.in_digits(point)
            if values is not None and self.fails(point, values):
                return Counterexample(point, float(values[self.place]), partly, where)
        return None

    def vanishes_somewhere(self) -> bool:
        """Whether the expression vanishes at a point, in many digits: it may be small throughout, as rounding is."""
        rows = np.flatnonzero(self.relative_size < _NOTHING)
        rows = rows[np.argsort(self.relative_size[rows], kind="stable")]
        for row in rows[np.unique(np.linspace(0, len(rows) - 1, _CONFIRMED).astype(int))] if len(rows) else ():
            point = self.samples.point(row)
            values = self.samples.in_digits(point)
            if values is not None and not self.fails(point, values):
                return True
        return False

    def plain_points(self) -> Iterator[dict[Symbol, float]]:
        """Yield points of moderate size, in three digits, near which the expression is clearly not zero."""
        rows = np.flatnonzero(self.relative_size > _SOMETHING)
        with np.errstate(all="ignore"):
            far = np.abs(np.log(np.abs(self.samples.points[rows]))).sum(axis=1) - np.log(self.relative_size[rows])
        for row in rows[np.argsort(far, kind="stable")[:_PLAIN]]:
            point = {symbol: float(f"{value:.3g}") for symbol, value in self.samples.point(row).items()}
            if self.samples.domain.contains(point):
                yield point

    def separation(self) -> str | None:
        """The inequality between where the expression vanishes and where it does not."""
        good, bad = self.relative_size < _NOTHING, self.relative_size > _SOMETHING
        for u, sign in self.samples.signs().items():
            for relation, s in ((">", 1.0), ("<", -1.0)):
                if good.any() and bad.any() and (sign[good] == s).all() and (sign[bad] != s).all():
                    return f"{u} {relation} 0"
        return None


def tidied(expression: sympy.Expr) -> sympy.Expr:
    """Return `expression`, multiplied out where that makes it shorter; a large one is returned as it is.

    This is not `sympy.simplify`, which can take minutes for a line of text.
    """
    if is_larger(expression, _TIDIED_NODES) or size_expanded(expression) > _TIDIED_TERMS:
        return expression
    out = sympy.expand(expression)
    return out if sympy.count_ops(out) < sympy.count_ops(expression) else expression


def is_larger(expression: sympy.Basic, nodes: int) -> bool:
    """Whether the tree of an expression has more than `nodes` nodes; the rest of it is not visited."""
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
        return max(sizes[0], math.comb(sizes[0] + power - 1, power))
    return max(sizes, default=1)


def definite_sign(u: Expr) -> str:
    """Return "positive", "negative", "nowhere negative" or "nowhere positive", if the terms of a sum show that."""
    signs, never_zero = set(), False
    for term in sympy.Add.make_args(u):
        factors = sympy.Mul.make_args(term)
        number = sympy.Mul(*[one for one in factors if one.is_number])
        rest = [one for one in factors if not one.is_number]
        if not (number.is_real and all(map(_is_nonnegative, rest))):
            return ""
        signs.add(bool(number > 0))
        never_zero |= bool(number != 0) and all(map(_is_positive, rest))
    words = ("negative", "positive") if never_zero else ("nowhere positive", "nowhere negative")
    return words[signs.pop()] if len(signs) == 1 else ""


def _is_positive(factor: Expr) -> bool:
    return factor.func in (sympy.exp, sympy.cosh)


def _is_nonnegative(factor: Expr) -> bool:
    even = factor.is_Pow and factor.exp.is_integer and factor.exp.is_even
    return bool(even) or factor.func is sympy.Abs or _is_positive(factor)
