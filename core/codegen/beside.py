"""Generate the lines that move a place where a field has a limit, but cannot be evaluated."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import sympy
from sympy import Expr, Symbol

from core.codegen.printing import assignments
from core.codegen.rounding import rounding_bound
from core.symbolic.expressions import TIME
from core.symbolic.mode import Mode
from core.symbolic.singularities import BESIDE

__all__ = ["lines_beside"]

#: Distance from a zero at which a field is evaluated in place of it where time and state vanish: its powers do not
#: underflow.
_NEXT_TO_NOTHING = 2.0**-200
#: A zero is one within this many times the first-order bound on its rounding: a field may add its terms in another
#: order.
_ROUNDINGS = 4.0 * 2.0**-52


def lines_beside(
    symbols: Mapping[Symbol, Expr],
    temporaries: Iterable[Symbol],
    modes: Iterable[Mode],
    t: Symbol,
    x: Sequence[Symbol],
    start: tuple[Expr, Sequence[Expr]] | None = None,
) -> list[str]:
    """Lines that move a place (t, x) to one beside it where the fields of some modes are 0/0 but have a limit.

    The quotient of two small numbers that are right to the last digit is the limit, as that of sin(u)/u; of two that
    are round-off it is not. Each
    coordinate is moved such that u grows: changes by one part of each would cancel where u is x − y.

    Parameters
    ----------
    symbols
        Names of the symbols in the generated text.
    start
        Time and state at the other end of a step: then it is the middle of the step that is moved, with (t, x).
    """
    lines = []
    for mode in modes:
        moving = {TIME: t, **dict(zip(mode.variables, x, strict=True))}
        place = {**symbols, **moving}
        if start is not None:
            others = (start[0], *start[1])
            place |= {v: (here + there) / 2 for (v, here), there in zip(moving.items(), others, strict=True)}
        for u in (*mode.zeros.removable, *mode.zeros.rounded):
            noise = sympy.Float(_ROUNDINGS) * rounding_bound(u, of_symbols=False)
            values = [v.xreplace(place) for v in (u, noise)]
            lines += [*assignments(["zero", "noise"], values, temporaries), "if abs(zero) <= noise:"]
            moved = [symbol for symbol in moving if symbol in u.free_symbols]
            slopes = [f"slope{k}" for k in range(len(moved))]
            slopes_of_u = [u.diff(symbol).xreplace(place) for symbol in moved]
            inner = assignments(slopes, slopes_of_u, temporaries)  # first: all are those at the place itself
            for symbol, slope in zip(moved, slopes, strict=True):
                v = moving[symbol]
                inner.append(f"{v} += (-1.0 if {slope} <= 0.0 else 1.0) * (abs({v}) * {BESIDE} + {_NEXT_TO_NOTHING})")
            lines += [f"    {line}" for line in inner]
    return lines
