"""Trajectories as the portrait draws them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import core
from core.diagnostics import starts_beyond_wall
from pwsviz.geometry.clipping import clipped
from pwsviz.geometry.plane import Axes, Plane
from pwsviz.geometry.polyline_reduction import Floats, distinct_pixels, screen_path
from pwsviz.geometry.projection import PLANE, shows_levels, surfaces_shown
from pwsviz.geometry.window import Window
from pwsviz.results.curves import FAR, curve, jump_lines, pixel_size
from pwsviz.results.requests import RunInputs

__all__ = ["PIECES_WITH_LEVELS", "RUNS_OFF", "End", "Levels", "Orbit", "drawn_within", "orbit_of", "places_near"]

Levels = tuple[tuple[int, tuple[float, ...]], ...]
"""Values of ψ for each region, by its number."""

BEGINNING = 4.0
"""Sizes of the box of its start, its first crossings and the origin in which a run that may have run off is viewed."""

FEW_STEPS = 300
"""Most steps of a run that are marked on its curve."""

APART = 40.0
"""Pixels that most steps are long if they are marked: three times the mark, on a screen of a third of `RESOLUTION`."""

RETURNED = 3
"""Consecutive steps that end near earlier ends where a run has returned to its own path; fewer where it crosses it."""

ON_SURFACE = 1e-9
"""Height above a surface, relative to 1 and to the state, up to which a place lies on it."""

MOST_PLACES = 1000
"""Most places of crossings of one run that are marked: more take a browser too long to paint."""

PIECES_WITH_LEVELS = 12
"""Pieces of a run, from its start on, through the beginnings of which level sets of ψ are drawn."""

RUNS_OFF = (
    core.Status.ESCAPED, core.Status.UNSTABLE, core.Status.SINGULAR, core.Status.NO_CONVERGENCE, core.Status.STEP_LIMIT,
)  # fmt: skip
"""Statuses of runs that may have gone very far, of which only the part near the beginning is drawn."""


@dataclass(frozen=True)
class End:
    """Where a run stopped before the end time.

    Attributes
    ----------
    status : core.Status
        Why it stopped.
    t : float
        When.
    place : (float, float)
        Where in the plane, be it beyond what is drawn: the last finite state.
    """

    status: core.Status
    t: float
    place: tuple[float, float]


@dataclass(frozen=True)
class Orbit:
    """One trajectory as the portrait draws it; each curve is a (k, 2) array with rows of NaN between its pieces."""

    method: str
    path: Floats
    reach: Floats
    """(2, 2) least and greatest values along all of it, be they beyond what is drawn."""
    crossings: Floats
    numbers: NDArray[np.intp]
    """Number of each crossing in the run, from 1."""
    times: Floats
    kinds: tuple[str, ...]
    jumps: Floats
    start: tuple[float, float]
    levels: Levels
    steps: Floats
    """Ends of the steps if they are few, until the run returns to its own path; else none."""
    more_steps: bool
    """Whether further steps are not marked, though the first are."""
    end: End | None
    """Where and why it stopped early; None if it reached the end time."""
    places: int
    """How many places of crossings a screen tells apart, of which the first `MOST_PLACES` are in `crossings`."""
    bare: bool
    """Whether a ψ is known where a run starts, but not defined at the start, so that no level set passes through it."""
    beyond: bool
    """Whether it starts beyond a wall, at which every run bounces."""
    focus: Floats
    """(k, 2) what a view of it is fitted to: all of it, or of a run that may have gone very far its beginning."""

    @property
    def runs_off(self) -> bool:
        """Whether it may have gone very far, and only its beginning is drawn."""
        return self.end is not None and self.end.status in RUNS_OFF


def orbit_of(inputs: RunInputs, run: core.Trajectory, near: Window | None, plane: Plane) -> Orbit:
    """Return a run as the portrait draws it, as far as it stays within `near`.

    Without such a window the whole of it, but of one that may have run off only the part near its beginning, `FAR`
    times as large as its view. A curve that leaves `near` ends on its border.
    """
    view = _surroundings(run, plane) if run.status in RUNS_OFF else None
    if near is None and view is not None:
        near = view.scaled(FAR)
    _, points, kinks, _ = curve(run, plane, near)
    crossings = run.crossings.passed
    at = plane.points(crossings.x)
    marks = np.flatnonzero(near.holds(at)) if near else np.arange(len(crossings))
    apart = distinct_pixels(at[marks])
    marks = marks[apart[:MOST_PLACES]]
    jumped = marks[crossings.kind[marks] == "jump"]
    jumped = jumped[~_along_surface(run, crossings[jumped], plane.axes)]
    pixel, within, reach = pixel_size(points, near), None, _reach(points)
    if near is not None:
        points, kinks, within = clipped(points, kinks, near)
    path = screen_path(points, kinks, within, pixel=pixel)
    steps, more_steps = _steps(run, near, plane)
    return Orbit(
        method=inputs.scheme.method,
        path=path,
        reach=reach,
        crossings=at[marks],
        numbers=1 + marks,
        times=crossings.t[marks],
        kinds=tuple(str(crossings.kind[k]) for k in marks),
        jumps=jump_lines(at[jumped], plane.points(crossings.x_after[jumped])).reshape(-1, PLANE),
        start=plane.place(inputs.problem.x0),
        levels=_levels(run),
        steps=steps,
        more_steps=more_steps,
        end=_end(run, plane),
        places=len(apart),
        bare=_bare(run),
        beyond=starts_beyond_wall(run),
        focus=path if view is None else _part(path, view),
    )


def _reach(points: Floats) -> Floats:
    finite = points if np.isfinite(points.sum()) else points[np.isfinite(points).all(axis=1)]
    return np.stack([finite.min(axis=0), finite.max(axis=0)]) if len(finite) else np.full((2, PLANE), np.nan)


def _along_surface(run: core.Trajectory, jumps: core.Crossings, axes: Axes) -> NDArray[np.bool_]:
    """Return (k,) which jumps lead along a surface that is drawn, which would hide a line from end to end."""
    along = np.zeros(len(jumps), dtype=bool)
    for mode in np.unique(jumps.mode).tolist():
        rows = (jumps.mode == mode) & np.isin(jumps.surface_met, surfaces_shown(run.system, axes))
        middle = 0.5 * (jumps.x[rows] + jumps.x_after[rows])
        heights = np.abs(run.system.heights(mode, jumps.t[rows], middle)).min(axis=-1)
        along[rows] = heights <= ON_SURFACE * (1.0 + np.abs(middle).max(axis=-1))
    return along


def places_near(run: core.Trajectory, axes: Axes) -> Floats:
    """Return where (k, 2) the states of a run are in a plane; of one that may have run off, those near its beginning.

    There is at least the first.
    """
    plane = Plane(axes)
    at = plane.points(run.x)
    return at[_surroundings(run, plane).holds(at)] if run.status in RUNS_OFF else at


def drawn_within(first: Orbit) -> Window:
    """Return the part of the plane in which the orbits beside the first one are drawn."""
    return Window.around(first.focus).scaled(FAR)


def _part(path: Floats, view: Window) -> Floats:
    """Return the points of a curve within a view, and where it leaves it; the start, if none is."""
    points, _, within = clipped(path, np.zeros(len(path), dtype=bool), view)
    return points[within] if within.any() else path[:1]


def _steps(run: core.Trajectory, near: Window | None, plane: Plane) -> tuple[Floats, bool]:
    """Return the ends of steps, if they are few and most are long, until they return; and whether there are more."""
    none = np.empty((0, PLANE)), False
    if len(run.t) > FEW_STEPS + 1:
        return none
    at = plane.points(run.x)
    at = np.ascontiguousarray(at[np.isfinite(at).all(axis=1) & (near.holds(at) if near else True)])
    length = np.hypot(*np.diff(at, axis=0).T)
    if 2 * np.count_nonzero(length > APART * pixel_size(at, near)) <= len(length):
        return none
    first = at[: _return(at, length)]
    return first, len(first) < len(at)


def _return(at: Floats, length: Floats) -> int:
    """Return how many places there are before steps end, one after another, within half a step of earlier places."""
    distance = np.hypot(*(at[1:, None] - at[None, :]).transpose(2, 0, 1))
    later = np.arange(len(at)) >= np.arange(len(at) - 1)[:, None]  # and the place before, a step away
    close = np.where(later, np.inf, distance).min(axis=1, initial=np.inf) < 0.5 * length
    ends = np.flatnonzero(np.convolve(close, np.ones(RETURNED)) == RETURNED)  # of as many in a row
    return int(ends[0]) - RETURNED + 2 if len(ends) else len(at)


def _end(run: core.Trajectory, plane: Plane) -> End | None:
    if run.status is core.Status.COMPLETED:
        return None
    at = plane.points(run.x)
    x, y = at[np.flatnonzero(np.isfinite(at).all(axis=1))[-1]].tolist()
    return End(run.status, float(run.t[-1]), (x, y))


def _surroundings(run: core.Trajectory, plane: Plane) -> Window:
    """Return a window many times as large as the first part of a run."""
    anchors = np.concatenate([plane.points(run.x[:1]), plane.points(run.crossings.x[:12]), np.zeros((1, PLANE))])
    return Window.around(np.concatenate([anchors - 0.5, anchors + 0.5])).scaled(BEGINNING)


def _bare(run: core.Trajectory) -> bool:
    """Return whether a ψ of the region of the start is not defined there, as where it has a logarithm of x < 0."""
    mode = int(run.mode[0])
    if not 0 <= mode < len(run.system.laws.regions):
        return False
    psi = run.system.conserved(run.system.laws.name(mode), run.t[0], run.x[0])
    return not np.isfinite(psi).all()


def _levels(run: core.Trajectory) -> Levels:
    """Return the regions of the first few segments, and the values of ψ where these began, if level sets are drawn.

    They are rounded to what a screen can resolve, so that a change by round-off finds the same backdrop in the cache.
    """
    modes = np.concatenate([run.mode[:1], run.crossings.mode])[: min(PIECES_WITH_LEVELS, len(run.entered_t))]
    values, drawn = dict[int, Floats](), shows_levels(run.system)
    for mode in sorted({*modes.tolist()} & {*range(len(run.system.laws.regions))}):
        number = np.flatnonzero(modes == mode)
        psi = run.system.conserved(run.system.laws.name(mode), run.entered_t[number], run.entered_x[number])
        values[mode] = psi[np.isfinite(psi[:, 0]), 0] if drawn and psi.shape[1] else np.zeros(0)
    scale = float(np.abs(np.concatenate([*values.values(), [0.0]])).max()) or 1.0
    digits = 4 - math.floor(math.log10(scale))
    return tuple((mode, tuple(dict.fromkeys(np.round(psi, digits).tolist()))) for mode, psi in values.items())
