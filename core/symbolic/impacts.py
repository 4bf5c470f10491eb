"""Test whether a jump leaves the state on the surface: from the declaration, not from a rounded value of g."""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence

import mpmath
import sympy
from sympy import Expr, Symbol

__all__ = ["stays_on_surface"]

#: Decimal digits of the arithmetic.
_DIGITS = 40
#: Number of points on the surface at which g after the jump is tested.
_POINTS = 4
#: Most random starts from which such points are sought.
_ATTEMPTS = 60
#: Largest size of the random coordinates, parameters and times of these starts.
_RANGE = 3.0
#: |g| below this part of the sizes of its terms is zero: a root in 40 digits may lose some 15 of them.
_ZERO = mpmath.mpf(10) ** -25

Point = dict[Symbol, mpmath.mpf]


def stays_on_surface(g: Expr, x: Sequence[Symbol], jump: Sequence[Expr]) -> bool:
    """Whether g(t, jump(t, x)) = 0 wherever g(t, x) = 0.

    True if g after the jump is the expression g itself, or vanishes to 25 of 40 digits at up to four random points of
    the surface. False also if no point of the surface is found.
    """
    after = g.xreplace(dict(zip(x, jump, strict=True)))
    if after == g:
        return True
    found = [_is_zero(after, point) for point in _points_on(g, x, sorted(after.free_symbols, key=str))]
    return bool(found) and all(found)


def _points_on(g: Expr, x: Sequence[Symbol], others: Sequence[Symbol]) -> Iterator[Point]:
    """A few random points at which g vanishes; the coordinates take turns in being solved for."""
    generator = random.Random(20261122)  # noqa: S311 - test points, not secrets
    names = sorted(g.free_symbols | set(others), key=str)
    solvable = [v for v in x if v in g.free_symbols]
    count = 0
    with mpmath.workdps(_DIGITS):
        for k in range(_ATTEMPTS):
            point = {s: mpmath.mpf(generator.uniform(-_RANGE, _RANGE)) for s in names}
            v = solvable[k % len(solvable)]
            along = sympy.lambdify([v], g.xreplace({s: _number(u) for s, u in point.items() if s != v}), "mpmath")
            try:
                point[v] = mpmath.findroot(along, point[v])
            except (ArithmeticError, ValueError, TypeError):  # no root found, or g has no value
                continue
            if mpmath.im(point[v]) == 0:
                yield point
                count += 1
            if count == _POINTS:
                return


def _is_zero(expression: Expr, point: Point) -> bool:
    with mpmath.workdps(_DIGITS):
        at = {s: _number(u) for s, u in point.items()}
        terms = [mpmath.mpmathify(sympy.N(term.xreplace(at), _DIGITS)) for term in sympy.Add.make_args(expression)]
        return bool(abs(mpmath.fsum(terms)) <= _ZERO * mpmath.fsum(map(abs, terms)))


def _number(value: mpmath.mpf) -> sympy.Float:
    return sympy.Float(value, _DIGITS)
