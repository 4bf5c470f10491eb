"""What runs of a work-precision study are compared with: the solution at the end time, and its crossings until then."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from core.integration.conserved_error import psi_size
from core.kernels.arrays import Floats
from core.reference import Solution
from core.studies.sequence import CrossingSequence
from core.system import PiecewiseSystem

__all__ = ["Target", "crossing_times", "target_of"]

#: Number of crossings to the default end time.
_CROSSINGS = 10
#: Default time span of a solution without crossings.
_LENGTH = 10.0
#: Round-off of run and reference together, relative to the size of the state: 16 eps.
_ROUND_OFF = 16.0 * 2.0**-52
#: Error of a reference, as part of its own estimate, which is the error of the worse of two solutions.
_OF_ESTIMATE = 0.1
#: That estimate, relative to the size of the state, from which on crossings of the reference are in doubt.
_LOST = 1e-2


@dataclass(frozen=True, eq=False)
class Target:
    """The reference solution at the end time."""

    t0: float
    end: float
    x: Floats
    crossings: CrossingSequence
    reference: str
    """Name of the reference solution."""
    floor: Mapping[str, float]
    """Errors that are round-off of run and reference, of "state", "time" and "invariant"."""

    @classmethod
    def unknown(cls, system: PiecewiseSystem, x0: tuple[float, ...], span: tuple[float, float | None]) -> Target:
        """Return what stands for a solution whose computation was cancelled."""
        end = span[0] + _LENGTH if span[1] is None else span[1]
        floor = dict.fromkeys(("state", "time", "invariant"), math.nan)
        return cls(span[0], end, np.full(len(x0), np.nan), CrossingSequence(system), "not computed", floor)


def target_of(
    system: PiecewiseSystem, exact: Solution, x0: tuple[float, ...], span: tuple[float, float | None]
) -> Target:
    """Return the solution at the end time; ValueError where it ends before."""
    t0, end = span
    if end is None:
        end = _default_end(exact, t0)
    times = crossing_times(exact, end)
    lost = exact.error  # of its crossings alone: at the end a jump may be at hand
    try:
        x = exact.state(end)
    except ValueError as why:
        raise ValueError(f"there is no reference until t = {end:g}: {why}; take an earlier end time") from None
    labels = [exact.side(t0), *(exact.entered(k + 1) for k in range(len(times)))]
    crossings = CrossingSequence.labelled(system, times, labels)
    size = max(float(np.linalg.norm(x0)), float(np.linalg.norm(x)))
    if times and lost > _LOST * _size_between(exact, (t0, *times, end)):
        raise ValueError(
            f"there is no reference until t = {end:g}: its error, {lost:.1g}, has grown to a part of the state "
            "that leaves its crossings in doubt; take an earlier end time"
        )
    estimate = _OF_ESTIMATE * exact.error
    floor = {
        "state": max(_ROUND_OFF * size, estimate),
        "time": max(_ROUND_OFF * max(abs(t0), abs(end)), estimate),
        "invariant": _ROUND_OFF * _largest_psi_size(system, exact, (t0, *times, end)),
    }
    return Target(t0, end, x, crossings, exact.name, floor)


def _size_between(exact: Solution, times: tuple[float, ...]) -> float:
    """Largest norm of the solution halfway between some times, and at them but the last."""
    instants = [*times[:-1], *((a + b) / 2 for a, b in pairwise(times))]
    return max(float(np.linalg.norm(exact.state(t))) for t in instants)


def _largest_psi_size(system: PiecewiseSystem, exact: Solution, times: tuple[float, ...]) -> float:
    """Largest `psi_size` of the solution at its start and end, at the crossings between, and halfway between these."""
    instants = sorted({*times, *((a + b) / 2 for a, b in pairwise(times))})
    modes = [system.laws.labelled(exact.side(t)) for t in instants]
    return max(float(psi_size(system, mode, t, exact.state(t))) for mode, t in zip(modes, instants, strict=True))


def _default_end(exact: Solution, t0: float) -> float:
    """Default end time: after ten crossings, or as many as there are, halfway between two of them."""
    times = [t0, *crossing_times(exact, math.inf, _CROSSINGS + 1)]
    return (times[-2] + times[-1]) / 2 if len(times) > 1 else t0 + _LENGTH


def crossing_times(exact: Solution, end: float, most: float = math.inf) -> list[float]:
    """Times of the crossings up to `end`; ValueError is how a solution says that it has no more.

    How many there are is asked first, as the search for one more may go on for long where a solution comes to rest.
    """
    times: list[float] = []
    if end < math.inf:
        with suppress(ValueError):  # it ends before: then the last one is soon found
            most = min(most, exact.count(end))
    while len(times) < most:
        try:
            t, _ = exact.crossing(len(times) + 1)
        except ValueError:
            break
        if t > end:
            break
        times.append(t)
    return times
