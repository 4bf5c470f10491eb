"""Warn where small errors grow to the size of the solution: rounding, or the errors of steps, decide what a run shows.

A second run starts a little beside the first. What their distance has become is how much errors are amplified: this is
measured, in one direction, and not a bound.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from core.integration.run_settings import Settings
from core.integration.runner import Runner
from core.integration.trajectory import Status, Trajectory
from core.kernels.arrays import Floats
from core.methods import METHODS

__all__ = ["amplified"]

#: Distance between the starts of two runs, relative to each variable: some thousand roundings.
_BESIDE = 1e-12
#: Distance, relative to the same, at which two runs have nothing in common any more.
_APART = 0.5
#: Factor by which errors are amplified where those of steps are compared, too: phases that drift do not make it.
_LARGE = 1e6
#: Part of the tolerance with which a method that chooses its steps makes a run again.
_FINER = 1.0 / 16.0
_EPS = 2.0**-52
#: How runs end in which the numerical solution grows without bound.
_RUNS_AWAY = (Status.ESCAPED, Status.UNSTABLE)
#: Equally spaced instants at which runs are compared.
_INSTANTS = 64
#: Most steps of each, times d: of longer runs, the beginning is examined.
_MOST_STEPS = 200_000


def amplified(run: Trajectory) -> Iterator[str]:
    """Say from when on a run depends on how it was rounded, or stepped.

    Yields
    ------
    str
        A sentence without the last full stop; none where small errors stay small.
    """
    if run.t[-1] == run.t[0] or run.status in _RUNS_AWAY:  # at a pole every error grows without bound
        return
    again = _Again(run)
    states = again.states(run.x[0])
    distance = _BESIDE * np.abs(np.vstack([run.x[:1], states[:1]])).max(axis=0)
    others = again.beside(distance)
    if (t := again.parted(states, others)) is not None:
        yield (
            f"Small errors grow: a change of the start by {_BESIDE:.0e} of its size changes the state by its own size "
            f"before t = {t:.3g}, and so do the errors of rounding; later states are not determined by the start"
        )
        return
    both = min(len(states), len(others))
    factor = np.abs(states[:both] - others[:both]).max(initial=0.0) / (distance.max() or 1.0)
    if factor > _LARGE and (t := again.parted(states, again.states(run.x[0], finer=True))) is not None:
        finer = "a smaller tolerance" if METHODS[run.method].adaptive else "half of tau"
        yield (
            f"Small errors grow, by a factor of {factor:.0e}: {finer} changes the state by its own size before "
            f"t = {t:.3g}; take less still, or end the run before"
        )


@dataclass(frozen=True)
class _Again:
    """Makes a run again, from other starts or with finer steps, and compares the states at some instants."""

    run: Trajectory

    @property
    def steps(self) -> int:
        """Number of steps that are examined, one at least: a run may end within its first."""
        return min(max(self.run.steps, 1), _MOST_STEPS // self.run.system.dimension)

    @property
    def times(self) -> Floats:
        """The instants."""
        part = self.steps / max(self.run.steps, 1) * (self.run.t[-1] - self.run.t[0])
        times: Floats = self.run.t[0] + np.arange(1, _INSTANTS + 1) / _INSTANTS * part
        return times

    def states(self, x0: Floats, finer: bool = False) -> Floats:
        """States there, up to where the run ends, or has taken many more steps or crossings than the first."""
        run, more = self.run, 4 if finer else 2
        steps, crossings = more * self.steps + _INSTANTS, more * run.crossing_count + _INSTANTS
        tau, tolerance = (0.5 * run.tau, max(_FINER * run.tolerance, _EPS)) if finer else (run.tau, run.tolerance)
        settings = Settings(tau, tolerance, max_crossings=crossings, max_steps=steps, slides=run.slides)
        runner = Runner(run.system, METHODS[run.method], float(run.t[0]), tuple(x0.tolist()), settings)
        states = np.empty((_INSTANTS, len(x0)))
        for k, t in enumerate(self.times.tolist()):
            if runner.advance(t, keep_hits=False) is not Status.COMPLETED:
                return states[:k]
            states[k] = runner.x
        return states

    def beside(self, distance: Floats) -> Floats:
        """States of a run that starts beside the first, on a side of it on which one can start."""
        for sign in (1.0, -1.0):
            try:
                return self.states(self.run.x[0] + sign * distance)
            except ValueError:  # no law is declared there
                continue
        return np.empty((0, len(distance)))

    def parted(self, states: Floats, others: Floats) -> float | None:
        """Time from which two runs have nothing in common; None if they stay together, or jump one after the other."""
        both = min(len(states), len(others))
        largest = np.maximum.accumulate(np.abs(np.vstack([self.run.x[:1], states[:both]])))[1:]
        far = _APART * np.where(largest > 0.0, largest, np.inf)
        apart = np.any(np.abs(states[:both] - others[:both]) >= far, axis=1)
        first = int(np.argmax(apart)) if apart.any() else both
        return float(self.times[first]) if 2 * np.count_nonzero(apart[first:]) > both - first else None
