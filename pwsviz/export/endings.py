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
    """Return which runs ended before the end time, where and why; empty if none did.

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
        which = "all" if len(early) == len(runs) else f"{len(early)} of the"
        return printed(f"but {which} {len(runs)} runs ended earlier, {when}")
    several = len({one.start for one in runs}) > 1
    alike: dict[str, list[str]] = {}
    for one in early:
        start = f" from start {one.start}" if several else ""
        alike.setdefault(_ending(one), []).append(f"{one.run.method}{start}")
    told = "; ".join(printed(f"{listed(names)} ended {words}") for words, names in alike.items())
    return f"but {told}" if told else ""


def _ending(one: DrawnRun) -> str:
    """Return when and why a run ended."""
    why = f": {on_page(one.run.reason)}"
    if one.run.status is core.Status.ZENO:
        why = f", where {met_at_surfaces(one.run.system)} accumulate (Zeno)"
    return f"at t = {float(one.run.t[-1]):.6g}{why}"
