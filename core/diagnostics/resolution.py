"""Whether g varies within a step more than its ends show: asked of steps in which no crossing was found."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from core.dense import Stepper, Track
from core.laws import Floats
from core.methods import METHODS
from core.trajectory import Trajectory

__all__ = ["unresolved"]

#: Where in a step g is looked at, in parts of it: at no equal distances, which a regular surface could hide behind.
#: What is narrower than a thirtieth of a step may be hidden all the same.
_PLACES = np.append(np.sort((np.arange(1, 48) * 0.6180339887498949) % 1.0), 1.0)
#: What g may be off the cubic between the places that are looked at, in parts of what it is off there.
_MARGIN = 3.0


def unresolved(run: Trajectory) -> tuple[str, ...]:
    """Say where a pair of crossings may lie unseen between the two ends of a step.

    The time loop takes g within a step for the cubic that has its values and rates at both ends, and so finds no
    crossing where that is positive. Here g is compared with this cubic, on the scheme itself: it is unresolved where it
    is negative, where the cubic is no larger than three times what they differ by, and where g may dip below zero
    between two places that are looked at.

    Returns
    -------
    tuple of str
        () where g is resolved, else one warning. A method that chooses its steps has a polynomial in place of the
        cubic, and only what is seen between is told of.
    """
    samples = run.samples
    if samples is None or not len(samples):
        return ()
    t, side, h = samples[:, 0], samples[:, 1].astype(np.int64), samples[:, 2]
    x = np.ascontiguousarray(samples[:, 3:])
    places, times = np.append(0.0, _PLACES), t[:, None] + h[:, None] * np.append(0.0, _PLACES)
    states = np.concatenate([x[:, None], _states(run, t, x, side, times[:, 1:])], axis=1)
    with np.errstate(all="ignore"):
        g = side[:, None] * run.system.switching(times, states)
        rates = (run.system.switching_rate(s, times, states) for s in (1, -1))
        rate: Floats = np.where(side[:, None] > 0, *rates) * (h * side)[:, None]
        cubic = _hermite(places, g[:, :1], g[:, -1:], rate[:, :1], rate[:, -1:])
        hidden = (g <= 0.0)[:, 1:].any(axis=1) | _may_dip(np.diff(places), g, rate).any(axis=1)
        if not METHODS[run.method].adaptive:
            hidden |= (cubic <= _MARGIN * np.abs(g - cubic))[:, 1:].any(axis=1)
        hidden &= (g[:, -1] > 0.0) & (h != 0.0)
    if not hidden.any():
        return ()
    when, length = float(t[hidden][0]), float(np.abs(h[hidden][0]))
    return (
        f"A step of {length:.3g} is too long for this surface: from t = {when:.6g} on g varies by more than its values "
        "and rates at both ends show, so crossings may have been missed; take a smaller tau",
    )


def _states(run: Trajectory, t: Floats, x: Floats, side: NDArray[np.int64], times: Floats) -> Floats:
    """States on the scheme, (k, places, d), at times after each of the k states; nan where a step has no solution."""
    number = np.arange(len(t))
    track = Track(t, x, side, number, t, x, side)
    found = Stepper(run.system, METHODS[run.method], run.tolerance).find(track, times.ravel())
    found.x[found.solved :] = np.nan
    return found.x.reshape(*times.shape, x.shape[1])


def _hermite(s: Floats, start: Floats, end: Floats, rate: Floats, rate_end: Floats) -> Floats:
    """Hermite's cubic at places s in [0, 1], by its values and slopes at 0 and 1."""
    by_values = (1 + 2 * s) * (1 - s) ** 2 * start + s * s * (3 - 2 * s) * end
    by_rates: Floats = s * (1 - s) ** 2 * rate + s * s * (s - 1) * rate_end
    return by_values + by_rates


def _may_dip(width: Floats, g: Floats, rate: Floats) -> NDArray[np.bool_]:
    """Whether the tangents at two places next to each other, between which g falls and rises, meet below zero."""
    low, high, g_low, g_high = rate[:, :-1], rate[:, 1:], g[:, :-1], g[:, 1:]
    meet = (g_high - g_low - high * width) / (low - high)
    return np.asarray((low < 0.0) & (high > 0.0) & (g_low + low * meet <= 0.0))
