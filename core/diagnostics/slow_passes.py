"""Where a run nearly comes to rest and goes on, as beside a saddle, whose sides lead to different places."""

from __future__ import annotations

import numpy as np

from core.integration.trajectory import Trajectory
from core.kernels.arrays import Floats

__all__ = ["SlowPasses"]

#: Rate of each variable at a slow pass, as part of its largest before and after.
_SLOW = 0.1
#: Most slow passes that are compared, the slowest of all.
_MOST = 64
#: Ratio of the least speeds of two runs up to which both pass alike. Beside a saddle of the plane, the square of that
#: speed is in proportion to the distance from the orbit that ends there: an error of this makes it 2 or more.
_ALIKE = 1.5


class SlowPasses:
    """The slow passes of a run, and another run to compare them with.

    There each rate is far below what it comes to both before and after. The largest, as a part of that, is the speed.
    """

    def __init__(self, run: Trajectory, other: Trajectory) -> None:
        rates = _rates(run)
        before, after = np.maximum.accumulate(rates), np.maximum.accumulate(rates[::-1])[::-1]
        self._units = np.minimum(before, after)
        self._units[self._units == 0.0] = np.inf
        self._speed = (rates / self._units).max(axis=1)
        inner, one_segment = self._speed[1:-1], run.segment[:-2] == run.segment[2:]
        least = one_segment & (inner <= self._speed[:-2]) & (inner < self._speed[2:]) & (inner <= _SLOW)
        rows = 1 + np.flatnonzero(least)
        self.rows = np.sort(rows[np.argsort(self._speed[rows], kind="stable")[:_MOST]])
        self._times, self._others = (other.t, _rates(other)) if len(rows) else (other.t[:0], rates[:0])

    def alike(self, row: int, t: float) -> bool:
        """Whether the other run is about as slow where it is slowest near time t; True but for rows of slow passes."""
        if row not in self.rows:
            return True
        k = int(np.argmin(np.abs(self._times - t)))
        while (
            slower := min(max(k - 1, 0), k, min(k + 1, len(self._times) - 1), key=lambda j: self._other(j, row))
        ) != k:
            k = slower
        other, own = self._other(k, row), float(self._speed[row])
        return own <= _ALIKE * other and other <= _ALIKE * own

    def _other(self, k: int, row: int) -> float:
        """Speed of the other run at its row k, in the units of a row of the run."""
        return float((self._others[k] / self._units[row]).max())


def _rates(run: Trajectory) -> Floats:
    """Sizes of the rates of the variables at the recorded states (n, d)."""
    laws, p, rates = run.system.laws, run.system.parameter_array, np.empty_like(run.x)
    for mode in np.unique(run.mode).tolist():
        rows = run.mode == mode
        field = laws.mode(mode).written.field
        rates[rows] = laws.evaluate(("field", mode), field, run.t[rows], run.x[rows], p)
    return np.asarray(np.nan_to_num(np.abs(rates), nan=np.inf))
