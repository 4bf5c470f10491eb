r"""Sliding along the surface g = 0, where both fields point to it: Filippov's field, derived from those of the sides.

On the surface the state obeys the convex combination of both fields that keeps g,

    f_s = (ġ₋ f₊ − ġ₊ f₋) / (ġ₋ − ġ₊),      ġ± = g_t + ∇g·f±.

With this formula f_s is defined beside the surface, too, and keeps g at every level. So g is a conserved quantity of
sliding, and the Discrete Multiplier Method holds the state on the surface. The sides may have quantities that f_s keeps
as well, as angular momentum about an axis of symmetry.

Reference: Filippov, Differential Equations with Discontinuous Righthand Sides (1988), §4, (10).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import sympy
from sympy import Expr, Symbol

from core.symbolic.algebra import cancel, together
from core.symbolic.mode import Mode
from core.symbolic.origin import Origin
from core.symbolic.zero_testing import Domain, independent, is_larger, is_zero

__all__ = ["eliminated", "sliding_mode"]

#: Most nodes of the tree of a quotient whose common factors are cancelled, as sympy takes long for more.
_CANCELLED_NODES = 200


def sliding_mode(minus: Mode, plus: Mode, g: Expr, name: str) -> Mode:
    """The mode of sliding along g = 0 between two modes that this surface separates; g > 0 in `plus`.

    Its first guards are the rates of g with both fields. While time runs forward, ġ₋ > 0 and ġ₊ < 0; backward, the
    surface attracts where it repels forward. Where one of them vanishes, the field of that side turns, and the state
    leaves. The other guards are those of both modes: further surfaces.
    """
    below, above = minus.rate_of(g), plus.rate_of(g)
    origin = Origin.of((*minus.field, *plus.field, g), minus.variables)
    pairs = zip(minus.field, plus.field, strict=True)
    field = tuple(_cancelled((below * b - above * a) / (below - above), origin) for a, b in pairs)
    others = {u: s for mode in (minus, plus) for u, s in zip(mode.guards, mode.signs, strict=True) if u != g}
    guards, signs = (_cancelled(below, origin), _cancelled(above, origin), *others), (1, -1, *others.values())
    sides = tuple(a if a == b else 0 for a, b in zip(minus.sides, plus.sides, strict=True))
    bare = Mode(name, sides, minus.variables, field, (), guards, signs, minus.taken, g)
    return replace(bare, conserved=tuple(_kept(bare, minus, plus)))


def _kept(sliding: Mode, minus: Mode, plus: Mode) -> Iterator[Expr]:
    """Quantities of the sides that the field of sliding keeps on the surface; last, g: d − 1 at most in all."""
    g, d = sliding.surface, len(sliding.variables)
    if g is None or d == 1:
        return
    chosen: list[Expr] = []
    most = min(d - 2, max(len(minus.conserved), len(plus.conserved)))
    domain = _attracting(sliding)
    for psi in dict.fromkeys((*minus.conserved, *plus.conserved)):
        rows = sympy.Matrix([[u.diff(v) for v in sliding.variables] for u in (*chosen, psi, g)])
        if len(chosen) < most and _is_zero_on(g, sliding, sliding.rate_of(psi)) and independent(rows, domain):
            chosen.append(psi)
    yield from chosen
    yield g


def _is_zero_on(g: Expr, sliding: Mode, u: Expr) -> bool:
    """Whether u vanishes where g does; if g is not linear in any variable, only a u that vanishes everywhere counts."""
    return is_zero(eliminated(u, g, sliding.variables), _attracting(sliding))


def eliminated(u: Expr, g: Expr, variables: Sequence[Symbol]) -> Expr:
    """u with a variable expressed by the others where g = 0; u itself if g is not linear in any variable."""
    for v in variables:
        slope = g.diff(v)
        if slope != 0 and not slope.free_symbols & set(variables):
            return u.xreplace({v: v - g / slope})
    return u


def _attracting(sliding: Mode) -> Domain:
    """Where the rates point to the surface from both sides, or away from it on both; within the other surfaces."""
    below, above, *others = sliding.heights
    return Domain(positive=(below * above, *others))


def _cancelled(u: Expr, origin: Origin) -> Expr:
    """u without common factors of numerator and denominator, multiplied out about a point, if that is shorter."""
    (about,) = origin.about((u,))
    if is_larger(about, _CANCELLED_NODES):
        return u
    short = cancel(together(about))
    return origin.back(short) if short.count_ops() < about.count_ops() else u
