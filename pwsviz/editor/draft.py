"""The texts of a system as a person types them, and a system written so."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import core
from pwsviz.editor.regions import region_texts
from pwsviz.text.numbers import shortest
from pwsviz.text.typed import as_typed

__all__ = ["FIELDS", "Draft"]

#: The label of each field on the page.
FIELDS: Mapping[str, str] = MappingProxyType(
    {
        "name": "Name",
        "variables": "Variables",
        "parameters": "Parameters",
        "f": "Field f, with sign, abs, max, min",
        "psi": "Conserved quantities ψ",
        "f_minus": "Field f₋, where g < 0",
        "f_plus": "Field f₊, where g > 0",
        "g": "Switching function g",
        "psi_minus": "Conserved quantities ψ₋",
        "psi_plus": "Conserved quantities ψ₊",
        "x0": "Start x₀",
        "jump": "Reset map at g = 0",
        "surfaces": "Switching functions g1, g2, …",
        "regions": "Regions and their fields",
        "quantities": "Conserved quantities of regions",
        "resets": "Resets at surfaces, such as walls",
        "transitions": "Transitions between regions that have names",
    }
)


@dataclass(frozen=True)
class Draft:
    """The texts in the fields. Entries of lists are separated by commas, semicolons or new lines."""

    name: str = ""
    """Of the system."""
    variables: str = ""
    """Names."""
    f_minus: str = ""
    """An expression for each variable."""
    f_plus: str = ""
    """An expression for each variable."""
    g: str = ""
    """The switching function."""
    psi_minus: str = ""
    """Expressions, fewer than there are variables; or none."""
    psi_plus: str = ""
    """Expressions, fewer than there are variables; or none."""
    parameters: str = ""
    """Entries such as ``k = 3 in [0.1, 10]``; the range is optional."""
    x0: str = ""
    """A number for each variable."""
    jump: str = ""
    """An expression for each variable, or nothing."""
    f: str = ""
    """In place of both fields and g: an expression for each variable, with sign, abs, max and so on."""
    psi: str = ""
    """Conserved quantities of such a field; or none."""
    surfaces: str = ""
    """In place of all these: several switching functions; or none, if the regions have names."""
    regions: str = ""
    """Entries such as ``+-: v, -x``: signs or a name, and an expression for each variable."""
    quantities: str = ""
    """Entries such as ``+-: (v**2 + x**2)/2``; or none."""
    resets: str = ""
    """Entries such as ``g1 => x, -r*v``; or none."""
    transitions: str = ""
    """Entries such as ``on -> off: 1 - x``, with ``=>`` and the state after it where that jumps."""

    known: tuple[core.Parameter, ...] = ()
    """Parameters of the system it was filled in from; those of the same names keep their symbols and descriptions."""

    @classmethod
    def of(cls, system: core.PiecewiseSystem) -> Draft:
        """Return a system as a user would type it, at its current parameter values.

        Raises
        ------
        ValueError
            If its regions have names that cannot be written in the fields.
        """
        if system.f:
            texts = {"f": "\n".join(system.f), "psi": "\n".join(system.psi)}
        elif system.two_sided:
            names = ("f_minus", "f_plus", "psi_minus", "psi_plus", "jump")
            texts = {n: "\n".join(getattr(system, n) or ()) for n in names} | {"g": system.g}
        else:
            texts = region_texts(system)
        return cls(
            name=system.name,
            variables=", ".join(system.variables),
            parameters="\n".join(_declared(p, system.values[p.name]) for p in system.parameters),
            x0=", ".join(map(_typed, system.x0)),
            known=tuple(p for p in system.parameters if p.latex or p.doc),
            **{field: as_typed(text) for field, text in texts.items()},
        )


def _declared(parameter: core.Parameter, value: float) -> str:
    within = "" if parameter.bounds is None else f" in [{', '.join(map(_typed, parameter.bounds))}]"
    return f"{parameter.name} = {_typed(value)}{within}"


def _typed(number: float) -> str:
    """Return the shortest text of a number."""
    return shortest(float(number))
