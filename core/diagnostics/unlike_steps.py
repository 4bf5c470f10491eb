"""Find the steps of a run between which the rates of change differ most: if one is astray, it is unlike the next."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.integration.trajectory import Trajectory
from core.integration.unlike import STEPS_BETWEEN
from core.kernels.arrays import Floats

__all__ = ["Stretches", "stretches", "unlike_steps"]

#: Number of equal parts of a run, in each of which two steps are chosen for each coordinate.
_PARTS = 128
#: Number of rows looked at in one go, to save memory.
_BLOCK = 2**16


def unlike_steps(run: Trajectory) -> NDArray[np.intp]:
    """Rows from which the steps start that are least like the one before, or the one after, in each part of a run.

    A step that leaps over something narrow takes the state farther, or less far, than its neighbours. Each coordinate
    is looked at by itself, so that none hides what happens to another.

    Returns
    -------
    NDArray
        (k,) numbers of rows, in order; none of a run that has not recorded its steps.
    """
    steps = len(run.t) - 1
    if run.record != "steps" or steps < 2:
        return np.empty(0, dtype=np.intp)
    size = -(-steps // _PARTS)
    block = max(_BLOCK // size, 1) * size
    found = [_least_like(run, first, min(first + block, steps), size) for first in range(0, steps, block)]
    later = np.concatenate(found)
    return np.union1d(later, np.maximum(later - 1, 0))


def _least_like(run: Trajectory, first: int, last: int, size: int) -> NDArray[np.intp]:
    """Of each part of `size` steps between two rows, the steps least like the one before in the same segment."""
    begin = max(first - 1, 0)
    t, x, segment = (values[begin : last + 1] for values in (run.t, run.x, run.segment))
    h, way, cut = np.diff(t), np.diff(x, axis=0), segment[1:] != segment[:-1]
    h[cut] = run.crossings.t[segment[:-1][cut]] - t[:-1][cut]
    way[cut] = run.crossings.x[segment[:-1][cut]] - x[:-1][cut]
    with np.errstate(all="ignore"):
        rate = way / h[:, None]
        change = np.abs(np.diff(rate, axis=0, prepend=rate[:1]))
        change[1:][cut[:-1]] = 0.0
    change = np.nan_to_num(change[first - begin :])
    parts = [change[k : k + size].argmax(axis=0) + k for k in range(0, len(change), size)]
    return first + np.concatenate(parts)


class Stretches(NamedTuple):
    """Consecutive steps from some states on, (k, steps + 1): some of a run that has not recorded its steps."""

    t: Floats
    x: Floats
    mode: NDArray[np.int64]

    def least_like(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Rows and columns of the steps least like the one before, by coordinate, and of those before."""
        with np.errstate(all="ignore"):
            rate = np.diff(self.x, axis=1) / np.diff(self.t)[..., None]
            change = np.nan_to_num(np.abs(np.diff(rate, axis=1)))
        later = change.argmax(axis=1) + 1
        rows = np.repeat(np.arange(len(later)), later.shape[1])
        pairs = np.concatenate([np.column_stack([rows, column.ravel()]) for column in (later, later - 1)])
        order = np.argsort(np.abs(self.t[tuple(pairs.T)] - self.t[0, 0]))  # in the order of the run, each step once:
        pairs, at = pairs[order], np.abs(self.t[tuple(pairs[order].T)] - self.t[0, 0])  # stretches may overlap
        rows, columns = pairs[np.diff(at, prepend=-np.inf) > 0.5 * np.abs(self.t[0, 1] - self.t[0, 0])].T
        return rows, columns


def stretches(run: Trajectory, states_after: Callable[..., Floats]) -> Stretches:
    """Make the steps again in the stretches that the loop has kept: two looks long each, or up to the end of the run.

    `states_after` gives the states (k, 1, d) after k states in their modes, at times (k, 1).
    """
    d, sign = run.x.shape[1], 1.0 if run.t[-1] >= run.t[0] else -1.0
    kept = np.empty((0, 3 + d)) if run.unlike is None else run.unlike
    kept = kept[np.unique(sign * kept[:, 0], return_index=True)[1]]  # in the order of the run
    t, x, mode = kept[:, 0], kept[:, 3 : 3 + d], kept[:, 2].astype(np.int64)
    times, states, end = [t], [x], run.t[-1]
    for _ in range(2 * STEPS_BETWEEN if len(t) else 0):
        later = sign * np.minimum(sign * times[-1] + run.tau, sign * end)
        states.append(states_after(times[-1], states[-1], mode, later[:, None])[:, 0])
        times.append(later)
    return Stretches(np.column_stack(times), np.stack(states, axis=1), mode)
