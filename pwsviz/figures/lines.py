"""The looks of integrators: their colours, dashes, markers and widths, legible without telling colours apart.

An integrator has one colour, one marker and one dash in every figure, legend and picture. What tells its curves apart
is never one of these: of several starts it is the width, of several crossings how full the marks are. Dashes are left
out where they tell nothing: of the curves over time, or in the plane, of one integrator alone, and where the turns of a
curve are so close that they would look like bricks.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

import core
from pwsviz.figures.colours import (
    BERRY,
    BLUE,
    BROWN,
    GREEN,
    OCHRE,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    VIOLET,
)


class Line(NamedTuple):
    """The look of one curve."""

    colour: str
    dash: tuple[int, ...]
    marker: str
    width: float


LOOKS: dict[str, tuple[Line, ...]] = {
    "DiscreteMultiplier": (Line(BLUE, (), "circle", 4.5),),
    "Composition": (
        Line(SKY, (14, 4), "hex", 1.6),
        Line(PURPLE, (10, 4, 2, 4), "diamond", 1.6),
        Line(ORANGE, (3, 3), "inverted_triangle", 2.4),
    ),
    "ButcherTableau": (
        Line(VERMILION, (8, 6), "square", 1.6),
        Line(GREEN, (4, 4), "triangle", 1.6),
        Line(BROWN, (10, 4, 2, 4, 2, 4), "star", 1.6),
        Line(BERRY, (2, 5), "square_pin", 2.4),
    ),
    "Projected": (Line(OCHRE, (6, 2), "plus", 2.4),),
    "TaylorSeries": (Line(VIOLET, (14, 4, 5, 4), "asterisk", 1.6),),
}
"""Looks of the integrators of each family, in their order (cyclically); all differ in colour, in dash and in marker.

Markers of those that have an order are closed, as order plots fill them."""

WIDEST = 4.5
"""Width in pixels of the first of several curves that are drawn together."""

NARROWEST = 2.2
"""Width of the last of them: its dashes are to be seen on those below, and those beside it."""

ALONE = 1.6
"""Width of a curve against time that is alone."""

SLIM = 0.7
"""Widths of curves against time, relative to those of curves in the plane."""

LEGEND_WIDTH = 2.5
"""Width in pixels of a line in every legend, whatever its width in the plot."""


def line_of(method: str) -> Line:
    """Return the look of an integrator, the same in every plot."""
    family = type(core.METHODS[method].scheme)
    looks = LOOKS[family.__name__]
    members = [name for name, one in core.METHODS.items() if type(one.scheme) is family]
    return looks[members.index(method) % len(looks)]


def together(lines: Iterable[Line]) -> list[Line]:
    """Return the looks of curves that are drawn together, each over those before it.

    Alike ones are solid, for there is none to tell apart. Else each look is narrower than those before it, which are so
    seen beside it where the curves coincide.
    """
    found = list(lines)
    looks = list(dict.fromkeys(found))
    if len(looks) == 1:
        return [line._replace(dash=()) for line in found]
    widths = dict(zip(looks, np.linspace(WIDEST, NARROWEST, len(looks)).tolist(), strict=True))
    return [line._replace(width=widths[line]) for line in found]


def widths_in_time(methods: Iterable[str]) -> list[float]:
    """Return the widths of curves of integrators against time, where they wind closely."""
    lines = together(map(line_of, methods))
    alike = len(set(lines)) == 1
    return [ALONE if alike else SLIM * line.width for line in lines]


LOOK_COLUMNS = ("method", "colour", "dash", "marker")
"""Columns of curves by integrator, see `look_columns`; in print they have markers (see `picture_markers.js`)."""


def look_columns(methods: Sequence[str]) -> dict[str, list[Any]]:
    """Return `LOOK_COLUMNS` of curves that are drawn together, of these integrators."""
    lines = together(map(line_of, methods))
    return {
        "method": list(methods),
        "colour": [line.colour for line in lines],
        "dash": [list(line.dash) for line in lines],
        "marker": [line.marker for line in lines],
    }
