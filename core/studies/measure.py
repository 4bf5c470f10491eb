"""One point of a work-precision diagram: cost and result of a run."""

from __future__ import annotations

import gc
import math
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from core.integrate import integrate
from core.integration.trajectory import Status, Trajectory
from core.interface.cancelling import Cancel, raise_if
from core.kernels.arrays import Floats
from core.methods import METHODS
from core.studies.external_solvers import EXTERNAL_SOLVERS, Arcs, ScalarFunctions, Stopped, external_arcs
from core.studies.sequence import CrossingSequence
from core.system import PiecewiseSystem

__all__ = ["Measured", "Problem", "measure"]

#: Held while one integrator is measured: threads that wait for the interpreter spend processor time on that, and it
#: would exceed that of a run of a tenth of a millisecond.
_one_at_a_time = threading.Lock()


class Problem(NamedTuple):
    """The initial value problem that every integrator solves, and how it is measured."""

    system: PiecewiseSystem
    t0: float
    end: float
    x0: tuple[float, ...]
    max_crossings: int
    """Number of crossings beyond which an external solver's run is given up."""
    repeats: int
    budget: float
    """Seconds that one run may take."""
    transition: str
    sliding: str
    """As in `integrate`, for the methods of this package."""
    cancel: Cancel
    """Returns True once nobody waits for the result."""


class Measured(NamedTuple):
    """Cost and result of one run; nan in all but `compiling` where it does not reach the end."""

    reason: str
    """Why there is no result; empty where there is one."""
    compiling: float
    """Processor time (s) to compile, or to load from disk; almost 0 where the code was in memory."""
    seconds: float = math.nan
    evaluations: float = math.nan
    x: Floats | None = None
    """(d,) state at the end."""
    crossings: CrossingSequence | None = None
    change_of_psi: float = math.nan
    """Largest |Δψ| off the surface, see `Trajectory.change_of_psi`."""


class _Clock:
    """Tells when a run has used up its budget of processor time, or nobody waits for it."""

    def __init__(self, budget: float, cancel: Cancel) -> None:
        self._budget, self._end, self._cancel = budget, time.thread_time() + budget, cancel

    def over(self) -> bool:
        return time.thread_time() > self._end or self._cancel()

    def check(self) -> None:
        if self.over():
            raise Stopped(self.reason)

    @property
    def reason(self) -> str:
        return f"takes longer than the {self._budget:g} s a run may take"


def measure(problem: Problem, name: str, setting: float) -> Measured:
    """Run one integrator at one setting; in one process, one at a time.

    The first run is not timed; it records the steps. Of the repeats that follow the fastest counts; no further one
    begins once they have taken `problem.budget` seconds together.

    Parameters
    ----------
    name
        A key of METHODS or of EXTERNAL_SOLVERS.
    setting
        Step size, or tolerance.
    """
    with _one_at_a_time:
        return _measure(problem, name, setting)


def _measure(problem: Problem, name: str, setting: float) -> Measured:
    raise_if(problem.cancel)
    started = time.thread_time()
    try:
        explore, again = (_own_method if name in METHODS else _external)(problem, name, setting)
    except Stopped as why:
        return Measured(str(why), time.thread_time() - started)
    compiling = time.thread_time() - started
    clock = _Clock(problem.budget, problem.cancel)
    try:
        arcs, change = explore(clock)
    except Stopped as why:
        return Measured(str(why), compiling)
    x, crossings = arcs.left[-1][1], _sequence(arcs, problem.system)
    if not np.isfinite(x).all():
        return Measured("the state at the end is not finite", compiling)
    seconds = _fastest(again, problem.repeats, problem.budget)
    raise_if(problem.cancel)
    return Measured("", compiling, seconds, arcs.evaluations, x, crossings, change)


#: A run within the budget, and its largest |Δψ|; the same run, to be timed.
_Runs: TypeAlias = tuple[Callable[[_Clock], tuple[Arcs, float]], Callable[[], object]]


def _own_method(problem: Problem, name: str, setting: float) -> _Runs:
    """A method of METHODS: a run that records its steps, and one that records only the end, to be timed."""
    key = "tolerance" if METHODS[name].adaptive else "tau"
    options: dict[str, Any] = {key: setting, "method": name, "transition": problem.transition}
    options["sliding"] = problem.sliding
    system, span, start = problem.system, (problem.t0, problem.end), problem.x0

    def explore(clock: _Clock) -> tuple[Arcs, float]:
        run = integrate(system, span, start, record="steps", cancel=clock.over, **options)
        if run.status is not Status.COMPLETED:
            raise Stopped(clock.reason if run.status is Status.CANCELLED else run.status.reason)
        return _arcs(run), float(np.fmax.reduce(run.change_of_psi()[~run.sliding], initial=np.nan))

    integrate(system, span, start, record="end", max_steps=1, **options)  # compiles what there is to compile
    return explore, lambda: integrate(system, span, start, record="end", cancel=problem.cancel, **options)


def _arcs(run: Trajectory) -> Arcs:
    t, x = [*run.crossings.t, run.t[-1]], [*run.crossings.x, run.x[-1].copy()]
    side = [run.system.laws.label(mode) for mode in (int(run.mode[0]), *run.crossings.mode.tolist())]
    entered = list(zip(run.entered_t, run.entered_x, strict=True))
    return Arcs(side, entered, list(zip(t, x, strict=True)), run.evaluations)


def _external(problem: Problem, name: str, setting: float) -> _Runs:
    """An external solver: a run within the budget, and the same run, to be timed."""
    start, functions = np.array(problem.x0), ScalarFunctions(problem.system, problem.sliding == "continue")
    prepared = EXTERNAL_SOLVERS[name].prepare(functions, setting, float(np.abs(start).max()) or 1.0)

    def run(check: Callable[[], None], record: bool = False) -> Arcs:
        return external_arcs(functions, prepared, problem.t0, problem.end, start, problem.max_crossings, check, record)

    def explore(clock: _Clock) -> tuple[Arcs, float]:
        arcs = run(clock.check, record=True)
        return arcs, arcs.change_of_psi(problem.system)

    return explore, lambda: run(partial(raise_if, problem.cancel))


def _fastest(run: Callable[[], object], repeats: int, budget: float) -> float:
    """Least processor time (s) of this thread over the repeats, which excludes other load of the machine."""
    times: list[float] = []
    collects = gc.isenabled()
    gc.disable()  # as `timeit` does
    try:
        while len(times) < repeats and sum(times) < budget:
            started = time.thread_time()
            run()
            times.append(time.thread_time() - started)
    finally:
        if collects:
            gc.enable()
    return min(times)


def _sequence(arcs: Arcs, system: PiecewiseSystem) -> CrossingSequence:
    return CrossingSequence.labelled(system, [t for t, _ in arcs.left[:-1]], arcs.side)
