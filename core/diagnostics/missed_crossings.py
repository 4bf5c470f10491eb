"""Test whether pairs of crossings may have been missed within steps: whether they resolve g."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.codegen.rounding import rounding_bound
from core.diagnostics.examined_steps import NEAR, SHORTEST, Steps
from core.diagnostics.narrow_features import dips_between
from core.integration.trajectory import Status
from core.kernels.arrays import Floats
from core.symbolic.expressions import TIME

__all__ = ["hides", "too_long_for_g"]

#: Bound on |g − cubic| between the places, in units of its value at the places.
_MARGIN = 3.0
#: Height below zero at an end of a step, as part of its largest size in it: a perturbation has put the state there.
_BEHIND = 2.0**-40
#: Bounds on rounding this many times the usual one within a step tell of a root or of 0/0, and not of an error there.
_UNUSUAL = 2.0**20
#: Largest error of a height or its rate, in units of the first-order bound on its rounding.
_ROUNDINGS = 16.0 * 2.0**-52


def too_long_for_g(steps: Steps, hidden: NDArray[np.bool_]) -> Iterator[str]:
    """Warn of a step in which a pair of crossings may have been missed."""
    if hidden.any():
        yield (
            f"{steps.named(np.argmax(hidden))} is too long for this surface: from there on g may change its "
            f"sign twice within a step, and two crossings may have been missed; "
            f"{steps.advice}"
        )


def hides(steps: Steps, beyond: bool = False) -> NDArray[np.bool_]:
    """Whether a pair of crossings may have been missed in each step; `beyond`: or if it has an end beyond g = 0.

    The time loop replaces the height of a guard within a step by the cubic with the same values and rates at both
    ends, and finds no crossing where the cubic is positive. Here the height on the scheme itself is compared with
    this cubic. It is unresolved where it is negative before the end, where the cubic is at most three times the
    difference of the two, and where the height may dip below zero between two places. A variable-step method has a
    polynomial in place of the cubic, so that the second test does not apply. Where the height is negative at the
    start or at the end, a perturbation has put the state there, or the end of the step: nothing is hidden in it.
    """
    hidden, places = np.zeros(len(steps), dtype=bool), steps.places()
    for rows, number, part in steps.by_mode():
        hidden[rows] = _hides(part, number, places, beyond)
    return hidden & ~_end_at_a_touch(steps)


def _end_at_a_touch(steps: Steps) -> NDArray[np.bool_]:
    """Which steps end where the run does, at a touch: of these, that is what is said of them."""
    run = steps.run
    end, left = run.t[-1], np.abs(run.t[-1] - steps.t - steps.h)
    return np.asarray((run.status is Status.GRAZING) & (left <= SHORTEST * np.abs(end) + NEAR * np.abs(steps.h)))


def _hides(steps: Steps, number: int, places: Floats, beyond: bool) -> NDArray[np.bool_]:
    """Whether a height of a mode, given by its number, is unresolved in some steps, all of that mode."""
    system, way, h = steps.run.system, steps.way(number, places), steps.h[:, None]
    law, hidden = system.laws.mode(number).written, np.zeros(len(steps), dtype=bool)
    symbols = (TIME, *system.laws.x, *system.laws.p)
    for k, height in enumerate(law.heights):
        rate = law.rate_of(height)
        wanted = (height, rate, rounding_bound(height), rounding_bound(rate))
        values = system.laws.evaluate(("height", number, k), wanted, way.times, way.states, system.parameter_array)
        g, rate, noise, noise_of_rate = np.moveaxis(values, 2, 0)
        sign = -1.0 if law.turns(k) and (h < 0.0).any() else 1.0  # see `Mode.heights`
        with np.errstate(all="ignore"):
            noise, noise_of_rate = _ROUNDINGS * noise, _ROUNDINGS * np.abs(h) * noise_of_rate
            heights = _Heights(places, sign * g, sign * h * rate, noise, noise_of_rate)
            above = heights.g > noise
        between = above[:, 1:] & above[:, :-1]
        dips = dips_between(int(sign) * height, symbols, way, system.parameter_array, between)
        hidden |= dips.found | heights.hide_roots(~dips.none, steps.method.adaptive, beyond)
    return hidden


class _Heights(NamedTuple):
    """Heights (k, n) at places of each step."""

    places: Floats
    """(n,), as parts of a step."""
    g: Floats
    rate: Floats
    """Their rates per step."""
    noise: Floats
    """Rounding errors of g."""
    noise_of_rate: Floats

    def hide_roots(self, between: NDArray[np.bool_], adaptive: bool, beyond: bool) -> NDArray[np.bool_]:
        """Whether heights are unresolved within steps, beside those places (k, n - 1) between which they may be.

        What is within rounding of zero tells nothing: where a slide ends, the height and its rate are both zero.
        """
        places, g, noise = self.places, self.g, self.noise
        with np.errstate(all="ignore"):
            behind = (g[:, [0, -1]] < -_BEHIND * np.abs(g).max(axis=1, keepdims=True)).any(axis=1)
            usual = np.median(self.noise_of_rate, axis=1, keepdims=True)
            nothing = (np.abs(self.rate) <= self.noise_of_rate) & (self.noise_of_rate <= _UNUSUAL * usual)
            rate = np.where(nothing, 0.0, self.rate)
            dips = between & _may_dip(np.diff(places), g, rate)
            hidden = np.asarray((g <= -noise)[:, 1:-1].any(axis=1) | dips.any(axis=1))
            if not adaptive:
                cubic = _hermite(places, g[:, :1], g[:, -1:], rate[:, :1], rate[:, -1:])
                apart, beside = np.abs(g - cubic), between[:, 1:] | between[:, :-1]
                unlike = (cubic <= _MARGIN * apart) & (apart > noise)
                hidden |= (unlike[:, 1:-1] & beside).any(axis=1)
        return np.asarray(hidden | behind if beyond else hidden & ~behind)


def _hermite(s: Floats, start: Floats, end: Floats, rate: Floats, rate_end: Floats) -> Floats:
    """The cubic Hermite interpolant at s in [0, 1], from values and slopes at 0 and 1."""
    by_values = (1 + 2 * s) * (1 - s) ** 2 * start + s * s * (3 - 2 * s) * end
    by_rates: Floats = s * (1 - s) ** 2 * rate + s * s * (s - 1) * rate_end
    return by_values + by_rates


def _may_dip(width: Floats, g: Floats, rate: Floats) -> NDArray[np.bool_]:
    """Whether g falls and rises between neighbouring places, and its tangents there meet below zero."""
    low, high, g_low, g_high = rate[:, :-1], rate[:, 1:], g[:, :-1], g[:, 1:]
    meet = (g_high - g_low - high * width) / (low - high)
    return np.asarray((low < 0.0) & (high > 0.0) & (g_low + low * meet <= 0.0))
