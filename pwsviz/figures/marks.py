"""The marks on trajectories: crossings by kind, and the ends of runs that stop early by reason."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from core import Status
from pwsviz.figures.colours import AMBER, GREEN, GREY, PURPLE, VERMILION
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.geometry.window import Window
from pwsviz.results.orbits import End, Orbit

__all__ = [
    "ENDS",
    "KIND_COLOURS",
    "KIND_MARKERS",
    "crossing_columns",
    "end_columns",
    "kind_columns",
    "left_out",
    "star_labels",
]

KIND_WORDS = {
    "transversal": "crossing", "grazing": "tangency", "sliding": "sliding begins", "leaving": "sliding ends",
    "corner": "corner",
}  # fmt: skip
"""What legends call crossings of some kinds; others by their own name."""

KIND_MARKERS = {
    "transversal": "circle", "grazing": "diamond", "sliding": "square", "repelling": "triangle", "jump": "hex",
    "leaving": "inverted_triangle", "corner": "star",
}  # fmt: skip
KIND_COLOURS = {
    "transversal": PURPLE, "grazing": VERMILION, "sliding": GREEN, "repelling": GREEN, "jump": AMBER,
    "leaving": GREEN, "corner": VERMILION,
}  # fmt: skip
"""Colours of crossings; kinds of the same colour differ in their marker."""

LARGER = {"triangle": 1.6, "inverted_triangle": 1.6, "diamond": 1.4, "star": 1.6}
"""Size of markers, relative to that of others, which Bokeh paints smaller: their white middle is to be seen."""

MOST_MARKS = 3000
"""Most crossings marked in one portrait, shared equally among its runs: more take a browser too long to paint."""

NEAR_STARS = 1 / 35
"""Distance of two stars, relative to the longer side of the view, within which one covers the number of the other."""

MARK_SIZE = {True: 9, False: 6}
"""Diameter in pixels of the mark of a crossing, wider than the curve: of the selected start, and of another one."""


class EndLook(NamedTuple):
    """The mark of a run that stops early."""

    word: str
    marker: str
    colour: str


ENDS = {
    Status.SLIDING: EndLook("sliding", "square_x", GREEN),
    Status.REPELLING: EndLook("repelling", "y", GREEN),
    Status.GRAZING: EndLook("tangency", "diamond_cross", VERMILION),
    Status.CORNER: EndLook("corner", "asterisk", VERMILION),
    Status.UNDECLARED: EndLook("no law", "circle_cross", VERMILION),
    Status.ZENO: EndLook("Zeno", "x", AMBER),
    Status.ESCAPED: EndLook("blow-up", "circle_x", VERMILION),
    Status.UNSTABLE: EndLook("unstable", "circle_x", VERMILION),
    Status.SINGULAR: EndLook("singular field", "circle_x", GREY),
    Status.NO_CONVERGENCE: EndLook("no solution", "circle_cross", GREY),
    Status.STEP_LIMIT: EndLook("step limit", "circle_cross", GREY),
    Status.CROSSING_LIMIT: EndLook("crossing limit", "circle_cross", GREY),
    Status.CONTRADICTION: EndLook("wrong side", "circle_cross", GREY),
}
"""Mark of an end by the status of the run; whatever stops a run has one.

A dot within a mark would be lost in a legend, where marks are small.
"""


def star_labels(starts: Sequence[tuple[float, float]], view: Window | None) -> tuple[list[str], list[str]]:
    """Return the number in the star of each start, and above it: of stars that cover one another, all numbers at once.

    These are in the order of the stars, from left to right or, if they lie one over the other, from the top down, and
    stand above the middle one, or the uppermost.

    Parameters
    ----------
    starts : sequence of (float, float)
        Where the stars are.
    view : Window or None
        What is seen, as far as it is known.
    """
    inside, above = [str(k + 1) for k in range(len(starts))], [""] * len(starts)
    near = 0.0 if view is None else NEAR_STARS * view.longest
    for crowd in _crowds(np.array(starts, dtype=float).reshape(-1, 2), near):
        across, up = np.ptp([starts[k] for k in crowd], axis=0)
        row = bool(across >= up)
        ordered = sorted(crowd, key=lambda k: starts[k][0] if row else -starts[k][1])
        above[ordered[(len(crowd) - 1) // 2 if row else 0]] = ", ".join(str(k + 1) for k in ordered)
        for k in crowd:
            inside[k] = ""
    return inside, above


def _crowds(places: Floats, near: float) -> list[list[int]]:
    """Return the groups of two or more places that hang together by distances of at most `near`."""
    left, crowds = list(range(len(places))), []
    while left:
        crowd, reached = [left.pop(0)], 0
        while reached < len(crowd):
            away = places[left] - places[crowd[reached]]
            joins = [k for k, there in zip(left, np.hypot(*away.T) <= near, strict=True) if there]
            left = [k for k in left if k not in joins]
            crowd += joins
            reached += 1
        if len(crowd) > 1:
            crowds.append(sorted(crowd))
    return crowds


def kind_columns(kinds: Sequence[str], sizes: Sequence[float]) -> dict[str, Sequence[Any]]:
    """Return the columns that give the look of crossings of these kinds, whose marks are as large as circles would be.

    The kind "crossing" stands for an unknown one.
    """
    markers = [KIND_MARKERS.get(kind, "circle") for kind in kinds]
    return {
        "label": [KIND_WORDS.get(kind, kind) for kind in kinds],
        "kind": kinds,
        "marker": markers,
        "colour": [KIND_COLOURS.get(kind, PURPLE) for kind in kinds],
        "size": [size * LARGER.get(marker, 1.0) for size, marker in zip(sizes, markers, strict=True)],
    }


def crossing_columns(orbits: Sequence[tuple[int, Orbit]], selected: int) -> dict[str, Any]:
    """Return a row for each marked crossing.

    Parameters
    ----------
    orbits : sequence of (int, Orbit)
        Every orbit drawn, with the number of its start.
    selected : int
        Number of the selected start.
    """
    most = _most_marks(len(orbits))
    marks = [(number, orbit, k) for number, orbit in orbits for k in range(min(len(orbit.kinds), most))]
    places = np.array([orbit.crossings[k] for _, orbit, k in marks]).reshape(-1, 2)
    chosen = [number == selected for number, _, _ in marks]
    return {
        "x": places[:, 0],
        "y": places[:, 1],
        **kind_columns([orbit.kinds[k] for _, orbit, k in marks], [MARK_SIZE[one] for one in chosen]),
        "method": [orbit.method for _, orbit, _ in marks],
        "number": [int(orbit.numbers[k]) for _, orbit, k in marks],
        "time": [float(orbit.times[k]) for _, orbit, k in marks],
        "start": [number for number, _, _ in marks],
        "chosen": chosen,
    }


def left_out(orbits: Sequence[Orbit]) -> str:
    """Say that not all places of crossings are marked, if they are too many."""
    most = _most_marks(len(orbits))
    marked, there = sum(min(len(one.kinds), most) for one in orbits), sum(one.places for one in orbits)
    return f"Crossings are marked at {marked:,} of {there:,} places, the first of each run." if marked < there else ""


def _most_marks(runs: int) -> int:
    return max(1, MOST_MARKS // max(runs, 1))


def end_columns(orbits: Iterable[tuple[int, Orbit]], view: Window | None = None) -> dict[str, Any]:
    """Return a row for each run that stops early; the orbits as for `crossing_columns`.

    The label says of ends that they lie outside the view, as far as that is known, if all of this kind do.
    """
    ends: list[tuple[int, Orbit, End]] = [(number, one, one.end) for number, one in orbits if one.end is not None]
    looks = [ENDS[end.status] for _, _, end in ends]
    inside = [view is None or bool(view.holds(np.array([end.place])).all()) for _, _, end in ends]
    seen = {look.word for look, there in zip(looks, inside, strict=True) if there}
    return {
        "x": [end.place[0] for _, _, end in ends],
        "y": [end.place[1] for _, _, end in ends],
        "label": [f"end: {look.word}{'' if look.word in seen else ', out of view'}" for look in looks],
        "marker": [look.marker for look in looks],
        "colour": [look.colour for look in looks],
        "method": [orbit.method for _, orbit, _ in ends],
        "time": [end.t for _, _, end in ends],
        "kind": [end.status.reason for _, _, end in ends],
        "start": [number for number, _, _ in ends],
    }
