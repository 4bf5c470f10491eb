"""The part of the plane that suits the trajectories of a portrait."""

from __future__ import annotations

import math

import numpy as np

from pwsviz.geometry.phase_plane import closed_surface
from pwsviz.geometry.projection import PLANE
from pwsviz.geometry.window import Window
from pwsviz.results.results import Pictures

__all__ = ["OTHERS", "extent", "power_of_ten"]

NEAR = 1.2
"""Size, relative to the first orbit, of the window within which orbits of other integrators may widen the view."""

OTHERS = 3.0
"""The same for orbits from other starts."""

COMPARABLE = 2.0
"""A closed surface within a window this many times as large as that of an orbit is shown whole beside it."""

BARE = 0.06
"""Margin around the trajectories of a projection, in which there is no field to be seen beside them."""


def extent(pictures: Pictures) -> Window:
    """Return the box of the first orbit that stays, closed surfaces of comparable size, and the orbits near it.

    Of the orbits from other starts, and in planes alike, those of the first integrator count, farther out (`OTHERS`)
    than the orbits of other integrators (`NEAR`). Of one that runs off only the start counts, unless all do. All starts
    are shown.
    """
    stay = [orbit for orbit in (*pictures.orbits, *pictures.thin) if not orbit.runs_off]
    base = stay[0] if stay else pictures.orbits[0]
    orbits, others = (
        [orbit.focus for orbit in given if not (orbit.runs_off and stay)]
        for given in (pictures.orbits, pictures.thin[:: len(pictures.orbits)])
    )
    system = pictures.system
    surface = closed_surface(system, Window.around(base.focus).scaled(COMPARABLE), pictures.plane)
    first = Window.around(np.concatenate([base.focus, surface]))
    points = np.concatenate([base.focus, surface, *orbits])
    there = np.concatenate([np.empty((0, 2)), *others])
    starts = np.array([orbit.start for orbit in (*pictures.orbits, *pictures.thin)])
    near, far = first.scaled(NEAR).holds(points), first.scaled(OTHERS).holds(there)
    shown = np.concatenate([points[near], there[far], starts])
    return Window.around(shown) if system.dimension == PLANE else Window.around(shown, BARE)


def power_of_ten(size: float) -> float:
    """Return the power of ten below a size: bounds of a range should change seldom, as each change refits the view."""
    return 10.0 ** math.floor(math.log10(size))
