"""The sequence of crossings of a run, and whether it is that of the solution."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from core.integration.crossings import Integers
from core.integration.tally import KINDS, Tally, kinds_of
from core.integration.trajectory import Trajectory
from core.kernels.arrays import Floats
from core.system import PiecewiseSystem
from core.transition.records import NO_MODE

__all__ = ["CrossingSequence"]

#: What happens where a side of the only surface is entered, by its label.
_WAYS = {-1: "enters the side g < 0", 0: "begins to slide", 1: "enters the side g > 0"}


@dataclass(frozen=True, eq=False)
class CrossingSequence:
    """When a trajectory meets a surface, and which mode it enters there; what happens follows from the modes."""

    system: PiecewiseSystem
    t: Floats = field(default_factory=lambda: np.empty(0))
    """(k,) times, increasing."""
    modes: Integers = field(default_factory=lambda: np.zeros(1, dtype=np.int64))
    """(k + 1,) numbers of the modes: that of the start, and those entered."""

    @classmethod
    def of(cls, run: Trajectory, until: float = np.inf) -> CrossingSequence:
        """Return that of the crossings up to a time after which a run continued."""
        met = run.crossings
        passed = (met.t <= until) & (met.mode != NO_MODE)
        return cls(run.system, met.t[passed], np.append(run.mode[:1], met.mode[passed]))

    @classmethod
    def labelled(cls, system: PiecewiseSystem, t: list[float], labels: list[int]) -> CrossingSequence:
        """Return the sequence with the given (k,) times and (k + 1,) labels of modes."""
        return cls(system, np.array(t), np.array([system.laws.labelled(label) for label in labels], dtype=np.int64))

    def __len__(self) -> int:
        """Return how often a surface is met."""
        return len(self.t)

    @property
    def kinds(self) -> Integers:
        """(k,) what happens, as indices into `KINDS`."""
        return kinds_of(self.modes, len(self.system.laws.regions))

    @cached_property
    def tally(self) -> Tally:
        """How often each of it happens."""
        return Tally.of(self.kinds)

    def difference(self, expected: CrossingSequence) -> str:
        """Say in what this differs first from the sequence expected; empty if it is the same.

        It is the same if surfaces are met as often, and the same modes are entered in the same order, each nearer in
        time to its own in the other sequence than to the neighbours of that.
        """
        if len(self) != len(expected):
            return self.tally.difference(expected.tally)
        between = (expected.t[1:] + expected.t[:-1]) / 2
        early, late = self.t[1:] < between, self.t[:-1] > between
        elsewhere = np.append(False, early) | np.append(late, False) if len(self) else np.zeros(0, dtype=bool)
        wrong = np.flatnonzero(elsewhere | (self.modes[1:] != expected.modes[1:]))
        if not len(wrong):
            return ""
        k = int(wrong[0])
        if self.modes[k + 1] != expected.modes[k + 1]:
            return f"at t = {self.t[k]:.4g} it {self._way(k)}, where the solution {expected._way(k)}"
        times = f"at t = {self.t[k]:.4g}, not {expected.t[k]:.4g}"
        return f"{self._name(k)} comes {times}, nearer to a different crossing of the reference"

    def _way(self, k: int) -> str:
        mode = int(self.modes[k + 1])
        several = self.system.laws.sides.shape[1] != 1
        return f"enters “{self.system.laws.name(mode)}”" if several else _WAYS[self.system.laws.label(mode)]

    def _name(self, k: int) -> str:
        """Return kind and number of the k-th, such as “crossing 3”."""
        kind = self.kinds[k]
        return f"{KINDS[kind][0]} {np.count_nonzero(self.kinds[: k + 1] == kind)}"
