"""Formulas as trees of numbers, names and known functions, which the browser evaluates without running any code."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any, TypeAlias

import sympy

import core
from core.symbolic import TIME, Mode
from pwsviz.geometry.plane import Plane
from pwsviz.geometry.projection import (
    PLANE,
    forced,
    moves,
    moves_curves,
    shows_regions,
    shows_surface,
    surfaces_shown,
    time_shown,
)
from pwsviz.geometry.shades import region_name
from pwsviz.geometry.walls import bare_name
from pwsviz.text.math_names import quantity_name, unicode_name

__all__ = ["FUNCTIONS", "Tree", "formulas", "tree"]

Tree: TypeAlias = "float | str | list[Any]"
"""A number, a name, or an operation followed by its operands."""

FUNCTIONS = ("sin", "cos", "tan", "exp", "log", "sinh", "cosh", "tanh")
"""Functions of one number; in sympy and in JavaScript's Math they have the same name."""

OPERATIONS = {sympy.Add: "add", sympy.Mul: "mul", sympy.Pow: "pow", sympy.Abs: "abs"}
"""Other operations, by the class of the expression."""


def tree(expression: sympy.Expr, names: Mapping[sympy.Expr, Tree]) -> Tree | None:
    """Return an expression as a tree; None if it has a part that the browser does not know.

    Parameters
    ----------
    expression : sympy.Expr
        What to write.
    names : mapping
        Number or name of each symbol; there is no value for an expression with another symbol.
    """
    if expression in names:
        return names[expression]
    if expression.is_number:
        return float(expression) if expression.is_real else None
    kind = type(expression)
    name = OPERATIONS.get(kind, kind.__name__ if kind.__name__ in FUNCTIONS else None)
    parts = [tree(part, names) for part in expression.args]
    return None if name is None or None in parts or not parts else [name, *parts]


def formulas(system: core.PiecewiseSystem, plane: Plane, there: Collection[int]) -> dict[str, Any]:
    """Return what can be evaluated at a point of the plane (x, y) and a time t.

    Parameters
    ----------
    system : core.PiecewiseSystem
        The system.
    plane : Plane
        The two variables that span it, and their units.
    there : collection of int
        Numbers of the regions in which a state may be.

    Returns
    -------
    dict
        "g": for each surface, a tree in the names x, y and t, or None where its value is not known from the two shown
        variables; "regions": for each of these the signs of the surfaces in it, its name, the name of its first ψ, and
        a tree of that or None; "bare": the name of the rest of the plane, "" for none; "moving" and "forced": whether a
        g, and whether a field depends on time; "drawn" and "curves_move": whether a surface is a curve, and
        whether one moves; "after": the time after that of
        the picture at which g is evaluated; "units": of the two shown variables.
    """
    laws = system.laws
    across, up = (laws.x[k] for k in plane.axes)
    x, y = (name if unit == 1.0 else ["mul", unit, name] for name, unit in zip("xy", plane.units, strict=True))
    numbers = {symbol: float(value) for symbol, value in zip(laws.p, system.parameter_array, strict=True)}
    names: dict[sympy.Expr, Tree] = {across: x, up: y, TIME: "t", **numbers}
    flat = system.dimension == PLANE
    psi = [mode.conserved[:1] if flat else () for mode in laws.regions]
    known, told = surfaces_shown(system, plane.axes), shows_regions(system, plane.axes)
    return {
        "g": [tree(g, names) if k in known else None for k, g in enumerate(laws.surfaces)],
        "regions": [
            [list(mode.sides), *_names(system, mode), tree(part[0], names) if part else None]
            for k, (mode, part) in enumerate(zip(laws.regions, psi, strict=True)) if told and k in there
        ],
        "bare": bare_name(system, there),
        "moving": moves(system),
        "drawn": shows_surface(system, plane.axes),
        "curves_move": moves_curves(system),
        "after": time_shown(system),
        "forced": forced(system),
        "units": list(plane.units),
    }  # fmt: skip


def _names(system: core.PiecewiseSystem, region: Mode) -> tuple[str, str]:
    """Return what the page calls a region, and its conserved quantity."""
    psi = quantity_name(region.name if system.two_sided else "", 0, len(region.conserved))
    where = f"g {'<' if region.name == '-' else '>'} 0" if system.two_sided else f"region {region_name(region)}"
    return where, unicode_name(psi, psi)
