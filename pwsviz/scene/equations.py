"""The equations of a system on one line of text."""

from __future__ import annotations

import re
from collections.abc import Iterable

import core
from pwsviz.geometry.shades import region_name
from pwsviz.scene.names import readable
from pwsviz.text.math_names import numbered, quantity_name, unicode_name, variable_name

__all__ = ["equations", "indexed"]

LOWERED = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")


def equations(system: core.PiecewiseSystem) -> str:
    """Return the laws of all regions, as “g < 0: x′ = 2y, ψ₋ = …; g > 0: …; g = …”; one for all as “x′ = …; g = …”."""
    words = {"-": ("g < 0", "-"), "+": ("g > 0", "+")} if system.two_sided else {}
    regions = list(zip(system.laws.regions, system.regions.values(), strict=True))
    if system.two_sided and regions[0][1] == regions[1][1]:
        words, regions = {regions[0][0].name: ("", "")}, regions[:1]
    laws = []
    for mode, region in regions:
        where, side = words.get(mode.name, (f"region {region_name(mode)}", ""))
        rates = [
            f"{variable_name(variable)}′ = {readable(rate, system)}"
            for variable, rate in zip(system.variables, region.f, strict=True)
        ]
        names = [quantity_name(side, k, len(region.psi)) for k in range(len(region.psi))]
        conserved = (
            f"{unicode_name(name, name)} = {readable(psi, system)}" for name, psi in zip(names, region.psi, strict=True)
        )
        laws.append(f"{where}: " * bool(where) + ", ".join([*rates, *conserved]))
    names = ["g"] if system.two_sided else [numbered("g", k + 1) for k in range(len(system.surfaces))]
    laws += [f"{name} = {readable(g, system)}" for name, g in zip(names, system.surfaces, strict=True)]
    state = f"({', '.join(map(variable_name, system.variables))})"
    laws += [f"reset map at {names[k]} = 0: {state} ↦ {_map(jump, system)}" for k, jump in system.jumps.items()]
    for way in system.transitions:
        jump = f", reset map {state} ↦ {_map(way.jump, system)}" if way.jump else ""
        laws.append(f"{way.mode} to {way.to} where {readable(way.guard, system)} = 0{jump}")
    return "; ".join(laws)


def _map(jump: Iterable[str], system: core.PiecewiseSystem) -> str:
    """Return the state after a jump, as “(x, −ε·v)”."""
    return f"({', '.join(readable(part, system) for part in jump)})"


def indexed(text: str) -> str:
    """Return a text with lowered indices, as x₁ for x1, and with √ for the root; the files have columns named x1."""
    indexed = re.sub(r"(?<!\w)([^\W\d_])(\d)(?![A-Za-z0-9_.])", lambda name: name[1] + name[2].translate(LOWERED), text)
    return indexed.replace("sqrt(", "√(")
