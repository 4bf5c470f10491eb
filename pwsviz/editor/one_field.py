"""A system typed as one field with sign, abs, max and so on: its surfaces and regions are found, and shown."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from core.symbolic import Declaration, Found, Problem, RegionText, parse, read_switching
from pwsviz.editor.typeset import equation, rate
from pwsviz.text.mathml import Names
from pwsviz.text.words import as_text

__all__ = ["OneField", "called_by_variables", "where"]

#: The names of the declaration's fields in messages, for which the page has one field each.
_NAMED = re.compile(r"(?:regions\['(?P<key>[-+]*)'\]\.|)(?P<part>f|psi)(?P<side>_minus|_plus|)(?:\[(?P<entry>\d+)\])?")
#: Endings of the fields of two sides -> key of the region.
_KEYS = {"_minus": "-", "_plus": "+"}


@dataclass(frozen=True)
class OneField:
    """The surfaces and regions found in one field."""

    declaration: Declaration
    found: Found

    @classmethod
    def read(
        cls, variables: tuple[str, ...], parameters: tuple[str, ...],
        bounds: tuple[tuple[float, float] | None, ...], f: Sequence[str], psi: Sequence[str], longest: int,
    ) -> OneField:  # fmt: skip
        """Find surfaces and regions (see `core.symbolic.switching_terms`); ValueError where that fails."""
        found = read_switching(variables, parameters, f, psi, bounds)
        regions = tuple(RegionText(key, law, found.quantities[key]) for key, law in found.fields.items())
        return cls(Declaration(variables, parameters, bounds, found.surfaces, regions, longest=longest), found)

    def problems(self, variables: Sequence[str]) -> list[Problem]:
        """Everything wrong with it, by the field of the page: f, psi, variables or parameters."""
        problems: dict[tuple[str, int | None], Problem] = {}  # of several regions, that of the first
        for field, message, entry in self.declaration.problems:
            named = _NAMED.fullmatch(field)
            place = named["part"] if named else {"g": "f", "surfaces": "f"}.get(field, field)
            problem = Problem(place, called_by_variables(message, variables), entry)
            problems.setdefault((place, entry), problem)
        return list(problems.values())

    def markup(self, variables: Sequence[str], symbols: Names) -> str:
        """The surfaces, and the law of each region; the LaTeX of symbols as in `markup`."""
        names, found = (*variables, *self.declaration.parameters), self.found
        one = len(found.surfaces) == 1
        parts = [
            as_text(
                f"Found: {_count(len(found.surfaces), 'surface')}, {_count(len(found.fields), 'region')}.", "finding"
            )
        ]
        for k, text in enumerate(found.surfaces, start=1):
            shown = "<mi>g</mi>" if one else f"<msub><mi>g</mi><mn>{k}</mn></msub>"
            parts.append(equation("g" if one else f"g{k}", shown, parse(text, names, "g"), symbols))
        for key, law in found.fields.items():
            parts.append(as_text(f"{where(key)[:1].upper()}{where(key)[1:]}:", "finding"))
            for variable, text in zip(variables, law, strict=True):
                parts.append(equation(*rate(variable), parse(text, names, "f"), symbols))
        return "".join(parts)


def called_by_variables(message: str, variables: Sequence[str]) -> str:
    """Rewrite a message that names fields as in Python: x′ for ``f[0]``, with the region where that is told."""

    def called(match: re.Match[str]) -> str:
        key = match["key"] or _KEYS.get(match["side"], "")
        entry = int(match["entry"] or 0)
        there = f" {where(key)}" if key else ""
        if match["part"] == "psi":
            return f"ψ{there}"
        return f"{variables[entry]}′{there}" if match["entry"] and entry < len(variables) else f"the field{there}"

    return re.sub(rf"\b(?:{_NAMED.pattern})(?=[\s,:;]|$)", called, message)


def where(key: str) -> str:
    """Where a region is, by the signs of its key: “where g < 0”, “where g1 > 0, g2 < 0”; or by its name."""
    if not key or set(key) - set("-+"):
        return f"in region {key}"
    signs = [f"{'<' if sign == '-' else '>'} 0" for sign in key]
    if len(signs) == 1:
        return f"where g {signs[0]}"
    return f"where {', '.join(f'g{k} {sign}' for k, sign in enumerate(signs, start=1))}"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' * (number != 1)}"
