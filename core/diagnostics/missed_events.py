"""Test whether events may have been missed within steps."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from sympy import Expr

from core.codegen.rounding import rounding_bound
from core.diagnostics.examined_steps import Integers, Steps
from core.diagnostics.narrow_features import dips_between
from core.integration.trajectory import Trajectory
from core.kernels.arrays import Floats
from core.methods import METHODS
from core.symbolic.expressions import TIME, parse

__all__ = ["too_long_for_events", "zeros_too_close"]

#: Size of an event function, as part of its largest in a step, above which rounding does not give it its sign.
_SMALL = 2.0**-30
#: The same near a zero, in units of the first-order bound on its rounding.
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


def too_long_for_events(steps: Steps) -> Iterator[str]:
    """Warn of a step in which an event function changes its sign between two places, and no event lies there."""
    events = steps.run.events.functions
    missed, places = np.zeros((len(events), len(steps)), dtype=bool), steps.places()
    for rows, number, part in steps.by_mode() if events else ():
        missed[:, rows] = _missed(part, number, places)
    for text, of_it in zip(events, missed, strict=True):
        if of_it.any():
            yield (
                f"{steps.named(np.argmax(of_it))} is too long for the event function {text!r}: from there on it "
                f"changes sign more often than events were found, so events may have been missed; {steps.advice}"
            )


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
            zero = np.abs(value) <= np.maximum(_ROUNDINGS * noise, _SMALL * size)
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
    return _Sampled(steps, k, times, values[..., 0], told).missed()


def _missed(steps: Steps, number: int, places: Floats) -> NDArray[np.bool_]:
    """Whether events of each function (m, k) may have been missed in steps that are all of the mode of this number."""
    system, way, events = steps.run.system, steps.way(number, places), steps.run.events.functions
    names, symbols = (*system.variables, *system.values), (TIME, *system.laws.x, *system.laws.p)
    found = np.zeros((len(events), len(steps)), dtype=bool)
    for k, text in enumerate(events):
        function = parse(text, names)
        values = system.laws.evaluate(("event", text), (function,), way.times, way.states, system.parameter_array)
        sampled = _Sampled(steps, k, way.times, values[..., 0])
        found[k], empty = sampled.missed(), sampled.none_between()
        for sign in (1, -1):
            same = sign * sampled.values > 0.0
            between = empty & same[:, 1:] & same[:, :-1]
            found[k] |= dips_between(sign * function, symbols, way, system.parameter_array, between).found
    return found


class _Sampled:
    """Values of event function k at places of steps, (steps, places)."""

    def __init__(
        self, steps: Steps, k: int, times: Floats, values: Floats, told: NDArray[np.bool_] | None = None
    ) -> None:
        self.steps, self.k, self.times, self.values = steps, k, times, values
        self.told = self._are_told() if told is None else told

    def missed(self) -> NDArray[np.bool_]:
        """Whether, in each step, there is a change of sign between places without event.

        Places are passed over that tell no sign.
        """
        told, values = self.told, self.values
        events, way = self.steps.run.events.of(self.k), self.steps.run.events.directions[self.k]
        missed = np.zeros(len(values), dtype=bool)
        for row in np.flatnonzero((told & (values > 0.0)).any(axis=1) & (told & (values < 0.0)).any(axis=1)):
            order = slice(None) if self.steps.h[row] > 0.0 else slice(None, None, -1)
            t, sign = self.times[row, told[row]][order], np.sign(values[row, told[row]])[order]
            at = np.flatnonzero(sign[1:] != sign[:-1])
            for direction in (1, -1):
                wanted = at[sign[at + 1] == direction] if way * direction >= 0 else at[:0]
                found = np.sort(events.t[events.direction == direction])
                within = np.searchsorted(found, t[wanted + 1], "right") - np.searchsorted(found, t[wanted])
                missed[row] |= bool((within == 0).any())
        return missed

    def none_between(self) -> NDArray[np.bool_]:
        """Whether no event lies between neighbouring places that both tell a sign."""
        before = np.searchsorted(np.sort(self.steps.run.events.of(self.k).t), self.times)
        return np.asarray((before[:, 1:] == before[:, :-1]) & self.told[:, 1:] & self.told[:, :-1])

    def _are_told(self) -> NDArray[np.bool_]:
        """Whether the sign of a value is not that of rounding, and the place not beyond the end."""
        size = np.abs(self.values)
        with np.errstate(all="ignore"):
            told = size > _SMALL * np.nanmax(size, axis=1, keepdims=True, initial=0.0)
        return np.asarray(told & ((self.times - self.steps.run.t[-1]) * self.steps.h[:, None] < 0.0))
