"""Test whether steps are short enough for the field: whether shorter ones lead to the same state."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.codegen.rounding import rounding_bound
from core.diagnostics.examined_steps import Steps
from core.diagnostics.narrow_pushes import PEAK, pushes
from core.kernels.arrays import Floats

__all__ = ["APART", "departures", "noise", "too_long_for_the_field"]

APART = 0.02
"""Distance between the ends of a step and of shorter ones above which it is reported, as part of the way.

At this bound rk2 adds 3 % to the energy of an oscillator in half a period, in which nine steps are made; at 0.05 it
adds 13 %.
"""

#: The same for a variable-step method, which keeps a tolerance.
_APART_KEPT = 1e-6
#: Distance below which it is not reported for such a method, in units of its tolerance times the state.
_TOLERANCES = 1e3
#: Distance below which it is round-off for any method, relative to the state.
_ROUNDING = 2.0**-44
#: Error of a step by rounding of the field, in units of the first-order bound on that.
_ROUNDINGS = 16.0 * 2.0**-52
#: The least normal double: a smaller distance is round-off, whatever the state is.
_NORMAL = 2.0**-1022
#: Places in a step of fixed size, as parts of it, for the field: its size was chosen for the field, so few suffice.
_FEW = np.array([0.0, 0.15, 0.29, 0.5, 0.68, 0.87, 1.0])
#: Places for a symmetric method, which does not damp what decays within a small part of its step: short steps do.
_GRADED = np.concatenate([[0.0], 16.0 ** np.arange(-11, -1), _FEW[1:]])
#: Most steps with a peak of the field at a place that are made again from place to place.
_MOST_PEAKS = 64
#: Part of the places in a step with a peak, those from which the state is least far, that tell how far it goes.
_USUAL = 0.75
#: Steps after a momentary rest that are examined, too; the last of them ends what tells how far the state goes.
_LATER = (8, 32)
#: Departure at such a rest, as part of the way of a later step on average, up to which a step is short enough.
_AT_REST = 1e-3
#: Least unit of a coordinate, relative to the largest unit of all coordinates.
_SLIGHT = 1e-9


class Departures(NamedTuple):
    """Of some steps, by coordinate (k, d)."""

    way: Floats
    """How far the state goes within the step."""
    apart: Floats
    """How far from there shorter steps lead; 0 where that may be round-off."""
    size: Floats
    """Largest size of the coordinate in the step."""


def too_long_for_the_field(groups: Sequence[Steps], pushed: Steps) -> Iterator[str]:
    """Warn of steps that lead elsewhere than shorter ones, and of some in which a peak of the field may be missed.

    Each coordinate is compared in units of its largest change over all steps examined: those of one group may all begin
    where it hardly changes, such as where a velocity is zero. A change that is 1e-9 of that of another coordinate may
    be round-off.
    """
    found = [*map(departures, groups), _pushed(pushed)]
    with np.errstate(all="ignore"):
        unit = np.nanmax(np.concatenate([of.way for of in found]), axis=0, initial=0.0)
    unit = np.maximum(unit, _SLIGHT * unit.max(initial=0.0))
    unit = np.where(unit > 0.0, unit, 1.0)
    for steps, of in zip((*groups, pushed), found, strict=True):
        yield from _too_long(steps, of, unit)


def departures(steps: Steps, places: Floats | None = None) -> Departures:
    """How far each step leads elsewhere than shorter ones do, from place to place.

    What each shorter step, from a state within the step, departs from it by is summed over the step: that is where
    all of them lead to, but for how departures grow within a step. The largest alone would be a part of it only,
    with seven places a third for a method of order 2.
    """
    if places is None:
        places = _GRADED if steps.method.symmetric else _FEW
        places = steps.places(of_each=3) if steps.method.adaptive else places
    times, whole = steps.at(places)
    with np.errstate(all="ignore"):
        apart = np.abs(np.cumsum(_by_steps_between(steps, times, whole) - whole[:, 2:], axis=1)).max(axis=1)
        way = np.abs(whole - whole[:, :1]).max(axis=1)
        size = np.abs(whole).max(axis=1)
    return Departures(way, np.where(apart > np.maximum(_least(steps) * size, _NORMAL), apart, 0.0), size)


def _pushed(steps: Steps) -> Departures:
    """How far steps lead elsewhere in which the field has a peak: as far as this pushes if it lies between two places.

    Where a place lies in the peak, steps from one place to the next feel it. A step to such a place may lead anywhere:
    how far the others do is told by those to most places.
    """
    peak, none = np.zeros(len(steps)), np.zeros_like(steps.x)
    found, places = Departures(none, none.copy(), none.copy()), steps.places()
    for rows, number, part in steps.by_mode():
        way = part.way(number, places)
        found.apart[rows] = pushes(steps.run.system, number, way)
        with np.errstate(all="ignore"):
            found.way[rows] = np.quantile(np.abs(way.states - way.states[:, :1]), _USUAL, axis=1)
            found.size[rows] = np.quantile(np.abs(way.states), _USUAL, axis=1)
            rates = np.abs(way.rates)
            peak[rows] = np.nan_to_num(rates.max(axis=1) / rates[:, [0, -1]].max(axis=1), nan=0.0).max(axis=1)
    rows = np.argsort(-peak, kind="stable")[:_MOST_PEAKS]
    rows = rows[peak[rows] > PEAK]
    found.apart[rows] = np.fmax(found.apart[rows], departures(steps.some(rows), places).apart)
    return found


def _by_steps_between(steps: Steps, times: Floats, whole: Floats) -> Floats:
    """States at all places except the first two, each by a step from the place before."""
    t, x = times[:, 1:-1], whole[:, 1:-1]
    mode = np.repeat(steps.mode, t.shape[1])
    found = steps.states(t.ravel(), x.reshape(-1, x.shape[2]), mode, times[:, 2:].reshape(-1, 1))
    return found.reshape(x.shape)


def _least(steps: Steps) -> float:
    """Distance below which no step is reported, relative to the state."""
    return max(_ROUNDING, _TOLERANCES * steps.run.tolerance if steps.method.adaptive else 0.0)


def _allowed(steps: Steps, found: Departures, unit: Floats) -> Floats:
    """Departures, by coordinate, that a variable-step method allows itself; 0 for other methods.

    Its tolerance is relative to the largest coordinate, which a decaying one may fall below. But a coordinate may
    be small because of its unit of measurement: no more is allowed to it than if it were as large as its changes.
    """
    if not steps.method.adaptive:
        return np.zeros_like(found.apart)
    return np.asarray(_TOLERANCES * steps.run.tolerance * np.minimum(found.size.max(axis=1, keepdims=True), unit))


def _too_long(steps: Steps, found: Departures, unit: Floats) -> Iterator[str]:
    """Warn of the step with the largest departure as part of its way, in units of each coordinate.

    None is a step of fixed size at a momentary rest, after which the next ones are far longer than its departure.
    """
    apart = np.where(found.apart > _allowed(steps, found, unit), found.apart, 0.0)
    part, most = _part(apart, found.way, unit), _APART_KEPT if steps.method.adaptive else APART
    suspected = np.flatnonzero(part > most)
    apart[suspected] *= apart[suspected] > noise(steps.some(suspected))  # its text is long, so few runs ask for it
    part[suspected] = _part(apart[suspected], found.way[suspected], unit)
    if len(suspected) and not steps.method.adaptive:
        part[suspected] *= ~_rests(steps.some(suspected), apart[suspected], unit)
    if part.max(initial=0.0) > most:
        worst = int(np.argmax(part))
        yield (
            f"{steps.named(worst)} is too long for this field: its result differs from that of shorter steps by "
            f"{_share(part[worst])}; {steps.advice}"
        )


def _part(apart: Floats, way: Floats, unit: Floats) -> Floats:
    """Departures (k,) as parts of the way, in units of each coordinate."""
    with np.errstate(all="ignore"):
        return np.asarray(np.nan_to_num((apart / unit).max(axis=1) / (way / unit).max(axis=1), nan=0.0))


def _rests(steps: Steps, apart: Floats, unit: Floats) -> NDArray[np.bool_]:
    """(k,) which steps begin at a momentary rest, and are short enough: later ones go far beyond the departure, and
    are short enough, too.

    From a rest the state goes as a power of time, of which a method of low order has a wrong factor whatever its step.
    """
    t, x, farthest = steps.t, steps.x, np.zeros_like(steps.x)
    resolved = np.ones(len(steps), dtype=bool)
    for later in range(1, _LATER[-1] + 1):
        x = steps.states(t, x, steps.mode, (t + steps.h)[:, None])[:, 0]
        t = t + steps.h
        with np.errstate(all="ignore"):
            farthest = np.fmax(farthest, np.abs(x - steps.x))
        if later in _LATER:
            found = departures(Steps(steps.run, t, x, steps.mode, steps.h))
            resolved &= np.isfinite(found.way).all(axis=1) & (_part(found.apart, found.way, unit) <= APART)
    return np.asarray(resolved & (_part(apart, farthest / _LATER[-1], unit) <= _AT_REST))


def noise(steps: Steps) -> Floats:
    """(k, d) bounds on what rounding of the field adds to the ends of steps: beside a rest it is all of their way."""
    laws, noise = steps.run.system.laws, np.zeros_like(steps.x)
    for rows, number, part in steps.by_mode():
        bounds = tuple(map(rounding_bound, laws.mode(number).written.field))
        p = steps.run.system.parameter_array
        noise[rows] = laws.evaluate(("rounding of the field", number), bounds, part.t, part.x, p)
    return np.nan_to_num(_ROUNDINGS * np.abs(steps.h)[:, None] * noise, nan=0.0, posinf=0.0)


def _share(part: float) -> str:
    """A part of the way of a step, in words."""
    return f"{part:.1g} of the distance covered" if part < 1.0 else "the whole distance covered, or more"
