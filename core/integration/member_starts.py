"""Where many runs of one system begin: the regions of their initial states, and which of these are in doubt."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.codegen.rounding import with_roundings
from core.compilation.guards import guard_table
from core.kernels.arrays import Floats
from core.symbolic.laws import Laws
from core.transition.records import NO_MODE

__all__ = ["Places", "first_places"]

_EPS = 2.0**-52
#: A switching function of less than so many bounds on the rounding of the state is surely zero for `starting`, of more
#: than the second surely not; between them `Runner` decides.
_ZERO, _NOT_ZERO = 0.5, 4.0


class Places(NamedTuple):
    """Where initial states lie."""

    rows: NDArray[np.int64]
    """(n,) row of the first guard of the region; `NO_MODE` where it has to be found by `starting.first_place`. Of two
    sides of one surface it is that of the first: the loop itself tells them apart."""
    guards: NDArray[np.int64]
    """(n,) number of the guard of that region at which the state lies; 0 if it lies at none."""
    plain: NDArray[np.bool_]
    """(n,) whether the state lies inside a region, off all surfaces, and all that is needed there is finite."""


def first_places(laws: Laws, t: float, x: Floats, p: Floats, given: int = NO_MODE) -> Places:
    """Find the regions of initial states.

    Parameters
    ----------
    t
        Initial time.
    x
        (n, d) initial states.
    p
        (n, parameters) parameter values.
    given
        Number of the region in which all begin; NO_MODE where their states tell.
    """
    count, d = len(laws.surfaces), len(laws.x)
    parameters = np.ascontiguousarray(p.T)
    values = laws.evaluate("start", laws.at_start, t, x, parameters)
    both = laws.evaluate("surfaces", with_roundings(laws.surfaces), t, x, parameters)
    heights, doubts, fields = values[:, :count], _EPS * both[:, count:], values[:, count * (2 + d) :]
    met, off = np.abs(heights) <= _ZERO * doubts, np.abs(heights) > _NOT_ZERO * doubts  # both False of nan
    clear = (met | off).all(axis=1) & (met.sum(axis=1) <= 1)
    plain = (np.isfinite(heights) & off).all(axis=1)
    region, guards = np.full(len(x), NO_MODE), np.zeros(len(x), dtype=np.int64)
    for k, ways in reversed(list(enumerate(laws.ways))):  # of several that contain a state, the first counts
        inside, at = np.ones(len(x), dtype=bool), np.zeros(len(x), dtype=np.int64)
        for n, way in reversed(list(enumerate(ways))):
            on = met[:, way.surface]
            inside &= on | (way.sign * heights[:, way.surface] > 0.0)
            at[on] = n
        region[inside], guards[inside] = k, at[inside]
        if k == given:
            plain &= inside
        plain &= ~inside | np.isfinite(fields[:, k * d : (k + 1) * d]).all(axis=1)
    plain &= region != NO_MODE
    if given != NO_MODE:
        return Places(np.full(len(x), guard_table(laws).first_rows[given]), np.zeros(len(x), dtype=np.int64), plain)
    if laws.two_sided:
        return Places(np.zeros(len(x), dtype=np.int64), np.zeros(len(x), dtype=np.int64), plain)
    found = clear & (region != NO_MODE)
    return Places(np.where(found, guard_table(laws).first_rows[region], NO_MODE), guards, plain)
