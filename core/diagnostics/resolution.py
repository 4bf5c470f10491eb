"""Test, on some steps of a run, whether they are short enough to resolve the field, g and event functions."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.codegen.rounding import rounding_bound
from core.diagnostics.doubtful_steps import doubtful_steps
from core.diagnostics.narrow_features import Way, dips_between
from core.diagnostics.unlike_steps import stretches, unlike_steps
from core.integration.dense_output import Stepper, Track
from core.integration.trajectory import Status, Trajectory
from core.kernels.arrays import Floats
from core.methods import METHODS
from core.symbolic.expressions import TIME, parse

__all__ = ["resolvable", "unresolved"]

#: How runs end in which the numerical solution grows without bound.
_RUNS_AWAY = (Status.ESCAPED, Status.UNSTABLE)
#: Steps before such an end in which steps of one size resolve nothing: at a pole, the time left is the time scale.
_LAST_STEPS = 64.0

Integers = NDArray[np.int64]

#: Number of places, over all steps examined, at which the field or g is evaluated.
_PLACES = 6144
#: Least number of places in each step: a feature narrower than 1/30 of the step may be missed.
_FEWEST = 48
#: Largest number of places in each step, where few steps are examined: it resolves 1/700 of the step.
_MOST = 1024
#: Places in a step of fixed size, as parts of it, for the field: its size was chosen for the field, so few suffice.
_FEW = np.array([0.0, 0.15, 0.29, 0.5, 0.68, 0.87, 1.0])
#: Bound on |g − cubic| between the places, in units of its value at the places.
_MARGIN = 3.0
#: Distance between the ends of a step and of shorter ones above which it is reported, as part of the way. At this bound
#: rk2 adds 3 % to the energy of an oscillator in half a period, in which nine steps are made; at 0.05 it adds 13 %.
_APART = 0.02
#: The same for a variable-step method, which keeps a tolerance.
_APART_KEPT = 1e-6
#: Distance below which it is not reported for such a method, in units of its tolerance times the state.
_TOLERANCES = 1e3
#: Distance below which it is round-off for any method, relative to the state.
_ROUNDING = 2.0**-44
#: The least normal double: a smaller distance is round-off, whatever the state is.
_NORMAL = 2.0**-1022
#: Height below zero at an end of a step, as part of its largest size in it: a perturbation has put the state there.
_BEHIND = 2.0**-40
#: Largest error of a height or its rate, in units of the first-order bound on its rounding.
_ROUNDINGS = 16.0 * 2.0**-52
#: Distance between the end of a step and that of the run, as part of the step, at which they are the same.
_NEAR = 2.0**-40
#: Shortest step that is examined, relative to the time: of a shorter one rounding hides what happens in it.
_SHORTEST = 2.0**-46
#: Least unit of a coordinate, relative to the largest unit of all coordinates.
_SLIGHT = 1e-9
#: Size of an event function, as part of its largest in a step, above which rounding does not give it its sign.
_SMALL = 2.0**-30
#: Most steps from entries into a mode that are examined, besides the steps kept by the loop.
_MOST_ENTRIES = 64


def unresolved(run: Trajectory) -> tuple[str, ...]:
    """Say where steps are too long for g, so that crossings may have been missed, or for the field.

    Returns
    -------
    tuple of str
        () where all steps examined are short enough, else warnings, the more serious first.
    """
    samples = run.samples
    if samples is None:
        return ()
    kept = _steps(run, samples[:, 0], samples[:, 3:], samples[:, 1].astype(np.int64), samples[:, 2])
    if run.status in _RUNS_AWAY:  # no step is short enough where the solution escapes
        return tuple(kept.too_long_for_g(kept.hides_before_it_runs_away()))
    first, doubtful = _first_steps(run), _doubtful(run)
    of_g = (words for steps in (kept, first, doubtful) for words in steps.too_long_for_g(steps.hides()))
    of_events = (words for steps in (kept, doubtful) for words in steps.too_long_for_events())
    of_field = _too_long_for_the_field((kept, _unlike(run), first))
    return (*islice(of_g, 1), *dict.fromkeys(of_events), *islice(of_field, 1))


def resolvable(run: Trajectory, t: Floats) -> NDArray[np.bool_]:
    """Whether steps of the size of a run could resolve the solution at times: not just before it grows without bound.

    A method that chooses its steps takes shorter ones there.
    """
    last = 0.0 if METHODS[run.method].adaptive or run.status not in _RUNS_AWAY else _LAST_STEPS * run.tau
    return np.asarray(np.abs(run.t[-1] - t) >= last)


def _unlike(run: Trajectory) -> _Steps:
    """Steps that are least like the one before."""
    return _unlike_recorded(run) if run.record == "steps" else _unlike_made_again(run)


def _unlike_made_again(run: Trajectory) -> _Steps:
    """Some of a run that has not recorded its steps, in the stretches that the loop has kept."""
    none = _Steps(run, np.empty(0), np.empty((0, run.system.dimension)), np.empty(0, dtype=np.int64), np.empty(0))
    made = stretches(run, none.states)
    if not made.t.shape[1] > 2:
        return none
    rows, columns = made.least_like()
    t, x = made.t[rows, columns], made.x[rows, columns]
    return _steps(run, t, x, made.mode[rows], made.t[rows, columns + 1] - t)


def _unlike_recorded(run: Trajectory) -> _Steps:
    """Of all steps of a run."""
    k = unlike_steps(run) if not METHODS[run.method].adaptive else np.empty(0, dtype=np.intp)
    k = k[run.mode[k] >= 0]
    h = run.t[k + 1] - run.t[k]
    cut = run.segment[k + 1] != run.segment[k]
    h[cut] = run.crossings.t[run.segment[k[cut]]] - run.t[k[cut]]
    return _steps(run, run.t[k], run.x[k], run.mode[k], h)


def _doubtful(run: Trajectory) -> _Steps:
    """Those that bounds leave in doubt."""
    k = doubtful_steps(run)
    return _steps(run, run.t[k], run.x[k], run.mode[k], run.t[k + 1] - run.t[k])


def _first_steps(run: Trajectory) -> _Steps:
    """Steps of the run's size from where it has entered a side."""
    crossings = run.crossings
    count = 0 if METHODS[run.method].adaptive else len(crossings) - 1
    k = np.unique(np.linspace(0, count - 1, _MOST_ENTRIES).astype(np.int64)) if count > 0 else np.empty(0, np.int64)
    return _steps(run, crossings.t[k], crossings.x_after[k], crossings.mode[k], crossings.t[k + 1] - crossings.t[k])


def _steps(run: Trajectory, t: Floats, x: Floats, mode: Integers, h: Floats) -> _Steps:
    """Steps towards the end of a run, none longer than τ; those that are too short to be examined are left out.

    A perturbation of a crossing lengthens the step to it, or ends it before it began: that is no fault of τ.
    """
    way = -1.0 if run.t[-1] < run.t[0] else 1.0
    h = way * np.clip(way * h, 0.0, np.inf if METHODS[run.method].adaptive else run.tau)
    long = np.abs(h) > _SHORTEST * np.abs(t)
    return _Steps(run, t[long], x[long], mode[long], h[long])


class _Departures(NamedTuple):
    """Of some steps, by coordinate (k, d)."""

    way: Floats
    """How far the state goes within the step."""
    apart: Floats
    """How far from there shorter steps lead; 0 where that may be round-off."""
    size: Floats
    """Largest size of the coordinate in the step."""


def _too_long_for_the_field(groups: tuple[_Steps, ...]) -> Iterator[str]:
    """Warn of steps that lead elsewhere than shorter ones.

    Each coordinate is compared in units of its largest change over all steps examined: those of one group may all begin
    where it hardly changes, such as where a velocity is zero. A change that is 1e-9 of that of another coordinate may
    be round-off.
    """
    found = [steps.departures() for steps in groups]
    with np.errstate(all="ignore"):
        unit = np.nanmax(np.concatenate([of.way for of in found]), axis=0, initial=0.0)
    unit = np.maximum(unit, _SLIGHT * unit.max(initial=0.0))
    unit = np.where(unit > 0.0, unit, 1.0)
    for steps, of in zip(groups, found, strict=True):
        yield from steps.too_long_for_the_field(of, unit)


class _Steps:
    """Some steps of a run's method: their start times, states and modes, and their lengths h."""

    def __init__(self, run: Trajectory, t: Floats, x: Floats, mode: Integers, h: Floats) -> None:
        self.run, self.method = run, METHODS[run.method]
        self.t, self.x, self.mode, self.h = t, x, mode, h
        self.stepper = Stepper(run.system, self.method, run.tolerance)

    def hides(self, beyond: bool = False) -> NDArray[np.bool_]:
        """Whether a pair of crossings may have been missed in each step; `beyond`: or if it has an end beyond g = 0.

        The time loop replaces the height of a guard within a step by the cubic with the same values and rates at both
        ends, and finds no crossing where the cubic is positive. Here the height on the scheme itself is compared with
        this cubic. It is unresolved where it is negative before the end, where the cubic is at most three times the
        difference of the two, and where the height may dip below zero between two places. A variable-step method has a
        polynomial in place of the cubic, so that the second test does not apply. Where the height is negative at the
        start or at the end, a perturbation has put the state there, or the end of the step: nothing is hidden in it.
        """
        hidden = np.zeros(len(self.t), dtype=bool)
        places = _places(len(self.t))
        for number in np.unique(self.mode).tolist():
            rows = np.flatnonzero(self.mode == number)
            hidden[rows] = self._hides(rows, number, places, beyond)
        return hidden & ~self._end_at_a_touch()

    def _end_at_a_touch(self) -> NDArray[np.bool_]:
        """Which steps end where the run does, at a touch: of these, that is what is said of them."""
        end, left = self.run.t[-1], np.abs(self.run.t[-1] - self.t - self.h)
        return np.asarray(
            (self.run.status is Status.GRAZING) & (left <= _SHORTEST * np.abs(end) + _NEAR * np.abs(self.h))
        )

    def hides_before_it_runs_away(self) -> NDArray[np.bool_]:
        """As `hides`, without the last steps, each faster than the one before, none of which resolves g or the field.

        Of a step that a crossing cuts, the part before it is not asked whether it does.
        """
        hidden, found = self.hides(), self.departures()
        speed = np.linalg.norm(found.way, axis=1) / np.abs(self.h)
        with np.errstate(all="ignore"):
            astray = self.hides(beyond=True) | ~(found.apart <= _APART * found.way.max(axis=1, keepdims=True)).all(
                axis=1
            )
            astray |= np.abs(self.h) < (1.0 - _NEAR) * (0.0 if self.method.adaptive else self.run.tau)
            astray[:-1] &= ~(speed[1:] < speed[:-1])
        last = len(astray) - int(np.argmin(astray[::-1])) if len(astray) and not astray.all() else 0
        hidden[last:] = False
        return hidden

    def too_long_for_g(self, hidden: NDArray[np.bool_]) -> Iterator[str]:
        """Warn of a step in which a pair of crossings may have been missed."""
        if hidden.any():
            yield (
                f"{self._step(np.argmax(hidden))} is too long for this surface: from there on g varies within a step "
                f"in ways that its values and rates at both ends do not show, so crossings may have been missed; "
                f"{self._advice}"
            )

    def _hides(self, rows: NDArray[np.intp], number: int, places: Floats, beyond: bool) -> NDArray[np.bool_]:
        """Whether a height of a mode, given by its number, is unresolved in some steps, all of that mode."""
        t, x, h, system = self.t[rows], self.x[rows], self.h[rows, None], self.run.system
        times = t[:, None] + h * places
        states = np.concatenate([x[:, None], self.states(t, x, self.mode[rows], times[:, 1:])], axis=1)
        law, hidden = system.laws.mode(number).written, np.zeros(len(rows), dtype=bool)
        rates = system.laws.evaluate(("field", number), law.field, times, states, system.parameter_array)
        way, symbols = Way(times, states, rates), (TIME, *system.laws.x, *system.laws.p)
        for k, height in enumerate(law.heights):
            rate = law.rate_of(height)
            wanted = (height, rate, rounding_bound(height), rounding_bound(rate))
            values = system.laws.evaluate(("height", number, k), wanted, times, states, system.parameter_array)
            g, rate, noise, noise_of_rate = np.moveaxis(values, 2, 0)
            sign = -1.0 if law.turns(k) and (h < 0.0).any() else 1.0  # see `Mode.heights`
            with np.errstate(all="ignore"):
                noise, noise_of_rate = _ROUNDINGS * noise, _ROUNDINGS * np.abs(h) * noise_of_rate
                hidden |= self._hides_roots(places, sign * g, sign * h * rate, noise, noise_of_rate, beyond)
                above = sign * g > noise
            between = above[:, 1:] & above[:, :-1]
            hidden |= dips_between(int(sign) * height, symbols, way, system.parameter_array, between)
        return hidden

    def _hides_roots(
        self, places: Floats, g: Floats, rate: Floats, noise: Floats, noise_of_rate: Floats, beyond: bool
    ) -> NDArray[np.bool_]:
        """Whether heights (k, places), with their rates per step, are unresolved within steps.

        What is within rounding of zero tells nothing: where a slide ends, the height and its rate are both zero.
        """
        behind = (g[:, [0, -1]] < -_BEHIND * np.abs(g).max(axis=1, keepdims=True)).any(axis=1)
        rate = np.where(np.abs(rate) > noise_of_rate, rate, 0.0)
        hidden = np.asarray((g <= -noise)[:, 1:-1].any(axis=1) | _may_dip(np.diff(places), g, rate).any(axis=1))
        if not self.method.adaptive:
            cubic = _hermite(places, g[:, :1], g[:, -1:], rate[:, :1], rate[:, -1:])
            apart = np.abs(g - cubic)
            hidden |= ((cubic <= _MARGIN * apart) & (apart > noise))[:, 1:-1].any(axis=1)
        return np.asarray(hidden | behind if beyond else hidden & ~behind)

    def too_long_for_events(self) -> Iterator[str]:
        """Warn of a step in which an event function changes its sign between two places, and no event lies there."""
        system, places = self.run.system, _places(len(self.t))
        if not self.run.events.functions:
            return
        names = (*system.variables, *system.values)
        times = self.t[:, None] + self.h[:, None] * places
        states = np.concatenate([self.x[:, None], self.states(self.t, self.x, self.mode, times[:, 1:])], axis=1)
        rates = np.empty_like(states)
        for number in np.unique(self.mode).tolist():
            rows, law = self.mode == number, system.laws.mode(number).written
            rates[rows] = system.laws.evaluate(
                ("field", number), law.field, times[rows], states[rows], system.parameter_array
            )
        way, symbols = Way(times, states, rates), (TIME, *system.laws.x, *system.laws.p)
        for k, text in enumerate(self.run.events.functions):
            function, values = parse(text, names), np.empty_like(times)
            for number in np.unique(self.mode).tolist():
                rows = self.mode == number
                values[rows] = system.laws.evaluate(
                    ("event", text), (function,), times[rows], states[rows], system.parameter_array
                )[..., 0]
            missed, empty = self._has_missed(k, times, values), self._has_none_between(k, times, values)
            for sign in (1, -1):
                between = empty & (sign * values[:, 1:] > 0.0) & (sign * values[:, :-1] > 0.0)
                missed |= dips_between(sign * function, symbols, way, system.parameter_array, between)
            if missed.any():
                yield (
                    f"{self._step(np.argmax(missed))} is too long for the event function {text!r}: from there on it "
                    f"changes sign more often than events were found, so events may have been missed; {self._advice}"
                )

    def _has_missed(self, k: int, times: Floats, values: Floats) -> NDArray[np.bool_]:
        """Whether, in each step, event function k has a change of sign between places (steps, places) without event.

        Places are passed over that tell no sign.
        """
        events, way = self.run.events.of(k), self.run.events.directions[k]
        missed, told = np.zeros(len(values), dtype=bool), self._is_told(times, values)
        for row in np.flatnonzero((told & (values > 0.0)).any(axis=1) & (told & (values < 0.0)).any(axis=1)):
            order = slice(None) if self.h[row] > 0.0 else slice(None, None, -1)
            t, sign = times[row, told[row]][order], np.sign(values[row, told[row]])[order]
            at = np.flatnonzero(sign[1:] != sign[:-1])
            for direction in (1, -1):
                wanted = at[sign[at + 1] == direction] if way * direction >= 0 else at[:0]
                found = np.sort(events.t[events.direction == direction])
                within = np.searchsorted(found, t[wanted + 1], "right") - np.searchsorted(found, t[wanted])
                missed[row] |= bool((within == 0).any())
        return missed

    def _has_none_between(self, k: int, times: Floats, values: Floats) -> NDArray[np.bool_]:
        """Whether no event of function k lies between neighbouring places (steps, places) that both tell a sign."""
        before, told = np.searchsorted(np.sort(self.run.events.of(k).t), times), self._is_told(times, values)
        return np.asarray((before[:, 1:] == before[:, :-1]) & told[:, 1:] & told[:, :-1])

    def _is_told(self, times: Floats, values: Floats) -> NDArray[np.bool_]:
        """Whether the sign of an event function is not that of rounding, and the place not beyond the end."""
        with np.errstate(all="ignore"):
            told = np.abs(values) > _SMALL * np.nanmax(np.abs(values), axis=1, keepdims=True, initial=0.0)
        return np.asarray(told & ((times - self.run.t[-1]) * self.h[:, None] < 0.0))

    def departures(self) -> _Departures:
        """How far each step leads elsewhere than shorter ones do, one after the other.

        What each shorter step, from a state within the step, departs from it by is summed over the step: that is where
        all of them lead to, but for how departures grow within a step. The largest alone would be a part of it only,
        with seven places a third for a method of order 2.
        """
        places = _places(3 * len(self.t)) if self.method.adaptive else _FEW
        times = self.t[:, None] + self.h[:, None] * places
        whole = np.concatenate([self.x[:, None], self.states(self.t, self.x, self.mode, times[:, 1:])], axis=1)
        with np.errstate(all="ignore"):
            apart = np.abs(np.cumsum(self._by_steps_between(times, whole) - whole[:, 2:], axis=1)).max(axis=1)
            way = np.abs(whole - whole[:, :1]).max(axis=1)
            size = np.abs(whole).max(axis=1)
        return _Departures(way, np.where(apart > np.maximum(self._least * size, _NORMAL), apart, 0.0), size)

    def _allowed(self, found: _Departures, unit: Floats) -> Floats:
        """Departures, by coordinate, that a variable-step method allows itself; 0 for other methods.

        Its tolerance is relative to the largest coordinate, which a decaying one may fall below. But a coordinate may
        be small because of its unit of measurement: no more is allowed to it than if it were as large as its changes.
        """
        if not self.method.adaptive:
            return np.zeros_like(found.apart)
        return np.asarray(_TOLERANCES * self.run.tolerance * np.minimum(found.size.max(axis=1, keepdims=True), unit))

    def too_long_for_the_field(self, found: _Departures, unit: Floats) -> Iterator[str]:
        """Warn of the step with the largest departure as part of its way, in units of each coordinate."""
        with np.errstate(all="ignore"):
            apart = np.where(found.apart > self._allowed(found, unit), found.apart, 0.0)
            part = (apart / unit).max(axis=1) / (found.way / unit).max(axis=1)
        if not len(part):
            return
        worst = int(np.argmax(np.nan_to_num(part, nan=0.0)))
        if part[worst] > (_APART_KEPT if self.method.adaptive else _APART):
            yield (
                f"{self._step(worst)} is too long for this field: its result differs from that of shorter steps by "
                f"{_share(part[worst])}; {self._advice}"
            )

    def _step(self, row: int | np.intp) -> str:
        """Return a step in words: its length, of which tau it is a part, and where it begins."""
        length, tau = abs(self.h[row]), self.run.tau
        part = "" if self.method.adaptive or length >= (1.0 - _NEAR) * tau else f" (part of tau = {tau:.6g})"
        return f"The step of {length:.3g}{part} at t = {self.t[row]:.6g}"

    @property
    def _advice(self) -> str:
        return "give a tau, which no step is longer than" if self.method.adaptive else "take a smaller tau"

    @property
    def _least(self) -> float:
        """Distance below which no step is reported, relative to the state."""
        return max(_ROUNDING, _TOLERANCES * self.run.tolerance if self.method.adaptive else 0.0)

    def _by_steps_between(self, times: Floats, whole: Floats) -> Floats:
        """States at all places except the first two, each by a step from the place before."""
        t, x = times[:, 1:-1], whole[:, 1:-1]
        mode = np.repeat(self.mode, t.shape[1])
        found = self.states(t.ravel(), x.reshape(-1, x.shape[2]), mode, times[:, 2:].reshape(-1, 1))
        return found.reshape(x.shape)

    def states(self, t: Floats, x: Floats, mode: Integers, times: Floats) -> Floats:
        """States (k, places, d) on the scheme at the given times after k states; nan where a step has no solution."""
        states = np.empty((*times.shape, x.shape[1]))
        for rows in _one_after_another(t, times[:, -1]):
            begin, start, number = t[rows], np.ascontiguousarray(x[rows]), np.arange(len(rows))
            track = Track(begin, start, mode[rows], number, begin, start, mode[rows])
            found = self.stepper.find(track, times[rows].ravel())
            found.x[found.solved :] = np.nan
            states[rows] = found.x.reshape(*times[rows].shape, x.shape[1])
        return states


def _share(part: float) -> str:
    """A part of the length of a step, in words."""
    return f"{part:.1g} of its length" if part < 1.0 else "its whole length or more"


def _one_after_another(begin: Floats, end: Floats) -> list[NDArray[np.intp]]:
    """Rows of steps in groups, in each of which every step ends before the next one begins.

    Neighbours meet in time, and the step to a crossing that is perturbed may overlap with several that follow.
    """
    groups: list[list[int]] = []
    sign = -1.0 if len(end) and (end < begin).any() else 1.0
    first, last = sign * begin, sign * end
    for row in np.argsort(first, kind="stable").tolist():
        group = next((rows for rows in groups if last[rows[-1]] < first[row]), None)
        if group is None:
            groups.append(group := [])
        group.append(row)
    return [np.array(rows, dtype=np.intp) for rows in groups]


def _places(steps: int) -> Floats:
    """Places in each of `steps` steps, as parts of it from 0 to 1; unequally spaced, so that no wave is missed."""
    count = min(max(_PLACES // max(steps, 1), _FEWEST), _MOST)
    return np.concatenate([[0.0], np.sort((np.arange(1, count) * 0.6180339887498949) % 1.0), [1.0]])


def _hermite(s: Floats, start: Floats, end: Floats, rate: Floats, rate_end: Floats) -> Floats:
    """The cubic Hermite interpolant at s in [0, 1], from values and slopes at 0 and 1."""
    by_values = (1 + 2 * s) * (1 - s) ** 2 * start + s * s * (3 - 2 * s) * end
    by_rates: Floats = s * (1 - s) ** 2 * rate + s * s * (s - 1) * rate_end
    return by_values + by_rates


def _may_dip(width: Floats, g: Floats, rate: Floats) -> NDArray[np.bool_]:
    """Whether g falls and rises between neighbouring places, and its tangents there meet below zero."""
    low, high, g_low, g_high = rate[:, :-1], rate[:, 1:], g[:, :-1], g[:, 1:]
    meet = (g_high - g_low - high * width) / (low - high)
    return np.asarray((low < 0.0) & (high > 0.0) & (g_low + low * meet <= 0.0))
