"""What a jump keeps, told by its declaration and not by rounded values: the surface, or a conserved quantity."""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence, Set
from functools import partial
from typing import Any

from sympy import Basic, Expr, Symbol

from core.symbolic.sliding import eliminated
from core.symbolic.tape import Digits, Tape, digits
from core.symbolic.zero_testing import is_zero

__all__ = ["keeps", "stays_on_surface"]

#: Decimal digits of the arithmetic.
_DIGITS = 40
#: Number of points on the surface at which g after the jump is tested.
_POINTS = 4
#: Most random starts from which such points are sought.
_ATTEMPTS = 60
#: Largest size of the random coordinates, parameters and times of these starts.
_RANGE = 3.0
#: |g| below this part of the sizes of its terms is zero: a root in 40 digits may lose some 15 of them.
_ZERO = 1e-25

#: Largest argument of exp, sinh, cosh or tanh: a search that strays farther finds no point.
_LARGEST = 1e4

Point = dict[Symbol, Any]


def stays_on_surface(g: Expr, x: Sequence[Symbol], jump: Sequence[Expr]) -> bool:
    """Whether g(t, jump(t, x)) = 0 wherever g(t, x) = 0.

    True if g after the jump is the expression g itself, or vanishes to 25 of 40 digits at up to four random points of
    the surface. False also if no point of the surface is found.
    """
    after = g.xreplace(dict(zip(x, jump, strict=True)))
    if after == g:
        return True
    tape = Tape([after])
    found = [_is_zero(after, tape, point) for point in _points_on(g, x, after.free_symbols)]
    return bool(found) and all(found)


def keeps(psi: Expr, g: Expr, x: Sequence[Symbol], jump: Sequence[Expr]) -> bool:
    """Whether ψ(jump(t, x)) = ψ(t, x) wherever g(t, x) = 0; if g is not linear in any variable, everywhere."""
    return is_zero(eliminated(psi.xreplace(dict(zip(x, jump, strict=True))) - psi, g, x))


def _points_on(g: Expr, x: Sequence[Symbol], others: Set[Basic]) -> Iterator[Point]:
    """A few random points at which g vanishes; the coordinates take turns in being solved for."""
    generator = random.Random(20261122)  # noqa: S311 - test points, not secrets
    names = sorted(g.free_symbols | others, key=str)
    solvable = [v for v in x if v in g.free_symbols]
    arithmetic, tape, count = digits(_DIGITS, _LARGEST), Tape([g]), 0
    for k in range(_ATTEMPTS):
        point = {s: arithmetic.context.mpf(generator.uniform(-_RANGE, _RANGE)) for s in names}
        v = solvable[k % len(solvable)]
        height = partial(_height, tape, arithmetic, point, v)
        try:
            point[v] = arithmetic.context.findroot(height, point[v])
        except (ArithmeticError, ValueError):  # g has no value on the way, or no root is found
            continue
        yield point
        count += 1
        if count == _POINTS:
            return


def _height(tape: Tape, arithmetic: Digits, point: Point, v: Symbol, u: Any) -> Any:
    """g at a point whose coordinate v is replaced by u."""
    return tape.run(arithmetic, {**point, v: u})[-1]


def _is_zero(expression: Expr, tape: Tape, point: Point) -> bool:
    try:
        values = tape.run(digits(_DIGITS, _LARGEST), point)
    except ArithmeticError:
        return False
    return bool(abs(values[-1]) <= _ZERO * tape.size(expression, values))
