"""How a variable-step method prepares a step: the Taylor coefficients of the solution, and the length they allow."""

from __future__ import annotations

from functools import lru_cache

from core.codegen import Names, excess_lines, function_text
from core.laws import Laws, Side
from core.recurrences import STRIDE
from core.series import SeriesCode, series_code
from core.signatures import LENGTH, ORDER, PER_UNIT, SETTLED, TOLERANCE, UNIT

__all__ = ["memo_rows", "reach_text"]

#: Steps are at most so many units of the system's own time long: powers of more could leave floating point.
_LONGEST = 2.0**20
#: Velocity over half the acceleration, in units of time, below which the unit is too long.
_SLOW = 2.0**-8


@lru_cache(maxsize=64)
def _series(laws: Laws, sign: int) -> SeriesCode:
    return series_code(laws, laws.sides[sign])


def memo_rows(laws: Laws) -> int:
    """Rows of coefficients that a step of either side needs."""
    return max(_series(laws, sign).rows for sign in laws.sides)


def reach_text(laws: Laws, side: Side) -> str:
    """Text of `reach`: coefficients to memo, those of the height over the surface in row d; the length to w[LENGTH]."""
    code, d = _series(laws, side.sign), len(laws.x)
    first, second = ("+".join(f"abs(c[{i}, {k}])" for i in range(d)) for k in (1, 2))
    attempt = [*code.lines, f"first, second = {first}, {second}", f"if not 0.0 < first < {_SLOW} * second:",
               "    break", "shrink = power_of_two(first / second)"]  # fmt: skip
    lines = [f"order = int(w[{ORDER}])", f"c = carray(memo, ({code.rows}, {STRIDE}))", "shrink = 1.0"]
    lines += ["for _ in range(2):", *(f"    {line}" for line in attempt)]
    lines += _excess_lines(laws, side)
    lines += [f"w[{UNIT}], w[{PER_UNIT}] = unit, 1.0 / unit", f"length = reach(c, {d}, order, w[{TOLERANCE}])"]
    lines += [f"w[{LENGTH}] = unit*({_LONGEST} if length > {_LONGEST} else length)", "return 1"]
    return function_text("reach", lines)


def _excess_lines(laws: Laws, side: Side) -> list[str]:
    """Lines that write what ψ is above its levels here to the frame, once for all steps from here that are tried."""
    names = Names(laws)
    targets = [f"w[{names.frame.excess + j}]" for j in range(len(side.conserved))]
    if not targets:
        return []
    lines = [f"if w[{SETTLED}] == 1.0:", f"    {' = '.join(targets)} = w[{SETTLED}] = 0.0", "else:"]
    lines += [f"    {line}" for line in excess_lines(names, side, quick=True)]
    return [*lines, *(f"    {target} = r{j}" for j, target in enumerate(targets))]
