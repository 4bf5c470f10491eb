"""The variable-step method beside heyoka on problems drawn at random, the two timed in turn."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable
from functools import partial
from typing import TypeVar

import numpy as np

import core
from pwsviz.bench.curves import TARGETS, Curve, Point
from pwsviz.bench.families import DrawnProblem, drawn_problems
from pwsviz.bench.heyoka_rival import HeyokaRun, installed_heyoka
from pwsviz.bench.own import TOLERANCES
from pwsviz.bench.plan import Plan
from pwsviz.bench.reference import reference_of
from pwsviz.bench.tables import aligned

__all__ = ["drawn"]

Result = TypeVar("Result")

_SEED = 20261122
_GOAL = 0.5  #: ours / heyoka at most
_METHOD = "taylor"
_TOLERANCES = TOLERANCES[::2]


def drawn(plan: Plan) -> Iterable[str]:
    """Lines of the ratios on the drawn problems, with their median and the worst."""
    yield f"Problems drawn at random (seed {_SEED}): time of {_METHOD} to a state error over that of heyoka, fast_math,"
    yield f"timed in turn, the least of {plan.repeats}. Aim: at most {_GOAL:g}."
    if installed_heyoka() is None:
        yield "heyoka is not installed."
        return
    ratios = {problem.name: _ratios(problem, plan) for problem in drawn_problems(plan.drawn, _SEED)}
    rows = [[name, *(f"{ratio:.2f}" for ratio in row)] for name, row in ratios.items()]
    for word, of in (("median", np.nanmedian), ("worst", np.nanmax)):
        rows.append([word, *(f"{ratio:.2f}" for ratio in of(list(ratios.values()), axis=0))])
    yield from aligned(["energy; surface", *(f"{target:.0e}" for target in TARGETS)], rows)


def _ratios(problem: DrawnProblem, plan: Plan) -> list[float]:
    """Ours / heyoka at each target; nan where one of them does not get there."""
    curves = _curves(problem, plan)
    times = [[curve.reach(target)[0] for curve in curves] for target in TARGETS]
    return [math.nan if a is None or b is None else a / b for a, b in times]


def _curves(problem: DrawnProblem, plan: Plan) -> tuple[Curve, Curve]:
    reference = reference_of(problem)
    points: tuple[list[Point], list[Point]] = ([], [])
    for tolerance in _TOLERANCES:
        rival = HeyokaRun(problem, tolerance, fast_math=True)
        walls = [math.inf, math.inf]
        for _ in range(plan.repeats + 1):
            rival.reset()
            wall, run = _timed(partial(_own, problem, tolerance))
            walls = [min(walls[0], wall), min(walls[1], _timed(rival.run)[0])]
        right = run.status is core.Status.COMPLETED and run.crossing_count == reference.crossings
        states = (run.x[-1] if right else np.full(2, np.inf), rival.state)
        for curve, state, wall in zip(points, states, walls, strict=True):
            curve.append(Point(tolerance, float(np.abs(state - reference.state).max()), wall))
    return Curve(_METHOD, points[0], 0.0), Curve("heyoka", points[1], 0.0)


def _own(problem: DrawnProblem, tolerance: float) -> core.Trajectory:
    return core.integrate(problem.system, (0.0, problem.end), method=_METHOD, tolerance=tolerance, record="end")


def _timed(call: Callable[[], Result]) -> tuple[float, Result]:
    """Wall time (s) and result of a call."""
    started = time.perf_counter()
    result = call()
    return time.perf_counter() - started, result
