"""Test whether events may have been missed within steps."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from core.diagnostics.examined_steps import Steps
from core.diagnostics.narrow_features import dips_between
from core.kernels.arrays import Floats
from core.symbolic.expressions import TIME, parse

__all__ = ["SMALL", "Sampled", "too_long_for_events"]

SMALL = 2.0**-30
"""Size of an event function, as part of its largest in a step, above which rounding does not give it its sign."""


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


def _missed(steps: Steps, number: int, places: Floats) -> NDArray[np.bool_]:
    """Whether events of each function (m, k) may have been missed in steps that are all of the mode of this number."""
    system, way, events = steps.run.system, steps.way(number, places), steps.run.events.functions
    names, symbols = (*system.variables, *system.values), (TIME, *system.laws.x, *system.laws.p)
    found = np.zeros((len(events), len(steps)), dtype=bool)
    for k, text in enumerate(events):
        function = parse(text, names)
        values = system.laws.evaluate(("event", text), (function,), way.times, way.states, system.parameter_array)
        sampled = Sampled(steps, k, way.times, values[..., 0])
        found[k], empty = sampled.missed(), sampled.none_between()
        for sign in (1, -1):
            same = sign * sampled.values > 0.0
            between = empty & same[:, 1:] & same[:, :-1]
            found[k] |= dips_between(sign * function, symbols, way, system.parameter_array, between).found
    return found


class Sampled:
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
            told = size > SMALL * np.nanmax(size, axis=1, keepdims=True, initial=0.0)
        return np.asarray(told & ((self.times - self.steps.run.t[-1]) * self.steps.h[:, None] < 0.0))
