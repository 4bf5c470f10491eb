"""Where runs ended before their end time, in words: for captions and headers of files."""

from __future__ import annotations

from collections.abc import Sequence

import core
from pwsviz.export.tables import DrawnRun
from pwsviz.scene.names import met_at_surfaces
from pwsviz.text.advice import on_page
from pwsviz.text.numbers import printed
from pwsviz.text.words import listed

__all__ = ["endings"]

FEW = 3
"""Most runs whose endings are told one by one."""


def endings(runs: Sequence[DrawnRun]) -> str:
    """Return a sentence, without its stop, on which runs end before the end time, where and why; empty if none does.

    Parameters
    ----------
    runs : sequence of DrawnRun
        All runs in a figure.
    """
    early = [one for one in runs if one.run.status is not core.Status.COMPLETED]
    if len(early) > FEW:
        times = [float(one.run.t[-1]) for one in early]
        first, last = (f"{time:.6g}" for time in (min(times), max(times)))
        when = f"at t = {first}" if first == last else f"between t = {first} and {last}"
        which = "All" if len(early) == len(runs) else f"{len(early)} of the"
        return printed(f"{which} {len(runs)} runs end before that, {when}")
    several = len({one.start for one in runs}) > 1
    alike: dict[str, list[str]] = {}
    for one in early:
        start = f" from start {one.start}" if several else ""
        alike.setdefault(_ending(one), []).append(f"{one.run.method}{start}")
    if len(alike) == 1 and len(early) == len(runs):
        who = {1: "The run ends", 2: "Both runs end"}.get(len(runs), "All runs end")
        return printed(f"{who} {next(iter(alike))}")
    ends = (f"{listed(names)} end{'s' * (len(names) == 1)} {words}" for words, names in alike.items())
    return "; ".join(map(printed, ends))


def _ending(one: DrawnRun) -> str:
    """Return when and why a run ended."""
    why = f": {on_page(one.run.reason)}"
    if one.run.status is core.Status.ZENO:
        why = f", where {met_at_surfaces(one.run.system)} accumulate (Zeno)"
    return f"at t = {float(one.run.t[-1]):.6g}{why}"
