"""Several surfaces, walls and hysteresis as a person types them: regions, resets and transitions."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from sympy import Expr

import core
from core.symbolic import SIDES, Declaration, Problem, RegionText, TransitionText, quoted
from pwsviz.editor.typeset import equation, is_zero, rate, state_after
from pwsviz.text.mathml import Names as LatexNames
from pwsviz.text.typed import as_python, rates, split
from pwsviz.text.words import as_text

__all__ = ["REGION_FIELDS", "Regions", "read_parts", "region_texts"]

REGION_FIELDS = ("surfaces", "regions", "quantities", "resets", "transitions")
"""The fields of the page that declare a system so."""

MAX_SHOWN = 40
"""Characters of a refused name that a message quotes."""

Formula = Callable[[str], str]
"""Returns what `core` reads for a formula as it was typed."""

_RESET = "=>"
#: What people type or paste for the arrows.
_ARROWS = {"⇒": _RESET, "→": "->"}
#: What stands before the first colon of a line.
_HEAD = re.compile(r"^([^:\n]*):", re.MULTILINE)
#: What stands before an arrow.
_SURFACES = re.compile(rf"^([^\n]*?){_RESET}", re.MULTILINE)
_AS_REGION = "begin each region with its signs or its name and a colon, as in +-: v, -x"
_AS_RESET = "write the surface, an arrow and the state after it, as in g1 => x, -v"
_AS_TRANSITION = "write both regions, a colon and the guard, as in on -> off: 1 - x"


class Place(NamedTuple):
    """What a field of a declaration holds."""

    kind: str
    """“surfaces”, “regions”, “jumps” or “transitions”; else the field itself."""
    which: str = ""
    """Name of the region; number of the surface or of the transition."""
    part: str = ""
    """“f”, “psi”, “jump” or “guard”."""


class Names:
    """What messages and headings call the fields of a declaration, and the field of the page for each."""

    def __init__(
        self, variables: Sequence[str], regions: Iterable[str], resets: Iterable[int], ways: Sequence[TransitionText]
    ) -> None:
        self.variables, self.ways = variables, ways
        places = {"surfaces": Place("surfaces"), "g": Place("surfaces"), "jump": Place("jumps", "0", "jump")}
        for part in ("f", "psi"):
            places |= {
                f"{part}_{word}": Place("regions", "-" if side < 0 else "+", part) for side, word in SIDES.items()
            }
            places |= {f"regions[{name!r}].{part}": Place("regions", name, part) for name in regions}
        places |= {f"jumps[{k}]": Place("jumps", str(k), "jump") for k in resets}
        for k in range(len(ways)):
            places |= {f"transitions[{k}].{part}": Place("transitions", str(k), part) for part in ("guard", "jump")}
        self._places = places

    def place(self, field: str) -> Place:
        """What a field of a declaration holds."""
        return self._places.get(field, Place(field))

    def field(self, field: str) -> str:
        """The field of the page for one of a declaration."""
        kind, _, part = self.place(field)
        return "quantities" if part == "psi" else "resets" if kind == "jumps" else kind

    def where(self, field: str) -> str:
        """The region, surface or transition of a field."""
        kind, which, _ = self.place(field)
        if kind == "jumps":
            return f"g{int(which) + 1}"
        if kind == "transitions":
            return f"{self.ways[int(which)].mode} → {self.ways[int(which)].to}"
        return f"region {which}"

    def called(self, field: str, entry: int | None) -> str:
        """The name of a field in messages, or of an entry of it."""
        kind, _, part = self.place(field)
        if kind == "surfaces":
            return f"g{(entry or 0) + 1}"
        there = self.where(field)
        if part in ("psi", "guard"):
            return f"ψ in {there}" if part == "psi" else f"the guard of {there}"
        if part == "f":
            return f"the field of {there}" if entry is None else f"{self.variables[entry]}′ in {there}"
        return f"the reset at {there}" if entry is None else f"{self.variables[entry]}⁺ at {there}"


@dataclass(frozen=True)
class Regions:
    """What was read of the fields, and the declaration that it makes."""

    declaration: Declaration
    names: Names

    @classmethod
    def of(
        cls, variables: tuple[str, ...], parameters: tuple[str, ...], bounds: tuple[tuple[float, float] | None, ...],
        parts: Mapping[str, Any], longest: int,
    ) -> Regions:  # fmt: skip
        """Declare what `read_parts` gives; ValueError where a quantity is of no region."""
        laws, psi, ways = parts["regions"], parts["quantities"], tuple(parts["transitions"])
        if lost := [name for name in psi if name not in laws]:
            raise ValueError(f"{quoted(lost[0])} is not a region: {_declared(laws)}")
        texts = tuple(RegionText(name, tuple(law), tuple(psi.get(name, ()))) for name, law in laws.items())
        jumps = tuple((k, tuple(jump)) for k, jump in sorted(parts["resets"].items()))
        names = Names(variables, laws, parts["resets"], ways)
        surfaces = tuple(parts["surfaces"])
        return cls(
            Declaration(variables, parameters, bounds, surfaces, texts, jumps, ways, names.called, longest), names
        )

    def arguments(self) -> dict[str, Any]:
        """The arguments of `core.PiecewiseSystem` that declare the same."""
        declared = self.declaration
        return {
            "surfaces": declared.surfaces,
            "regions": {one.name: core.Region(one.f, one.psi) for one in declared.regions},
            "jumps": dict(declared.jumps),
            "transitions": tuple(core.Transition(*way[:3], way.jump or None) for way in declared.transitions),
        }

    def problems(self) -> list[Problem]:
        """Everything wrong with it, by the field of the page."""
        return [
            Problem(self.names.field(one.field), one.message if one.entry is not None else self._whole(one), one.entry)
            for one in self.declaration.problems
        ]

    def _whole(self, problem: Problem) -> str:
        """Say of which region, surface or transition a message is that names no expression."""
        kind, _, part = self.names.place(problem.field)
        if kind == "jumps" and not part:
            count = len(self.declaration.surfaces)
            lost = ", ".join(f"g{k + 1}" for k, _ in self.declaration.jumps if k >= count)
            return f"there is no surface {lost}: {count} switching function{'s' * (count != 1)} are given"
        if not part:
            return re.sub(r"^transition (\d+)", lambda found: self._between(int(found[1])), problem.message)
        where = {"regions": self.names.where, "jumps": lambda field: f"at {self.names.where(field)}"}
        told = (
            where[kind](problem.field) if kind in where else self._between(int(self.names.place(problem.field).which))
        )
        return f"{told}: {problem.message}"

    def _between(self, k: int) -> str:
        return f"from {self.declaration.transitions[k].mode} to {self.declaration.transitions[k].to}"

    def maths(self, symbols: LatexNames) -> dict[str, str]:
        """The expressions that could be read, typeset, by the field of the page; symbols as in `markup`."""
        declared, found = self.declaration, dict.fromkeys(REGION_FIELDS, "")
        for field in declared.texts:
            lines = [self._typeset(field, k, u, symbols) for k, u in declared.expressions(field).items()]
            kind, _, part = self.names.place(field)
            if lines and part and (kind, part) != ("transitions", "jump"):  # which follows its guard
                where = self.names.where(field)
                title = {"regions": _capital(where), "jumps": f"Where {where} = 0 is reached"}.get(
                    kind, f"{where}, where"
                )
                lines.insert(0, as_text(f"{title}:", "finding"))
            found[self.names.field(field)] += "".join(lines)
        return found

    def _typeset(self, field: str, k: int, found: Expr, symbols: LatexNames) -> str:
        part = self.names.place(field).part
        if part == "guard":
            return is_zero(found, symbols)
        if part in ("f", "jump"):
            return equation(*(rate if part == "f" else state_after)(self.declaration.variables[k]), found, symbols)
        shown = ("ψ", "<mi>ψ</mi>") if part else (f"g{k + 1}", f"<msub><mi>g</mi><mn>{k + 1}</mn></msub>")
        return equation(*shown, found, symbols)


def _capital(words: str) -> str:
    return words[:1].upper() + words[1:]


def _declared(laws: Iterable[str]) -> str:
    return f"the regions are {', '.join(laws)}" if laws else "write its field first"


# Reading -------------------------------------------------------------------------------------------------------------


def read_parts(
    texts: Mapping[str, str], variables: Sequence[str], formula: Formula = as_python
) -> Iterator[tuple[str, Any]]:
    """Read the fields of the page one by one; what cannot be read comes as the ValueError that says so."""
    read = {
        "surfaces": lambda text: [formula(one) for one in split(text)],
        "regions": lambda text: {
            name: [formula(one) for one in rates(law, variables)] for name, law in _blocks(text, _AS_REGION)
        },
        "quantities": lambda text: {
            name: [formula(one) for one in split(law)] for name, law in _blocks(text, _AS_REGION)
        },
        "resets": lambda text: _resets(text, variables, formula),
        "transitions": lambda text: [
            _transition(name, rest, variables, formula) for name, rest in _blocks(text, _AS_TRANSITION, twice=True)
        ],
    }
    for field in REGION_FIELDS:
        text = re.sub(r"\r\n?", "\n", texts[field])
        for arrow, plain in _ARROWS.items():
            text = text.replace(arrow, plain)
        try:
            yield field, read[field](text)
        except ValueError as reason:
            yield field, reason


def _blocks(text: str, remedy: str, twice: bool = False) -> list[tuple[str, str]]:
    """Return what stands before each colon that is the first of its line, and what follows it."""
    before, *rest = _HEAD.split(text)
    if before.strip():
        raise ValueError(f"{quoted(before.strip())} belongs to no region: {remedy}")
    names = [_name(name) for name in rest[::2]]
    if "" in names:
        raise ValueError(f"nothing stands before a colon: {remedy}")
    if hidden := [name for name in names if not name.isprintable()]:
        raise ValueError(f"{hidden[0][:MAX_SHOWN]!a} contains invisible characters: remove them")
    if not twice and (again := [name for name in names if names.count(name) > 1]):
        raise ValueError(f"{quoted(again[0])} is there twice: write each region once")
    return list(zip(names, rest[1::2], strict=True))


def _name(typed: str) -> str:
    """Return the name of a region: signs without spaces, or a name."""
    name = typed.strip()
    return name.replace(" ", "") if set(name) <= set("+- ") else name


def _resets(text: str, variables: Sequence[str], formula: Formula) -> dict[int, list[str]]:
    before, *rest = _SURFACES.split(text)
    if before.strip():
        raise ValueError(f"{quoted(before.strip())} is at no surface: {_AS_RESET}")
    found: dict[int, list[str]] = {}
    for names, after in zip(rest[::2], rest[1::2], strict=True):
        for name in split(names) or [""]:
            number = re.fullmatch(r"g ?([1-9]?)", name)
            if number is None:
                raise ValueError(f"{quoted(name)} is not a surface: {_AS_RESET}")
            k = int(number[1] or 1) - 1
            if k in found:
                raise ValueError(f"the surface g{k + 1} is there twice: write one reset for each")
            found[k] = _after(after, variables, formula)
    return found


def _after(text: str, variables: Sequence[str], formula: Formula) -> list[str]:
    """Return the state after a reset; one of no expressions would be none."""
    if not (after := [formula(one) for one in split(text)]):
        raise ValueError(f"nothing stands after an arrow: write the value of each of {', '.join(variables)}")
    return after


def _transition(name: str, rest: str, variables: Sequence[str], formula: Formula) -> TransitionText:
    mode, arrow, to = (part.strip() for part in name.partition("->"))
    guard, reset, after = rest.partition(_RESET)
    guards = split(guard)
    if not (mode and arrow and to) or len(guards) != 1:
        raise ValueError(f"{quoted(f'{name}:{rest}'.strip())} is not a transition: {_AS_TRANSITION}")
    return TransitionText(
        _name(mode), formula(guards[0]), _name(to), tuple(_after(after, variables, formula)) if reset else ()
    )


# Writing -------------------------------------------------------------------------------------------------------------


def region_texts(system: core.PiecewiseSystem) -> dict[str, str]:
    """Write a system as a person would type it into the fields.

    Raises
    ------
    ValueError
        Where a region has a name that these fields take for something else.
    """
    laws, ways = system.regions.items(), system.transitions
    texts = {
        "surfaces": "\n".join(system.surfaces),
        "regions": "\n".join(f"{name}: {', '.join(law.f)}" for name, law in laws),
        "quantities": "\n".join(f"{name}: {', '.join(law.psi)}" for name, law in laws if law.psi),
        "resets": "\n".join(f"g{k + 1} {_RESET} {', '.join(jump)}" for k, jump in system.jumps.items()),
        "transitions": "\n".join(
            f"{way.mode} -> {way.to}: {way.guard}" + (f" {_RESET} {', '.join(way.jump)}" if way.jump else "")
            for way in ways
        ),
    }
    read = dict(read_parts(texts, system.variables))
    names = [(way.mode, way.to) for way in ways]
    wrong = any(isinstance(part, ValueError) for part in read.values())
    if wrong or list(read["regions"]) != list(system.regions) or [(w.mode, w.to) for w in read["transitions"]] != names:
        raise ValueError(f"{system.name} has regions with names that cannot be written here: start from another system")
    return texts
