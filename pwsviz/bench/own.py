"""Our own methods in the comparison."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

import core
from pwsviz.bench.clock import first_call, timed
from pwsviz.bench.curves import TARGETS, Curve, Point
from pwsviz.bench.plan import Plan
from pwsviz.bench.problems import Problem

__all__ = ["TOLERANCES", "own_curve"]

#: Of whatever takes a tolerance and is not SciPy.
TOLERANCES = (*(10.0**-k for k in range(2, 16)), 2.0**-52)
_COARSEST = 0.4
_DIGITS = 1.5  #: between a step size and the next, by the method's order
_FINE_ENOUGH = min(TARGETS) / 3
_PATIENCE = 2  #: finer step sizes without a smaller error: round-off


def own_curve(problem: Problem, method: core.Method, exact: NDArray[np.float64], crossings: int, plan: Plan) -> Curve:
    """Time against error of a method, by the clock on the wall around all of `core.integrate`."""

    def run(end: float, setting: float) -> core.Trajectory:
        chosen = {"tolerance": setting} if method.adaptive else {"tau": setting}
        return core.integrate(problem.system, (0.0, end), method=method.name, record="end", **chosen)  # type: ignore[arg-type]

    compiling = first_call(lambda: run(1.0, 1e-2))
    points: list[Point] = []
    for setting in _settings(method):
        if points and not method.adaptive and _next_loop(points[-1], setting) > plan.own_budget:
            break
        runs = timed(lambda: run(problem.end, setting), plan.repeats, plan.repeat_seconds)  # noqa: B023 - called here
        last = runs[-1][1]
        right = last.status is core.Status.COMPLETED and last.crossing_count == crossings
        error = float(np.abs(last.x[-1] - exact).max()) if right else np.inf
        loop = min(result.seconds for _, result in runs)
        points.append(Point(setting, error, min(wall for wall, _ in runs), loop, last.crossing_count))
        if not method.adaptive and _done(points):
            break
    return Curve(method.name, points, compiling)


def _settings(method: core.Method) -> Iterator[float]:
    if method.order is None:
        yield from TOLERANCES
        return
    for k in range(60):
        yield _COARSEST * 10 ** (-_DIGITS * k / method.order)


def _next_loop(point: Point, setting: float) -> float:
    """Processor time to expect: the clock on the wall may have stalled."""
    return (point.loop or 0.0) * point.setting / setting


def _done(points: list[Point]) -> bool:
    best = min(range(len(points)), key=lambda k: points[k].error)
    stuck = np.isfinite(points[best].error) and len(points) - 1 - best >= _PATIENCE
    return bool(points[best].error <= _FINE_ENOUGH or stuck)
