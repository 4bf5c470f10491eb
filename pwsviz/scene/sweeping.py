"""The settings of a bifurcation diagram: what a system suggests for them, and their checks."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import core
from pwsviz.geometry.section_crossings import chosen_direction, usual_direction
from pwsviz.geometry.section_plane import fixed_variables
from pwsviz.scene.names import SWEEP_CONTINUATIONS, SWEEP_DIRECTIONS, choice_name, short_name
from pwsviz.scene.validation import number, one_of

if TYPE_CHECKING:
    from pwsviz.scene.scene import Scene

__all__ = [
    "AFRESH", "COUNTS", "MOST_POINTS", "USUAL_DISCARD", "checked", "swept_coordinate",
    "swept_direction", "swept_parameter", "swept_range", "usual_parameter", "usual_range",
]  # fmt: skip

MOST_POINTS = 2_000_000
"""Most points of a diagram, so that its memory is bounded."""

COUNTS = {
    "sweep_values": ("The number of values", 2, 4000),
    "sweep_points": ("The number of points for each value", 1, 5000),
    "sweep_discard": ("The number of points discarded", 0, 1_000_000),
}
"""Whole numbers of the settings: what each is, the least and the greatest."""

USUAL_DISCARD = 100
"""Points of each value discarded first where that is automatic, and most runs have more."""

AFRESH: Mapping[str, Any] = {"sweep_parameter": "", "sweep_range": None, "sweep_coordinate": "", "sweep_of": ""}
"""Settings that mean something only for one system, with their values for a new one."""

LARGEST = 1e6
"""Largest |value| of a parameter without bounds."""


# What a system suggests ----------------------------------------------------------------------------------------------


def swept_parameter(scene: Scene) -> core.Parameter | None:
    """Return the chosen parameter, or the one that the system suggests; None if it has none."""
    system = scene.declaration
    chosen = next((q for q in system.parameters if q.name == scene.sweep_parameter), None)
    return chosen or usual_parameter(system)


def usual_parameter(system: core.PiecewiseSystem) -> core.Parameter | None:
    """Return the parameter on which the points on the surfaces are most likely to depend; None if there is none.

    That is the first one of the surfaces and reset maps, else of the field where the system starts (of the orbit of a
    conservative system it may be that no other moves the points), else of any; one with bounds before others.
    """
    laws = system.laws
    jumps = (value for ways in laws.ways for way in ways for value in way.jump or ())
    start = max(range(len(laws.regions)), key=lambda k: system.heights(k, 0.0, system.x0).min())
    parts = ((*laws.surfaces, *jumps), laws.regions[start].field)
    names = [{str(symbol) for expression in part for symbol in expression.free_symbols} for part in parts]

    def rank(parameter: core.Parameter) -> tuple[bool, int]:
        return parameter.bounds is None, next((k for k, part in enumerate(names) if parameter.name in part), len(names))

    return min(system.parameters, key=rank, default=None)


def swept_range(scene: Scene) -> tuple[float, float]:
    """Return the first and the last value of the parameter; (0, 1) if there is none."""
    parameter = swept_parameter(scene)
    if parameter is None:
        return 0.0, 1.0
    low, high = scene.sweep_range or usual_range(parameter)
    return float(low), float(high)


def usual_range(parameter: core.Parameter) -> tuple[float, float]:
    """Return the bounds of a parameter, or where it has none, values around its default."""
    if parameter.bounds:
        return parameter.bounds
    half = abs(parameter.default) / 2 or 1.0
    return parameter.default - half, parameter.default + half


def swept_coordinate(scene: Scene) -> str:
    """Return the chosen variable, or the first one that varies on the surface of the section."""
    system = scene.declaration
    if scene.sweep_coordinate in system.variables:
        return str(scene.sweep_coordinate)
    fixed = fixed_variables(system, scene.sweep_of)
    return next(name for name in system.variables if name not in fixed)


def swept_direction(scene: Scene) -> int:
    """Return the chosen direction of crossing, or the one in which a simple loop has one point, where there is one."""
    if scene.sweep_direction == "auto":
        return usual_direction(scene.declaration, scene.sweep_of, scene.slides)
    return chosen_direction(scene.declaration, scene.sweep_of, int(scene.sweep_direction))


# Their checks --------------------------------------------------------------------------------------------------------


def checked(scene: Scene, name: str, part: str, value: object) -> object:
    """Return one of `pwsviz.scene.views.SWEEP_SETTINGS` as it is applied, as `pwsviz.scene.checks.checked` does.

    `part` is "0" for the first value of a range alone, "1" for its last; else it is empty.
    """
    system = scene.declaration
    if name == "sweep_discard" and (value is None or str(value).strip() in ("", "auto")):
        return None
    if name in COUNTS:
        return _checked_count(scene, name, value)
    match name:
        case "sweep_parameter":
            return value and one_of(system.values, value, str)
        case "sweep_range":
            return _checked_range(scene, part, value)
        case "sweep_coordinate":
            return value and one_of(system.variables, value, str)
        case "sweep_direction":
            return one_of(SWEEP_DIRECTIONS, value, partial(choice_name, name))
        case "sweep_continuation":
            return one_of(SWEEP_CONTINUATIONS, value, partial(choice_name, name))
    return number(value, "The end time of the diagram", *scene.param[name].bounds)


def _checked_count(scene: Scene, name: str, value: object) -> int:
    what, low, high = COUNTS[name]
    count = number(value, what, low, high)
    if count != int(count):
        raise ValueError(f"{what} has to be a whole number; it is “{value}”.")
    factors = {key: getattr(scene, key) for key in ("sweep_values", "sweep_points")} | {name: int(count)}
    if (points := factors["sweep_values"] * factors["sweep_points"]) > MOST_POINTS:
        raise ValueError(
            f"{points:,} points are more than a diagram has ({MOST_POINTS:,}): take fewer values, or fewer points for "
            "each."
        )
    return int(count)


def _checked_range(scene: Scene, part: str, value: object) -> tuple[float, float] | None:
    parameter = swept_parameter(scene)
    if value is None:
        return None
    if parameter is None:
        raise ValueError("This system has no parameter.")
    ends = [*swept_range(scene)] if part else value
    if not isinstance(ends, tuple | list) or len(ends) != 2:
        raise ValueError("A range needs two numbers: the first and the last value.")
    given = list(ends)
    if part:
        given[int(part)] = value
    bounds = parameter.bounds or (-LARGEST, LARGEST)
    low, high = (number(end, short_name(parameter), *bounds) for end in given)
    if not low < high:
        raise ValueError("The last value has to be greater than the first.")
    return low, high
