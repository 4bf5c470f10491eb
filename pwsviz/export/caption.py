"""The captions of a picture: what it shows, the system, its parameters and how it was integrated."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

import core
from pwsviz.export.about import about, named, release
from pwsviz.scene.equations import Law, equations, equations_of, indexed
from pwsviz.scene.names import met_at_surfaces, short_name
from pwsviz.scene.scene import Scene
from pwsviz.text.numbers import brief, printed
from pwsviz.text.words import at_surface, listed

__all__ = ["caption", "short_caption"]

LONGEST = 400
"""Characters of equations in a caption, about five lines of a page; instead of longer ones, what the system is."""

LONGEST_STARTS = 70
"""Characters of the starts in a short caption, about a line and a half; of longer ones the number is told."""

LONGEST_START = 160
"""Characters of the only start in a short caption, about three lines and a half; a longer one is left out."""

OMITTED = "equations omitted for their length"
"""What a caption says in place of longer equations; those of the surfaces stay."""

IF_KNOWN = " where one is known"
"""With which the declaration of an integrator ends a clause on what it does with a conserved quantity."""

METHOD = re.compile(rf"\b({'|'.join(core.METHODS)})\b")
"""The name of an integrator."""

NAME = re.compile(rf"(?:{METHOD.pattern}|[^\W\d_][^\w’]|[τψ‖|])")
"""How a sentence begins that begins with an integrator or a quantity."""

ORDINARY = {"Classical", "Composition", "Explicit"}
"""Words at the beginning of the declaration of an integrator that are no names."""


def caption(
    scene: Scene, heading: str, how: str = "", *, every_start: bool = True, met: bool = True, slid: bool = True,
    endings: str = "", free: str = "",
) -> str:  # fmt: skip
    """Return the caption of a picture: what it shows, the equations, the parameters and the method.

    Parameters
    ----------
    scene, how, every_start, met, slid, endings, free
        As in `about`.
    heading : str
        What the picture shows, to be followed by “of the system”.
    """
    parts = about(scene, how=how, every_start=every_start, met=met, slid=slid, endings=endings, free=free, told=brief)
    laws = _of_laws(scene.declaration)
    clauses, _, further = parts["integration"].partition(". ")
    runs = _with_methods(_sentences([*clauses.split("; "), further]), scene.declaration.laws.most_conserved > 0)
    said = [*laws, *_of_parameters(parts["parameters"]), parts["starts"]]
    return f"{named(scene, heading)}. {printed(indexed(f'{_sentences(said)} {runs}'))}"


def short_caption(
    scene: Scene, heading: str, how: str = "", *, every_start: bool = True, met: bool = True, slid: bool = True,
    endings: str = "", free: str = "",
) -> str:  # fmt: skip
    """Return a caption of a few lines, for a picture whose text tells the equations; the arguments as of `caption`.

    Of how a study was made it has the first clause, the integrator, and what is unusual at crossings.
    """
    parts = about(scene, how=how, every_start=every_start, met=met, slid=slid, free=free, told=brief)
    known = [q for q in scene.declaration.parameters if q.name != free]
    values = ", ".join(f"{short_name(q)} {brief(scene.values[q.name])}" for q in known)
    first, *further = parts["integration"].split("; ")
    what = met_at_surfaces(scene.declaration)
    usual = at_surface(what, locate=True, slide=False)
    needed = [
        one for one in further
        if one.startswith("integrated by ") or (one.startswith(f"{what} ") and one.partition(". ")[0] != usual)
    ]  # fmt: skip
    said = [_short_starts(scene, parts["starts"], every_start), first, *needed, endings]
    begin = f"{named(scene, heading)}{f': {printed(values)}' * bool(values)}."
    return f"{begin} {printed(indexed(_sentences(said)))}"


def _sentences(clauses: Iterable[str]) -> str:
    """Return clauses as sentences, each with its stop; the names of integrators and quantities keep small letters."""
    kept = (one.rstrip(".") for one in clauses if one)
    return " ".join(f"{one if NAME.match(one) else f'{one[0].upper()}{one[1:]}'}." for one in kept)


def _of_laws(system: core.PiecewiseSystem) -> Iterator[str]:
    """Yield the equations as clauses: “for g < 0: x′ = 2y, conserving ψ₋ = …”, “S = {g = 0} with g = …”."""
    told = equations_of(system)
    short = len(equations(system)) <= LONGEST
    known = f"; they are those of {release()}" * (system.name in {one.name for one in core.CATALOGUE.values()})
    yield from map(_law, told.laws) if short else [system.doc, f"{OMITTED}{known}"]
    if len(surfaces := ", ".join(told.surfaces)) <= LONGEST and surfaces:
        signs = f"; a region is named by the signs of {listed([one.partition(' ')[0] for one in told.surfaces])}"
        signs *= system.laws.sides.shape[1] > 0
        yield f"S = {{g = 0}} with {surfaces}" if system.two_sided else f"surfaces gᵢ = 0 with {surfaces}{signs}"
    if short:
        yield from _resets(told.resets)
        if told.transitions:
            yield f"transitions: from {'; from '.join(told.transitions)}"


def _resets(resets: Sequence[tuple[str, str]]) -> Iterator[str]:
    """Yield the reset maps, one that acts at several surfaces once: “reset map at g₁ = 0 and g₂ = 0: …”."""
    places: dict[str, list[str]] = {}
    for where, what in resets:
        places.setdefault(what, []).append(where)
    yield from (f"reset map at {listed(where)}: {what}" for what, where in places.items())


def _law(law: Law) -> str:
    before = "in" if law.where.startswith("region") else "for"
    where = f"{before} {law.where}: " if law.where else "equations: "
    return f"{where}{law.rates}{f', conserving {law.conserved}' * bool(law.conserved)}"


def _of_parameters(values: str) -> Iterator[str]:
    if values:
        yield f"parameter{'s' * (', ' in values)}: {values}"


def _short_starts(scene: Scene, told: str, every: bool) -> str:
    """Return the starts, or of long ones how many there are, or which is shown; nothing of a single one."""
    count = len(scene.starts)
    if len(told) <= (LONGEST_START if count == 1 else LONGEST_STARTS):
        return told
    if count == 1:
        return ""
    return (
        f"{count} initial states, as numbered"
        if every
        else f"from start {min(scene.selected, count - 1) + 1} of {count}"
    )


def _with_methods(words: str, known: bool) -> str:
    """Return sentences in which each integrator is explained where it is named first; `known` as of `_declared`."""
    explained: list[str] = []

    def explain(found: re.Match[str]) -> str:
        name = found[0]
        if name in explained:
            return name
        explained.append(name)
        return f"{name} ({_declared(name, known)})"

    words = METHOD.sub(explain, words)
    within = [name for name in METHOD.findall(words) if name not in explained]  # the words on one may name another
    return " ".join([words, *(f"{name}: {_declared(name, known)}." for name in dict.fromkeys(within))])


def _declared(name: str, known: bool) -> str:
    """Return what an integrator is, as it is declared; also what it does “where one is known”, a ψ, if one is."""
    first, *more = re.split("[:;] ", core.METHODS[name].doc.rstrip("."))
    more = [one.removesuffix(IF_KNOWN) for one in more if known and one.endswith(IF_KNOWN)]
    return ", ".join([_within_a_sentence(first), *more])


def _within_a_sentence(words: str) -> str:
    """Return words that began a sentence, with a small letter unless they begin with a name."""
    first = words.split(" ", 1)[0]
    return words if first not in ORDINARY else f"{words[0].lower()}{words[1:]}"
