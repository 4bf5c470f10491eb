"""The sequence of crossings of a run, and whether it is that of the solution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.integration.crossings import Crossings
from core.kernels.arrays import Floats

__all__ = ["CrossingSequence"]


#: What happens at a crossing, by the side entered.
_WAYS = {-1: "enters the side g < 0", 0: "begins to slide", 1: "enters the side g > 0"}


@dataclass(frozen=True, eq=False)
class CrossingSequence:
    """When a trajectory crosses the surface, and which side it enters, or that it slides from there.

    Their kind follows from that, and from the system: all are jumps, or none is.
    """

    t: Floats
    """(k,) times, increasing."""
    side: NDArray[np.int64]
    """(k,) sides entered, −1 or +1; 0 where sliding begins. Of several surfaces the numbers of the modes entered."""

    several: bool = False
    """Whether there are several surfaces."""

    @classmethod
    def of(cls, crossings: Crossings) -> CrossingSequence:
        """Return that of the crossings after which a run continued."""
        passed = crossings.passed
        several = passed.side.ndim > 1
        return cls(passed.t, passed.mode if several else passed.side, several)

    def __len__(self) -> int:
        """Return the number of crossings."""
        return len(self.t)

    def _way(self, k: int) -> str:
        return f"enters mode {self.side[k]}" if self.several else _WAYS[int(self.side[k])]

    def difference(self, expected: CrossingSequence) -> str:
        """Say in which crossing this differs from the sequence expected; empty if it is the same.

        It is the same if there are as many crossings, which enter the same sides in the same order, each nearer in time
        to its own in the other sequence than to the neighbours of that.
        """
        if len(self) != len(expected):
            return f"{len(self)} crossing{'s' * (len(self) != 1)} instead of {len(expected)}"
        between = (expected.t[1:] + expected.t[:-1]) / 2
        early, late = self.t[1:] < between, self.t[:-1] > between
        elsewhere = np.append(False, early) | np.append(late, False) if len(self) else np.zeros(0, dtype=bool)
        wrong = np.flatnonzero(elsewhere | (self.side != expected.side))
        if not len(wrong):
            return ""
        k = int(wrong[0])
        if self.side[k] != expected.side[k]:
            return f"crossing {k + 1} {self._way(k)}, where the solution {expected._way(k)}"
        return f"crossing {k + 1} is at t = {self.t[k]:.4g} instead of {expected.t[k]:.4g}, nearer to another one"
