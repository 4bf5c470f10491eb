"""Choose the steps of a run in which bounds leave in doubt that g keeps its sign, or that the field has no peak."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray
from sympy import Expr

from core.diagnostics.boxes import Way
from core.diagnostics.narrow_features import doubts
from core.diagnostics.narrow_pushes import excess
from core.integration.trajectory import Trajectory
from core.kernels.arrays import Floats
from core.methods import METHODS
from core.symbolic.expressions import TIME, parse

__all__ = ["doubtful_steps", "pushed_steps"]

#: Most steps that are chosen; of a variable-step method, of all steps.
_MOST, _MOST_OF_ALL = 64, 512
#: Most steps over which bounds are worked out.
_MOST_BOUNDED = 50_000


def doubtful_steps(run: Trajectory) -> NDArray[np.intp]:
    """Rows of a run at which steps begin that no crossing cuts, those that are most in doubt.

    A step of a variable-step method is too long for a cubic: all are in doubt, unless there are many. Of a run that has
    not recorded its steps there are none.
    """
    return _most(run, _doubt_of_signs)


def pushed_steps(run: Trajectory) -> NDArray[np.intp]:
    """Likewise those in which it is most in doubt that the field stays below a multiple of its size at both ends."""
    return _most(run, _doubt_of_field)


def _most(run: Trajectory, doubt_of: Callable[[Trajectory, int, Way], Floats]) -> NDArray[np.intp]:
    if run.record != "steps":
        return np.empty(0, dtype=np.intp)
    rows = np.flatnonzero((run.mode[:-1] >= 0) & (run.segment[1:] == run.segment[:-1]))
    if METHODS[run.method].adaptive:
        return rows if len(rows) <= _MOST_OF_ALL else rows[:0]
    doubt, laws = np.zeros(len(run.t)), run.system.laws
    rows = rows[:_MOST_BOUNDED]
    for number in np.unique(run.mode[rows]).tolist():
        of_mode = rows[run.mode[rows] == number]
        ends = of_mode[:, None] + np.arange(2)
        t, x, field = run.t[ends], run.x[ends], laws.mode(number).written.field
        rates = laws.evaluate(("field", number), field, t, x, run.system.parameter_array)
        doubt[of_mode] = doubt_of(run, number, Way(t, x, rates))
    worst = np.argsort(-doubt, kind="stable")[:_MOST]
    return np.sort(worst[doubt[worst] > 0.0])


def _doubt_of_signs(run: Trajectory, number: int, way: Way) -> Floats:
    """The largest of `doubts` over steps in a mode."""
    laws, p, backward = run.system.laws, run.system.parameter_array, bool((way.times[:, 1] < way.times[:, 0]).any())
    found = np.zeros(len(way.times))
    for key, function in _watched(run, number, backward):
        values = laws.evaluate(key, (function,), way.times, way.states, p)[..., 0]
        found = np.maximum(found, doubts(function, (TIME, *laws.x, *laws.p), way, p, values))
    return found


def _doubt_of_field(run: Trajectory, number: int, way: Way) -> Floats:
    return excess(run.system, number, way)


def _watched(run: Trajectory, number: int, backward: bool) -> Iterator[tuple[object, Expr]]:
    """What is positive until a mode ends, and what is until there is an event, each with a key."""
    law = run.system.laws.mode(number).written
    for k, height in enumerate(law.heights):
        yield ("alone", number, k, backward), -height if law.turns(k) and backward else height
    for text in run.events.functions:
        for sign in (1, -1):
            yield ("alone", text, sign), sign * parse(text, (*run.system.variables, *run.system.values))
