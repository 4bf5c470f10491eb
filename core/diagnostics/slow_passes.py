"""Where a run nearly comes to rest and goes on, as beside a saddle, whose sides lead to different places."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from core.integration.trajectory import Trajectory
from core.kernels.arrays import Floats

__all__ = ["SlowPasses"]

#: Rate of each variable at a slow pass, as part of its largest before and after.
_SLOW = 0.1
#: Part of the largest rate of a variable up to which it is no more than round-off, or on its way to that.
_RESTS = 1e-6
#: Part of the unit of a rate that may be round-off.
_ROUNDING = 2.0**-40
#: Most slow passes that are compared, the slowest of all.
_MOST = 64
#: Ratio of the least speeds of two runs up to which both pass alike. Beside a saddle of the plane, the square of that
#: speed is in proportion to the distance from the orbit that ends there: an error of this makes it 2 or more.
_ALIKE = 1.5


class SlowPasses:
    """The slow passes of a run, and another run to compare them with.

    There each rate of some variables, on which no other ones depend and that depend on no other ones, is far below what
    it comes to both before and after. The largest of these rates, as a part of that, is the speed.
    """

    def __init__(self, run: Trajectory, other: Trajectory) -> None:
        rates = _rates(run)
        before, after = np.maximum.accumulate(rates), np.maximum.accumulate(rates[::-1])[::-1]
        least, ever = _RESTS * rates.max(axis=0), np.minimum(before, after)
        self._rates, self._units = rates, np.maximum(ever, np.where(least > 0.0, least, np.inf))
        self._passes: dict[int, list[list[int]]] = {}
        for part in _independent(run):
            speed, goes_on = self._speed(rates, self._units, part), (ever > least)[:, part].any(axis=1)
            inner, one_segment = speed[1:-1], run.segment[:-2] == run.segment[2:]
            slowest = one_segment & (inner <= speed[:-2]) & (inner < speed[2:]) & (inner <= _SLOW)
            rows = _minima(speed, run.segment, 1 + np.flatnonzero(slowest & goes_on[1:-1]))
            for row in rows[np.argsort(speed[rows], kind="stable")[:_MOST]].tolist():
                self._passes.setdefault(row, []).append(part)
        self._way = 1.0 if run.t[-1] >= run.t[0] else -1.0
        self._times, self._others = (other.t, _rates(other)) if self._passes else (other.t[:0], rates[:0])

    @property
    def rows(self) -> list[int]:
        """Rows of the run at which some variables are slowest."""
        return sorted(self._passes)

    def alike(self, row: int, t: float) -> bool:
        """Whether the other run is about as slow where it is slowest near time t, if it comes so far.

        True but for rows of slow passes.
        """
        if not len(self._times) or self._way * (t - self._times[-1]) >= 0.0:
            return True
        return all(self._alike(row, t, part) for part in self._passes.get(row, ()))

    def _alike(self, row: int, t: float, part: list[int]) -> bool:
        k, last = int(np.argmin(np.abs(self._times - t))), len(self._times) - 1

        def other(j: int) -> float:
            return float(self._speed(self._others[j], self._units[row], part))

        while (slower := min(max(k - 1, 0), k, min(k + 1, last), key=other)) != k:
            k = slower
        own = float(self._speed(self._rates[row], self._units[row], part))
        return own <= _ALIKE * other(k) and other(k) <= _ALIKE * own

    @staticmethod
    def _speed(rates: Floats, units: Floats, part: list[int]) -> Floats:
        return np.asarray((rates[..., part] / units[..., part]).max(axis=-1))


def _minima(speed: Floats, segment: NDArray[np.intp], rows: NDArray[np.intp]) -> NDArray[np.intp]:
    """Those of some rows at which a speed is least, before and after which it is higher in the segment.

    It is higher by more than rounding: a speed that is constant in a segment has minima of no meaning.
    """
    first, last = (np.searchsorted(segment, segment[rows], side) for side in ("left", "right"))
    before, after = np.zeros((2, len(rows)), dtype=bool)
    distance, least = 1, speed[rows] + _ROUNDING
    while distance < 2 * len(speed):
        before |= speed[np.maximum(rows - distance, first)] > least
        after |= speed[np.minimum(rows + distance, last - 1)] > least
        distance *= 2
    return rows[before & after]


def _independent(run: Trajectory) -> list[list[int]]:
    """Put the variables into the smallest sets of which the fields of one do not contain the variables of another."""
    laws = run.system.laws
    x, parts = laws.x, [{k} for k in range(run.system.dimension)]
    for mode in np.unique(run.mode).tolist():
        for k, rate in enumerate(laws.mode(mode).field):
            linked = {k} | {j for j, v in enumerate(x) if v in rate.free_symbols}
            parts = [p for p in parts if not p & linked] + [linked.union(*(p for p in parts if p & linked))]
    return [sorted(part) for part in parts]


def _rates(run: Trajectory) -> Floats:
    """Sizes of the rates of the variables at the recorded states (n, d)."""
    laws, p, rates = run.system.laws, run.system.parameter_array, np.empty_like(run.x)
    for mode in np.unique(run.mode).tolist():
        rows = run.mode == mode
        field = laws.mode(mode).written.field
        rates[rows] = laws.evaluate(("field", mode), field, run.t[rows], run.x[rows], p)
    return np.nan_to_num(np.abs(rates), nan=np.finfo(float).max)
