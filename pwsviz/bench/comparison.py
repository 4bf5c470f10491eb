"""Time to a given error of the state: the Taylor method compared with heyoka and SciPy."""

from __future__ import annotations

import timeit
from collections.abc import Callable, Iterator, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

import core
from pwsviz.bench.heyoka import HeyokaByRegion, HeyokaRun, has_heyoka
from pwsviz.bench.plan import Plan
from pwsviz.bench.problems import ENDS, Problem, drawn_problems, named_problem
from pwsviz.bench.table import UNKNOWN, Table, milliseconds

__all__ = ["drawn", "named", "time_to_error"]

Floats: TypeAlias = NDArray[np.float64]
#: Functions: one to call before a run, the run itself, and one that returns the state at its end.
Integrator: TypeAlias = tuple[Callable[[], object], Callable[[], object], Callable[[], Floats]]

#: Errors of the state for which times are stated.
_TARGETS = (1e-3, 1e-6, 1e-9, 1e-12)
#: Tolerances of the Taylor method and of heyoka.
_TOLERANCES = (*(10.0**-k for k in range(2, 16)), 2.0**-52)
#: Tolerances of SciPy, which accepts none below 100 eps; coarser ones miss the first target.
_SCIPY_TOLERANCES = (1e-6, 1e-8, 1e-10, 1e-12, 2.3e-14)
#: Seed of the problems drawn at random.
_SEED = 20261122
#: Least error of the state: a smaller one is round-off, and may be 0.
_LEAST_ERROR = 1e-17


def named(plan: Plan) -> Table:
    """Times to the target errors on systems of the catalogue."""
    rows: list[list[str]] = []
    ends = ", ".join(f"{plan.share * ENDS[name]:.4g}" for name in plan.compared)
    for name in plan.compared:
        problem = named_problem(name, plan.share)
        times = np.array([*_own_and_heyoka(problem, plan), _scipy(problem, plan)])
        rows += [[name, f"{e:.0e}", *map(milliseconds, t), *_ratios(t)] for e, t in zip(_TARGETS, times.T, strict=True)]
    return Table(
        "Time to a state error",
        f"milliseconds to integrate to t = {ends}, after some {500 * plan.share:.0f} crossings, until the state is "
        f"right to an error; the least of {plan.repeats} runs, interpolated between tolerances. taylor is all of "
        "core.integrate(record='end') and heyoka propagate_until alone, in wall-clock time (with an "
        "integrator for each region where there are more than two). SciPy is DOP853, restarted "
        "at terminal events, in processor time, as in core.work_precision. The last columns are the ratios of taylor's "
        f"times to those of the three. {UNKNOWN}: not reached, or heyoka is not installed.",
        ("system", "error", "taylor", "heyoka", "fast_math", "SciPy", "/ heyoka", "/ fast_math", "/ SciPy"),
        rows,
    )


def drawn(plan: Plan) -> Table:
    """Ratios of the Taylor method's times to heyoka's on problems drawn at random."""
    ratios = {}
    for problem in drawn_problems(plan.drawn if has_heyoka() else 0, _SEED):
        own, _, fast = _own_and_heyoka(problem, plan)
        ratios[problem.name] = own / fast
    if ratios:
        found = list(ratios.values())
        ratios |= {"median": np.nanmedian(found, axis=0), "worst": np.nanmax(found, axis=0)}
    return Table(
        "Problems drawn at random",
        f"the same ratios of taylor's time to heyoka's with fast_math (seed {_SEED}). No rows if heyoka is not "
        "installed.",
        ("energy; surface", *(f"{error:.0e}" for error in _TARGETS)),
        [[name, *(f"{ratio:.2f}" for ratio in row)] for name, row in ratios.items()],
    )


def _own_and_heyoka(problem: Problem, plan: Plan) -> list[Floats]:
    """Seconds to each target of the Taylor method, heyoka, and heyoka with fast_math; nan where not reached."""
    exact = core.reference_solution(problem.system).state(problem.end)
    errors, seconds = np.full((2, 3, len(_TOLERANCES)), np.nan)
    for k, tolerance in enumerate(_TOLERANCES):
        for row, (prepare, run, state) in enumerate(_integrators(problem, tolerance)):
            seconds[row, k] = min(timeit.repeat(run, prepare, number=1, repeat=plan.repeats))
            errors[row, k] = np.abs(state() - exact).max()
    return [time_to_error(*curve) for curve in zip(errors, seconds, strict=True)]


def _integrators(problem: Problem, tolerance: float) -> Iterator[Integrator]:
    """The Taylor method and, where it is installed, heyoka without and with fast_math."""

    def run() -> core.Trajectory:
        return core.integrate(problem.system, (0.0, problem.end), method="taylor", tolerance=tolerance, record="end")

    yield run, run, lambda: run().x[-1]
    for fast_math in (False, True) if has_heyoka() else ():
        other = (HeyokaRun if problem.system.two_sided else HeyokaByRegion)(problem, tolerance, fast_math)
        yield other.reset, other.run, lambda: other.state  # noqa: B023 - called before the next iteration


def _scipy(problem: Problem, plan: Plan) -> Floats:
    """Seconds to each target; nan where not reached."""
    settings = {"scipy": _SCIPY_TOLERANCES}
    study = core.work_precision(
        problem.system, (0.0, problem.end), methods=(), settings=settings, repeats=plan.repeats, budget=plan.budget
    )
    return time_to_error(study.curves[0].state_error, study.curves[0].seconds)


def time_to_error(errors: Floats, seconds: Floats, targets: Sequence[float] = _TARGETS) -> Floats:
    """Seconds to each target, by interpolation in logarithms between neighbouring settings; nan where not reached.

    The error of a setting is taken as the largest of its own and those of finer settings, down to the setting of least
    error, so that an accidentally small error does not count; settings beyond that one are ignored, as their error is
    round-off. A finer setting that is faster takes precedence.

    Parameters
    ----------
    errors, seconds
        (n,) errors and run times (s) of n settings, the coarsest first; nan where a setting has not been measured.
    targets
        (m,) errors.
    """
    known = np.isfinite(errors) & np.isfinite(seconds)
    errors, seconds = np.maximum(errors[known], _LEAST_ERROR), seconds[known]
    if not len(errors):
        return np.full(len(targets), np.nan)
    best = int(errors.argmin()) + 1
    bounds, seconds = np.maximum.accumulate(errors[:best][::-1])[::-1], seconds[:best]
    between = np.exp(np.interp(-np.log(targets), -np.log(bounds), np.log(seconds)))
    fastest = np.minimum.accumulate(seconds[::-1])[::-1]
    first = np.array([np.argmax(bounds <= target) for target in targets])
    return np.where(bounds[-1] <= np.array(targets), np.minimum(between, fastest[first]), np.nan)


def _ratios(times: Floats) -> list[str]:
    return [UNKNOWN if np.isnan(ratio) else f"{ratio:.2g}" for ratio in times[0] / times[1:]]
