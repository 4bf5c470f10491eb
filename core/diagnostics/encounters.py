"""Both branches of every crossing of a run: the arc that leads to a surface, and the arc that leads on from there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.integration.crossings import Crossings, Integers
from core.integration.trajectory import Trajectory
from core.kernels.arrays import Floats
from core.symbolic.laws import Laws

__all__ = ["Branch", "Encounters", "by_number", "encounters"]

#: In place of the number of a region where there is none.
_NONE = -1
#: Time to the surface from a state after a jump, in steps, beyond which it counts as off the surface.
_AWAY = 2.0**-10


@dataclass(frozen=True)
class Branch:
    """One arc at every crossing: that which leads to the surface, or that which leads away from it."""

    t: Floats
    """(k,) time at the surface."""
    x: Floats
    """(k, d) state at the surface; for an arc after a jump, the state after the jump."""
    mode: Integers
    """(k,) number of the region of the arc; −1 where it slides, or where there is no such arc: the theory is silent."""
    surface: Integers
    """(k,) number of the surface."""
    rate: Floats
    """(k,) ∇g·f + g_t of that region there."""
    length: Floats
    """(k,) signed length of the longest step examined: negative for an arc before a crossing, if time increases."""

    @property
    def known(self) -> NDArray[np.bool_]:
        """(k,) whether there is an arc in a region."""
        return np.asarray(self.mode != _NONE)

    def where(self, rows: NDArray[np.bool_] | slice) -> Branch:
        """The branch at some of the crossings."""
        return Branch(*(getattr(self, f.name)[rows] for f in fields(self)))


@dataclass(frozen=True)
class Encounters:
    """Both branches of every crossing."""

    before: Branch
    after: Branch
    transversal: NDArray[np.bool_]
    """(k,) whether the trajectory arrives and leaves at rates other than 0."""
    one_way: NDArray[np.bool_]
    """(k,) whether the guard is none of the mode entered, as with hysteresis: only the arrival is at the surface."""
    minus: Integers
    """(k,) number of the region that meets there where g < 0; −1 where none does."""
    plus: Integers
    """(k,) number of that where g > 0."""

    def where(self, rows: slice) -> Encounters:
        """Both branches of some of the crossings."""
        branches = self.before.where(rows), self.after.where(rows)
        return Encounters(*branches, self.transversal[rows], self.one_way[rows], self.minus[rows], self.plus[rows])


class _Meeting(NamedTuple):
    """The surface met by a mode, and the regions that meet there."""

    surface: int
    minus: int
    plus: int
    one_way: bool


def encounters(run: Trajectory, crossings: Crossings) -> Encounters:
    """Both branches of every crossing of a run.

    The longest steps examined have length τ, or that of the arc if it is shorter: from one crossing to the next, or
    between a crossing and an end of the run.
    """
    t, count, laws = crossings.t, len(crossings), run.system.laws
    jumped = crossings.kind == "jump"
    left = np.concatenate([run.mode[:1], crossings.mode])[:count]
    met = _meetings(laws, left, crossings.surface_met)
    onward = np.where(jumped[:, None], crossings.x_after, crossings.surface)
    surface = met[:, 0]
    one_way = (met[:, 3] != 0) | (jumped & _off(run, surface, t, onward, crossings.rate_after))
    last = run.crossings.t[count] if count < len(run.crossings) else run.t[-1]
    gaps = np.minimum(np.abs(np.diff(np.concatenate([run.t[:1], t, [last]]))), run.tau)
    direction = 1.0 if run.t[-1] >= run.t[0] else -1.0
    before, after = crossings.rate_before, crossings.rate_after
    leading_to, leading_on = _regions(laws, left), _regions(laws, crossings.mode)
    both = np.sign(before) * np.sign(after)  # the rates themselves may be as large as numbers are
    crosses = np.where(one_way, before != 0.0, np.where(jumped, both != 0.0, both > 0.0))
    crosses &= (leading_to != _NONE) & (leading_on != _NONE) & (crossings.kind != "corner")
    return Encounters(
        Branch(t, crossings.surface, leading_to, surface, before, -direction * gaps[:-1]),
        Branch(t, onward, leading_on, surface, after, direction * gaps[1:]),
        crosses,
        one_way,
        met[:, 1],
        met[:, 2],
    )


def _off(run: Trajectory, surface: Integers, t: Floats, x: Floats, rate: Floats) -> NDArray[np.bool_]:
    """Whether states lie so far from their surfaces that the field there is not that at the surface."""
    heights = run.system.laws.evaluate("heights", run.system.laws.surfaces, t, x, run.system.parameter_array)
    with np.errstate(all="ignore"):
        away = np.abs(np.take_along_axis(heights, surface[:, None], axis=1)[:, 0] / rate)
    return np.asarray(away > _AWAY * run.tau)


def by_number(numbers: Integers, function: Callable[..., Floats], *arrays: Floats) -> Floats:
    """Call function(number, *arrays) on the rows of each number that occurs, and merge the results.

    Below 0 stands for nothing to evaluate: the values of such rows are nan.
    """
    found = set(numbers.tolist())
    if len(found) == 1 and min(found) >= 0:
        return function(found.pop(), *arrays)
    kept = [n for n in found if n >= 0] or [0]
    parts = [(rows, function(n, *(a[rows] for a in arrays))) for n in kept for rows in (numbers == n,)]
    result = np.full((len(numbers), *parts[0][1].shape[1:]), np.nan)
    for rows, part in parts:
        result[rows] = part
    return result


def _regions(laws: Laws, modes: Integers) -> Integers:
    """The modes that are regions, −1 for the others."""
    return np.asarray(np.where(modes < len(laws.regions), modes, _NONE))


def _meetings(laws: Laws, left: Integers, surfaces: Integers) -> Integers:
    """(k, 4) a `_Meeting` for each mode left at a surface."""
    numbers = left * (len(laws.surfaces) + 1) + surfaces + 1
    _, first, which = np.unique(numbers, return_index=True, return_inverse=True)
    rows = [_meeting(laws, int(left[k]), int(surfaces[k])) for k in first]
    found: Integers = np.array(rows, dtype=np.int64).reshape(-1, 4)[which.ravel()]
    return found


def _meeting(laws: Laws, left: int, surface: int) -> _Meeting:
    """What meets where a mode is left at a surface; where sliding ends by itself, that along which it slides."""
    if left >= len(laws.regions):
        low, high, along = laws.pairs[left - len(laws.regions)]
        if surface in (_NONE, along):
            return _Meeting(along, low, high, False)
        return _Meeting(surface, _NONE, _NONE, False)
    way = next(way for way in laws.ways[left] if way.surface == surface)
    other = _NONE if way.to is None else way.to
    one_way = way.to is not None and way.back is None
    return _Meeting(surface, *((left, other) if way.sign < 0 else (other, left)), one_way)
