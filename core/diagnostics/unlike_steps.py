"""Find the steps of a run between which the rates of change differ most: if one is astray, it is unlike the next."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from core.integration.trajectory import Trajectory

__all__ = ["unlike_steps"]

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
