"""The phase portrait in words."""

from __future__ import annotations

from collections.abc import Sequence

import core
from pwsviz.figures.marks import ENDS
from pwsviz.results.results import Pictures
from pwsviz.text.words import listed

__all__ = ["SUMMARY", "figures_of", "portrait_text"]

SUMMARY = "Phase portrait"


def portrait_text(
    system: core.PiecewiseSystem, pictures: Pictures, starts: Sequence[tuple[float, float]], selected: int
) -> str:
    """Return what the portrait shows, in sentences for screen readers."""
    across, up = (system.variables[k] for k in pictures.inputs.axes)
    x, y = starts[selected]
    count = len(starts)
    which = "one trajectory, which starts" if count == 1 else f"{count} trajectories; number {selected + 1} starts"
    met = "; ".join(f"{one.method}: {one.met}" for one in pictures.summaries)
    return f"{SUMMARY} of {system.name}, {up} against {across}: {which} at ({x:.4g}, {y:.4g}). {met}."


def figures_of(pictures: Pictures) -> str:
    """Return of which start the figures below the portrait are, and which others stop early; empty if there is one."""
    count, index = pictures.inputs.start_count, pictures.inputs.index
    if count == 1:
        return ""
    stops: dict[str, set[int]] = {}
    for number, orbit in pictures.numbered:
        if orbit.end is not None and number != index + 1:
            stops.setdefault(ENDS[orbit.end.status].word, set()).add(number)
    told = "; ".join(f"{listed([str(k) for k in sorted(who)])}: {word}" for word, who in stops.items())
    return f"Start {index + 1} of {count}." + (f" Others that stop early: {told}." if told else "")
