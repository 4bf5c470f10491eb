"""Some steps of a run, made again at places within them, to see what the run could not."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from core.diagnostics.boxes import Way
from core.integration.dense_output import Stepper, Track
from core.integration.trajectory import Trajectory
from core.kernels.arrays import Floats
from core.methods import METHODS

__all__ = ["NEAR", "SHORTEST", "Integers", "Steps"]

Integers = NDArray[np.int64]

SHORTEST = 2.0**-46
"""Shortest step that is examined, relative to the time: of a shorter one rounding hides what happens in it."""

SHORTEST_PART = 2.0**-36
"""The same of less than half a step of fixed size, as beside a crossing: of one shorter than this, the times at both
ends tell the length to 16 bits only, as of a step that the clock does not resolve (`clock`)."""

NEAR = 2.0**-40
"""Distance between the ends of two steps, as part of a step, at which they are the same."""

#: Number of places, over all steps examined, at which the field or g is evaluated.
_PLACES = 6144
#: Least number of places in each step: a feature narrower than 1/30 of the step may be missed.
_FEWEST = 48
#: Largest number of places in each step, where few steps are examined: it resolves 1/700 of the step.
_MOST = 1024


class Steps:
    """Some steps of a run's method: their start times, states and modes, and their lengths h."""

    def __init__(self, run: Trajectory, t: Floats, x: Floats, mode: Integers, h: Floats) -> None:
        self.run, self.method = run, METHODS[run.method]
        self.t, self.x, self.mode, self.h = t, x, mode, h
        self._stepper = Stepper(run.system, self.method, run.tolerance)

    @classmethod
    def towards_the_end(cls, run: Trajectory, t: Floats, x: Floats, mode: Integers, h: Floats) -> Steps:
        """Steps towards the end of a run, none longer than τ; without those that are too short to be examined.

        A perturbation of a crossing lengthens the step to it, or ends it before it began: that is no fault of τ.
        """
        way = -1.0 if run.t[-1] < run.t[0] else 1.0
        h = way * np.clip(way * h, 0.0, np.inf if METHODS[run.method].adaptive else run.tau)
        whole = METHODS[run.method].adaptive | (np.abs(h) >= 0.5 * run.tau)
        long = np.abs(h) > np.where(whole, SHORTEST, SHORTEST_PART) * np.abs(t)
        return cls(run, t[long], x[long], mode[long], h[long])

    def __len__(self) -> int:
        return len(self.t)

    def by_mode(self) -> Iterator[tuple[NDArray[np.intp], int, Steps]]:
        """Rows of the steps in each mode, its number, and these steps."""
        for number in np.unique(self.mode).tolist():
            rows = np.flatnonzero(self.mode == number)
            yield rows, number, self.some(rows)

    def with_others(self, others: Steps) -> Steps:
        """These steps and others of the run."""
        t, x, h = (np.concatenate(pair) for pair in ((self.t, others.t), (self.x, others.x), (self.h, others.h)))
        return Steps(self.run, t, x, np.concatenate([self.mode, others.mode]), h)

    def some(self, rows: NDArray[np.intp]) -> Steps:
        """Some of these steps."""
        return Steps(self.run, self.t[rows], self.x[rows], self.mode[rows], self.h[rows])

    def places(self, of_each: int = 1) -> Floats:
        """Places in each step, as parts of it from 0 to 1: unequally spaced, so that no wave is missed."""
        count = min(max(_PLACES // max(of_each * len(self), 1), _FEWEST), _MOST)
        return np.concatenate([[0.0], np.sort((np.arange(1, count) * 0.6180339887498949) % 1.0), [1.0]])

    def at(self, places: Floats) -> tuple[Floats, Floats]:
        """Times (k, n) and states (k, n, d) at places of each step, the first of which is its start."""
        times = self.t[:, None] + self.h[:, None] * places
        states = np.concatenate([self.x[:, None], self.states(self.t, self.x, self.mode, times[:, 1:])], axis=1)
        return times, states

    def way(self, number: int, places: Floats) -> Way:
        """Times, states and their rates at places of each step, all in the mode of this number."""
        system, (times, states) = self.run.system, self.at(places)
        field = system.laws.mode(number).written.field
        return Way(times, states, system.laws.evaluate(("field", number), field, times, states, system.parameter_array))

    def states(self, t: Floats, x: Floats, mode: Integers, times: Floats) -> Floats:
        """States (k, places, d) on the scheme at the given times after k states; nan where a step has no solution."""
        states = np.empty((*times.shape, x.shape[1]))
        for rows in _one_after_another(t, times[:, -1]):
            begin, start, number = t[rows], np.ascontiguousarray(x[rows]), np.arange(len(rows))
            track = Track(begin, start, mode[rows], number, begin, start, mode[rows])
            found = self._stepper.find(track, times[rows].ravel())
            states[rows] = found.x.reshape(*times[rows].shape, x.shape[1])
        return states

    def named(self, row: int | np.intp) -> str:
        """Return a step in words: its length, of which tau it is a part, and where it begins."""
        length, tau = abs(self.h[row]), self.run.tau
        whole = self.method.adaptive or length >= (1.0 - NEAR) * tau or f"{length:.3g}" == f"{tau:.3g}"
        part = "" if whole else f" (part of tau = {tau:.6g})"
        return f"The step of {length:.3g}{part} at t = {self.t[row]:.6g}"

    @property
    def advice(self) -> str:
        """Return what would help."""
        return "give a tau, which no step is longer than" if self.method.adaptive else "take a smaller tau"


def _one_after_another(begin: Floats, end: Floats) -> list[NDArray[np.intp]]:
    """Rows of steps in groups, in each of which every step ends before the next one begins.

    Neighbours meet in time, and the step to a crossing that is perturbed may overlap with several that follow.
    """
    groups: list[list[int]] = []
    sign = -1.0 if len(end) and (end < begin).any() else 1.0
    first, last = sign * begin, sign * end
    for row in np.argsort(first, kind="stable").tolist():
        group = next((rows for rows in groups if last[rows[-1]] < first[row]), None)
        if group is None:
            groups.append(group := [])
        group.append(row)
    return [np.array(rows, dtype=np.intp) for rows in groups]
