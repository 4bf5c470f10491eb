"""section(): points at which many runs meet a surface, and the return map between them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from core.ensemble import Ensemble, checked_members, integrate_all
from core.integrate import checked_method, checked_settings, checked_span
from core.integration.crossings import Integers
from core.integration.members import Wanted
from core.interface.arguments import count, listed, number
from core.interface.cancelling import Cancel
from core.kernels.arrays import Floats
from core.maps.surface import with_surface
from core.methods import Method
from core.symbolic.expressions import quoted
from core.systems import System, system_of

__all__ = ["Section", "checked_wanted", "coordinate_numbers", "section"]

#: Most points of a member, and most of them that are left out.
_MOST = 10**12


@dataclass(frozen=True, eq=False)
class Section:
    """Points of a Poincaré section, member after member."""

    coordinates: tuple[str, ...]
    """Names of the k variables that are the coordinates."""
    points: Floats
    """(c, k) their values."""
    ensemble: Ensemble
    """The members, their ends and all else that is known of the points: ``ensemble.crossings``."""

    def __len__(self) -> int:
        return len(self.points)

    def __repr__(self) -> str:
        return f"<Section: {len(self)} points of {len(self.ensemble)} members in {', '.join(self.coordinates)}>"

    @property
    def member(self) -> Integers:
        """(c,) number of the member of each point."""
        return self.ensemble.crossings.member

    def return_map(self, coordinate: str | None = None) -> Floats:
        """Return (m, 2) pairs of a coordinate: at a point, and at the next one of the same member.

        Parameters
        ----------
        coordinate
            One of `coordinates`; the first where not given.
        """
        name = self.coordinates[0] if coordinate is None else coordinate
        if name not in self.coordinates:
            raise ValueError(f"coordinate = {coordinate!r}: choose from {', '.join(self.coordinates)}")
        values, member = self.points[:, self.coordinates.index(name)], self.member
        follows = member[1:] == member[:-1]
        return np.column_stack([values[:-1][follows], values[1:][follows]])


def section(
    system: System,
    t_span: tuple[float, float],
    x0: ArrayLike | None = None,
    parameters: Mapping[str, ArrayLike] | None = None,
    *,
    points: int,
    of: str | None = None,
    direction: int = 0,
    coordinates: tuple[str, ...] | None = None,
    discard: int = 0,
    tau: float | None = None,
    method: str | Method = "dmm2",
    tolerance: float | None = None,
    max_steps: int | None = None,
    sliding: str = "stop",
    executor: Executor | None = None,
    cancel: Cancel | None = None,
    progress: Callable[[float], object] | None = None,
) -> Section:
    """Find where runs meet a surface: a Poincaré section.

    Crossings of the surface are located like all others, whether anything switches there or not.

    Parameters
    ----------
    system, x0, parameters, tau, method, tolerance, max_steps, sliding, executor, cancel, progress
        As of `ensemble`.
    t_span
        Start time, and the time at which a member ends that has not had all its points by then.
    points
        Number of points of each member, at most. Memory is bounded by that, as of `ensemble`.
    of
        h(t, x), an expression whose zeros are the surface: one of the system's own, or a further one of at most six in
        all. None: the switching surface; of several surfaces, all. A member that touches it stops there, GRAZING, as at
        any surface.
    direction
        1: where h increases, −1: where it decreases, 0: both.
    coordinates
        Variables that are the coordinates of a point; all where not given.
    discard
        Number of the first points of each member that are left out: a transient.

    Returns
    -------
    Section

    Raises
    ------
    ValueError
        On arguments that make no sense.
    """
    own = system_of(system)
    chosen, wanted = checked_method(own, method), checked_wanted(points, direction, discard)
    surface = with_surface(own, of)
    wanted = wanted._replace(surface=surface.number, way=wanted.way * surface.sign)
    settings = checked_settings(
        chosen, tau, tolerance, max_crossings=10**9, max_steps=max_steps, sliding=sliding
    )  # fmt: skip
    names = own.variables if coordinates is None else coordinates
    columns = coordinate_numbers(own.variables, names)
    members = checked_members(surface.system, chosen, settings, checked_span(t_span), x0, parameters, wanted)
    found = integrate_all(members, executor, cancel, progress)
    return Section(tuple(names), found.crossings.x[:, columns], found)


def checked_wanted(points: int, direction: int, discard: int) -> Wanted:
    """Return which crossings are wanted, of a surface still to be named; ValueError if that makes no sense."""
    if direction not in (-1, 0, 1):
        raise ValueError(f"direction = {direction!r}: 1 where h increases, -1 where it decreases, 0 for both")
    first = number(discard, "discard")
    if first < 0 or first != int(first) or first > _MOST:
        raise ValueError(f"discard = {discard!r}: a whole number from 0 to {_MOST:,} is needed")
    return Wanted(way=int(direction), discard=int(first), most=count(points, "points", _MOST))


def coordinate_numbers(variables: tuple[str, ...], names: tuple[str, ...]) -> list[int]:
    """Return the numbers of variables, by their names; ValueError if one is none."""
    given = listed(names, "coordinates", "names of variables are needed", str)
    for name in given:
        if name not in variables:
            raise ValueError(f"{quoted(str(name))} is no variable; coordinates are some of {', '.join(variables)}")
    if not given:
        raise ValueError(f"coordinates = {names!r}: at least one of {', '.join(variables)} is needed")
    return [variables.index(name) for name in given]
