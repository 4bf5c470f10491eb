"""The plane of a Poincaré section: its surface, and what may be its coordinates."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import sympy
from contourpy import LineType, contour_generator

import core
from core.kernels import Floats
from core.symbolic import TIME, parse
from pwsviz.geometry.line_pieces import joined
from pwsviz.geometry.window import Window
from pwsviz.text.math_names import variable_name

__all__ = [
    "TURN", "angles", "coordinate_label", "coordinate_names", "fixed_variables", "in_first_turn", "names_time",
    "seen_as_curves", "surface_curves", "surface_functions", "usual_plane",
]  # fmt: skip

GRID = 240
"""Cells along each side of the grid on which the curves of a surface are traced."""

TURN = 2 * math.pi
"""Period of an angle."""


def coordinate_names(system: core.PiecewiseSystem) -> tuple[str, ...]:
    """Return what may be an axis of a section, as it is printed: the variables, and time."""
    return (*map(variable_name, system.variables), "t")


def coordinate_label(system: core.PiecewiseSystem, k: int) -> str:
    """Return the name of a coordinate as it is shown; of an angle, that full turns are left out."""
    name = coordinate_names(system)[k]
    return f"{name} mod 2π" if k in angles(system) else name


def in_first_turn(system: core.PiecewiseSystem, k: int, values: Floats) -> Floats:
    """Return values of a coordinate as they are shown: those of an angle in the first turn."""
    return np.mod(values, TURN) if k in angles(system) else values


def surface_functions(system: core.PiecewiseSystem, of: str) -> tuple[sympy.Expr, ...]:
    """Return h of a section; of the system's own surfaces, which "" stands for, every switching function.

    Raises
    ------
    ValueError
        If the text is not a function of the system's variables, its parameters and t, or is constant.
    """
    if not of:
        return tuple(system.laws.surfaces)
    return (_read(of, (*system.variables, *system.values)),)


@lru_cache(maxsize=256)
def _read(of: str, names: tuple[str, ...]) -> sympy.Expr:
    found = parse(of, names, "h")
    if not found.free_symbols:
        raise ValueError(f"h = {of} is constant: a section needs a function that vanishes somewhere.")
    return found


def usual_plane(system: core.PiecewiseSystem, of: str) -> tuple[int, int]:
    """Return the numbers of the two coordinates that show most of a section.

    A variable that h = 0 determines is left out: one that is constant there, or in which h is linear, of which the
    factor does not change. Of the others, a coordinate and its rate are preferred. In a plane, both variables are
    shown, unless one is constant; a variable that is left alone is shown over time.
    """
    count, functions = system.dimension, surface_functions(system, of)
    constant = fixed_variables(system, of)
    if count <= 2:
        free = [k for k, name in enumerate(system.variables) if name not in constant] or [0]
        return (free[0], free[1]) if len(free) == 2 else (free[0], count)
    given = next(
        (k for k, x in enumerate(system.laws.x) if x.name in constant or all(_determines(h, x) for h in functions)),
        None,
    )
    left = [k for k in range(count) if k != given]
    fields = [mode.field for mode in system.laws.regions]
    for a in left:
        for b in left:
            if a != b and all(field[a] == system.laws.x[b] for field in fields):
                return a, b
    return left[0], left[1]


def names_time(system: core.PiecewiseSystem, of: str) -> bool:
    """Whether it matters when a run is at a point of a section: a law, a reset map or the surface contains t."""
    return system.laws.names_time or any(TIME in h.free_symbols for h in surface_functions(system, of))


def seen_as_curves(system: core.PiecewiseSystem, of: str, axes: tuple[int, int]) -> list[sympy.Expr]:
    """Return those h of a section that depend on the two coordinates shown alone, so that h = 0 is a curve there."""
    shown = {system.laws.x[k] for k in axes if k < system.dimension} | set(system.laws.p)
    return [h for h in surface_functions(system, of) if h.free_symbols - set(system.laws.p) and h.free_symbols <= shown]


def surface_curves(system: core.PiecewiseSystem, of: str, axes: tuple[int, int], window: Window) -> Floats:
    """Return (k, 2) the curves h = 0 in a window, where the coordinates shown decide it; NaN between the pieces."""
    x, y = np.linspace(window.x_low, window.x_high, GRID + 1), np.linspace(window.y_low, window.y_high, GRID + 1)
    states = np.zeros((len(y), len(x), system.dimension + 1))  # time is the last coordinate
    states[..., axes[0]], states[..., axes[1]] = np.meshgrid(x, y)
    curves = []
    for h in seen_as_curves(system, of, axes):
        with np.errstate(all="ignore"):
            values = system.laws.evaluate(("curve", h), (h,), 0.0, states[..., :-1], system.parameter_array)
        trace = contour_generator(x, y, np.asarray(values)[..., 0], line_type=LineType.ChunkCombinedNan)
        curves += [line for line in trace.lines(0.0)[0] if line is not None]
    return joined(curves)


def fixed_variables(system: core.PiecewiseSystem, of: str) -> set[str]:
    """Return the variables that are constant on the surface of a section; of several surfaces, on each."""
    return set.intersection(*(_fixed_on(h, system) for h in surface_functions(system, of)))


def _fixed_on(h: sympy.Expr, system: core.PiecewiseSystem) -> set[str]:
    """Return the variable that is constant where h = 0: the only one of h, if the surface does not move."""
    within = {symbol.name for symbol in h.free_symbols} & {TIME.name, *system.variables}
    return within if len(within) == 1 and TIME.name not in within else set()


def _determines(h: sympy.Expr, x: sympy.Symbol) -> bool:
    """Whether h = 0 has one solution x, whatever the other variables are."""
    slope = sympy.diff(h, x)
    return slope != 0 and not slope.free_symbols


@lru_cache(maxsize=64)
def angles(system: core.PiecewiseSystem) -> frozenset[int]:
    """Return the numbers of the variables that are angles: a full turn, 2π, changes no law."""
    return frozenset(k for k in range(system.dimension) if _turns(system, k))


def _turns(system: core.PiecewiseSystem, k: int) -> bool:
    laws = system.laws
    x, turn = laws.x[k], {laws.x[k]: laws.x[k] + 2 * sympy.pi}
    smooth = [*laws.surfaces, *(f for mode in laws.regions for f in mode.field)]
    if any(e.subs(turn) != e for e in smooth):
        return False
    jumps = [way.jump for ways in laws.ways for way in ways if way.jump]
    changes = [sympy.expand(part.subs(turn) - part) for jump in jumps for part in jump]
    wanted = [2 * sympy.pi if n == k else sympy.S.Zero for jump in jumps for n in range(len(jump))]
    named = any(x in e.free_symbols for e in smooth)
    return changes == wanted and named
