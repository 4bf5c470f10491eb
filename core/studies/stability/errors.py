"""The largest |Δψ| of each of many runs, evaluated together: for a short run, alone, that takes longer than the run."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from core.integration.conserved_error import level_residual_along
from core.integration.crossings import Integers
from core.integration.trajectory import Status, Trajectory
from core.kernels.arrays import Floats

__all__ = ["worst_error", "worst_errors"]

#: Endings after which Δψ is a difference of huge numbers.
_GONE = (Status.ESCAPED, Status.UNSTABLE)


def worst_error(run: Trajectory) -> float:
    """Largest |Δψ| of one run, see `worst_errors`."""
    return float(worst_errors([run])[0])


def worst_errors(runs: Sequence[Trajectory]) -> Floats:
    """Largest |Δψ| off the surface of runs that have recorded their steps, see `Trajectory.change_of_psi`.

    Parameters
    ----------
    runs
        Of one system, method and `sliding`.

    Returns
    -------
    (runs,)
        nan where no ψ is known, where it is undefined, and for a run that has escaped or become unstable: its Δψ would
        be a difference of huge numbers.
    """
    found = np.full(len(runs), np.nan)
    which = [k for k, run in enumerate(runs) if run.status not in _GONE]
    if which:
        found[which] = _largest_changes([runs[k] for k in which])
    return found


def _largest_changes(runs: list[Trajectory]) -> Floats:
    regions = len(runs[0].system.laws.regions)
    mode, firsts = _joined(runs, "mode"), _starts(run.entered_t for run in runs)
    segment = np.concatenate([run.segment + first for run, first in zip(runs, firsts.tolist(), strict=True)])
    entries = _joined(runs, "entered_t"), _joined(runs, "entered_x")
    residual = _residual(runs, _joined(runs, "t"), _joined(runs, "x"), mode, segment, *entries)
    change = residual + _carried(runs, regions, firsts, entries)[segment]
    change[(mode < 0) | (mode >= regions)] = np.nan  # on the surface
    largest = np.full(len(change), np.nan)
    for column in change.T:
        np.fmax(largest, np.abs(column), out=largest)
    return np.fmax.reduceat(largest, _starts(run.t for run in runs))


def _carried(runs: list[Trajectory], regions: int, firsts: Integers, entries: tuple[Floats, Floats]) -> Floats:
    """`Trajectory.carried_error` of each run, one after another: (s, m) for all segments."""
    met = [run.crossings for run in runs]
    t, mode, kind = (_joined(met, name) for name in ("t", "mode", "kind"))
    left = np.concatenate([np.append(run.mode[:1], run.crossings.mode)[:-1] for run in runs])
    before = np.concatenate([first + np.arange(len(one)) for first, one in zip(firsts.tolist(), met, strict=True)])
    at_exit = np.nan_to_num(_residual(runs, t, _joined(met, "x"), left, before, *entries))
    at_exit[kind == "leaving"] = 0.0
    off_surface = _residual(runs, t, _joined(met, "x_after"), mode, np.arange(len(t)), t, _joined(met, "surface"))
    off_surface[(kind == "jump") | (mode >= regions)] = 0.0
    errors, total = at_exit + np.nan_to_num(off_surface), np.zeros((len(entries[0]), at_exit.shape[1]))
    begin = 0
    for run, first, one in zip(runs, firsts.tolist(), met, strict=True):
        own, begin = errors[begin : begin + len(one)], begin + len(one)
        total[first + 1 : first + len(run.entered_t)] = np.cumsum(own, axis=0)[: len(run.entered_t) - 1]
    return total


def _residual(
    runs: list[Trajectory], t: Floats, x: Floats, mode: Integers, segment: Integers, entered_t: Floats,
    entered_x: Floats,
) -> Floats:  # fmt: skip
    one = runs[0]
    return level_residual_along(one.system, one.method, t, x, mode, segment, entered_t, entered_x, sliding=one.slides)


def _joined(parts: Iterable[Any], name: str) -> NDArray[Any]:
    """One array of runs, or of their crossings, one after another."""
    return np.concatenate([getattr(part, name) for part in parts])


def _starts(arrays: Iterable[NDArray[Any]]) -> Integers:
    """Where each array begins when they are joined."""
    return np.concatenate([[0], np.cumsum([len(array) for array in arrays])[:-1]])
