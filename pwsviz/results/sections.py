"""Poincaré sections for the page: points of all starts, in portions that grow."""

from __future__ import annotations

from concurrent.futures import Executor, as_completed
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import core
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.results.requests import SectionInputs
from pwsviz.tasks.cancellation import Cancel, Cancelled, Report

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


@dataclass(frozen=True)
class SectionPoints:
    """The points of a section, as far as they are computed."""

    inputs: SectionInputs
    portions: tuple[SectionPortion, ...]
    """Of each start in order of time."""
    statuses: tuple[core.Status | None, ...]
    """How the run of each start ended; None while it is under way."""
    ends: tuple[float, ...]
    """Time that the run of each start has reached."""

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

    def of_start(self, k: int) -> SectionPortion:
        """Return all points of one start as one portion."""
        mine = [one for one in self.portions if one.start == k]
        d = len(self.inputs.starts[k])
        return SectionPortion(
            k,
            np.concatenate([np.empty(0), *(one.t for one in mine)]),
            np.concatenate([np.empty((0, d)), *(one.x for one in mine)]),
            np.concatenate([np.empty(0, dtype=np.int16), *(one.mode for one in mine)]),
        )


def section_arguments(inputs: SectionInputs) -> dict[str, Any]:
    """Return the arguments of `core.section` beside system, end time and starts."""
    given: dict[str, Any] = {"points": inputs.points, "of": inputs.of or None, "direction": inputs.direction}
    given |= {"discard": inputs.discard, "method": inputs.scheme.method, "tau": inputs.tau}
    given |= {} if inputs.scheme.tolerance is None else {"tolerance": inputs.scheme.tolerance}
    most = LEAST_STEPS + STEPS_A_POINT * (inputs.points + inputs.discard)
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

    def run(start: int, points: int) -> core.Section:
        if cancel():
            raise Cancelled
        arguments = section_arguments(inputs) | {"points": points}
        return core.section(system, (0.0, HORIZON), inputs.starts[start], cancel=cancel, **arguments)

    for points in _rounds(inputs.points, inputs.discard):
        going = [k for k, status in enumerate(found.statuses) if status is None]
        under_way = {pool.submit(run, k, points): k for k in going}
        try:
            for future in as_completed(under_way):
                section = future.result()
                if not cancel():
                    found = _extended(found, under_way[future], section, points)
                    report(sum(found.counts), inputs.points * count, found)
        finally:
            for future in under_way:
                future.cancel()
    return found


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
    goes_on = len(section) == wanted < found.inputs.points
    statuses[start] = None if goes_on else core.Status(int(section.ensemble.status[0]))
    ends[start] = float(section.ensemble.t[0])
    mode = crossings.mode if len(crossings) else events.mode
    fresh = SectionPortion(start, section.t[before:].copy(), section.points[before:].copy(), mode[before:].copy())
    portions = (*found.portions, fresh) if len(fresh.t) else found.portions
    return replace(found, portions=portions, statuses=tuple(statuses), ends=tuple(ends))


def _require_room(inputs: SectionInputs) -> None:
    """Raise a ValueError that says what to change if the points would take too much memory."""
    each = len(inputs.starts) * (2 + len(inputs.starts[0]))
    if inputs.points * each > MOST_NUMBERS:
        raise ValueError(
            f"{inputs.points:,} points of each of {len(inputs.starts)} starts are more than this page keeps: take at "
            f"most {MOST_NUMBERS // each:,}, or fewer starts."
        )
