"""What can be drawn of a system in the plane of two of its variables, and what the page says of the rest.

If a system has more variables, the portrait shows the projections of trajectories. A slice through a surface or a field
is not a projection and would mislead, so it is left out.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import lru_cache
from typing import TypeVar

import sympy

import core
from core.symbolic import TIME, parse, to_text
from pwsviz.geometry.plane import Axes, Plane
from pwsviz.geometry.shades import region_name
from pwsviz.text.math_names import variable_name
from pwsviz.text.numbers import printed

Name = TypeVar("Name")

PLANE = 2
"""Dimension of a portrait."""

JUST_AFTER = 1e-9
"""Time after that of a picture at which the law is shown: at that time itself it may change."""

_NUMBERED = re.compile(r"(\D+)(\d+)")


def planes(system: core.PiecewiseSystem) -> list[Axes]:
    """Return all pairs of variables that can span the portrait."""
    return [(a, b) for b in range(system.dimension) for a in range(b)]


def planes_alike(system: core.PiecewiseSystem, axes: Axes) -> list[Axes]:
    """Return the planes of variables that are named as those of a plane but for one number, as of several bodies.

    With x1, y1 these are x2, y2 and x3, y3: one picture shows all of them. There are none where a surface is drawn: it
    divides the plane of one body, and the others would pass through it unharmed.
    """
    if shows_surface(system, axes):
        return []
    named = [_NUMBERED.fullmatch(name) for name in system.variables]
    across, up = (named[k] for k in axes)
    if across is None or up is None or across[2] != up[2] or across[1] == up[1]:
        return []
    place = {(found[1], found[2]): k for k, found in enumerate(named) if found is not None}
    numbers = [number for letters, number in place if letters == across[1] and number != across[2]]
    return [(place[across[1], n], place[up[1], n]) for n in numbers if (up[1], n) in place]


def surfaces_shown(system: core.PiecewiseSystem, axes: Axes) -> list[int]:
    """Return the numbers of the surfaces that are curves in the plane: their g depends on no other variable."""
    hidden = set(_others(system.laws.x, axes))
    return [k for k, g in enumerate(system.laws.surfaces) if not _symbols(g) & hidden]


def shows_surface(system: core.PiecewiseSystem, axes: Axes) -> bool:
    """Whether a surface is a curve in the plane: an instant is none."""
    return bool({*surfaces_shown(system, axes)} - system.laws.instants)


def shows_regions(system: core.PiecewiseSystem, axes: Axes) -> bool:
    """Whether the plane is divided into regions: all surfaces are curves in it, and their signs tell the region."""
    return bool(len(surfaces_shown(system, axes)) == len(system.laws.surfaces) == system.laws.sides.shape[1])


def shows_field(system: core.PiecewiseSystem) -> bool:
    """Whether the field can be drawn as arrows in the plane."""
    return system.dimension == PLANE and is_divided(system)


def is_divided(system: core.PiecewiseSystem) -> bool:
    """Whether a point of the plane tells the region; of several surfaces, if they do not move."""
    return system.two_sided or (shows_regions(system, (0, 1)) and not moves(system))


def shows_levels(system: core.PiecewiseSystem) -> bool:
    """Whether trajectories follow level sets in the plane: ψ does not depend on time."""
    return system.dimension == PLANE and not psi_names_time(system) and is_divided(system)


def shows_sliding(system: core.PiecewiseSystem) -> bool:
    """Whether the pieces of the surface along which states slide can be drawn: nothing changes with time or jumps."""
    return system.dimension == PLANE and not forced(system) and not moves(system) and not system.laws.jumps


def surface_name(system: core.PiecewiseSystem) -> str:
    """Return the name of the surface in the legend."""
    name = "S: g = 0" if len(system.laws.surfaces) == 1 else "surfaces"
    return f"{name} at t = 0" if moves_curves(system) else name


def surface_texts(system: core.PiecewiseSystem) -> tuple[str, ...]:
    """Return the switching functions as text: as they are declared, where one is."""
    names = (*system.variables, *system.values)
    declared = (*system.surfaces, *(way.guard for way in system.transitions))
    texts = {parse(text, names, "g"): text for text in reversed(declared)}
    return tuple(texts.get(g) or to_text(g) for g in system.laws.surfaces)


def axis_labels(system: core.PiecewiseSystem, plane: Plane) -> tuple[str, str]:
    """Return the labels of the axes of the portrait, with the unit of a variable that has one: y / 10³."""
    names = list(map(variable_name, system.variables))
    drawn = [plane.axes, *planes_alike(system, plane.axes)]
    units = [f" / {unit:.0e}" if unit != 1.0 else "" for unit in plane.units]
    across, up = (printed(", ".join(names[axes[k]] + unit for axes in drawn)) for k, unit in enumerate(units))
    others = [name for k, name in enumerate(names) if all(k not in axes for axes in drawn)]
    if not others:
        return across, up
    hidden = min(", ".join(others), f"{len(others)} other variables", key=len)
    return f"{across} ({hidden} not shown)", up


def conserved_note(system: core.PiecewiseSystem) -> str:
    """Return a note for the plot of ψ if a side has no ψ, or more than one; else nothing."""
    counts = {mode.name: len(mode.conserved) for mode in system.laws.regions}
    where = "on either side" if system.two_sided else "in any region"
    if not any(counts.values()):
        return f"{system.name}: no conserved quantity is known {where}, so there is no |Δψ| to show."
    bare = [mode for mode in system.laws.regions if not mode.conserved]
    if bare and system.two_sided:
        side = "<" if bare[0].name == "-" else ">"
        return f"No conserved quantity is known where g {side} 0: there the curves have gaps."
    if bare:
        names = f"region{'s' * (len(bare) > 1)} {', '.join(map(region_name, bare))}"
        return f"No conserved quantity is known in {names}: there the curves have gaps."
    most = max(counts.values())
    which = "larger |Δψ| of the two" if most == 2 else f"largest |Δψ| of the {most}"
    return f"The {which} conserved quantities is drawn at each time." if most > 1 else ""


def has_bare(system: core.PiecewiseSystem) -> bool:
    """Whether a region has no conserved quantity."""
    return any(not mode.conserved for mode in system.laws.regions)


def _others(names: Sequence[Name], axes: Axes) -> list[Name]:
    return [name for k, name in enumerate(names) if k not in axes]


def moves(system: core.PiecewiseSystem) -> bool:
    """Whether the regions change with time: a g names it."""
    return any(TIME in _symbols(g) for g in system.laws.surfaces)


def moves_curves(system: core.PiecewiseSystem) -> bool:
    """Whether a surface moves: its g names time and a variable."""
    return any(TIME in _symbols(g) for k, g in enumerate(system.laws.surfaces) if k not in system.laws.instants)


def time_shown(system: core.PiecewiseSystem) -> float:
    """Return the time at which the regions are drawn: t = 0, or just after, as the law may change at an instant."""
    return JUST_AFTER if system.laws.instants else 0.0


def forced(system: core.PiecewiseSystem) -> bool:
    """Whether a field names time."""
    return any(TIME in _symbols(f) for mode in system.laws.regions for f in mode.field)


def psi_names_time(system: core.PiecewiseSystem) -> bool:
    """Whether a conserved quantity names time."""
    return any(TIME in _symbols(psi) for mode in system.laws.regions for psi in mode.conserved)


@lru_cache(maxsize=1024)
def _symbols(expression: sympy.Expr) -> frozenset[sympy.Basic]:
    """Return the names in an expression; kept, as they are asked for at each move of a slider."""
    return frozenset(expression.free_symbols)
