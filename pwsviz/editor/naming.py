"""The name that the form proposes for a system, which follows what is typed."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace
from itertools import count

from pwsviz.editor.draft import Draft
from pwsviz.text.typed import split

__all__ = ["CHANGED", "MAX_NAME", "UNNAMED", "proposed_name"]

MAX_NAME = 60
"""Characters of the name of a system."""

CHANGED = " (changed)"
"""What follows the name of a system of which a part has been changed."""

UNNAMED = "My system"
"""The name of a system that has nothing in common with the one it was begun from."""

#: Fields that hold one law: it stands while all of it does.
_ONE_LAW = ("f", "f_minus", "f_plus", "g")
#: Fields that hold a law on each line.
_LAW_A_LINE = ("surfaces", "regions", "transitions")


def proposed_name(begun: Draft, draft: Draft, listed: Collection[str]) -> str:
    """Return a name for a draft whose name nobody typed.

    Parameters
    ----------
    begun : Draft
        What the fields were filled in with.
    draft : Draft
        What they hold now.
    listed : collection of str
        Names of other systems in the same list, which a system that differs must not have.

    Returns
    -------
    str
        The name it was begun with while a field or a surface of that system still stands, with “(changed)” if another
        system has it; “My system” otherwise, with a number if that is taken.
    """
    if replace(draft, name=begun.name) == begun:
        return begun.name
    if begun.name and not set(_laws(begun)).isdisjoint(_laws(draft)):
        taken = begun.name in listed and not begun.name.endswith(CHANGED)
        return begun.name[: MAX_NAME - len(CHANGED)] + CHANGED if taken else begun.name
    names = (UNNAMED if k == 1 else f"{UNNAMED} {k}" for k in count(1))
    return next(name for name in names if name not in listed)


def _laws(draft: Draft) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield each field and each surface that a draft holds, with the name of its place."""
    for name in _ONE_LAW:
        if law := tuple(split(getattr(draft, name))):
            yield name, law
    for name in _LAW_A_LINE:
        for line in getattr(draft, name).splitlines():
            if law := tuple(split(line)):
                yield name, law
