"""How a variable-step method prepares a step: the Taylor coefficients of the solution, and the length they allow."""

from __future__ import annotations

from functools import lru_cache

from core.codegen import function_text
from core.laws import Laws, Side
from core.series import SeriesCode, series_code
from core.signatures import LENGTH, ORDER, TOLERANCE, UNIT

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
    lines = [f"order = int(w[{ORDER}])", f"c = carray(memo, ({code.rows}, order + 1))", "shrink = 1.0"]
    lines += ["for _ in range(2):", *(f"    {line}" for line in attempt)]
    lines += [f"w[{UNIT}] = unit", f"length = reach(c, {d}, order, w[{TOLERANCE}])"]
    lines += [f"w[{LENGTH}] = unit*({_LONGEST} if length > {_LONGEST} else length)", "return 1"]
    return function_text("reach", lines)
