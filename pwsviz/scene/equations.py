"""The equations of a system as text."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import NamedTuple

import core
from pwsviz.geometry.shades import region_name
from pwsviz.scene.names import readable
from pwsviz.text.math_names import numbered, quantity_name, unicode_name, variable_name

__all__ = ["Equations", "Law", "equations", "equations_of", "indexed"]

LOWERED = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")


class Law(NamedTuple):
    """The law of a region."""

    where: str
    """Where it holds, as “g < 0”; empty if it is the only one."""
    rates: str
    """Of each variable, “x′ = …”."""
    conserved: str
    """Of each conserved quantity, “ψ₋ = …”."""


class Equations(NamedTuple):
    """The equations of a system, part by part."""

    laws: list[Law]
    surfaces: list[str]
    """Of each surface, “g = …”."""
    resets: list[tuple[str, str]]
    """Of each surface at which the state jumps, “g = 0” and the map, “(y, v) ↦ (0, −ε·v)”."""
    transitions: list[str]
    """Of each transition between regions, “on to off where … = 0”."""


def equations_of(system: core.PiecewiseSystem) -> Equations:
    """Return the equations of a system; a law that holds on both sides of one surface is told once."""
    names = ["g"] if system.two_sided else [numbered("g", k + 1) for k in range(len(system.surfaces))]
    surfaces = [f"{name} = {readable(g, system)}" for name, g in zip(names, system.surfaces, strict=True)]
    state = f"({', '.join(map(variable_name, system.variables))})"
    resets = [(f"{names[k]} = 0", f"{state} ↦ {_map(jump, system)}") for k, jump in system.jumps.items()]
    transitions = []
    for way in system.transitions:
        jump = f", reset map {state} ↦ {_map(way.jump, system)}" if way.jump else ""
        transitions.append(f"{way.mode} to {way.to} where {readable(way.guard, system)} = 0{jump}")
    return Equations(_laws(system), surfaces, resets, transitions)


def equations(system: core.PiecewiseSystem) -> str:
    """Return them on one line: “g < 0: x′ = 2y, ψ₋ = …; g > 0: …; g = …”; one law for all as “x′ = …; g = …”."""
    found = equations_of(system)
    laws = (f"{law.where}: " * bool(law.where) + ", ".join(filter(None, law[1:])) for law in found.laws)
    resets = (f"reset map at {where}: {what}" for where, what in found.resets)
    return "; ".join([*laws, *found.surfaces, *resets, *found.transitions])


def _laws(system: core.PiecewiseSystem) -> list[Law]:
    words = {"-": ("g < 0", "-"), "+": ("g > 0", "+")} if system.two_sided else {}
    regions = list(zip(system.laws.regions, system.regions.values(), strict=True))
    if system.two_sided and regions[0][1] == regions[1][1]:
        words, regions = {regions[0][0].name: ("", "")}, regions[:1]
    laws = []
    for mode, region in regions:
        where, side = words.get(mode.name, (f"region {region_name(mode)}", ""))
        rates = (
            f"{variable_name(variable)}′ = {readable(rate, system)}"
            for variable, rate in zip(system.variables, region.f, strict=True)
        )
        names = [quantity_name(side, k, len(region.psi)) for k in range(len(region.psi))]
        conserved = (
            f"{unicode_name(name, name)} = {readable(psi, system)}" for name, psi in zip(names, region.psi, strict=True)
        )
        laws.append(Law(where, ", ".join(rates), ", ".join(conserved)))
    return laws


def _map(jump: Iterable[str], system: core.PiecewiseSystem) -> str:
    """Return the state after a jump, as “(x, −ε·v)”."""
    return f"({', '.join(readable(part, system) for part in jump)})"


def indexed(text: str) -> str:
    """Return a text with lowered indices, as x₁ for x1, and with √ for the root; the files have columns named x1."""
    indexed = re.sub(r"(?<!\w)([^\W\d_])(\d)(?![A-Za-z0-9_.])", lambda name: name[1] + name[2].translate(LOWERED), text)
    return indexed.replace("sqrt(", "√(")
