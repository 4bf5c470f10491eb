"""What is wrong with the names and the numbers of a declaration's entries, before any expression is read."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from core.symbolic.declared_texts import DeclaredTexts, Problem
from core.symbolic.expressions import check_name

__all__ = [
    "MAX_DIMENSION", "MAX_REGIONS", "MAX_SURFACES", "miscounted", "wrong_counts", "wrong_names", "wrong_regions",
]  # fmt: skip

#: Largest number of variables.
MAX_DIMENSION = 24
#: Largest number of surfaces.
MAX_SURFACES = 6
#: Largest number of regions that have names.
MAX_REGIONS = 64
#: Largest number of guards of one region.
MAX_GUARDS = 6


def wrong_names(declared: DeclaredTexts) -> Iterator[Problem]:
    """Yield what is wrong with names of variables and parameters."""
    for role, names in (("variable", declared.variables), ("parameter", declared.parameters)):
        for name in names:
            try:
                check_name(name, role)
            except ValueError as reason:
                yield Problem(f"{role}s", str(reason))
    times = Counter((*declared.variables, *declared.parameters))
    for twice in sorted(name for name in times if times[name] > 1):
        field = "parameters" if twice in declared.parameters else "variables"
        yield Problem(field, f"the name {twice!r} is used twice: names must differ")


def wrong_regions(declared: DeclaredTexts) -> Iterator[Problem]:
    """Yield what is wrong with regions, and with the surfaces or transitions between them."""
    names, k = [region.name for region in declared.regions], len(declared.surfaces)
    if not names:
        yield Problem("regions", "there are none; declare at least one")
    elif len(names) > MAX_REGIONS:
        yield Problem("regions", f"{len(names)} regions: at most {MAX_REGIONS} are possible")
    elif declared.transitions:
        yield from _wrong_transitions(declared, names)
    elif not declared.two_sided:
        if not 1 <= k <= MAX_SURFACES:
            yield Problem("surfaces", f"{k} surfaces: from 1 to {MAX_SURFACES} are possible")
        for name in names:
            if len(name) != k or set(name) - set("-+"):
                yield Problem(
                    "regions", f"{name!r} is not a region: write {_count(k, 'sign')}, - or +, one for each surface"
                )
        for number, _ in declared.jumps:
            if number not in range(k):
                yield Problem("jumps", f"{number!r} is not a surface: they have the numbers 0 to {k - 1}")


def _wrong_transitions(declared: DeclaredTexts, names: Sequence[str]) -> Iterator[Problem]:
    if declared.surfaces or declared.jumps:
        yield Problem("transitions", "give either transitions, or surfaces and jumps, from which transitions follow")
    for k, transition in enumerate(declared.transitions):
        for name in (transition.mode, transition.to):
            if name not in names:
                words = f"{name!r} is not a region; there are {', '.join(map(repr, names))}"
                yield Problem("transitions", f"transition {k}: {words}")
    for name, guards in Counter(transition.mode for transition in declared.transitions).items():
        if guards > MAX_GUARDS:
            yield Problem("transitions", f"region {name!r} has {guards} guards: at most {MAX_GUARDS} are possible")
    for name in names:
        if name not in {transition.mode for transition in declared.transitions}:
            yield Problem("transitions", f"region {name!r} has no guard, so a run would never leave it")


def wrong_counts(declared: DeclaredTexts) -> Iterator[Problem]:
    """Yield where there are too few or too many variables, expressions or conserved quantities."""
    d = len(declared.variables)
    if not 1 <= d <= MAX_DIMENSION:
        yield Problem("variables", f"{d} variables: from 1 to {MAX_DIMENSION} are possible")
        return
    for field in declared.texts:
        if declared.kind(field) in ("f", "jump") and (
            words := miscounted(declared.texts[field], "expression", declared.variables)
        ):
            yield Problem(field, words)
    if declared.two_sided and len(declared.surfaces) != 1:
        yield Problem("g", "type one expression, as in: x**2 + y**2 - 1; the law changes where it is zero")
    for field, texts in declared.texts.items():
        if declared.kind(field) == "psi" and len(texts) >= d:
            yield Problem(field, f"there are {len(texts)} here; with {_count(d, 'variable')}, {d - 1} at most")


def miscounted(given: Sequence[object], noun: str, variables: Sequence[str]) -> str:
    """Message that the number of entries is not the number of variables; empty if it is."""
    if len(given) == len(variables):
        return ""
    each = "variable" if len(set(variables)) < len(variables) else f"of {', '.join(variables)}"
    return f"{_count(len(given), noun)} given, {len(variables)} needed: one for each {each}"


def _count(number: int, noun: str) -> str:
    return f"{number or 'no'} {noun}{'' if number == 1 else 's'}"
