"""What is looked at first of a system that nobody has looked at: which plane, and where in it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import core
from core.diagnostics import inhabited
from pwsviz.geometry.plane import Axes
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.geometry.projection import PLANE, is_divided, planes, surfaces_shown, time_shown
from pwsviz.geometry.window import Window

__all__ = ["first_plane", "with_room"]

FLAT = 1 / 3
"""Ratio of height and width, or of width and height, below which a trajectory looks like a line at equal scales."""

TAILS = 0.02
"""Part of the states at either end of a coordinate that do not count for its extent: a run may end far out."""

SAMPLES = 24
"""Points along each side of a window at which it is looked whether the laws hold."""


def first_plane(system: core.PiecewiseSystem, states: Floats) -> Axes:
    """Return the plane in which a run is looked at first: that of the first two variables, as a rule.

    Where it is flat there, or no surface is seen and another plane shows one, it is the plane that shows most surfaces
    among those where the run is not flat; of equals, where it is least flat.

    Parameters
    ----------
    system : core.PiecewiseSystem
        The system.
    states : (n, d) array
        The states of the run; those that are not finite do not count.
    """
    there = states[np.isfinite(states).all(axis=1)]
    low, high = np.quantile(there, [TAILS, 1.0 - TAILS], axis=0)
    extent = high - low

    def fullness(axes: Axes) -> float:
        sides = extent[list(axes)]
        return float(sides.min() / sides.max()) if sides.max() > 0.0 else 0.0

    def worth(axes: Axes) -> tuple[int, float]:
        return len(surfaces_shown(system, axes)), fullness(axes)

    usual: Axes = (0, 1)
    offered = planes(system)
    full = [axes for axes in offered if fullness(axes) >= FLAT] or offered
    blank = fullness(usual) >= FLAT and not worth(usual)[0] and any(worth(axes)[0] for axes in full)
    if not blank and (fullness(usual) >= FLAT or not any(fullness(axes) > fullness(usual) for axes in offered)):
        return usual
    return max(full, key=worth)


def with_room(system: core.PiecewiseSystem, window: Window) -> Window:
    """Return a window with the room that a portrait adds to its shorter side at equal scales, where the laws hold.

    The frame of a portrait is nearly square on most screens. The room is on both sides, as the browser adds it, unless
    more of it lies within the laws on one of them: nothing is to be seen beyond a wall, or, where ψ has a logarithm of
    x, beyond x = 0.

    Parameters
    ----------
    system : core.PiecewiseSystem
        A system; of one with more than two variables, or whose regions cannot be told, the window is returned.
    window : Window
        What has to be shown.
    """
    if system.dimension != PLANE or not is_divided(system):
        return window
    more_x = max(0.0, window.height - window.width)
    more_y = max(0.0, window.width - window.height)

    def grown(share: float) -> Window:
        x, y = window.x_low - share * more_x, window.y_low - share * more_y
        return Window(x, x + window.width + more_x, y, y + window.height + more_y)

    offered = [grown(share) for share in (0.5, 0.0, 1.0)]
    lawful = [_lawful(system, one).sum() for one in offered]
    best = int(np.argmax(lawful))  # the first of equals
    return offered[best] if best > 0 else window


def _lawful(system: core.PiecewiseSystem, window: Window) -> NDArray[np.bool_]:
    """Return at which points of a lattice on a window a state may be, and field and ψ are finite there, at t = 0."""
    across = np.linspace(window.x_low, window.x_high, SAMPLES)
    up = np.linspace(window.y_low, window.y_high, SAMPLES)
    states = np.stack(np.meshgrid(across, up), axis=-1).reshape(-1, PLANE)
    lawful = np.zeros(len(states), dtype=bool)
    with np.errstate(all="ignore"):
        for mode in sorted(inhabited(system)):
            law = system.laws.regions[mode]
            inside = system.heights(mode, time_shown(system), states).min(axis=-1) > 0
            for values in (system.field(law.name, 0.0, states), system.conserved(law.name, 0.0, states)):
                inside = inside & np.isfinite(values).all(axis=-1)
            lawful |= inside
    return lawful
