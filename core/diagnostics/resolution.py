"""Whether steps are short enough for what the field and g do in them: asked of some steps of a run, afterwards."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from core.integration.dense_output import Stepper, Track
from core.integration.trajectory import Status, Trajectory
from core.kernels.arrays import Floats
from core.methods import METHODS

__all__ = ["unresolved"]

Integers = NDArray[np.int64]

#: The field or g is evaluated at so many places in all …
_PLACES = 6144
#: … at least at so many of each step: a feature narrower than a thirtieth of the step may be hidden …
_FEWEST = 48
#: … and at most at so many, where few steps are examined: a seven hundredth.
_MOST = 1024
#: Places in a step of fixed size, in parts of it: the size has been chosen for the field.
_FEW = np.array([0.0, 0.15, 0.29, 0.5, 0.68, 0.87, 1.0])
#: Between the places g may differ from a cubic by so many times what it differs there.
_MARGIN = 3.0
#: A step and the shorter ones that lead the same way may differ by this part of the way …
_APART = 0.05
#: … those of a method that keeps a tolerance by this part …
_APART_KEPT = 1e-6
#: … or by so many times the tolerance …
_TOLERANCES = 1e3
#: … and all of them by rounding, in parts of the state.
_ROUNDING = 2.0**-44
#: The least unit of a coordinate, in parts of the largest.
_SLIGHT = 1e-9
#: Steps from where the run has entered a mode, besides those that the loop has kept.
_MOST_ENTRIES = 64


def unresolved(run: Trajectory) -> tuple[str, ...]:
    """Say where steps are too long for g, so that crossings may have been missed, or for the field.

    Returns
    -------
    tuple of str
        () where all steps that are looked at are short enough, else warnings, the worse first.
    """
    samples = run.samples
    if samples is None:
        return ()
    samples = samples[samples[:, 2] != 0.0]
    t, side, h, x = samples[:, 0], samples[:, 1].astype(np.int64), samples[:, 2], samples[:, 3:]
    kept = _Steps(run, t, x, side, h)
    if run.status is Status.ESCAPED:  # where the solution runs away no step is short enough
        return tuple(kept.too_long_for_g())
    return (*kept.too_long_for_g(), *kept.too_long_for_the_field(), *_first_steps(run).too_long_for_the_field())


def _first_steps(run: Trajectory) -> _Steps:
    """Steps of the run's size from where it has entered a side."""
    crossings = run.crossings
    if METHODS[run.method].adaptive or len(crossings) < 2:
        return _Steps(run, np.empty(0), np.empty((0, run.system.dimension)), np.empty(0, dtype=np.int64), np.empty(0))
    k = np.unique(np.linspace(0, len(crossings) - 2, _MOST_ENTRIES).astype(np.int64))
    length = crossings.t[k + 1] - crossings.t[k]
    h = np.sign(length) * np.minimum(run.tau, np.abs(length))
    k, h = k[h != 0.0], h[h != 0.0]
    return _Steps(run, crossings.t[k], crossings.x_after[k], crossings.side[k].astype(np.int64), h)


class _Steps:
    """Steps of a run's method, one after another: from times and states, on sides, of lengths."""

    def __init__(self, run: Trajectory, t: Floats, x: Floats, side: Integers, h: Floats) -> None:
        self.run, self.method = run, METHODS[run.method]
        self.t, self.x, self.side, self.h = t, x, side, h
        self.stepper = Stepper(run.system, self.method, run.tolerance)

    def too_long_for_g(self) -> Iterator[str]:
        """Tell of a step in which a pair of crossings may lie unseen.

        The time loop takes g within a step for the cubic that has its values and rates at both ends, and so finds no
        crossing where that is positive. Here g is compared with this cubic, on the scheme itself: it is unresolved
        where it is negative before the end, where the cubic is no larger than three times what they differ by, and
        where g may dip below zero between two places that are looked at. A method that chooses its steps has a
        polynomial in place of the cubic, and only what is seen between is told of.
        """
        h, side = self.h[:, None], self.side[:, None]
        places = _places(len(h))
        times = self.t[:, None] + h * places
        states = np.concatenate([self.x[:, None], self._states(self.t, self.x, self.side, times[:, 1:])], axis=1)
        with np.errstate(all="ignore"):
            g = side * self.run.system.switching(times, states)
            rates = (self.run.system.switching_rate(s, times, states) for s in (1, -1))
            rate: Floats = np.where(side > 0, *rates) * (h * side)
            cubic = _hermite(places, g[:, :1], g[:, -1:], rate[:, :1], rate[:, -1:])
            hidden = (g <= 0.0)[:, 1:-1].any(axis=1) | _may_dip(np.diff(places), g, rate).any(axis=1)
            if not self.method.adaptive:
                hidden |= (cubic <= _MARGIN * np.abs(g - cubic))[:, 1:-1].any(axis=1)
        if hidden.any():
            yield (
                f"A step of {abs(self.h[hidden][0]):.3g} is too long for this surface: from t = "
                f"{self.t[hidden][0]:.6g} on g varies by more than its values and rates at both ends show, so "
                f"crossings may have been missed; {self._advice}"
            )

    def too_long_for_the_field(self) -> Iterator[str]:
        """Tell of a step that does not lead where shorter ones do, each from where the step itself leads to by then.

        Coordinates are compared in units of how far each moves in the steps looked at; what moves a billionth of
        the way of others may be their rounding.
        """
        places = _places(3 * len(self.t)) if self.method.adaptive else _FEW
        times = self.t[:, None] + self.h[:, None] * places
        whole = np.concatenate([self.x[:, None], self._states(self.t, self.x, self.side, times[:, 1:])], axis=1)
        with np.errstate(all="ignore"):
            apart = np.abs(self._by_steps_between(times, whole) - whole[:, 2:]).max(axis=1)
            way = np.abs(whole - whole[:, :1]).max(axis=1)
            unit = np.nanmax(way, axis=0, initial=0.0)
            unit = np.maximum(unit, _SLIGHT * unit.max(initial=0.0))
            unit = np.where(unit > 0.0, unit, 1.0)
            least = self._least * np.abs(whole).max(axis=1)
            part = np.where(apart > least, apart / unit, 0.0).max(axis=1) / (way / unit).max(axis=1)
        if not len(part):
            return
        worst = int(np.argmax(np.nan_to_num(part, nan=0.0)))
        if part[worst] > (_APART_KEPT if self.method.adaptive else _APART):
            yield (
                f"A step of {abs(self.h[worst]):.3g} is too long for this field: from t = {self.t[worst]:.6g} on it "
                f"leads elsewhere than shorter ones, by {min(part[worst], 1.0):.1g} of the way; {self._advice}"
            )

    @property
    def _advice(self) -> str:
        return "give a tau, which no step is longer than" if self.method.adaptive else "take a smaller tau"

    @property
    def _least(self) -> float:
        """What a step may be off by, in parts of the state."""
        return max(_ROUNDING, _TOLERANCES * self.run.tolerance if self.method.adaptive else 0.0)

    def _by_steps_between(self, times: Floats, whole: Floats) -> Floats:
        """States at all places but the first two, by a step from the place before."""
        t, x = times[:, 1:-1], whole[:, 1:-1]
        side = np.repeat(self.side, t.shape[1])
        found = self._states(t.ravel(), x.reshape(-1, x.shape[2]), side, times[:, 2:].reshape(-1, 1))
        return found.reshape(x.shape)

    def _states(self, t: Floats, x: Floats, side: Integers, times: Floats) -> Floats:
        """States on the scheme, (k, places, d), at times after each of k states; nan where a step has no solution."""
        states = np.empty((*times.shape, x.shape[1]))
        for first in (0, 1):  # every other step, so that each ends before the next one begins
            rows = slice(first, None, 2)
            if not len(t[rows]):
                continue
            begin, start, number = t[rows].copy(), np.ascontiguousarray(x[rows]), np.arange(len(t[rows]))
            track = Track(begin, start, side[rows].copy(), number, begin, start, side[rows].copy())
            found = self.stepper.find(track, times[rows].ravel())
            found.x[found.solved :] = np.nan
            states[rows] = found.x.reshape(*times[rows].shape, x.shape[1])
        return states


def _places(steps: int) -> Floats:
    """Where in each of so many steps to look, from 0 to 1: at no equal distances, behind which a wave could hide."""
    count = min(max(_PLACES // max(steps, 1), _FEWEST), _MOST)
    return np.concatenate([[0.0], np.sort((np.arange(1, count) * 0.6180339887498949) % 1.0), [1.0]])


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
