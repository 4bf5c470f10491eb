"""section(): points at which many runs meet a surface, and the return map between them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from core.ensemble import MOST, Ensemble, checked_discard, checked_members, integrate_all
from core.integrate import checked_method, checked_region, checked_settings, checked_span
from core.integration.crossings import Integers
from core.integration.events import NOTHING, Event, checked_direction, checked_events
from core.integration.members import Wanted
from core.interface.arguments import count, listed
from core.interface.cancelling import Cancel
from core.interface.tasks import check_hooks
from core.kernels.arrays import Floats
from core.maps.surface import own_surface
from core.methods import Method
from core.symbolic.source_text import quoted
from core.systems import System, system_of

__all__ = ["Section", "coordinate_numbers", "section"]


@dataclass(frozen=True, eq=False)
class Section:
    """Points of a Poincaré section, member after member."""

    coordinates: tuple[str, ...]
    """Names of the k variables that are the coordinates."""
    points: Floats
    """(c, k) their values; where a reset map acts, those after it."""
    t: Floats
    """(c,) times of the points."""
    member: Integers
    """(c,) number of the member of each point."""
    ensemble: Ensemble
    """The members, their ends, and all else that is known of the points: they are ``ensemble.crossings`` of a section
    of the system's own surface, else ``ensemble.events``."""

    def __len__(self) -> int:
        return len(self.points)

    def __repr__(self) -> str:
        return f"<Section: {len(self)} points of {len(self.ensemble)} members in {', '.join(self.coordinates)}>"

    @property
    def message(self) -> str:
        """How the members ended, and a warning of steps that are too long: see `Ensemble.message`."""
        return self.ensemble.message

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
    region: str | None = None,
    executor: Executor | None = None,
    cancel: Cancel | None = None,
    progress: Callable[[float], object] | None = None,
) -> Section:
    """Find where runs meet a surface: a Poincaré section.

    Where nothing switches there, the points are `events` of the runs, which are the same without them.

    Parameters
    ----------
    system, x0, parameters, tau, method, tolerance, max_steps, sliding, region, executor, cancel, progress
        As of `ensemble`.
    t_span
        Start time, and the time at which a member ends that has not had all its points by then.
    points
        Number of points of each member, at most. Memory is bounded by that, as of `ensemble`.
    of
        h(t, x), an expression whose zeros are the surface. None: the switching surface; of several surfaces, all.
    direction
        1: where h increases with time, −1: where it decreases, 0: both; so also of runs that go back in time.
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
    check_hooks(cancel, progress, executor)
    own = system_of(system)
    chosen, way, first = checked_method(own, method), checked_direction(direction), checked_discard(discard)
    most, surface, events = count(points, "points", MOST), own_surface(own, of), NOTHING
    if surface is None:
        wanted, events = Wanted(events=1, discard=first), checked_events(own, Event(str(of), way))
    else:
        wanted = Wanted(surface=surface.number, way=way * surface.sign, discard=first, most=most)
    settings = checked_settings(
        chosen, tau, tolerance, max_crossings=10**9, max_steps=max_steps, sliding=sliding, events=events,
        max_events=first + most, region=checked_region(own, region),
    )  # fmt: skip
    names = own.variables if coordinates is None else coordinates
    columns = coordinate_numbers(own.variables, names)
    members = checked_members(own, chosen, settings, checked_span(t_span), x0, parameters, wanted)
    found = integrate_all(members, executor, cancel, progress)
    if surface is None:
        t, x, member = found.events.t, found.events.x, found.events.member
    else:
        t, x, member = found.crossings.t, found.crossings.x_after, found.crossings.member
    return Section(tuple(names), x[:, columns], t, member, found)


def coordinate_numbers(variables: tuple[str, ...], names: tuple[str, ...]) -> list[int]:
    """Return the numbers of variables, by their names; ValueError if one is none."""
    given = listed(names, "coordinates", "names of variables are needed", str)
    for name in given:
        if name not in variables:
            raise ValueError(f"{quoted(str(name))} is not a variable; coordinates are some of {', '.join(variables)}")
    if len(set(given)) < len(given):
        raise ValueError(f"coordinates = {names!r}: a variable is given twice")
    if not given:
        raise ValueError(f"coordinates = {names!r}: at least one of {', '.join(variables)} is needed")
    return [variables.index(name) for name in given]
