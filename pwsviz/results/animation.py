"""What figures need of a run besides its curves: the states that the player shows, and the marks of crossings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import core
from core.integration import KINDS
from pwsviz.geometry.plane import Plane
from pwsviz.geometry.polyline_reduction import Floats, simplify
from pwsviz.geometry.projection import PLANE
from pwsviz.geometry.window import Window
from pwsviz.results.curves import curve, pixel_size
from pwsviz.scene.names import tally_of

FEW = 500
"""Steps below which states between them are shown, so that the marker moves smoothly along the curve."""

VERTICES = 10
"""Vertices of a traced path at most for each state that may be shown: more are too much to send."""

MOST_CROSSINGS = 100_000
"""Crossings whose times are sent to the browser."""

MET = KINDS[:3]
"""What is counted while a run plays: an end of sliding follows from its beginning."""


@dataclass(frozen=True)
class Frames:
    """The path of one run in the plane, at its own steps, and also between them if they are few or the path bends.

    Attributes
    ----------
    method : str
        The integrator.
    t : (n,) array
        Times, ascending; a jump takes three, all equal.
    places : (n, 2) array
        Places in the plane at these times; NaN between the two ends of a jump.
    steps : (m,) array
        Times of the steps among `t`.
    met : tuple of (k,) arrays
        Times of the crossings, jumps and beginnings of sliding, at most `MOST_CROSSINGS` each.
    tally : Tally
        How many there are of each.
    traced : bool
        Whether the lines from place to place are the drawn curve. Those of a run whose curve has too many vertices are
        not: they are chords across it.
    """

    method: str
    t: Floats
    places: Floats
    steps: Floats
    met: tuple[Floats, ...]
    tally: core.Tally
    traced: bool


@dataclass(frozen=True)
class Landmarks:
    """What the plot of the conserved quantity marks of its first run.

    Attributes
    ----------
    places : (k, 2) array
        Place of each crossing in the portrait.
    kinds : tuple of str
        Kind of each crossing.
    """

    places: Floats
    kinds: tuple[str, ...]


def frames(run: core.Trajectory, plane: Plane, limit: int = 2000, near: Window | None = None) -> Frames:
    """Return the states of a run, every k-th if it has more than `limit` steps, and the vertices of its drawn curve.

    Parameters
    ----------
    run : core.Trajectory
        The run. Its first and last finite states are always kept; states that are not finite never are.
    plane : Plane
        That of the portrait.
    limit : int
        Bound on the steps shown, at least 1, and on the jumps; there is one more state than there are steps, and up to
        `VERTICES` times as many vertices. A curve that has more is left out.
    near : Window, optional
        The part of the plane in which the curve is drawn, as for `curve`.

    Raises
    ------
    ValueError
        If the limit is below 1.
    """
    if limit < 1:
        raise ValueError(f"limit = {limit}: at least 1 is needed, one step from the first state to the last")
    steps, t, places = _evenly(run, plane, limit)
    drawn, traced = _drawn(run, plane, near, VERTICES * limit)
    new = ~np.isin(t, drawn[0])
    t, x = np.concatenate([drawn[0], t[new]]), np.concatenate([drawn[1], places[new]])
    order = np.argsort(t, kind="stable")
    times, kinds = run.crossings.passed.t, run.kinds_met
    tally = tally_of(run)
    if tally != run.tally:  # crossings at which the state jumps, and nothing else is met
        kinds = np.where(kinds == 0, 1, kinds)
    met = tuple(times[kinds == kind][:MOST_CROSSINGS] for kind in range(len(MET)))
    return Frames(run.method, t[order], np.ascontiguousarray(x[order]), steps, met, tally, traced)


def _evenly(run: core.Trajectory, plane: Plane, limit: int) -> tuple[Floats, Floats, Floats]:
    """Return times of steps that are shown, and times and places of the states shown, which may be more."""
    there = np.flatnonzero(np.isfinite(plane.points(run.x)).all(axis=1))
    every = max(1, -(-(len(there) - 1) // limit))
    kept = there[::every] if (len(there) - 1) % every == 0 else np.append(there[::every], there[-1])
    steps, x = run.t[kept], run.x[kept]
    t = steps
    if len(steps) < min(FEW, limit):
        t = np.union1d(steps, np.linspace(steps.min(), steps.max(), limit))
        try:
            x = run.at(t)
        except ValueError:  # a part of a step may have no solution where the whole step has one
            t = steps
    return steps, t, plane.points(x)


def _drawn(run: core.Trajectory, plane: Plane, near: Window | None, most: int) -> tuple[tuple[Floats, Floats], bool]:
    """Return times and places of the vertices of the drawn curve, and True; if they are too many, the jumps alone."""
    t, points, kinks, whole = curve(run, plane, near)
    gaps = kinks & ~np.isfinite(points).all(axis=1)
    pinned = gaps.copy()
    pinned[:-1] |= gaps[1:]
    pinned[1:] |= gaps[:-1]
    finite = np.isfinite(points).all(axis=1)
    there = np.flatnonzero((finite | gaps) & ~np.logical_or.accumulate(~finite & ~gaps))  # up to the last finite state
    kept = there[simplify(points[there], pixel_size(points, near) / 4, pinned[there])]
    traced = whole and len(kept) <= most
    if not traced:
        kept = np.flatnonzero(pinned).reshape(-1, 3)[:: -(-int(gaps.sum()) * PLANE // most) or 1].ravel()
    return (t[kept], points[kept]), traced


def landmarks(run: core.Trajectory, plane: Plane) -> Landmarks:
    """Return what the plot of the conserved quantity marks of a run."""
    met = run.crossings.passed
    return Landmarks(np.ascontiguousarray(plane.points(met.x)), tuple(map(str, met.kind)))
