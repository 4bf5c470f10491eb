"""Prove that surfaces cannot have certain signs at once, so that the region of these signs is empty."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import sympy
from sympy import Add, Expr, Integer, Mul, Rational, Symbol

__all__ = ["Signs", "contradict"]

#: Relative distance of an irrational constant from its rational bounds.
_ROUNDING = Rational(1, 10**25)
#: Result of a linear program, of numbers of size 1, that may be round-off.
_ROUND_OFF = 1e-9

#: Surface -> its sign, −1 or +1.
Signs = dict[Expr, int]
#: Term -> its coefficient, and 1 -> the constant, of a sum that is positive.
Row = Mapping[Expr, Rational]


def contradict(signs: Signs, ranges: Mapping[Symbol, tuple[float, float]]) -> bool:
    """Whether surfaces cannot have these signs: whether positive multiples of them add up to what is never positive.

    The multiples that prove it are found by a linear program in floating point, then worked out exactly.
    """
    strict = _without_free_terms([_row(g, s) for g, s in signs.items()], ranges)
    if not strict:
        return False
    from scipy.optimize import linprog  # takes long to import

    terms = sorted({v for row in strict for v in row} - {Integer(1)}, key=str)
    rows = [*strict, *(row for v in terms for row in _bounds(v, ranges))]
    exact = [[row.get(v, Integer(0)) for v in (*terms, Integer(1))] for row in rows]
    scaled = np.array([[float(c / max(map(abs, row))) for c in row] for row in exact])
    counted = [k < len(strict) for k in range(len(rows))]
    equal = np.vstack([scaled[:, :-1].T, counted])
    found = linprog(scaled[:, -1], A_eq=equal, b_eq=[0] * len(terms) + [1], method="highs-ds")
    if found.x is None or found.fun is None or found.fun > _ROUND_OFF:
        return False
    used = [k for k, multiple in enumerate(found.x) if multiple > _ROUND_OFF]
    multiples = sympy.Matrix([exact[k][:-1] for k in used]).T.nullspace()
    if len(multiples) != 1:
        return False
    y = multiples[0] * (1 if multiples[0][0] > 0 else -1)
    return all(v > 0 for v in y) and sum(v * exact[k][-1] for v, k in zip(y, used, strict=True)) <= 0


def _without_free_terms(rows: Sequence[Row], ranges: Mapping[Symbol, tuple[float, float]]) -> Sequence[Row]:
    """The rows that remain when each with an unbounded term of its own is dropped: that term makes it positive."""
    times = Counter(v for row in rows for v in row)
    free = {v for v, n in times.items() if n == 1 and v.free_symbols and not any(_bounds(v, ranges))}
    kept = [row for row in rows if not free & row.keys()]
    return kept if len(kept) == len(rows) else _without_free_terms(kept, ranges)


def _row(g: Expr, sign: int = 1) -> Row:
    return {v: sign * factor for factor, v in (term.as_coeff_Mul() for term in Add.make_args(g))}


def _bounds(v: Expr, ranges: Mapping[Symbol, tuple[float, float]]) -> Iterator[Row]:
    """Yield sums that are never negative for a term."""
    low, high = map(Rational, ranges[v]) if v in ranges else (None, None)
    if not v.free_symbols:
        value = Rational(str(v.evalf(30)))
        low, high = value - abs(value) * _ROUNDING, value + abs(value) * _ROUNDING
    elif isinstance(v, sympy.sin | sympy.cos | sympy.tanh):
        low, high = Integer(-1), Integer(1)
    elif v not in ranges and all(_never_negative(u, ranges) for u in Mul.make_args(v)):
        low = Integer(v.func is sympy.cosh)
    yield from () if low is None else ({v: Integer(1), Integer(1): -low},)
    yield from () if high is None else ({v: Integer(-1), Integer(1): high},)


def _never_negative(u: Expr, ranges: Mapping[Symbol, tuple[float, float]]) -> bool:
    base, power = u.as_base_exp()
    if power.is_number and not (power.is_Integer and power % 2):  # an even power, or a root
        return True
    return bool(base.is_positive) or u.func is sympy.cosh or (base in ranges and ranges[base][0] >= 0)
