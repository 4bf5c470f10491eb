"""Double-double numbers of every size, and distances from exact values: what tests of `doubledouble` share."""

from __future__ import annotations

import math
from typing import Any

import mpmath as mp
from hypothesis import strategies as st

DIGITS = 60
#: One part in 2¹⁰⁴: the unit in which errors are counted, 4 u² with u = 2⁻⁵³.
UNIT = 2.0**-104

Pair = tuple[float, float]


@st.composite
def pairs(draw: st.DrawFn, high: st.SearchStrategy[float]) -> Pair:
    """A high part with a low part of any size below half its last digit."""
    h = draw(high)
    part = draw(st.sampled_from([0.0, 1.0, 1e-3, 1e-16])) * draw(st.integers(-(2**20), 2**20)) / 2**20
    low = 0.5 * math.ulp(h) * part
    total = h + low
    return total, low - (total - h)


def sized(least: float, most: float) -> st.SearchStrategy[float]:
    """Numbers of either sign whose sizes are spread evenly over the orders of magnitude, 2^least … 2^most."""
    sizes = st.floats(least, most).map(lambda k: math.exp2(k))
    return st.builds(lambda sign, size: sign * size, st.sampled_from([-1.0, 1.0]), sizes)


def exact(pair: Pair) -> Any:
    """hi + lo."""
    with mp.workdps(DIGITS):
        return mp.mpf(pair[0]) + mp.mpf(pair[1])


def error(got: Pair, value: Any) -> float:
    """Distance from a value, in units of 2⁻¹⁰⁴ (and of that value, where the caller divides)."""
    with mp.workdps(DIGITS):
        return float(abs(exact(got) - value) / UNIT)


def relative_error(got: Pair, value: Any) -> float:
    """Distance from a value relative to it, in units of 2⁻¹⁰⁴."""
    with mp.workdps(DIGITS):
        return float(abs(exact(got) - value) / (UNIT * abs(value))) if value else (0.0 if not any(got) else math.inf)
