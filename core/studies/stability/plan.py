"""What a stability study is asked for, checked."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from core.integrate import checked_method, checked_settings, checked_start
from core.interface.arguments import count, listed, number
from core.kernels.arrays import Floats
from core.methods import Method
from core.studies.stability.verdict import reference_run
from core.system import PiecewiseSystem, Start

__all__ = ["MAX_STEPS", "Plan", "checked_plan"]

MAX_STEPS = 50_000
"""Steps of one run at the most, the long one apart."""

_T_SPAN = (0.0, 20.0)
_TAUS, _FINEST, _COARSEST = 25, 20_000.0, 10.0  # of the step sizes: how many, and in how many steps to the end
_DEFAULT_STEPS = 1_000.0  # the same, of the step size of the long run and of the runs beside a tangency
_VALUES = 25
_MOST = 400  # step sizes, or values
_MOST_STEPS = 10**9
#: What is seen of an orbit: as far as this many times the median of the distances from its start, and a margin.
_FAR, _MARGIN = 4.0, 0.2


@dataclass(frozen=True, eq=False)
class Plan:
    """A study's arguments, each with a value that makes sense."""

    system: PiecewiseSystem
    t_span: tuple[float, float]
    x0: tuple[float, ...]
    methods: tuple[str, ...]
    taus: Floats
    """(m,) increasing."""
    coordinate: int
    values: Floats
    """(n,) increasing, of that coordinate of x₀."""
    tau: float
    """Step size of the long run and beside a tangency."""
    steps: int
    """Of the long run."""


def checked_plan(
    system: PiecewiseSystem, t_span: tuple[float, float] | None, x0: Start | None,
    methods: Sequence[str | Method] | str | Method, taus: Iterable[float] | None, coordinate: int | str,
    values: Iterable[float] | None, tau: float | None, steps: int,
) -> Plan:  # fmt: skip
    """Return the plan of a study, if its arguments make sense, else raise ValueError."""
    span = _span(_T_SPAN if t_span is None else t_span)
    start = checked_start(system, span[0], x0)
    names, length = _methods(system, methods), span[1] - span[0]
    ladder = np.geomspace(length / _FINEST, length / _COARSEST, _TAUS) if taus is None else _increasing(taus, "taus")
    chosen = [checked_method(system, name) for name in names]
    for one in (*ladder, length / _DEFAULT_STEPS if tau is None else tau):
        step = checked_settings(chosen[0], one).tau
    index = _coordinate(system, coordinate)
    wanted = _default_values(system, start, span, index) if values is None else _increasing(values, "values")
    return Plan(system, span, start, names, ladder, index, wanted, step, count(steps, "steps", _MOST_STEPS))


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
    """Return several different finite numbers in order, else raise ValueError."""
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


def _default_values(
    system: PiecewiseSystem, x0: tuple[float, ...], t_span: tuple[float, float], coordinate: int
) -> Floats:
    """Values about as far as the trajectory from x₀ goes, and a little farther: what a portrait of it shows."""
    seen = reference_run(system, x0, t_span, record="steps").x[:, coordinate]
    away = np.abs(seen - x0[coordinate])
    seen = seen[away <= _FAR * max(float(np.median(away)), float(away.max()) / 1e6)]
    low, high = float(seen.min()), float(seen.max())
    margin = _MARGIN * (high - low) or max(abs(low), 1.0) / 2
    return np.linspace(low - margin, high + margin, _VALUES)
