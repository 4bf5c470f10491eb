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

from core.integration.crossings import Crossings
from core.integration.run_settings import Settings
from core.integration.runner import Runner
from core.integration.starting import way_out
from core.integration.trajectory import Trajectory
from core.kernels.arrays import Floats
from core.methods import METHODS
from core.symbolic.source_text import to_text

__all__ = ["undecided_corners"]

#: Most places at which the ways out are examined: those that are nearest to a corner.
_MOST = 64
#: Most steps that are made again, half as long.
_MOST_STEPS = 1e6
#: Tolerance of a variable-step method in that, as part of its own.
_TIGHTER = 2.0**-7
_EPS = 2.0**-52
#: Bound on the error of a run, in units of its estimate from half the step.
_SAFETY = 2.0
#: Error by rounding, in units of its first-order bound.
_MARGIN = 16.0


class _Passage(NamedTuple):
    """A crossing near a corner, out of which the laws around do not lead one way."""

    number: int
    """Index of the crossing."""
    t: float
    met: int
    """Number of the surface met."""
    near: int
    """Number of the other surface."""
    height: float
    """Its switching function there."""
    reason: str
    """Why the laws do not tell the way out."""


def undecided_corners(run: Trajectory) -> Iterator[str]:
    """Warn of the first crossing that is nearer to an ambiguous corner than the run is accurate.

    How accurate it is there is told by a run with half the step; of a long run, by the last part of it.
    """
    crossings = run.crossings
    laws = run.system.laws
    if len(laws.surfaces) < 2 or not laws.regions[0].sides or not np.array_equal(crossings.x, crossings.surface):
        return  # regions by name have no corners; a run that is perturbed, or steps over surfaces, is off them anyway
    passages = _passages(run)
    if not passages:
        return
    begin = int(np.argmax(np.abs(run.entered_t - passages[-1].t) <= _MOST_STEPS * run.tau / 2.0))
    closer = _made_again(run, begin, passages[-1].t, run.tau / 2.0)
    order = METHODS[run.method].order
    factor = 1.0 if order is None else 1.0 / (1.0 - 2.0**-order)  # Richardson
    for passage in passages:
        error = _difference(run, passage, closer)
        length = abs(passage.t - run.entered_t[passage.number])
        if 0.0 < length < run.tau:  # half the step may have made the same part of a step
            error += _difference(run, passage, _made_again(run, passage.number, passage.t, length / 2.0))
        error = factor * error + _rounding(run, passage)
        if abs(passage.height) <= _SAFETY * error:
            met, near = (to_text(laws.surfaces[k]) for k in (passage.met, passage.near))
            yield (
                f"At t = {passage.t:.6g} {met} = 0 is met so near to {near} = 0 that a run of this accuracy does not "
                f"tell which of them is met first, and {passage.reason}: with other steps it may go on elsewhere"
            )
            return


def _passages(run: Trajectory) -> list[_Passage]:
    """Crossings within a step of an ambiguous corner, in order of time."""
    system, laws, crossings = run.system, run.system.laws, run.crossings
    known = np.flatnonzero((crossings.kind != "corner") & (crossings.surface_met >= 0))
    t, x, met = crossings.t[known], crossings.x[known], crossings.surface_met[known]
    arriving = np.concatenate([run.mode[:1], crossings.mode])[known]  # before each
    distance = np.full((len(known), len(laws.surfaces)), np.inf)  # in time, with the speed at which it arrives
    heights = laws.evaluate("heights", laws.surfaces, t, x, system.parameter_array)
    for number in np.unique(arriving[arriving >= 0]).tolist():
        rows, mode = arriving == number, laws.mode(number)
        wanted = tuple(map(mode.rate_of, laws.surfaces))
        rates = laws.evaluate(("rates", number), wanted, t[rows], x[rows], system.parameter_array)
        with np.errstate(all="ignore"):
            distance[rows] = np.abs(heights[rows] / rates)
    distance[np.arange(len(known)), met] = np.inf
    rows, others = np.nonzero(distance <= run.tau)
    nearest = np.argsort(distance[rows, others])[:_MOST]
    direction, found = math.copysign(1.0, run.t[-1] - run.t[0]), []
    for row, other in sorted(zip(rows[nearest].tolist(), others[nearest].tolist(), strict=True)):
        surfaces = tuple(sorted((int(met[row]), other)))
        way = way_out(system, float(t[row]), x[row], surfaces, direction)
        if way.mode is None:
            place = int(known[row]), float(t[row]), int(met[row]), other
            found.append(_Passage(*place, float(heights[row, other]), way.reason))
    return found


def _made_again(run: Trajectory, begin: int, t: float, step: float) -> Crossings:
    """Crossings, up to shortly after time t, of a run by shorter steps from where a segment was entered.

    A variable-step method keeps a smaller tolerance as well.
    """
    method = METHODS[run.method]
    tighter = max(_EPS, run.tolerance * _TIGHTER) if method.adaptive else math.nan
    start = run.system, method, float(run.entered_t[begin]), tuple(run.entered_x[begin].tolist())
    runner = Runner(*start, Settings(step, tighter, slides=run.slides))
    runner.advance(t + math.copysign(2.0 * step, run.t[-1] - run.t[0]))
    return runner.crossings()


def _rounding(run: Trajectory, passage: _Passage) -> float:
    """Bound on the error of the height of the other surface by rounding the states of the segment that led there."""
    laws, row, k = run.system.laws, len(run.system.laws.surfaces) + passage.near, passage.number
    states = np.stack([run.entered_x[k], run.crossings.x[k]])
    times = np.array([run.entered_t[k], passage.t])
    sizes = laws.evaluate("sizes", laws.surfaces_and_roundings, times, states, run.system.parameter_array)[:, row]
    return _MARGIN * _EPS * float(sizes.sum())


def _difference(run: Trajectory, passage: _Passage, closer: Crossings) -> float:
    """By how much the height of the other surface differs in another run; inf where that meets another one first."""
    system, laws = run.system, run.system.laws
    rows = np.flatnonzero(np.isin(closer.surface_met, (passage.met, passage.near)))
    if not len(rows):
        return math.inf
    row = rows[np.argmin(np.abs(closer.t[rows] - passage.t))]
    if closer.surface_met[row] != passage.met or closer.kind[row] == "corner":
        return math.inf
    heights: Floats = laws.evaluate("heights", laws.surfaces, closer.t[row], closer.x[row], system.parameter_array)
    return abs(float(heights[passage.near]) - passage.height)
