"""A declaration as text: regions, transitions, surfaces, jumps, and the names of the fields that hold them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import NamedTuple, Self

__all__ = ["SIDES", "SIGNS", "DeclaredTexts", "Problem", "RegionText", "Texts", "TransitionText"]

#: Sign of g -> the word for that side in the names of fields.
SIDES: Mapping[int, str] = MappingProxyType({-1: "minus", 1: "plus"})
#: Sign of a switching function in the key of a region -> the sign as a number.
SIGNS = {"-": -1, "+": 1}

Texts = tuple[str, ...]


class RegionText(NamedTuple):
    """A region as text: its key, d expressions of its field, and its conserved quantities."""

    name: str
    f: Texts
    psi: Texts = ()


class TransitionText(NamedTuple):
    """A transition as text: where a guard of a region falls to zero, the region that follows, and the jump or ()."""

    mode: str
    guard: str
    to: str
    jump: Texts = ()


class Problem(NamedTuple):
    """Something that is wrong with a declaration."""

    field: str
    """Field of the declaration in which it is."""
    message: str
    """What is wrong and how to correct it, without a full stop."""
    entry: int | None = None
    """Index of the expression that the message names first; None where the message is about the whole field."""


def _as_declared(field: str, entry: int | None) -> str:
    """Name of a field or of one of its entries, as in Python: ``f_plus[1]``."""
    return field if entry is None or field == "g" or field.endswith(".guard") else f"{field}[{entry}]"


@dataclass(frozen=True)
class DeclaredTexts:
    """The texts of a system, valid or not.

    Parameters
    ----------
    bounds
        Least and greatest value of each parameter; None where it has none.
    surfaces
        The switching functions; () where transitions are declared.
    regions
        Its key has one sign a surface, in the order of `surfaces`; any names where transitions are declared.
    jumps
        (number of the surface, d expressions) where the state jumps.
    transitions
        The ways between regions that have names.
    called
        (field, index or None) -> the name that messages give to the field or to that entry of it.
    longest
        Most nodes in the trees of all first derivatives of one expression; None for no limit.
    """

    variables: tuple[str, ...]
    parameters: tuple[str, ...]
    bounds: tuple[tuple[float, float] | None, ...]
    surfaces: Texts
    regions: tuple[RegionText, ...]
    jumps: tuple[tuple[int, Texts], ...] = ()
    transitions: tuple[TransitionText, ...] = ()
    called: Callable[[str, int | None], str] = _as_declared
    longest: int | None = None

    @classmethod
    def of_sides(
        cls, variables: Texts, parameters: Texts, bounds: tuple[tuple[float, float] | None, ...], f_minus: Texts,
        f_plus: Texts, g: Texts, psi_minus: Texts = (), psi_plus: Texts = (), jump: Texts = (),
        called: Callable[[str, int | None], str] = _as_declared, longest: int | None = None,
    ) -> Self:  # fmt: skip
        """A system with one surface, g = 0: its regions are “-” and “+”."""
        regions = (RegionText("-", f_minus, psi_minus), RegionText("+", f_plus, psi_plus))
        jumps = ((0, jump),) if jump else ()
        return cls(variables, parameters, bounds, g, regions, jumps, (), called, longest)

    @property
    def two_sided(self) -> bool:
        """Whether there is one surface, with a region on either side: fields are then named f_minus, g and so on."""
        names = [region.name for region in self.regions]
        return not self.transitions and names == ["-", "+"] and {number for number, _ in self.jumps} <= {0}

    def field_of(self, region: str, part: str) -> str:
        """Name of the field that holds a region's f or psi."""
        return f"{part}_{SIDES[SIGNS[region]]}" if self.two_sided else f"regions[{region!r}].{part}"

    @cached_property
    def texts(self) -> Mapping[str, Texts]:
        """Field -> its expressions."""
        found: dict[str, Texts] = {self.field_of(region.name, "f"): region.f for region in self.regions}
        found["g" if self.two_sided else "surfaces"] = self.surfaces
        found |= {self.field_of(region.name, "psi"): region.psi for region in self.regions}
        found |= {"jump" if self.two_sided else f"jumps[{k}]": texts for k, texts in self.jumps}
        for k, transition in enumerate(self.transitions):
            found[f"transitions[{k}].guard"] = (transition.guard,)
            if transition.jump:
                found[f"transitions[{k}].jump"] = transition.jump
        return found

    def given(self, field: str) -> tuple[str, ...]:
        """What a message quotes of a field: its expressions, or the keys of regions and transitions."""
        if field == "regions":
            return tuple(region.name for region in self.regions)
        if field == "transitions":
            return tuple(f"{way.mode} to {way.to}" for way in self.transitions)
        found = self.texts.get(field, getattr(self, field, ()))
        return tuple(map(str, found))

    def kind(self, field: str) -> str:
        """What a field holds: f, psi, jump, or switching functions."""
        for kind in ("f", "psi", "jump"):
            if field.startswith((f"{kind}_", "jumps[")) or field.endswith(f"].{kind}") or field == kind:
                return "jump" if field.startswith("jumps[") else kind
        return "surface"
