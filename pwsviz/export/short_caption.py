"""The short caption of a picture: what is drawn, the parameters and the integrators, without the equations."""

from __future__ import annotations

from pwsviz.export.about import about, brief, named
from pwsviz.scene.equations import indexed
from pwsviz.scene.names import met_at_surfaces, short_name
from pwsviz.scene.scene import Scene
from pwsviz.text.numbers import printed
from pwsviz.text.words import at_surface

__all__ = ["short_caption"]

LONGEST = 70
"""Characters of the starts, about a line and a half of a column; of longer ones the number is told."""


def short_caption(
    scene: Scene, heading: str, how: str = "", *, every_start: bool = True, slid: bool = True, endings: str = "",
    free: str = "",
) -> str:  # fmt: skip
    """Return a caption of a few lines, for a picture whose text tells the equations; the arguments as of `caption`.

    Of how a study was made it has the first clause, the integrator, and what is unusual at crossings.
    """
    parts = about(scene, how=how, every_start=every_start, slid=slid, free=free, told=brief)
    known = [q for q in scene.declaration.parameters if q.name != free]
    values = ", ".join(f"{short_name(q)} {brief(scene.values[q.name])}" for q in known)
    first, *further = parts["integration"].split("; ")
    met = met_at_surfaces(scene.declaration)
    usual = at_surface(met, locate=True, slide=False)
    needed = [
        one for one in further
        if one.startswith("integrated by ") or (one.startswith(f"{met} ") and one.partition(". ")[0] != usual)
    ]  # fmt: skip
    told = "; ".join([first, *needed])
    sentences = [*filter(None, [_starts(scene, parts["starts"], every_start), told, endings])]
    said = [*filter(None, [values]), *(f"{one[0].upper()}{one[1:]}" for one in sentences)]
    begin = f"{named(scene, heading)}{':' if values else '.'}"
    return f"{begin} {printed(indexed('. '.join(said).rstrip('.')))}."


def _starts(scene: Scene, told: str, every: bool) -> str:
    """Return the starts, or of long ones how many there are, or which is shown; nothing of the only one."""
    count = len(scene.starts)
    if len(told) <= LONGEST:
        return told
    if count == 1:
        return ""
    return (
        f"{count} initial states, as numbered"
        if every
        else f"from start {min(scene.selected, count - 1) + 1} of {count}"
    )
