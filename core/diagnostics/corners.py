"""Test whether a run passes a corner, at which several surfaces meet, on a side that its accuracy does not tell.

The loop takes surfaces to be met at the same instant where they are to rounding. The error of a method is larger: of a
solution that meets a corner, a numerical one meets one of the surfaces first, which of them is a matter of the step.
That decides where the run goes on, unless the laws around lead the same way out of the corner whatever is met first.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.codegen.rounding import with_roundings
from core.integration.crossings import Crossings
from core.integration.run_settings import Settings
from core.integration.runner import Runner
from core.integration.starting import onto_surfaces, way_out
from core.integration.trajectory import Trajectory
from core.kernels.arrays import Floats
from core.methods import METHODS
from core.symbolic.source_text import to_text
from core.transition.records import NO_MODE

__all__ = ["slid_into_corners", "undecided_corners"]

#: Most crossings that are examined: those that are nearest to other surfaces.
_MOST = 64
#: Most steps that are made again, half as long.
_MOST_STEPS = 1_000_000
#: Tolerance of a variable-step method in that, as part of its own.
_TIGHTER = 2.0**-7
#: Most steps that a shorter run takes, as a multiple of those of the run, and beside these.
_MORE_STEPS, _FEW_STEPS = 4, 64
_EPS = 2.0**-52
#: Bound on the error of a run, in units of its estimate from half the step.
_SAFETY = 2.0
#: Error by rounding, in units of its first-order bound.
_MARGIN = 16.0


class _Passage(NamedTuple):
    """A crossing near a corner."""

    number: int
    """Index of the crossing."""
    t: float
    met: int
    """Number of the surface met."""
    near: int
    """Number of the other surface."""
    height: float
    """Its switching function there."""
    corner: Floats
    """(d,) where the two surfaces meet."""
    reach: float
    """Length of a step there."""
    rounding: float
    """Bound on the error of the height by rounding the states of the segment that led there."""


def undecided_corners(run: Trajectory) -> Iterator[str]:
    """Warn of the first crossing that is nearer to a corner than the run is accurate, if its laws lead out in two ways.

    How accurate it is there is told by a run with half the step; of a long run, by the last part of it.
    """
    crossings, laws = run.crossings, run.system.laws
    passed = crossings.kind == "corner"  # the state goes on from where the surfaces meet
    as_met = np.array_equal(crossings.x[~passed], crossings.surface[~passed])
    if len(laws.surfaces) < 2 or not laws.regions[0].sides or not as_met:
        return  # regions by name have no corners; a run that is perturbed, or steps over surfaces, is off them anyway
    passages = _passages(run)
    if not passages:
        return
    direction = math.copysign(1.0, run.t[-1] - run.t[0])
    begin = int(np.argmax(np.abs(run.entered_t - passages[-1].t) <= _MOST_STEPS * run.tau / 2.0))
    closer = _made_again(run, begin, passages[-1].t, run.tau / 2.0)
    for passage in passages:
        if abs(passage.height) > _SAFETY * _error(run, passage, closer):
            continue
        way = way_out(run.system, passage.t, passage.corner, tuple(sorted((passage.met, passage.near))), direction)
        if way.mode is None:
            met, near = (to_text(laws.surfaces[k]) for k in (passage.met, passage.near))
            yield (
                f"At t = {passage.t:.6g} {met} = 0 is met so near to {near} = 0 that a run of this accuracy does not "
                f"tell which of them is met first, and {way.reason}: with other steps it may go on elsewhere"
            )
            return


def slid_into_corners(run: Trajectory) -> Iterator[str]:
    """Warn of the first corner that a run has passed, if solutions beside it slide, at which the run would end."""
    crossings, laws = run.crossings, run.system.laws
    passed = () if run.slides else np.flatnonzero((crossings.kind == "corner") & (crossings.mode != NO_MODE))
    for row in passed:
        t, x = float(crossings.t[row]), crossings.x[row]
        heights, rounding = _heights(run, np.array([row]))
        met = tuple(np.flatnonzero(np.abs(heights[0]) <= rounding[0]).tolist())
        if way_out(run.system, t, x, met, math.copysign(1.0, run.t[-1] - run.t[0])).slid_into:
            zeros = " and ".join(f"{to_text(laws.surfaces[k])} = 0" for k in met)
            yield (
                f"At t = {t:.6g} {zeros} are met at once, to rounding, and the run goes on, but solutions beside it "
                "slide: one that met only one of them would end there"
            )
            return


def _passages(run: Trajectory) -> list[_Passage]:
    """Crossings within a step of a corner, in order of time."""
    system, laws, crossings, p = run.system, run.system.laws, run.crossings, run.system.parameter_array
    count = len(laws.surfaces)
    at_once = np.diff(crossings.t, prepend=np.nan) == 0.0  # a surface beyond which a jump led: it was met after that
    known = np.flatnonzero((crossings.kind != "corner") & (crossings.surface_met >= 0) & ~at_once)
    t, x, met = crossings.t[known], crossings.x[known], crossings.surface_met[known]
    arriving = np.concatenate([run.mode[:1], crossings.mode])[known]  # of each crossing, the mode before it
    heights, rounding = _heights(run, known)
    away, reach = np.full(heights.shape, np.inf), np.zeros(len(known))  # time to the other surfaces; way of a step
    for number in np.unique(arriving[arriving >= 0]).tolist():
        rows, mode = arriving == number, laws.mode(number).written
        wanted = (*map(mode.rate_of, laws.surfaces), *mode.field)
        rates = laws.evaluate(("rates and field", number), wanted, t[rows], x[rows], p)
        with np.errstate(all="ignore"):
            away[rows] = np.abs(heights[rows] / rates[:, :count])
        reach[rows] = run.tau * np.abs(rates[:, count:]).max(axis=1)
    away[np.arange(len(known)), met] = np.inf
    rows, others = np.nonzero(away <= run.tau)
    nearest = np.argsort(away[rows, others])[:_MOST]
    found = []
    for row, near in sorted(zip(rows[nearest].tolist(), others[nearest].tolist(), strict=True)):
        corner = onto_surfaces(system, float(t[row]), x[row], tuple(sorted((int(met[row]), near))))
        left = abs(_height(run, near, float(t[row]), corner))
        met_nearby = left <= abs(heights[row, near]) / 4.0 + rounding[row, near]  # else they are parallel, or far apart
        if met_nearby and np.abs(corner - x[row]).max() <= reach[row]:
            place = int(known[row]), float(t[row]), int(met[row]), near, float(heights[row, near]), corner
            found.append(_Passage(*place, float(reach[row]), float(rounding[row, near])))
    return found


def _heights(run: Trajectory, rows: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """The switching functions at some crossings, and bounds on their error by rounding the states of the segments."""
    crossings, laws, p = run.crossings, run.system.laws, run.system.parameter_array
    wanted = "heights and roundings", with_roundings(laws.surfaces)
    values = laws.evaluate(*wanted, crossings.t[rows], crossings.x[rows], p)
    before = laws.evaluate(*wanted, run.entered_t[rows], run.entered_x[rows], p)
    count = len(laws.surfaces)
    return values[:, :count], _MARGIN * _EPS * (values + before)[:, count:]


def _height(run: Trajectory, surface: int, t: float, x: Floats) -> float:
    """A switching function at a state (d,)."""
    return float(
        run.system.laws.evaluate("heights", run.system.laws.surfaces, t, x, run.system.parameter_array)[surface]
    )


class _Closer(NamedTuple):
    """A run with shorter steps."""

    crossings: Crossings
    end: float
    """Time up to which it was made: its steps are limited."""


def _made_again(run: Trajectory, begin: int, t: float, step: float) -> _Closer:
    """Run by shorter steps from where a segment was entered, up to shortly after time t.

    A variable-step method keeps a smaller tolerance as well.
    """
    method = METHODS[run.method]
    tighter = max(_EPS, run.tolerance * _TIGHTER) if method.adaptive else math.nan
    start = run.system, method, float(run.entered_t[begin]), tuple(_entered(run, begin).tolist())
    steps = min(_MORE_STEPS * run.steps, _MOST_STEPS) + _FEW_STEPS  # beyond the end of the run there may be a pole
    runner = Runner(*start, Settings(step, tighter, max_steps=steps, slides=run.slides))
    runner.advance(t + math.copysign(2.0 * step, run.t[-1] - run.t[0]))
    return _Closer(runner.crossings(), runner.t)


def _entered(run: Trajectory, segment: int) -> Floats:
    """(d,) where a segment was entered: on the surface met there, beside which rounding may have put it."""
    t = float(run.entered_t[segment])
    x: Floats = run.entered_x[segment]
    met = int(run.crossings.surface_met[segment - 1]) if segment > 0 else -1
    if met < 0:
        return x
    there = onto_surfaces(run.system, t, x, (met,))
    return there if np.abs(there - x).max() <= _MARGIN * _EPS * np.abs(x).max() else x


def _error(run: Trajectory, passage: _Passage, closer: _Closer) -> float:
    """Estimate of the error of the height of the other surface; inf where that may be met first."""
    order = METHODS[run.method].order
    factor = 1.0 if order is None else 1.0 / (1.0 - 2.0**-order)  # Richardson
    error, length = _difference(run, passage, closer), abs(passage.t - run.entered_t[passage.number])
    if 0.0 < length < run.tau:  # half the step may have made the same part of a step
        error += _difference(run, passage, _made_again(run, passage.number, passage.t, length / 2.0))
    return factor * error + passage.rounding


def _difference(run: Trajectory, passage: _Passage, closer: _Closer) -> float:
    """By how much the height of the other surface differs in another run; inf where that meets the other one first.

    A run that ends before or does not come near the corner, having parted from this one, tells nothing here.
    """
    others, way = closer.crossings, math.copysign(1.0, run.t[-1] - run.t[0])
    rows = np.flatnonzero(np.abs(others.x - passage.corner).max(axis=1) <= passage.reach)
    if not len(rows) or way * (passage.t - closer.end) > run.tau:
        return 0.0
    row = rows[np.argmin(np.abs(others.t[rows] - passage.t))]
    if others.surface_met[row] != passage.met or others.kind[row] == "corner":
        return math.inf
    return abs(_height(run, passage.near, float(others.t[row]), others.x[row]) - passage.height)
