"""What can be drawn of a system in the plane of two of its variables, and what the page says of the rest.

If a system has more variables, the portrait shows the projections of trajectories. A slice through a surface or a field
is not a projection and would mislead, so it is left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import core
from core.kernels import Floats
from core.symbolic import TIME

Name = TypeVar("Name")

PLANE = 2
"""Dimension of a portrait."""

Axes = tuple[int, int]
"""The two variables, by number, that span the portrait."""


def planes(system: core.PiecewiseSystem) -> list[Axes]:
    """Return all pairs of variables that can span the portrait."""
    return [(a, b) for b in range(system.dimension) for a in range(b)]


def in_plane(x: Floats, axes: Axes) -> Floats:
    """Return the two shown coordinates (n, 2) of states (n, d), without a copy where possible."""
    a, b = axes
    return x[:, a : b + 1 : b - a] if a < b else x[:, (a, b)]


def shows_surface(system: core.PiecewiseSystem, axes: Axes) -> bool:
    """Whether g = 0 is a curve in the plane: g depends on no other variable."""
    return not system.laws.g.free_symbols & set(_others(system.laws.x, axes))


def shows_field(system: core.PiecewiseSystem) -> bool:
    """Whether the field can be drawn as arrows in the plane."""
    return system.dimension == PLANE


def shows_levels(system: core.PiecewiseSystem) -> bool:
    """Whether trajectories follow level sets in the plane: ψ does not depend on time."""
    return system.dimension == PLANE and not _psi_names_time(system)


def shows_sliding(system: core.PiecewiseSystem) -> bool:
    """Whether the pieces of the surface along which states slide can be drawn: nothing changes with time or jumps."""
    laws = system.laws
    timed = any(TIME in f.free_symbols for mode in laws.modes.values() for f in mode.field) or moves(system)
    return system.dimension == PLANE and not timed and system.jump is None


def surface_name(system: core.PiecewiseSystem) -> str:
    """Return the name of the surface in the legend."""
    return "S: g = 0 at t = 0" if moves(system) else "S: g = 0"


def axis_labels(system: core.PiecewiseSystem, axes: Axes) -> tuple[str, str]:
    """Return the labels of the axes of the portrait."""
    across, up = (system.variables[k] for k in axes)
    if system.dimension == PLANE:
        return across, up
    return f"{across} ({', '.join(_others(system.variables, axes))} not shown)", up


def portrait_note(system: core.PiecewiseSystem, axes: Axes) -> str:
    """Return in words what the portrait leaves out or shows at t = 0 only; empty if that is nothing."""
    sentences = []
    if system.dimension > PLANE:
        plane = ", ".join(system.variables[k] for k in axes)
        sentences.append(f"Projected onto the plane of {plane}, in which the field and the level sets cannot be drawn.")
        if not shows_surface(system, axes):
            sentences.append(f"Nor can the surface {system.g} = 0, which is not a curve there.")
    if moves(system) and shows_surface(system, axes):
        sentences.append("The surface moves with time: it is drawn at t = 0, and while animated at the time shown.")
    if system.dimension == PLANE and _psi_names_time(system):
        sentences.append("ψ depends on time, so its level sets move and are not drawn.")
    return " ".join(sentences)


def conserved_note(system: core.PiecewiseSystem) -> str:
    """Return a note for the plot of ψ if a side has no ψ, or more than one; else nothing."""
    counts = {side: len(system.laws.modes[side].conserved) for side in (-1, 1)}
    if not any(counts.values()):
        return f"{system.name}: no conserved quantity is known on either side, so there is no drift to show."
    bare = [f"g {'<' if side < 0 else '>'} 0" for side, count in counts.items() if count == 0]
    if bare:
        return f"No conserved quantity is known where {bare[0]}: there the curves have gaps."
    most = max(counts.values())
    return f"Of the {most} conserved quantities the one that changes most is shown." if most > 1 else ""


def _others(names: Sequence[Name], axes: Axes) -> list[Name]:
    return [name for k, name in enumerate(names) if k not in axes]


def moves(system: core.PiecewiseSystem) -> bool:
    """Whether the surface moves: g names time."""
    return TIME in system.laws.g.free_symbols


def _psi_names_time(system: core.PiecewiseSystem) -> bool:
    return any(TIME in psi.free_symbols for mode in system.laws.modes.values() for psi in mode.conserved)
