"""The part of the plane that suits the trajectories of a portrait."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pwsviz.geometry.phase_plane import Window
from pwsviz.results.orbits import Orbit

__all__ = ["OTHERS", "extent", "power_of_ten"]

NEAR = 1.2
"""Size, relative to the first orbit, of the window within which orbits of other integrators may widen the view."""

OTHERS = 3.0
"""The same for orbits from other starts."""


def extent(orbits: Sequence[Orbit], others: Sequence[Orbit] = ()) -> Window:
    """Return the box of the first orbit that stays, closed surfaces of comparable size, and the orbits near it.

    Parameters
    ----------
    orbits : sequence of Orbit
        One for each integrator, from the selected start.
    others : sequence of Orbit
        The same from the other starts, start by start. Those of the first integrator count, farther out (`OTHERS`)
        than the orbits of other integrators (`NEAR`).
    """
    stay = [orbit for orbit in (*orbits, *others) if not orbit.runs_off]
    base = stay[0] if stay else orbits[0]
    first = Window.around(np.concatenate([base.path, base.surface]))
    points = np.concatenate([base.path, base.surface, *(orbit.path for orbit in orbits)])
    there = np.concatenate([np.empty((0, 2)), *(orbit.path for orbit in others[:: len(orbits)])])
    near, far = first.scaled(NEAR).holds(points), first.scaled(OTHERS).holds(there)
    return Window.around(np.concatenate([points[near], there[far]]))


def power_of_ten(size: float) -> float:
    """Return the power of ten below a size: bounds of a range should change seldom, as each change refits the view."""
    return 10.0 ** math.floor(math.log10(size))
