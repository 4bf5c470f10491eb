"""How often a run meets surfaces, counted by what happens there, and the words for it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from core.integration.crossings import Integers

__all__ = ["KINDS", "Tally", "crossed", "kinds_of"]

#: What may happen where a surface is met, in the order of the fields of a `Tally`: one of it, and several.
KINDS = (("crossing", "crossings"), ("jump", "jumps"), ("slide", "slides"), ("end of sliding", "ends of sliding"))


class Tally(NamedTuple):
    """How often surfaces are met, by what happens there; as text, such as “3 crossings, 2 slides”."""

    crossings: int = 0
    """Another region is entered, with or without a jump of the state."""
    jumps: int = 0
    """The state jumps, and stays in its region."""
    slides: int = 0
    """Sliding along a surface begins."""
    ends: int = 0
    """Sliding ends."""

    @classmethod
    def of(cls, kinds: Integers) -> Tally:
        """Count each of `kinds_of`."""
        return cls(*np.bincount(kinds, minlength=len(KINDS)).tolist())

    def __str__(self) -> str:
        """Count crossings, jumps and slides: an end of sliding follows from its beginning."""
        shown = [_counted(number, kind) for kind, number in enumerate(self[:3]) if number]
        return ", ".join(shown) or _counted(0, 0)

    def difference(self, expected: Tally) -> str:
        """Say which numbers differ from those expected, such as “7 crossings instead of 8”; empty if none does."""
        both = list(zip(self, expected, strict=True))
        differ = [kind for kind, (has, should) in enumerate(both) if has != should]
        return ", ".join(f"{_counted(both[kind][0], kind)} instead of {both[kind][1]:,}" for kind in differ)


def kinds_of(modes: Integers, regions: int) -> Integers:
    """Return (k,) what happens between (k + 1,) modes, the first and those entered: indices into `KINDS`.

    Modes are given by their numbers; those from the number of `regions` on slide.
    """
    before, after = modes[:-1], modes[1:]
    return np.where(after >= regions, 2, np.where(before >= regions, 3, after == before))


def crossed(met: Integers) -> Integers:
    """Return (...) how often surfaces are met without sliding, of (..., 4) tallies; −1 where these are unknown."""
    return np.asarray(np.maximum(met[..., 0] + met[..., 1], -1))


def _counted(number: int, kind: int) -> str:
    return f"{number:,} {KINDS[kind][number != 1]}"
