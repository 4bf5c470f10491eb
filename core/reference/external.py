"""The reference integrator for systems without a closed form: SciPy's DOP853, restarted on the surface."""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np
import scipy  # loads a subpackage when it is first used
import sympy
from numpy.typing import ArrayLike, NDArray
from sympy import Expr

from core.reference.search import Sample, Time, first_zero
from core.reference.solution import MAX_CROSSINGS, Arc, Arrival, ReferenceSolution, State
from core.reference.transitions import Dynamics, Entry, Transitions
from core.symbolic.expressions import TIME
from core.symbolic.laws import Laws
from core.system import PiecewiseSystem

__all__ = ["Functions", "external_solution", "functions_of"]

#: Parts of a step at which the guards are evaluated, besides its ends, to find pairs of crossings.
_INNER = (0.25, 0.5, 0.75)
#: Most steps of one arc before the search for a crossing is given up.
_MAX_STEPS = 200_000
#: Relative tolerance of one step: some 500 eps, where DOP853 still keeps it.
_RTOL = 1e-13
#: Estimate of the error of a solution, in units of the tolerance of one step.
_STEPS_OF_ERROR = 10
#: Relative rounding of an initial value.
_ROUNDED = 2.0**-51
#: Rate at which a guard vanishes, as part of its largest, below which it may be touched: where it is, its height is
#: found to ten tolerances of a step, and its rate to the root of that.
_TANGENT = 1e-6
#: A second guard below this part of its largest height vanishes with the first: one that is met a hundred tolerances of
#: a step later cannot be told from it.
_AT_ONCE = 1e-11


@dataclass(frozen=True)
class Functions:
    """A system as the external solver needs it: functions of plain numbers, of modes and guards by their numbers."""

    laws: Laws
    field: Callable[[int, float, NDArray[np.float64]], ArrayLike]
    """(mode, t, x) -> f (d,)."""
    guards: Callable[[int, float, NDArray[np.float64]], Sequence[tuple[float, float]]]
    """(mode, t, x) -> height, positive inside, and rate of each guard."""
    jump: Callable[[int, int, float, NDArray[np.float64]], ArrayLike]
    """(region, guard, t, x) -> the state (d,) after reaching it, if its way has a jump."""
    size: Callable[[int, int, float, NDArray[np.float64]], float] = lambda mode, guard, t, x: 0.0
    """(mode, guard, t, x) -> by how much t and x together change the height; 0 if only an exact zero is one."""


def functions_of(system: PiecewiseSystem) -> Functions:
    """The functions of a declared system."""
    laws = system.laws
    heights_and_rates: dict[int, tuple[Expr, ...]] = {}

    def values(key: object, wanted: Sequence[Expr], t: float, x: NDArray[np.float64]) -> list[float]:
        return laws.numbers(("external", key), wanted, t, x.tolist(), system.parameter_array)

    def field(mode: int, t: float, x: NDArray[np.float64]) -> ArrayLike:
        return values(("f", mode), laws.mode(mode).written.field, t, x)

    def guards(mode: int, t: float, x: NDArray[np.float64]) -> Sequence[tuple[float, float]]:
        if mode not in heights_and_rates:
            law = laws.mode(mode).written
            heights_and_rates[mode] = tuple(e for u in law.heights for e in (u, law.rate_of(u)))
        both = values(("guards", mode), heights_and_rates[mode], t, x)
        return list(zip(both[::2], both[1::2], strict=True))

    def jump(region: int, guard: int, t: float, x: NDArray[np.float64]) -> ArrayLike:
        return values(("jump", region, guard), laws.ways[region][guard].jump or laws.x, t, x)

    def size(mode: int, guard: int, t: float, x: NDArray[np.float64]) -> float:
        """Σ|u ∂g/∂u| over t and the variables u."""
        height = laws.mode(mode).heights[guard]
        terms = (sympy.Abs(u * height.diff(u)) for u in (TIME, *laws.x))
        return values(("size", mode, guard), (sympy.Add(*terms),), t, x)[0]

    return Functions(laws, field, guards, jump, size)


def external_solution(
    functions: Functions,
    t0: float,
    x0: ArrayLike,
    max_crossings: int = MAX_CROSSINGS,
    slides: bool = False,
) -> ReferenceSolution:
    """Solution by SciPy's DOP853 at its tightest sensible tolerance, restarted where a guard vanishes.

    Parameters
    ----------
    functions : Functions
    t0 : float
    x0 : (d,)
        On a surface only if g vanishes there to rounding; ValueError as for `exact_solution`.
    max_crossings : int
    slides : bool
        Whether it slides along a surface to which both fields point; else it ends there.

    Returns
    -------
    ReferenceSolution
        Its `error`, ten times the tolerance of one step, holds for some tens of units of time; later the error grows.
    """

    def start(t: Time, x: State, entry: Entry) -> Arc:
        return _ExternalArc(float(t), x.astype(float), entry, functions)

    def evaluate(mode: int, guard: int, t: Time, x: State) -> tuple[Time, Time]:
        return functions.guards(mode, float(t), x.astype(float))[guard]

    def land(mode: int, guard: int, t: Time, x: State) -> State:
        return np.asarray(functions.jump(mode, guard, float(t), x.astype(float)), dtype=float)

    def size(mode: int, guard: int, t: Time, x: State) -> float:
        return functions.size(mode, guard, float(t), x.astype(float))

    x = np.asarray(x0, dtype=float)
    dynamics = Dynamics(functions.laws, start, evaluate, land, size, _ROUNDED, _AT_ONCE, _TANGENT)
    rules = Transitions(dynamics, slides)
    error = _STEPS_OF_ERROR * _RTOL * float(np.abs(x).max() or 1.0)
    return ReferenceSolution(f"SciPy DOP853, rtol {_RTOL:g}", rules, float(t0), x, max_crossings, error)


class _ExternalArc:
    """An arc by DOP853, with the time and state at the end of every step."""

    def __init__(self, t: float, x: NDArray[np.float64], entry: Entry, functions: Functions) -> None:
        self.t: Time = t
        self.x: State = x
        self.mode = mode = entry.mode
        self._guards = functions.guards
        self._f = lambda u, y: np.asarray(functions.field(mode, u, y), dtype=float)
        self._atol = _RTOL / 10 * (np.abs(x).max() or 1.0)
        self._solver = scipy.integrate.DOP853(self._f, t, x, np.inf, rtol=_RTOL, atol=self._atol)
        self._times, self._states = [t], [x]
        here = functions.guards(mode, t, x)
        self._largest_heights, self._largest_rates = np.abs(np.array(here, dtype=float).reshape(-1, 2)).T
        self._last = [Sample(t, 0.0 if k in entry.at else h, rate) for k, (h, rate) in enumerate(here)]
        self._found = None if entry.past is None else Arrival(t, x, entry.past, at_once=True)

    def largest_height(self, guard: int) -> float:
        """Largest height of a guard found on it, in size."""
        return float(self._largest_heights[guard])

    def largest_rate(self, guard: int) -> float:
        """Largest rate of a guard found on it, in size."""
        return float(self._largest_rates[guard])

    def arrival(self, until: float) -> Arrival | None:
        """First time and state on the surface; None if not before `until`."""
        while self._found is None and self._times[-1] < until:
            if len(self._times) > _MAX_STEPS:
                raise ValueError(f"no crossing found in {_MAX_STEPS} steps, up to t = {self._times[-1]:.17g}")
            message = self._solver.step()
            t, x = float(self._solver.t), self._solver.y
            if self._solver.status == "failed" or not np.isfinite(x).all():
                raise ValueError(f"the reference integrator stops at t = {self._times[-1]:.17g}: {message}")
            self._search(t, x)
            self._times.append(t)
            self._states.append(x.copy())
        return self._found

    def _search(self, t: float, x: NDArray[np.float64]) -> None:
        """Find the first zero of a guard on the step just taken, to (t, x)."""
        path, start = self._solver.dense_output(), self._times[-1]
        inner = [start + (t - start) * part for part in _INNER]
        places = [*((u, path(u)) for u in inner), (t, x)]
        rows = [self._last, *([Sample(u, *pair) for pair in self._guards(self.mode, u, y)] for u, y in places)]
        for before, after in pairwise(rows):
            met = []
            for k, (a, b) in enumerate(zip(before, after, strict=True)):
                self._largest_rates[k] = max(self._largest_rates[k], abs(float(a.rate)))
                self._largest_heights[k] = max(self._largest_heights[k], abs(float(a.height)))
                when = first_zero(partial(self._evaluate, k), a, b)
                if when is not None:
                    met.append((float(when), k))
            if met:
                first, guard = min(met)
                self._found = Arrival(first, self.state(first), guard)
                return
        self._last = rows[-1]

    def _evaluate(self, guard: int, t: Time) -> tuple[Time, Time]:
        return self._guards(self.mode, float(t), self.state(float(t)))[guard]

    def state(self, t: float) -> State:
        """State (d,) at time t, by a step of the integrator from the last one before t; no interpolant is used."""
        node = bisect_right(self._times, t) - 1
        t0, x0 = self._times[node], self._states[node]
        if t == t0:
            return x0
        run = scipy.integrate.solve_ivp(self._f, (t0, t), x0, "DOP853", rtol=_RTOL, atol=self._atol, first_step=t - t0)
        if not run.success:
            raise ValueError(f"the reference integrator stops after t = {t0:.17g}: {run.message}")
        return np.asarray(run.y[:, -1])
