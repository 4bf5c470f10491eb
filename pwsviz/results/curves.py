"""The curve of a run in the plane: its states, its crossings, and where steps are long the solution between them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

import core
from pwsviz.geometry.bends import bent_pieces
from pwsviz.geometry.plane import Plane
from pwsviz.geometry.polyline_reduction import (
    EVERYWHERE,
    RESOLUTION,
    Floats,
    Mask,
    longest_side,
    painted_first,
    spliced,
)
from pwsviz.geometry.projection import PLANE
from pwsviz.geometry.window import Window

__all__ = ["FAR", "Curve", "curve", "jump_lines", "pixel_size"]

FAR = 8.0
"""Sizes of a view within which orbits are drawn: as far as a user may zoom out and still see them leave."""

LONG_STEPS = 4000
"""States up to which all steps are looked between; of more of them, only those that reach pixels not painted yet."""

FINEST = 20_000
"""Vertices added to a curve from which it is not refined further."""

BEND = 1.0
"""Pixels between a vertex and the line through its neighbours from which the curve between them is looked at."""

STRAIGHT = 0.25
"""Pixels between a piece of the curve and its chord from which the piece is divided."""

PARTS = 4
"""Parts into which such a piece is divided, so that a piece with a turning point is seen to bend."""

ROUNDS = 8
"""Times that a piece is divided at most, into 65,536 parts in all: what bends then is a leap from one solution of the
equations of a step to another, which no division makes straight."""


class Curve(NamedTuple):
    """The curve of a run in the plane."""

    t: Floats
    """(n,) times of the vertices, ascending; a jump has three, all equal."""
    points: Floats
    """(n, 2) vertices; NaN between the two ends of a jump."""
    kinks: Mask
    """(n,) which vertices are crossings or belong to jumps."""
    whole: bool = True
    """Whether it has all turns of an orbit; of many long steps it has gaps where later turns repeat earlier ones."""


def pixel_size(points: Floats, near: Window | None) -> float:
    """Return the size of a pixel of the view for which points (n, 2) are drawn within `near`, `FAR` times this view."""
    size = longest_side(points, near or EVERYWHERE)
    return (size if near is None else min(size, near.longest / FAR)) / RESOLUTION


def curve(run: core.Trajectory, plane: Plane, near: Window | None = None) -> Curve:
    """Return the curve of a run; a jump leaves a gap.

    Between steps that are long on a screen, vertices come from the method's own continuous extension, `run.at`.

    Parameters
    ----------
    run : core.Trajectory
        The run, with its steps recorded.
    plane : Plane
        The two variables that span it, and their units.
    near : Window, optional
        The part of the plane that matters, `FAR` times the view; without it all of the plane does.
    """
    crossings = run.crossings
    places = np.searchsorted(run.segment, np.arange(len(crossings)), side="right")
    rows = jump_lines(plane.points(crossings.x), plane.points(crossings.x_after))
    rows = rows[:, [0, 2, 1]]  # before, gap, after
    there = np.ones(rows.shape[:2], dtype=bool)
    there[crossings.kind != "jump", 1:] = False
    inserted = np.repeat(places, there.sum(axis=1))
    points, kinks = spliced(plane.points(run.x), rows[there], inserted)
    t = np.insert(run.t, inserted, np.broadcast_to(crossings.t[:, None], there.shape)[there])
    given = Curve(t, points, kinks)
    return _refined(run, plane, given if len(run.t) <= LONG_STEPS else _first_turns(given, near), near)


def jump_lines(before: Floats, after: Floats) -> Floats:
    """Return (k, 3, 2): where each jump starts and ends in the plane, and a gap."""
    return np.stack([before, after, np.full((len(before), PLANE), np.nan)], axis=1)


def _first_turns(given: Curve, near: Window | None) -> Curve:
    """Leave out the steps that repeat earlier ones on the screen, if any is long enough to bend visibly."""
    t, points, kinks, _ = given
    pixel = pixel_size(points, near)
    if pixel == 0.0 or not _bent(given, near, pixel).any():
        return given
    shown: Mask = np.isfinite(points[:, 0]) & np.isfinite(points[:, 1])
    if near is not None:
        shown &= near.holds(points)
    new = painted_first(np.where(shown[:, None], points, np.nan), pixel) | ~(shown[1:] & shown[:-1])
    if new.all():
        return given
    there = np.append(new, False) | np.insert(new, 0, False)
    kept = np.flatnonzero(there)
    gaps = 1 + np.flatnonzero(~new[kept[:-1]])
    return Curve(
        np.insert(t[kept], gaps, t[kept[gaps - 1]]),
        np.insert(points[kept], gaps, np.nan, axis=0),
        np.insert(kinks[kept], gaps, False),
        whole=False,
    )


def _bent(given: Curve, near: Window | None, pixel: float) -> Mask:
    """Return (n − 1,) which pieces of a curve may bend visibly, where it is seen."""
    return bent_pieces(given.t, given.points, given.kinks, BEND * pixel, near or EVERYWHERE)


def _refined(run: core.Trajectory, plane: Plane, given: Curve, near: Window | None) -> Curve:
    """Divide the pieces of a curve that bend visibly, until none does but leaps."""
    t, points, kinks, whole = given
    pixel = pixel_size(points, near)
    if pixel == 0.0:
        return given
    bent = _bent(given, near, pixel)
    most = len(points) + FINEST
    for _ in range(ROUNDS):
        k = np.flatnonzero(bent)
        if not len(k) or len(points) >= most:
            break
        share = np.arange(1, PARTS) / PARTS
        times = t[k, None] + (t[k + 1] - t[k])[:, None] * share
        try:
            new = plane.points(run.at(times.ravel()))
        except ValueError:  # a part of a step may have no solution where the whole step has one
            break
        chord = points[k, None] + (points[k + 1] - points[k])[:, None] * share[:, None]
        away = np.hypot(*np.moveaxis(new.reshape(chord.shape) - chord, -1, 0)).max(axis=1)
        counts = np.where(bent, PARTS, 1)
        still = np.zeros(len(bent), dtype=bool)
        still[k] = away > PARTS**2 * STRAIGHT * pixel
        bent = np.repeat(still, counts)
        inserted = np.repeat(k + 1, PARTS - 1)
        t, kinks = np.insert(t, inserted, times.ravel()), np.insert(kinks, inserted, False)
        points = np.insert(points, inserted, new, axis=0)
    return Curve(t, points, kinks, whole)
