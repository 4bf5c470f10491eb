"""Power series of expressions in one symbol about zero, with negative powers, and exact coefficients in the others."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import sympy
from sympy import Expr, Symbol

from core.symbolic.zero_testing import is_zero

__all__ = ["LONGEST", "NoSeries", "Series", "SeriesIn"]

#: Number of operations of a coefficient beyond which a series is given up, to save time.
LONGEST = 60


class NoSeries(Exception):  # noqa: N818 - the answer to a question, no error
    """An expression has no power series, or none of a moderate length is found."""


class Series(NamedTuple):
    """Σ coefficients[k] w^(first + k), where coefficients[0] does not vanish."""

    first: int
    coefficients: list[Expr]


class SeriesIn:
    """Finds the series of expressions in a symbol w, each once."""

    def __init__(self, w: Symbol, terms: int) -> None:
        self._w, self._terms = w, terms
        self._known: dict[Expr, Series] = {}

    def of(self, u: Expr) -> Series:
        """Return the series of an expression; raise `NoSeries` where it has none."""
        if u not in self._known:
            self._known[u] = self._led(self._derived(u))
        return self._known[u]

    def _derived(self, u: Expr) -> Series:
        n = self._terms
        if not u.has(self._w):
            return Series(0, [u, *[sympy.S.Zero] * (n - 1)])
        if u == self._w:
            return Series(1, [sympy.S.One, *[sympy.S.Zero] * (n - 1)])
        if u.is_Add:
            return _sum([self.of(v) for v in u.args])
        if u.is_Mul:
            total, *others = map(self.of, u.args)
            for other in others:
                total = Series(total.first + other.first, _product(total.coefficients, other.coefficients))
            return total
        if u.is_Pow and not u.exp.has(self._w):
            return self._power(self.of(u.base), u.exp)
        return self._function(type(u).__name__, self.of(u.args[0]))

    def _led(self, series: Series) -> Series:
        """The series without leading coefficients that vanish."""
        for k, c in enumerate(series.coefficients):
            if not is_zero(c):
                return Series(series.first + k, series.coefficients[k:])
        raise NoSeries  # zero, to all orders looked at

    def _power(self, base: Series, exponent: Expr) -> Series:
        """The power b = aᵖ with a b' = p a' b: k a₀ bₖ = Σ (p j − (k − j)) aⱼ bₖ₋ⱼ."""
        if base.first and not exponent.is_Integer:
            raise NoSeries
        a = base.coefficients
        b = [a[0] ** exponent]
        for k in range(1, len(a)):
            terms = ((exponent * j - (k - j)) * a[j] * b[k - j] for j in range(1, k + 1) if a[j] != 0)
            b.append(_tidy(sympy.Add(*terms) / (k * a[0])))
        return Series(base.first * int(exponent) if base.first else 0, b)

    def _function(self, name: str, argument: Series) -> Series:
        """A function of a series, by its differential equation."""
        if argument.first < 0:
            raise NoSeries
        a = [sympy.S.Zero] * argument.first + argument.coefficients
        a = a[: self._terms]
        if name == "exp":
            return Series(0, _moved([sympy.exp(a[0])], a, 1, (0,))[0])
        if name in ("sin", "cos", "sinh", "cosh"):
            h = "h" if name.endswith("h") else ""
            starts = [getattr(sympy, stem + h)(a[0]) for stem in ("sin", "cos")]
            return Series(0, _moved(starts, a, 1 if h else -1, (1, 0))[name.startswith("cos")])
        if name in ("tan", "tanh"):
            h = "h" if name.endswith("h") else ""
            above, below = (self._led(self._function(stem + h, argument)) for stem in ("sin", "cos"))
            under = self._power(below, sympy.S.NegativeOne)
            return Series(above.first + under.first, _product(above.coefficients, under.coefficients))
        if name == "log" and a[0] != 0:
            slope = _product([(k + 1) * c for k, c in enumerate(a[1:])], self._power(Series(0, a), -sympy.S.One)[1])
            return Series(0, [sympy.log(a[0]), *(_tidy(c / (k + 1)) for k, c in enumerate(slope))])
        raise NoSeries


def _moved(starts: list[Expr], a: Sequence[Expr], sign: int, other: Sequence[int]) -> list[list[Expr]]:
    """Series φᵢ with φ₀' = a' φ of `other`, φ₁' = ±a' φ of `other`, from their coefficients 0."""
    found = [[start] for start in starts]
    for k in range(1, len(a)):
        news = []
        for i in range(len(starts)):
            terms = (j * a[j] * found[other[i]][k - j] for j in range(1, k + 1) if a[j] != 0)
            news.append(_tidy((sign if i else 1) * sympy.Add(*terms) / k))
        for row, new in zip(found, news, strict=True):
            row.append(new)
    return found


def _sum(parts: Sequence[Series]) -> Series:
    first = min(part.first for part in parts)
    last = min(part.first + len(part.coefficients) for part in parts)
    totals = [
        _tidy(sympy.Add(*(p.coefficients[k - p.first] for p in parts if k >= p.first))) for k in range(first, last)
    ]
    return Series(first, totals)


def _product(a: Sequence[Expr], b: Sequence[Expr]) -> list[Expr]:
    count = min(len(a), len(b))
    return [_tidy(sympy.Add(*(a[j] * b[k - j] for j in range(k + 1) if a[j] != 0))) for k in range(count)]


def _tidy(c: Expr) -> Expr:
    if c.is_Rational:
        return c
    c = sympy.expand(c)
    if c.count_ops() > LONGEST:
        raise NoSeries
    return c
