"""The surface of a section: one of the system's own, or another one, at which nothing switches."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

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
        h(t, x), whose zeros are the section. None, or one of the system's switching functions: the section is of that.

    Raises
    ------
    ValueError
        If h makes no sense, or there are six surfaces already; or if h cannot be followed through the system's jumps.
    """
    if function is None:
        return Surface(system, 0 if system.two_sided else -1)
    if function in system.surfaces:
        return Surface(system, system.surfaces.index(function))
    laws = {f"{name}{sign}": Region(region.f, region.psi) for name, region in system.regions.items() for sign in "-+"}
    if not system.transitions:
        jumps = dict(system.jumps)
        return Surface(
            _redeclared(system, laws, surfaces=(*system.surfaces, function), jumps=jumps), len(system.surfaces)
        )
    if any(way.jump for way in system.transitions):
        raise ValueError(
            f"of = {function!r}: a section of a system whose transitions jump is that of one of its guards"
        )
    ways = [replace(way, mode=f"{way.mode}{sign}", to=f"{way.to}{sign}") for way in system.transitions for sign in "-+"]
    for name in system.regions:
        ways += [Transition(f"{name}-", f"-({function})", f"{name}+"), Transition(f"{name}+", function, f"{name}-")]
    extended = _redeclared(system, laws, transitions=tuple(ways))
    guard = extended.laws.ways[extended.laws.numbers_of_modes[f"{next(iter(system.regions))}+"]][-1]
    return Surface(extended, guard.surface, guard.sign)


def _redeclared(system: PiecewiseSystem, laws: Mapping[str, Region], **more: Any) -> PiecewiseSystem:
    """Return a system of the same variables and parameters, by its regions."""
    return PiecewiseSystem(
        system.name, system.variables, parameters=system.parameters, x0=system.x0, doc=system.doc,
        values=dict(system.values), regions=laws, **more,
    )  # fmt: skip
