"""The first zero of the switching function along an arc of the external solver, to the last digit."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import scipy  # loads a subpackage when it is first used

__all__ = ["Sample", "Time", "first_zero"]

Time: TypeAlias = Any  # a float, or a number of many digits
Evaluate: TypeAlias = Callable[[Time], tuple[Time, Time]]


class Sample(NamedTuple):
    """Time, side·g (positive inside) and its rate at a point of an arc."""

    t: Time
    height: Time
    rate: Time


def first_zero(evaluate: Evaluate, a: Sample, b: Sample) -> Time | None:
    """First time in (a, b] at which the height vanishes, or None; a zero at a itself does not count.

    Two zeros between a and b show by a change of the sign of the rate: the height is evaluated at the extremum.

    Raises
    ------
    ValueError
        If the arc leaves the surface at a, and is back at b, tangentially.
    """
    if a.height > 0 and b.height <= 0:
        return _newton(evaluate, a.t, b.t)
    if a.rate < 0 < b.rate:
        bottom = _extremum(evaluate, a.t, b.t)
        return _newton(evaluate, a.t, bottom) if evaluate(bottom)[0] <= 0 else None
    if b.height <= 0:  # and a is on the surface: left and met again between two samples
        top = _extremum(evaluate, a.t, b.t) if a.rate > 0 > b.rate else a.t
        if evaluate(top)[0] <= 0:
            raise ValueError(f"the solution leaves the surface tangentially; it is back after {b.t - a.t:.3g}")
        return _newton(evaluate, top, b.t)
    return None


def _extremum(evaluate: Evaluate, a: Time, b: Time) -> Time:
    """Time between a and b, where the rate has opposite signs, at which it vanishes."""
    return a + (b - a) * scipy.optimize.brentq(lambda s: float(evaluate(a + (b - a) * s)[1]), 0.0, 1.0)


def _newton(evaluate: Evaluate, inside: Time, outside: Time) -> Time:
    """Zero of the height in a bracket, to the last digit: Newton's method, bisecting where it would leave."""
    t = inside + (outside - inside) / 2
    for _ in range(200):
        height, rate = evaluate(t)
        if height > 0:
            inside = t
        else:
            outside = t
        step = -height / rate if rate != 0 else np.inf
        new = t + step if inside < t + step < outside else inside + (outside - inside) / 2
        if height == 0 or new in (t, inside, outside):
            break
        t = new
    return t
