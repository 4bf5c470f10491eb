"""Test whether zeros of an event function are so close together that events may have been missed."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from sympy import Expr

from core.codegen.rounding import rounding_bound
from core.diagnostics.examined_steps import Integers, Steps
from core.diagnostics.missed_events import SMALL, Sampled
from core.integration.trajectory import Trajectory
from core.kernels.arrays import Floats
from core.methods import METHODS
from core.symbolic.expressions import parse

__all__ = ["zeros_too_close"]

#: Size of an event function near a zero, in units of the first-order bound on its rounding, from which on that does not
#: give it its sign.
_ROUNDINGS = 32.0 * 2.0**-52
#: Where an event function would change in half a step, at its rate at a zero, by this part of its size or less, …
_FLAT = 0.5
#: … other zeros may be close; they are looked for beside as many zeros, the flattest.
_MOST_FLAT = 64
#: Distances from such a zero, as parts of a step, at which that is done.
_BESIDE = 2.0 ** -np.arange(42.0, 0.0, -0.25)
#: Places in each step of a variable-step method at which it is looked for dips of an event function towards zero, and
#: most steps of such a run, …
_DIPS, _MOST_STEPS = 32, 4096
#: … to less than this part of its size within as many places, and how often the lowest is sought anew beside the last.
_LOW, _TRIALS = 2.0**-10, 10


def zeros_too_close(run: Trajectory) -> Iterator[str]:
    """Warn of a zero of an event function beside which it has others, too close for a step to tell them apart.

    Between three zeros that are close together an event function remains far below its size in the rest of the step,
    and its rate at each of them is far below that of a simple zero. Beside such zeros it is sampled at distances in a
    geometric progression. Of a run that has not recorded its steps nothing is known there.
    """
    for k, text in enumerate(run.events.functions if run.record == "steps" else ()):
        function = parse(text, (*run.system.variables, *run.system.values))
        found = run.events.of(k)
        t, x = np.append(run.t[:1], found.t), np.concatenate([run.x[:1], found.x.reshape(-1, run.x.shape[1])])
        flatness = _flatness(run, function, t, x, np.append(run.mode[:1], found.mode))
        rows = np.argsort(flatness, kind="stable")[:_MOST_FLAT]
        places = np.concatenate([np.sort(t[rows[flatness[rows] <= _FLAT]]), _dips(run, k, function)])
        others = _has_others_beside(run, k, function, places)
        if others.any():
            yield (
                f"At t = {places[np.argmax(others)]:.6g} the event function {text!r} has zeros too close for the step "
                f"to tell them apart, so events may have been missed; take a smaller tau, of the size of their distance"
            )


def _flatness(run: Trajectory, function: Expr, t: Floats, x: Floats, mode: Integers) -> Floats:
    """Change of a function in half a step at its rate, by its size there, at places of a run; inf where it is not 0."""
    laws, p, flatness = run.system.laws, run.system.parameter_array, np.full(len(t), np.inf)
    for number in np.unique(mode[mode >= 0]).tolist():
        rows, law = np.flatnonzero(mode == number), laws.mode(number).written
        wanted = (function, rounding_bound(function), law.rate_of(function), *law.field)
        values = laws.evaluate(("flat", function, number), wanted, t[rows], x[rows], p)
        value, noise, rate, field = values[:, 0], values[:, 1], values[:, 2], values[:, 3:]
        beside = [
            laws.evaluate(("event", function), (function,), t[rows] + h, x[rows] + h * field, p)[:, 0]
            for h in (-0.5 * run.tau, 0.5 * run.tau)
        ]
        with np.errstate(all="ignore"):
            size = np.nanmax(np.abs(beside), axis=0, initial=0.0)
            zero = np.abs(value) <= np.maximum(_ROUNDINGS * noise, SMALL * size)
            flatness[rows] = np.where(zero & (size > 0.0), 0.5 * run.tau * np.abs(rate) / size, np.inf)
    return flatness


def _dips(run: Trajectory, k: int, function: Expr) -> Floats:
    """Where event function k comes close to zero without an event.

    Beyond an even number of zeros that are close together it has its sign again.
    """
    long = METHODS[run.method].adaptive
    if not 1 < len(run.t) <= (_MOST_STEPS if long else _DIPS * _MOST_STEPS):
        return np.empty(0)
    laws, p, t, x = run.system.laws, run.system.parameter_array, run.t, run.x
    if long:
        t = np.append(np.linspace(t[:-1], t[1:], _DIPS, endpoint=False).T.ravel(), t[-1])
        x = run.at(t)
    size = np.abs(laws.evaluate(("event", function), (function,), t, x, p)[:, 0])
    there = np.flatnonzero((size[1:-1] <= size[:-2]) & (size[1:-1] <= size[2:])) + 1
    met = np.sort(run.events.of(k).t)
    before, after = np.minimum(t[there - 1], t[there + 1]), np.maximum(t[there - 1], t[there + 1])
    there = there[np.searchsorted(met, before) == np.searchsorted(met, after, "right")]
    around = np.clip(there[:, None] + np.arange(-_DIPS, _DIPS + 1), 0, len(t) - 1)
    lowest = t[there[size[there] < _LOW * size[around].max(axis=1, initial=0.0)]][:_MOST_FLAT]
    for _ in range(_TRIALS if len(lowest) else 0):
        times = _times_beside(run, lowest)
        sizes = np.abs(laws.evaluate(("event", function), (function,), times, run.at(times), p)[..., 0])
        lowest = times[np.arange(len(lowest)), np.nanargmin(sizes, axis=1)]
    return np.asarray(lowest)


def _times_beside(run: Trajectory, t: Floats) -> Floats:
    """Times (k, n) about each of k times, up to a step and the next crossing or end away."""
    ends = np.sort(np.concatenate([run.t[[0, -1]], run.crossings.t]))
    before, after = np.searchsorted(ends, t) - 1, np.searchsorted(ends, t, "right")
    low = np.fmax(ends[np.maximum(before, 0)], t - run.tau)
    high = np.fmin(ends[np.minimum(after, len(ends) - 1)], t + run.tau)
    ways = (t - low)[:, None] * -_BESIDE[::-1], np.zeros((len(t), 1)), (high - t)[:, None] * _BESIDE
    return np.asarray(np.clip(t[:, None] + np.concatenate(ways, axis=1), low[:, None], high[:, None]))


def _has_others_beside(run: Trajectory, k: int, function: Expr, t: Floats) -> NDArray[np.bool_]:
    """Whether event function k changes its sign, in a step before or after each time, where no event is."""
    times = _times_beside(run, t)
    wanted = (function, rounding_bound(function))
    values = run.system.laws.evaluate(("beside", function), wanted, times, run.at(times), run.system.parameter_array)
    told = np.abs(values[..., 0]) > _ROUNDINGS * values[..., 1]
    steps = Steps(run, t, np.empty((len(t), 0)), np.empty(len(t), dtype=np.int64), np.ones(len(t)))
    return Sampled(steps, k, times, values[..., 0], told).missed()
