"""Time against error of one integrator at several settings, and the time to a given error read off it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

__all__ = ["TARGETS", "Curve", "Point"]

#: State errors to which the time is stated.
TARGETS = (1e-3, 1e-6, 1e-9, 1e-12)


class Point(NamedTuple):
    """One setting of an integrator."""

    setting: float
    """Step size or tolerance."""
    error: float
    """Largest error of the state at the end; infinite where the crossings are not as many as they should be."""
    wall: float
    """Least wall time, in seconds."""
    loop: float | None = None
    """Least processor time of the compiled loop alone, where that is known."""
    crossings: int = 0


@dataclass(frozen=True)
class Curve:
    """An integrator on a problem, from its coarsest setting to its finest."""

    name: str
    points: Sequence[Point]
    compiling: float
    """Seconds to compile, or to load from disk, before the first run; in no other time."""

    @property
    def finest(self) -> Point:
        """The point of the least error."""
        return min(self.points, key=lambda point: point.error)

    def reach(self, target: float) -> tuple[float | None, float | None]:
        """Wall time and time of the loop to an error; None where it is not reached, or not known."""
        wall = _time_to(target, [p.error for p in self.points], [p.wall for p in self.points])
        loops = [p.loop for p in self.points if p.loop is not None]
        return wall, _time_to(target, [p.error for p in self.points], loops) if loops else None


def _time_to(target: float, errors: Sequence[float], times: Sequence[float]) -> float | None:
    """Interpolate the logarithms between the two settings beside the target.

    A setting counts with the largest error of itself and the finer ones, down to the least error of all, so that a
    small error by luck is none; beyond that, round-off grows. A finer setting that is faster takes precedence.
    """
    best = min(range(len(errors)), key=errors.__getitem__)
    bounds = [max(errors[k : best + 1]) for k in range(best + 1)]
    if not bounds[best] <= target:
        return None
    first = next(k for k, bound in enumerate(bounds) if bound <= target)
    reached = min(times[first : best + 1])
    if first == 0 or math.isinf(bounds[first - 1]):
        return reached
    low, high = math.log(max(bounds[first], 1e-17)), math.log(bounds[first - 1])
    part = (high - math.log(target)) / (high - low)
    return min(reached, float(times[first - 1] ** (1 - part) * times[first] ** part))
