"""heyoka in the comparison: Taylor's method compiled by LLVM, with a terminal event. It need not be installed."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pwsviz.bench.clock import timed
from pwsviz.bench.curves import Curve, Point
from pwsviz.bench.own import TOLERANCES
from pwsviz.bench.plan import Plan
from pwsviz.bench.problems import Problem

__all__ = ["HeyokaRun", "heyoka_curves", "installed_heyoka"]


def installed_heyoka() -> Any | None:
    """The module, or None where it is not installed."""
    try:
        import heyoka
    except ImportError:
        return None
    return heyoka


class HeyokaRun:
    """One integrator on a problem, to be run again and again.

    The switched coefficient is a parameter of the integrator. The one terminal event changes it and lets the
    integration go on; the direction in which g goes through zero tells the side entered.

    Parameters
    ----------
    tolerance
        Relative, from eps of the number type on.
    fast_math
        heyoka's option to reorder floating-point operations.
    counting
        Whether crossings are counted, which takes a little time.
    extended
        Whether to calculate in extended precision.

    Attributes
    ----------
    crossings
        How many there have been since the last reset, where they are counted.
    compiling
        Seconds to build the integrator. heyoka keeps machine code in memory, so the same one again takes less.
    """

    def __init__(
        self, problem: Problem, tolerance: float | np.longdouble, fast_math: bool = False, counting: bool = False,
        extended: bool = False,
    ) -> None:  # fmt: skip
        hy = installed_heyoka()
        if hy is None:
            raise ImportError("heyoka is not installed")
        self._problem, self._number = problem, np.longdouble if extended else float
        self.crossings = 0
        started = time.perf_counter()
        variables = hy.make_vars(*problem.system.variables)
        names = dict(zip(problem.system.laws.x, variables, strict=True)) | {problem.coefficient: hy.par[0]}
        field = [(v, hy.from_sympy(f, names)) for v, f in zip(variables, problem.field, strict=True)]
        event = hy.t_event(
            hy.from_sympy(problem.surface, names), callback=self._callback(counting), fp_type=self._number
        )
        self._integrator = hy.taylor_adaptive(
            field, problem.start.astype(self._number), time=self._number(0), pars=[self._number(self._level(1))],
            tol=self._number(tolerance), t_events=[event], fast_math=fast_math, fp_type=self._number,
        )  # fmt: skip
        self._parameters = self._integrator.pars  # looked up once: each look costs as much as the event
        self.compiling = time.perf_counter() - started
        self.reset()

    def _level(self, direction: int) -> float:
        return self._problem.levels[direction]

    def _callback(self, counting: bool) -> Any:
        below, above = self._problem.levels[-1], self._problem.levels[1]

        def switch(_: Any, direction: int) -> bool:
            self._parameters[0] = above if direction > 0 else below
            return True

        def switch_and_count(integrator: Any, direction: int) -> bool:
            self.crossings += 1
            return switch(integrator, direction)

        return switch_and_count if counting else switch

    def reset(self) -> None:
        """Go back to the start."""
        self._integrator.time = self._number(0)
        self._integrator.state[:] = self._problem.start
        self._parameters[0] = self._level(self._problem.first_side)
        self._integrator.reset_cooldowns()
        self.crossings = 0

    def run(self) -> None:
        """Integrate to the end."""
        self._integrator.propagate_until(self._number(self._problem.end))

    @property
    def state(self) -> NDArray[np.float64]:
        """State (d,), where the integrator is."""
        return self._integrator.state.astype(float)  # type: ignore[no-any-return]


def heyoka_curves(problem: Problem, exact: NDArray[np.float64], crossings: int, plan: Plan) -> list[Curve]:
    """Time against error of heyoka, without and with fast_math: `propagate_until` alone is timed."""
    return [_curve(problem, exact, crossings, plan, fast) for fast in (False, True)]


def _curve(problem: Problem, exact: NDArray[np.float64], crossings: int, plan: Plan, fast_math: bool) -> Curve:
    points, compiling = [], 0.0
    for tolerance in TOLERANCES:
        one = HeyokaRun(problem, tolerance, fast_math)
        compiling = max(compiling, one.compiling)
        wall = min(wall for wall, _ in timed(one.run, plan.repeats, plan.repeat_seconds, before=one.reset))
        counter = HeyokaRun(problem, tolerance, fast_math, counting=True)
        counter.run()
        error = float(np.abs(one.state - exact).max()) if counter.crossings == crossings else np.inf
        points.append(Point(tolerance, error, wall, None, counter.crossings))
    return Curve("heyoka, fast_math" if fast_math else "heyoka", points, compiling)
