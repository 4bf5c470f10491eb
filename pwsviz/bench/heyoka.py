"""heyoka on a problem: a Taylor method compiled by LLVM, with a terminal event. It need not be installed."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

import core
from core.studies import heyoka_integrator
from pwsviz.bench.problems import Problem

__all__ = ["HeyokaBatches", "HeyokaByRegion", "HeyokaEnsemble", "HeyokaRun", "has_heyoka"]


def has_heyoka() -> bool:
    """Whether heyoka is installed."""
    return find_spec("heyoka") is not None


class HeyokaRun:
    """One integrator on a problem, to be run any number of times.

    The coefficient that differs between the sides is a parameter of the integrator. The single terminal event changes
    it and lets the integration continue; the direction in which g passes zero tells the side entered. Two integrators,
    one per side, would take twice the time.

    Parameters
    ----------
    tolerance
        Relative tolerance, at least eps.
    fast_math
        heyoka's option to reorder floating-point operations.
    """

    def __init__(self, problem: Problem, tolerance: float, fast_math: bool = False) -> None:
        self._problem = problem
        self._start = np.array(problem.system.x0)
        self._integrator = _integrator(problem, tolerance, self._switch(), fast_math)
        self._parameters = self._integrator.pars  # looked up once: each access costs as much as the event

    def _switch(self) -> Any:
        below, above = self._problem.levels[-1], self._problem.levels[1]

        def switch(_: Any, direction: int) -> bool:
            self._parameters[0] = above if direction > 0 else below
            return True

        return switch

    def reset(self) -> None:
        """Go back to the start."""
        above = self._problem.system.switching(0.0, self._start) > 0
        self._integrator.time = 0.0
        self._integrator.state[:] = self._start
        self._parameters[0] = self._problem.levels[1 if above else -1]
        self._integrator.reset_cooldowns()

    def run(self) -> None:
        """Integrate to the end."""
        self._integrator.propagate_until(self._problem.end)

    @property
    def state(self) -> NDArray[np.float64]:
        """State (d,) at the time that the integrator has reached."""
        return self._integrator.state.copy()  # type: ignore[no-any-return]


class HeyokaEnsemble:
    """heyoka's ensemble_propagate_until on a problem whose sides differ in one coefficient.

    Parameters
    ----------
    problem, tolerance
        As for `HeyokaRun`.
    """

    def __init__(self, problem: Problem, tolerance: float) -> None:
        self._problem = problem
        below, above = problem.levels[-1], problem.levels[1]
        self._integrator = _integrator(problem, tolerance, _Switch(below, above), fast_math=False)

    def ends(self, x0: NDArray[np.float64], end: float) -> NDArray[np.float64]:
        """Return the last states (n, d) of members that begin at x0 (n, d)."""
        import heyoka as hy

        signs = self._problem.system.switching(0.0, x0)
        levels = [self._problem.levels[1 if sign > 0 else -1] for sign in signs]

        def begin(one: Any, k: int) -> Any:
            one.state[:], one.pars[0] = x0[k], levels[k]
            return one

        return np.array([one[0].state for one in hy.ensemble_propagate_until(self._integrator, end, len(x0), begin)])


class HeyokaBatches:
    """heyoka's ensemble_propagate_until_batch, which integrates as many members at once as the processor has lanes.

    Parameters
    ----------
    problem, tolerance
        As for `HeyokaRun`.
    """

    def __init__(self, problem: Problem, tolerance: float) -> None:
        import heyoka as hy

        self._problem, self._lanes = problem, hy.recommended_simd_size()
        field, surface = _in_heyoka(problem)
        event = hy.t_event_batch(surface, callback=_Switch(problem.levels[-1], problem.levels[1]))
        start = np.repeat(np.array(problem.system.x0)[:, None], self._lanes, axis=1)
        pars = np.zeros((1, self._lanes))
        self._integrator = hy.taylor_adaptive_batch(field, start, pars=pars, tol=tolerance, t_events=[event])

    def ends(self, x0: NDArray[np.float64], end: float) -> NDArray[np.float64]:
        """Return the last states (n, d) of members that begin at x0 (n, d)."""
        import heyoka as hy

        lanes, batches = self._lanes, -(-len(x0) // self._lanes)
        starts = np.resize(x0, (batches * lanes, x0.shape[1]))  # the last batch is filled up with the first members
        above = self._problem.system.switching(0.0, starts) > 0
        levels = np.where(above, self._problem.levels[1], self._problem.levels[-1])

        def begin(one: Any, k: int) -> Any:
            which = slice(k * lanes, (k + 1) * lanes)
            one.state[:], one.pars[0] = starts[which].T, levels[which]
            return one

        ends = hy.ensemble_propagate_until_batch(self._integrator, end, batches, begin)
        return np.concatenate([one[0].state.T for one in ends])[: len(x0)]


class _Switch:
    """Sets the coefficient of the integrator that crosses, or of a lane; heyoka copies it with the integrator."""

    def __init__(self, below: float, above: float) -> None:
        self.below, self.above = below, above

    def __call__(self, integrator: Any, direction: int, *lane: int) -> bool:
        integrator.pars[(0, *lane)] = self.above if direction > 0 else self.below
        return True


def _integrator(problem: Problem, tolerance: float, switch: Callable[[Any, int], bool], fast_math: bool) -> Any:
    """heyoka's integrator of a problem, with the surface as terminal event."""
    import heyoka as hy

    field, surface = _in_heyoka(problem)
    event = hy.t_event(surface, callback=switch)
    start = np.array(problem.system.x0)
    return hy.taylor_adaptive(field, start, pars=[0.0], tol=tolerance, t_events=[event], fast_math=fast_math)


def _in_heyoka(problem: Problem) -> tuple[list[tuple[Any, Any]], Any]:
    """Field and surface of a problem as heyoka's expressions."""
    import heyoka as hy

    variables = hy.make_vars(*problem.system.variables)
    names = dict(zip(problem.system.laws.x, variables, strict=True)) | {problem.coefficient: hy.par[0]}
    field = [(v, hy.from_sympy(f, names)) for v, f in zip(variables, problem.field, strict=True)]
    return field, hy.from_sympy(problem.surface, names)


class HeyokaByRegion:
    """An integrator for each region on a problem without jumps, exchanged by hand where an event ends one.

    Parameters
    ----------
    tolerance, fast_math
        As for `HeyokaRun`.
    """

    def __init__(self, problem: Problem, tolerance: float, fast_math: bool = False) -> None:
        import heyoka as hy

        hy.set_logger_level_error()  # it warns of each step from a state that is not finite; the error tells of those
        system = problem.system
        self._end, self._start = problem.end, np.array(system.x0)
        self._beyond = [[way.to for way in ways] for ways in system.laws.ways]
        first_step = core.integrate(system, (0.0, problem.end), method="taylor", max_steps=1, record="end")
        self._first = int(first_step.mode[0])
        ones = [heyoka_integrator(system, mode, tolerance, fast_math) for mode in system.laws.regions]
        self._integrators = [(one, one.state) for one in ones]  # looked up once: each access costs as much as an event
        self.reset()

    def reset(self) -> None:
        """Go back to the start."""
        self._now, self.state = self._integrators[self._first]
        self._now.time, self.state[:] = 0.0, self._start
        self._now.reset_cooldowns()

    def run(self) -> None:
        """Integrate to the end; `state` is then that of the last region."""
        region = self._first
        while (met := -1 - int(self._now.propagate_until(self._end)[0])) < len(self._beyond[region]):
            beyond = self._beyond[region][met]
            if beyond is None:
                raise ValueError(f"at t = {self._now.time:.6g} heyoka has left all regions that are declared")
            region = beyond
            now, state = self._integrators[region]
            state[:] = self.state
            now.time = self._now.time
            now.reset_cooldowns()
            self._now, self.state = now, state
