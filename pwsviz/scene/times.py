"""Step size and end time with which a system is shown first."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import core
from core.studies import moderate_time

__all__ = ["END_TIME", "STEP_SIZE", "Times", "are_alike", "times_of", "usual_times"]

STEP_SIZE = 1e-2
"""Step size of a system of the catalogue."""

END_TIME = 20.0
"""End time of a system of the catalogue that has none of its own in `END_TIMES`."""

END_TIMES = {"vibrating_table": 12.0, "type_upward": 40.0, "type_downward": 40.0, "type_sliding": 40.0}
"""End times of systems that are too slow for `END_TIME`, or run out of sight by then."""


class Times(NamedTuple):
    """Step size and end time."""

    tau: float
    t_end: float
    own: bool = False
    """Whether they are of a system of the user's own."""


def times_of(key: str, own: core.PiecewiseSystem | None = None) -> Times:
    """Return the times of a system of the catalogue; of the user's own, if given, those that follow from its scale."""
    return Times(STEP_SIZE, END_TIMES.get(key, END_TIME)) if own is None else _of_own(own)


def usual_times(system: core.PiecewiseSystem) -> Times:
    """Return the times of a system as it is declared, be it of the catalogue or not."""
    key = next((key for key, one in core.CATALOGUE.items() if one == system), None)
    return _of_own(system) if key is None else times_of(key)


def are_alike(one: core.PiecewiseSystem, other: core.PiecewiseSystem) -> bool:
    """Return whether the times chosen for one system suit another: of the same variables, and about as fast."""
    return one.variables == other.variables and _of_own(one) == _of_own(other)


@lru_cache(maxsize=32)
def _of_own(system: core.PiecewiseSystem) -> Times:
    end = moderate_time(system, END_TIME)
    return Times(end / (END_TIME / STEP_SIZE), end, own=True)
