"""Whether g varies within a step more than its ends show: asked of steps in which no crossing was found."""

from __future__ import annotations

import numpy as np

from core.dense import Stepper, Track
from core.laws import Floats
from core.methods import METHODS
from core.trajectory import Trajectory

__all__ = ["unresolved"]

#: Where in a step g is looked at, in parts of it: at no equal distances, which a regular surface could hide behind.
_PLACES = np.array([0.07, 0.17, 0.29, 0.38, 0.53, 0.62, 0.74, 0.86, 0.95, 1.0])
#: What g may be off the cubic between the places that are looked at, in parts of what it is off there.
_MARGIN = 3.0


def unresolved(run: Trajectory) -> tuple[str, ...]:
    """Say where a pair of crossings may lie unseen between the two ends of a step.

    The time loop takes g within a step for the cubic that has its values and rates at both ends, and so finds no
    crossing where that is positive. Here g is compared with this cubic, on the scheme itself: it is unresolved where it
    is negative, or where the cubic is no larger than three times what they differ by.

    Returns
    -------
    tuple of str
        () where g is resolved, or where the method chooses its steps and has no such cubic; else one warning.
    """
    samples = run.samples
    if samples is None or not len(samples) or METHODS[run.method].adaptive:
        return ()
    t, side, x = samples[:, 0], samples[:, 1].astype(np.int64), np.ascontiguousarray(samples[:, 2:])
    h = run.tau if run.t[-1] >= run.t[0] else -run.tau
    times = t[:, None] + h * _PLACES
    found = _states(run, t, x, side, times)
    with np.errstate(all="ignore"):
        g = side[:, None] * run.system.switching(times, found)
        cubic = _cubic(run, t, x, side, h, g[:, -1], found[:, -1])
        hidden = (g[:, -1] > 0.0) & ((g <= 0.0) | (cubic <= _MARGIN * np.abs(g - cubic))).any(axis=1)
    if not hidden.any():
        return ()
    return (
        f"tau = {run.tau:.3g} is too long for this surface: within the step at t = {t[hidden][0]:.6g} g varies by more "
        "than its values and rates at both ends show, so crossings may have been missed; take a smaller tau",
    )


def _states(run: Trajectory, t: Floats, x: Floats, side: np.ndarray, times: Floats) -> Floats:
    """States on the scheme, (k, places, d), at times after each of the k states; nan where a step has no solution."""
    number = np.arange(len(t))
    track = Track(t, x, side, number, t, x, side)
    found = Stepper(run.system, METHODS[run.method], run.tolerance).find(track, times.ravel())
    found.x[found.solved :] = np.nan
    return found.x.reshape(*times.shape, x.shape[1])


def _cubic(run: Trajectory, t: Floats, x: Floats, side: np.ndarray, h: float, g_end: Floats, end: Floats) -> Floats:
    """Hermite's cubic of the height, (k, places), by its values and rates at both ends of each step."""
    system, s = run.system, _PLACES
    rates = np.empty((2, len(t)))
    for sign in (-1, 1):
        rows = side == sign
        rates[0, rows] = system.switching_rate(sign, t[rows], x[rows])
        rates[1, rows] = system.switching_rate(sign, t[rows] + h, end[rows])
    start, slope, slope_end = side * system.switching(t, x), h * side * rates[0], h * side * rates[1]
    values = np.stack([start, slope, g_end, slope_end], axis=1)
    basis = np.stack([(1 + 2 * s) * (1 - s) ** 2, s * (1 - s) ** 2, s * s * (3 - 2 * s), s * s * (s - 1)])
    return values @ basis
