"""Poincaré sections for the page: points of all starts, in portions that grow."""

from __future__ import annotations

import math
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import core
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.geometry.section_plane import in_first_turn
from pwsviz.results.requests import SectionInputs
from pwsviz.results.resting import ROUND_OFF, first_at_rest
from pwsviz.tasks.cancellation import Cancel, Cancelled, Report
from pwsviz.text.advice import on_page

__all__ = ["HORIZON", "SectionPoints", "SectionPortion", "section_arguments", "studied_section"]

HORIZON = 1e9
"""End time of the runs of a section, which end by their points."""

STEPS_A_POINT = 5000
"""Steps for each point, on average, after which a run is given up: it does not come back."""

LEAST_STEPS = 200_000
"""Steps that every run is given."""

FIRST = 200
"""Points of each start in the first round, at least: they are there at once."""

GROWTH = 4
"""Ratio of the points of two rounds. Each round begins anew, so that its points are those of one long run to the last
bit, even where time or hysteresis matters; all rounds before the last take a third of its time."""

MOST_NUMBERS = 24_000_000
"""Most numbers kept of one section: 192 MB."""


@dataclass(frozen=True)
class SectionPortion:
    """Points of one start, that came together."""

    start: int
    """Index of the start."""
    t: Floats
    """(n,) times."""
    x: Floats
    """(n, d) states; at a surface with a reset map, those after it."""
    mode: NDArray[np.int16]
    """(n,) mode entered."""
    surface: NDArray[np.int8]
    """(n,) number of the system's own surface that is met; 0 of another one."""


@dataclass(frozen=True)
class SectionPoints:
    """The points of a section, as far as they are computed."""

    inputs: SectionInputs
    portions: tuple[SectionPortion, ...]
    """Of each start in order of time."""
    statuses: tuple[core.Status | None, ...]
    """How the run of each start ended; None while it is under way."""
    ends: tuple[float, ...]
    """Time that the run of each start has reached, or at which it has come to rest."""
    at_rest: frozenset[int] = frozenset()
    """Indices of the starts whose motion has come to rest; points from then on are left out."""
    warnings: tuple[str, ...] = ()
    """What is said against the steps of the run of each start, once all are done; empty where nothing is."""

    @property
    def counts(self) -> tuple[int, ...]:
        """Number of points of each start."""
        found = [0] * len(self.statuses)
        for portion in self.portions:
            found[portion.start] += len(portion.t)
        return tuple(found)

    @property
    def short(self) -> tuple[int, ...]:
        """Indices of the starts whose runs ended before they had all their points."""
        counts, most = self.counts, self.inputs.points
        return tuple(k for k, status in enumerate(self.statuses) if status is not None and counts[k] < most)

    @property
    def noise(self) -> float:
        """Difference of two points that may be one of errors alone: of rounding, or of steps within the tolerance.

        Roundings of many steps add up as the square root of their number; they, and those of a time in the laws, are
        relative to the largest number on the way.
        """
        system, tolerance = self.inputs.problem.declaration, self.inputs.scheme.tolerance
        parts = [np.array(self.inputs.starts), *(portion.x for portion in self.portions)]
        size = max(float(np.abs(part).max(initial=0.0)) for part in parts)
        shown = [in_first_turn(system, k, part[:, k]) for part in parts for k in range(system.dimension)]
        drawn = max(float(np.abs(column).max(initial=0.0)) for column in shown)
        steps = max(self.ends, default=0.0) / self.inputs.tau
        each = 2 * float(np.finfo(float).eps) * math.sqrt(max(steps, 0.0)) if tolerance is None else tolerance
        return max(ROUND_OFF * size, each * drawn)

    def is_one_point(self, k: int) -> bool:
        """Whether the points of a start differ by no more than errors may."""
        x, system = self.of_start(k).x, self.inputs.problem.declaration
        columns = [in_first_turn(system, j, x[:, j]) for j in range(system.dimension)]
        return len(x) > 1 and all(np.ptp(column) <= self.noise for column in columns)

    def of_start(self, k: int) -> SectionPortion:
        """Return all points of one start as one portion."""
        mine = [one for one in self.portions if one.start == k]
        d = len(self.inputs.starts[k])
        return SectionPortion(
            k,
            np.concatenate([np.empty(0), *(one.t for one in mine)]),
            np.concatenate([np.empty((0, d)), *(one.x for one in mine)]),
            np.concatenate([np.empty(0, dtype=np.int16), *(one.mode for one in mine)]),
            np.concatenate([np.empty(0, dtype=np.int8), *(one.surface for one in mine)]),
        )


def section_arguments(inputs: SectionInputs, points: int | None = None) -> dict[str, Any]:
    """Return the arguments of `core.section` beside system, end time and starts, for so many points or for all."""
    wanted = inputs.points if points is None else points
    given: dict[str, Any] = {"points": wanted, "of": inputs.of or None, "direction": inputs.direction}
    given |= {"discard": inputs.discard, "method": inputs.scheme.method, "tau": inputs.tau}
    given |= {} if inputs.scheme.tolerance is None else {"tolerance": inputs.scheme.tolerance}
    most = LEAST_STEPS + STEPS_A_POINT * (wanted + inputs.discard)
    return {**given, "max_steps": most, "sliding": inputs.scheme.sliding}


def studied_section(inputs: SectionInputs, pool: Executor, cancel: Cancel, report: Report) -> SectionPoints:
    """Compute the points of a section, round by round, each with more points of every start.

    Raises
    ------
    ValueError
        If there are too many points to keep, or `core.section` refuses the surface.
    """
    _require_room(inputs)
    system, count = inputs.problem.build(), len(inputs.starts)
    found = SectionPoints(inputs, (), (None,) * count, (0.0,) * count)
    last: dict[int, core.Section] = {}

    def run(start: int, points: int) -> core.Section:
        if cancel():
            raise Cancelled
        arguments = section_arguments(inputs, points)
        return core.section(system, (0.0, HORIZON), inputs.starts[start], cancel=cancel, **arguments)

    for points in _rounds(inputs.points, inputs.discard):
        going = [k for k, status in enumerate(found.statuses) if status is None]
        under_way = {pool.submit(run, k, points): k for k in going}
        try:
            for future in as_completed(under_way):
                section = last[under_way[future]] = future.result()
                if not cancel():
                    found = _extended(found, under_way[future], section, points)
                    report(sum(found.counts), inputs.points * count, found)
        finally:
            for future in under_way:
                future.cancel()
    if cancel():
        return found
    return replace(found, warnings=tuple(pool.map(_warning, (last[k] for k in range(count)))))


def _warning(section: core.Section) -> str:
    """Return what is said against the steps of the run of a start."""
    system = section.ensemble.system
    return on_page(section.ensemble.warning(0), system.variables)


def _rounds(points: int, discard: int) -> list[int]:
    """Return the numbers of points of each start, round by round; those left out are found anew in each round."""
    sizes, most = [points], points + discard
    while (most := most // GROWTH) - discard >= FIRST:
        sizes.append(most - discard)
    return sizes[::-1]


def _extended(found: SectionPoints, start: int, section: core.Section, wanted: int) -> SectionPoints:
    """Add those points of a start that were not there before; so many were wanted."""
    crossings, events, before = section.ensemble.crossings, section.ensemble.events, found.counts[start]
    statuses, ends = list(found.statuses), list(found.ends)
    status, times = core.Status(int(section.ensemble.status[0])), [*section.t, section.ensemble.t[0]]
    first = _first_at_rest(found.inputs, start, section, status)
    at_rest = found.at_rest | {start} if first < len(times) else found.at_rest
    goes_on = wanted < found.inputs.points and (len(section) == wanted or status is core.Status.STEP_LIMIT)
    statuses[start] = None if goes_on and start not in at_rest else status
    ends[start] = float(times[min(first, len(section))])
    mode, kept = crossings.mode if len(crossings) else events.mode, slice(before, first + 1)
    surface = crossings.surface_met if len(crossings) else np.zeros(len(mode), dtype=np.int8)
    fresh = SectionPortion(
        start, section.t[kept].copy(), section.points[kept].copy(), mode[kept].copy(), surface[kept].copy()
    )
    portions = (*found.portions, fresh) if len(fresh.t) else found.portions
    return replace(found, portions=portions, statuses=tuple(statuses), ends=tuple(ends), at_rest=at_rest)


def _first_at_rest(inputs: SectionInputs, start: int, section: core.Section, status: core.Status) -> int:
    """Return the number of the first state at rest, of the points and the end of a run; that of states if none is."""
    states = np.vstack([section.points, section.ensemble.x])
    size = float(np.abs([*states, inputs.starts[start]]).max())
    if status in (core.Status.CROSSING_LIMIT, core.Status.EVENT_LIMIT):  # it goes on: does it from point to point?
        may_rest = float(np.abs(np.diff(section.points[-2:], axis=0)).max(initial=0.0)) <= ROUND_OFF * size
    else:
        may_rest = status in (core.Status.STEP_LIMIT, core.Status.COMPLETED, core.Status.NO_CONVERGENCE)
    if not may_rest:
        return len(states)
    return first_at_rest(inputs.problem.build(), states, size, inputs.scheme.sliding)


def _require_room(inputs: SectionInputs) -> None:
    """Raise a ValueError that says what to change if the points would take too much memory."""
    each = len(inputs.starts) * (2 + len(inputs.starts[0]))
    if inputs.points * each > MOST_NUMBERS:
        raise ValueError(
            f"{inputs.points:,} points of each of {len(inputs.starts)} starts are more than this page keeps: take at "
            f"most {MOST_NUMBERS // each:,}, or fewer starts."
        )
