"""Where runs ended before their end time, in words: for captions and headers of files."""

from __future__ import annotations

from collections.abc import Sequence

import core
from pwsviz.export.tables import DrawnRun
from pwsviz.text.advice import on_page
from pwsviz.text.numbers import printed

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
        return printed(f"{len(early)} of the {len(runs)} runs ended earlier, {when}")
    several = len({one.start for one in runs}) > 1
    return "; ".join(printed(_ending(one, several)) for one in early)


def _ending(one: DrawnRun, several: bool) -> str:
    start = f" from start {one.start}" if several else ""
    return f"{one.run.method}{start} ended at t = {float(one.run.t[-1]):.6g}: {on_page(one.run.reason)}"
