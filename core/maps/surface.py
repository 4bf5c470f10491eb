"""The surface of a section: one of the system's own, or another one, at which nothing switches."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import sympy

from core.symbolic.expressions import parse
from core.symbolic.parts import Region, Transition
from core.system import PiecewiseSystem

__all__ = ["Surface", "with_surface"]


class Surface(NamedTuple):
    """Where a section is."""

    system: PiecewiseSystem
    """The system, with the surface among its own."""
    number: int
    """Number of the surface; −1 for all."""
    sign: int = 1
    """Sign with which the system has its function: a guard may be the negative of another one."""


def with_surface(system: PiecewiseSystem, function: str | None) -> Surface:
    """Add a surface at which nothing switches, so that it is located as the others are.

    Each region becomes two, of the same law. Where regions have names, these are those of the region and a sign.

    Parameters
    ----------
    function
        h(t, x), whose zeros are the section. None, or a multiple of one of the system's switching functions: the
        section is of that.

    Raises
    ------
    ValueError
        If h makes no sense, or there are six surfaces already; or if h cannot be followed through the system's jumps.
    """
    if function is None:
        return Surface(system, 0 if system.two_sided else -1)
    own = _own_surface(system, function)
    if own is not None:
        return own
    laws = {f"{name}{sign}": Region(region.f, region.psi) for name, region in system.regions.items() for sign in "-+"}
    if not system.transitions:
        jumps = dict(system.jumps)
        surfaces = (*system.surfaces, function)
        return Surface(_redeclared(system, laws, function, surfaces=surfaces, jumps=jumps), len(system.surfaces))
    if any(way.jump for way in system.transitions):
        raise ValueError(
            f"of = {function!r}: a section of a system whose transitions jump is that of one of its guards"
        )
    ways = [replace(way, mode=f"{way.mode}{sign}", to=f"{way.to}{sign}") for way in system.transitions for sign in "-+"]
    for name in system.regions:
        ways += [Transition(f"{name}-", f"-({function})", f"{name}+"), Transition(f"{name}+", function, f"{name}-")]
    extended = _redeclared(system, laws, function, transitions=tuple(ways))
    guard = extended.laws.ways[extended.laws.numbers_of_modes[f"{next(iter(system.regions))}+"]][-1]
    return Surface(extended, guard.surface, guard.sign)


def _own_surface(system: PiecewiseSystem, function: str) -> Surface | None:
    """Return the surface of the system of whose switching function another one is a multiple; None if there is none."""
    laws, names = system.laws, (*system.variables, *system.values)
    wanted = sympy.expand(parse(function, names, "of")).primitive()[1]
    for number, surface in enumerate(laws.surfaces):
        for sign in (1, -1):
            if sympy.expand(sign * surface).primitive()[1] == wanted:
                return Surface(system, number, sign)
    return None


def _redeclared(system: PiecewiseSystem, laws: Mapping[str, Region], function: str, **more: Any) -> PiecewiseSystem:
    """Return a system of the same variables and parameters, by its regions."""
    try:
        return PiecewiseSystem(
            system.name, system.variables, parameters=system.parameters, x0=system.x0, doc=system.doc,
            values=dict(system.values), regions=laws, **more,
        )  # fmt: skip
    except ValueError as reason:
        raise ValueError(f"of = {function!r} cannot be a surface of {system.name!r}: {reason}") from None
