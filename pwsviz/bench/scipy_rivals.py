# mypy: disable-error-code="no-untyped-def, no-untyped-call"
"""SciPy's solve_ivp in the comparison: restarted at terminal events, or blind to the surface."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, NamedTuple

import numpy as np
import sympy
from numba import njit
from numba.np.unsafe.ndarray import to_fixed_tuple
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from pwsviz.bench.clock import first_call, timed
from pwsviz.bench.curves import TARGETS, Curve, Point
from pwsviz.bench.plan import Plan
from pwsviz.bench.problems import Problem

__all__ = ["scipy_curves"]

Function = Any  # compiled by numba, which types it in its own way
_Method = Literal["DOP853", "LSODA"]
_jit: Any = njit(error_model="numpy")
_unpack: Any = to_fixed_tuple

_TOLERANCES = (1e-6, 1e-8, 1e-10, 1e-12, 2.3e-14)  # coarser ones miss 1e-3, and SciPy takes none below 100 eps
_FINE_ENOUGH = min(TARGETS) / 3


class _End(NamedTuple):
    state: NDArray[np.float64]
    crossings: int
    success: bool


class _Compiled(NamedTuple):
    """Compiled by numba: nothing but SciPy itself runs in Python."""

    fields: dict[int, Function]
    """f(t, x) of each side, its coefficient a constant."""
    events: dict[int, Function]
    """g(t, x), terminal where it leaves the side: so a restart on the surface does not fire again."""
    blind: Function
    """f(t, x) with the sign of g looked up in it."""


def scipy_curves(problem: Problem, exact: NDArray[np.float64], crossings: int, plan: Plan) -> list[Curve]:
    """Time against error of DOP853 and LSODA restarted at events, and of DOP853 with the `if` in the field."""
    code = _compiled(problem)

    def restarted(method: _Method) -> Callable[[float, float], _End]:
        return lambda end, tolerance: _restarted(problem, code, method, end, tolerance, 2 * crossings)

    def blind(end: float, tolerance: float) -> _End:
        return _blind(problem, code, end, tolerance)

    rivals = {
        "SciPy DOP853, events": restarted("DOP853"),
        "SciPy LSODA, events": restarted("LSODA"),
        "SciPy DOP853, if": blind,
    }
    return [_curve(name, run, problem.end, exact, crossings, plan) for name, run in rivals.items()]


def _curve(
    name: str, run: Callable[[float, float], _End], end: float, exact: NDArray[np.float64], crossings: int, plan: Plan
) -> Curve:
    compiling = first_call(lambda: run(end / 50, 1e-4))
    points: list[Point] = []
    for tolerance in _TOLERANCES:
        runs = timed(lambda: run(end, tolerance), plan.repeats, plan.repeat_seconds, warm=True)  # noqa: B023 - called here
        last = runs[-1][1]
        right = last.success and last.crossings == crossings
        error = float(np.abs(last.state - exact).max()) if right else np.inf
        points.append(Point(tolerance, error, min(wall for wall, _ in runs), None, last.crossings))
        if error <= _FINE_ENOUGH or points[-1].wall > plan.rival_budget:
            break
    return Curve(name, points, compiling)


def _restarted(problem: Problem, code: _Compiled, method: _Method, end: float, tolerance: float, most: int) -> _End:
    """Integrate from event to event. The side is carried."""
    t, x, side = 0.0, problem.start, problem.first_side
    for crossings in range(most):
        run = solve_ivp(
            code.fields[side], (t, end), x, method, rtol=tolerance, atol=tolerance, events=code.events[side]
        )
        t, x = run.t[-1], np.ascontiguousarray(run.y[:, -1])
        if run.status != 1:
            return _End(x, crossings, run.success)
        side = -side
    return _End(x, most, False)


def _blind(problem: Problem, code: _Compiled, end: float, tolerance: float) -> _End:
    """Integrate across the surface; crossings are changes of sign from step to step, counted after the run."""
    run = solve_ivp(code.blind, (0.0, end), problem.start, "DOP853", rtol=tolerance, atol=tolerance)
    above = problem.system.switching(0.0, run.y.T) > 0
    return _End(run.y[:, -1], int(np.count_nonzero(above[1:] != above[:-1])), run.success)


def _compiled(problem: Problem) -> _Compiled:
    d, variables = problem.system.dimension, problem.system.laws.x
    field = _jit(sympy.lambdify([*variables, problem.coefficient], problem.field, "math"))
    surface = _jit(sympy.lambdify(variables, problem.surface, "math"))
    below, above = problem.levels[-1], problem.levels[1]

    def on_side(level: float) -> Function:
        @_jit
        def rate(t, x):
            return np.array(field(*_unpack(x, d), level))

        return rate

    def leaving(side: int) -> Function:
        @_jit
        def height(t, x):
            return surface(*_unpack(x, d))

        height.terminal, height.direction = True, -side
        return height

    @_jit
    def blind(t, x):
        state = _unpack(x, d)
        level = above if surface(*state) > 0 else below
        return np.array(field(*state, level))

    return _Compiled({-1: on_side(below), 1: on_side(above)}, {s: leaving(s) for s in (-1, 1)}, blind)
