"""The checked arguments of a stability study."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from core.diagnostics import beyond_walls
from core.integrate import checked_method, checked_settings, checked_start
from core.integration.trajectory import Status
from core.interface.arguments import count, listed, number
from core.interface.cancelling import Cancel
from core.kernels.arrays import Floats
from core.methods import Method
from core.studies.stability.verdict import reference_run
from core.system import PiecewiseSystem, Start

__all__ = ["MAX_STEPS", "STARTS_OF_MAP", "Plan", "checked_plan", "default_taus"]

MAX_STEPS = 50_000
"""Most steps of one run, other than the long one."""

STARTS_OF_MAP = 25
"""Default number of values of the coordinate."""

#: Default start and end time.
_T_SPAN = (0.0, 20.0)
#: Default number of step sizes.
_TAUS = 25
#: Number of steps to the end time with the finest default step size.
_FINEST = 20_000.0
#: Number of steps to the end time with the coarsest default step size.
_COARSEST = 10.0
#: Number of steps to the end time with the default step size of the long run and of the runs near a tangency.
_DEFAULT_STEPS = 1_000.0
#: Number of instants along the trajectory, and of values in its range, by which the default values are chosen.
_INSTANTS = 1001
#: Most step sizes, and most values.
_MOST = 400
#: Most steps of the long run.
_MOST_STEPS = 10**9
#: Largest distance of a default value from the start, in units of the median distance along the trajectory.
_FAR = 4.0
#: Margin around the default values, as part of their range.
_MARGIN = 0.2


@dataclass(frozen=True, eq=False)
class Plan:
    """The arguments of a study, checked and with defaults filled in."""

    system: PiecewiseSystem
    t_span: tuple[float, float]
    x0: tuple[float, ...]
    methods: tuple[str, ...]
    taus: Floats
    """(m,) step sizes, increasing."""
    coordinate: int
    """Index of the coordinate of x₀ that is varied."""
    values: Floats
    """(n,) values of that coordinate, increasing."""
    tau: float
    """Step size of the long run and of the runs near a tangency."""
    steps: int
    """Number of steps of the long run."""
    transition: str
    """As in `integrate`."""
    sliding: str
    """As in `integrate`."""


def checked_plan(
    system: PiecewiseSystem, t_span: tuple[float, float] | None, x0: Start | None,
    methods: Sequence[str | Method] | str | Method, taus: Iterable[float] | None, coordinate: int | str,
    values: Iterable[float] | None, tau: float | None, steps: int, transition: str, sliding: str,
    cancel: Cancel | None,
) -> Plan:  # fmt: skip
    """Return the plan of a study; ValueError if an argument makes no sense."""
    span = _span(_T_SPAN if t_span is None else t_span)
    start = checked_start(system, span[0], x0)
    names, length = _methods(system, methods), span[1] - span[0]
    ladder = default_taus(length) if taus is None else _increasing(taus, "taus")
    chosen = [checked_method(system, name) for name in names]
    for one in (*ladder, length / _DEFAULT_STEPS if tau is None else tau):
        step = checked_settings(chosen[0], one, transition=transition, sliding=sliding).tau
    index = _coordinate(system, coordinate)
    wanted = (
        _default_values(system, start, span, index, sliding, cancel)
        if values is None
        else _increasing(values, "values")
    )
    most = count(steps, "steps", _MOST_STEPS)
    return Plan(system, span, start, names, ladder, index, wanted, step, most, transition, sliding)


def _span(t_span: Any) -> tuple[float, float]:
    try:
        start, end = t_span
    except (TypeError, ValueError):
        raise ValueError(f"t_span = {t_span!r}: a start and an end time are needed, as in (0.0, 20.0)") from None
    t0, t1 = number(start, "start time"), number(end, "end time")
    if not t0 < t1:
        raise ValueError(f"t_span = {t_span!r}: two times are needed, the later one second")
    return t0, t1


def _methods(system: PiecewiseSystem, methods: Sequence[str | Method] | str | Method) -> tuple[str, ...]:
    given = listed(methods, "methods", "a tuple is needed, as in ('dmm2', 'rk2')", (str, Method))
    names = tuple(checked_method(system, one).name for one in given)
    if not names or len(set(names)) < len(names):
        raise ValueError(f"methods = {methods!r}: one or several different ones are needed, as in ('dmm2', 'rk2')")
    return names


def _increasing(given: Iterable[float], what: str) -> Floats:
    """Return the numbers in increasing order, without repetition; ValueError unless 2 to 400 finite ones remain."""
    numbers = np.unique(
        np.array([number(value, what) for value in listed(given, what, "numbers are needed, as in (0.1, 0.2)")])
    )
    if not 2 <= len(numbers) <= _MOST:
        raise ValueError(f"{what} = {given!r}: from 2 to {_MOST} different finite numbers are needed")
    return numbers


def _coordinate(system: PiecewiseSystem, coordinate: int | str) -> int:
    if isinstance(coordinate, str) and coordinate in system.variables:
        return system.variables.index(coordinate)
    whole = isinstance(coordinate, int | np.integer) and not isinstance(coordinate, bool)
    if not whole or not 0 <= int(coordinate) < system.dimension:
        names = ", ".join(system.variables)
        raise ValueError(f"coordinate = {coordinate!r}: one of {names}, or a number from 0 to {system.dimension - 1}")
    return int(coordinate)


def default_taus(length: float, least: float = 0.0, most: float = math.inf) -> Floats:
    """Default step sizes for a time span of some length, within bounds unless less than a decade of them lies there."""
    finest = max(length / _FINEST, least)
    return np.geomspace(finest, max(min(length / _COARSEST, most), 10.0 * finest), _TAUS)


def _default_values(
    system: PiecewiseSystem, x0: tuple[float, ...], t_span: tuple[float, float], coordinate: int,
    sliding: str, cancel: Cancel | None,
) -> Floats:  # fmt: skip
    """Default values: that of x₀, and others in the range along its trajectory and a margin, as in the portrait."""
    run = reference_run(system, x0, t_span, record="steps", sliding=sliding, cancel=cancel)
    seen, times = run.x[:, coordinate], np.linspace(run.t[0], run.t[-1], _INSTANTS)
    away = np.abs(seen - x0[coordinate])
    usual = float(np.median(np.interp(times, run.t, away)))  # over the time: before a pole steps crowd
    least = 0.0 if run.status is Status.ESCAPED else float(away.max()) / 1e6  # of one that rests most of the time
    seen = seen[away <= _FAR * max(usual, least)]
    low, high = float(seen.min()), float(seen.max())
    margin = _MARGIN * (high - low) or max(abs(low), 1.0) / 2
    wide = np.linspace(low - margin, high + margin, _INSTANTS)
    within = _within_walls(system, x0, t_span[0], coordinate, wide)
    return _evenly_about(x0[coordinate], float(within[0]), float(within[-1]))


def _evenly_about(value: float, low: float, high: float) -> Floats:
    """Return equally spaced values in a range, one of which is the value given, but for rounding."""
    last = STARTS_OF_MAP - 1
    before = round(last * (value - low) / (high - low))
    apart = min((end / count for end, count in ((value - low, before), (high - value, last - before)) if count))
    return np.linspace(value - before * apart, value + (last - before) * apart, STARTS_OF_MAP)


def _within_walls(system: PiecewiseSystem, x0: tuple[float, ...], t0: float, coordinate: int, values: Floats) -> Floats:
    """Return the values around that of x₀ from which no start lies beyond a wall; all, if x₀ itself lies there."""
    starts = np.tile(np.array(x0), (len(values), 1))
    starts[:, coordinate] = values
    beyond = beyond_walls(system, t0, starts)
    if beyond_walls(system, t0, np.array(x0)) or not beyond.any():
        return values
    here = int(np.searchsorted(values, x0[coordinate]))
    before, after = np.flatnonzero(beyond[:here]), np.flatnonzero(beyond[here:])
    first = before[-1] + 1 if len(before) else 0
    last = here + after[0] if len(after) else len(values)
    return values[first:last]
