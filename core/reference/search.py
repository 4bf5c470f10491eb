"""Where along an arc the switching function first vanishes, to the last digit."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import scipy  # loads a subpackage when it is first used

__all__ = ["Sample", "Time", "first_zero"]

Time: TypeAlias = Any  # a float, or a number of many digits
Watch: TypeAlias = Callable[[Time], tuple[Time, Time]]


class Sample(NamedTuple):
    """One look at an arc: the time, side·g (positive inside) and its rate."""

    t: Time
    depth: Time
    rate: Time


def first_zero(watch: Watch, a: Sample, b: Sample) -> Time | None:
    """First time in (a, b] at which the depth vanishes, or None; not the zero at a itself.

    Two zeros between a and b show in the sign of the rate: the extremum between them is looked at.
    """
    if a.depth > 0 and b.depth <= 0:
        return _newton(watch, a.t, b.t)
    if a.rate < 0 < b.rate:
        bottom = _extremum(watch, a.t, b.t)
        return _newton(watch, a.t, bottom) if watch(bottom)[0] <= 0 else None
    if b.depth <= 0:  # and a is on the surface: left and met again between two looks
        top = _extremum(watch, a.t, b.t) if a.rate > 0 > b.rate else a.t
        if watch(top)[0] <= 0:
            raise ValueError(f"the solution leaves the surface tangentially; it is back after {b.t - a.t:.3g}")
        return _newton(watch, top, b.t)
    return None


def _extremum(watch: Watch, a: Time, b: Time) -> Time:
    """Time between a and b, where the rate has opposite signs, at which it vanishes."""
    return a + (b - a) * scipy.optimize.brentq(lambda s: float(watch(a + (b - a) * s)[1]), 0.0, 1.0)


def _newton(watch: Watch, inside: Time, outside: Time) -> Time:
    """Zero of the depth in a bracket, to the last digit: Newton's method, bisecting where it would leave."""
    t = inside + (outside - inside) / 2
    for _ in range(200):
        depth, rate = watch(t)
        if depth > 0:
            inside = t
        else:
            outside = t
        step = -depth / rate if rate != 0 else np.inf
        new = t + step if inside < t + step < outside else inside + (outside - inside) / 2
        if depth == 0 or new in (t, inside, outside):
            break
        t = new
    return t
