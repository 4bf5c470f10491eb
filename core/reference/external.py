"""The reference integrator for systems without a closed form: SciPy's DOP853, restarted on the surface."""

from bisect import bisect_right
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import scipy  # loads a subpackage when it is first used
import sympy
from numpy.typing import ArrayLike, NDArray

from core.reference.laws_in_numbers import two_sides
from core.reference.search import Sample, Time, first_zero
from core.reference.solution import MAX_CROSSINGS, Arc, Arrival, ReferenceSolution, State
from core.reference.transitions import Dynamics, Entry, Transitions

__all__ = ["external_solution"]

#: Parts of a step at which g is evaluated, besides its ends, to find pairs of crossings.
_INNER = (0.25, 0.5, 0.75)
#: Most steps of one arc before the search for a crossing is given up.
_MAX_STEPS = 200_000
#: Relative tolerance of one step: some 500 eps, where DOP853 still keeps it.
_RTOL = 1e-13
#: Side of each mode.
_SIDES = (-1, 1)
#: Estimate of the error of a solution, in units of the tolerance of one step.
_STEPS_OF_ERROR = 10


def external_solution(
    f: Callable[[int, float, NDArray[np.float64]], ArrayLike],
    g: Callable[[float, NDArray[np.float64]], float],
    gdot: Callable[[int, float, NDArray[np.float64]], float],
    t0: float,
    x0: ArrayLike,
    max_crossings: int = MAX_CROSSINGS,
    jump: Callable[[float, NDArray[np.float64]], ArrayLike] | None = None,
) -> ReferenceSolution:
    """Solution by SciPy's DOP853 at its tightest sensible tolerance, restarted on the surface.

    Parameters
    ----------
    f : callable (side, t, x) -> (d,)
    g : callable (t, x) -> float
    gdot : callable (side, t, x) -> float
        ∂g/∂t + ∇g·f of the side.
    t0 : float
    x0 : (d,)
        On the surface only if g vanishes there exactly; ValueError as for `exact_solution`.
    max_crossings : int
    jump : callable (t, x) -> (d,), or None
        The state after reaching the surface; None where it is continuous.

    Returns
    -------
    ReferenceSolution
        Its `error`, ten times the tolerance of one step, holds for some tens of units of time; later the error grows.
    """

    def start(t: Time, x: State, entry: Entry) -> Arc:
        return _ExternalArc(float(t), x.astype(float), entry, f, g, gdot)

    def evaluate(mode: int, guard: int, t: Time, x: State) -> tuple[Time, Time]:
        side, y = _SIDES[mode], x.astype(float)
        return side * float(g(float(t), y)), side * float(gdot(side, float(t), y))

    def land(mode: int, guard: int, t: Time, x: State) -> State:
        return np.asarray(jump(float(t), x.astype(float)) if jump else x, dtype=float)

    x = np.asarray(x0, dtype=float)
    laws = two_sides((), (), sympy.Symbol("g"), (), () if jump else None)
    rules = Transitions(Dynamics(laws, start, evaluate, land))
    error = _STEPS_OF_ERROR * _RTOL * float(np.abs(x).max() or 1.0)
    return ReferenceSolution(f"SciPy DOP853, rtol {_RTOL:g}", rules, float(t0), x, max_crossings, error)


class _ExternalArc:
    """An arc by DOP853, with the time and state at the end of every step."""

    def __init__(
        self, t: float, x: NDArray[np.float64], entry: Entry,
        f: Callable[[int, float, NDArray[np.float64]], ArrayLike],
        g: Callable[[float, NDArray[np.float64]], float],
        gdot: Callable[[int, float, NDArray[np.float64]], float],
    ) -> None:  # fmt: skip
        self.t: Time = t
        self.x: State = x
        self.mode = entry.mode
        self._side = side = _SIDES[entry.mode]
        self._g, self._gdot = g, gdot
        self._f = lambda u, y: np.asarray(f(side, u, y), dtype=float)
        self._atol = _RTOL / 10 * (np.abs(x).max() or 1.0)
        self._solver = scipy.integrate.DOP853(self._f, t, x, np.inf, rtol=_RTOL, atol=self._atol)
        self._times, self._states = [t], [x]
        height, rate = self._height_and_rate(t, x)
        self._largest_rate, self._largest_height = abs(rate), abs(height)
        self._last = Sample(t, 0.0 if entry.at else height, rate)
        self._found = None if entry.past is None else Arrival(t, x, entry.past, at_once=True)

    def largest_height(self, guard: int) -> float:
        """Largest |g| found on it."""
        return self._largest_height

    def largest_rate(self, guard: int) -> float:
        """Largest |ġ| found on it."""
        return self._largest_rate

    def arrival(self, until: float) -> Arrival | None:
        """First time and state on the surface; None if not before `until`."""
        while self._found is None and self._last.t < until:
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
        """Find the first crossing on the step just taken, to (t, x)."""
        path, start = self._solver.dense_output(), self._times[-1]
        inner = [start + (t - start) * part for part in _INNER]
        samples = [
            self._last,
            *(Sample(u, *self._height_and_rate(u, path(u))) for u in inner),
            Sample(t, *self._height_and_rate(t, x)),
        ]
        for a, b in pairwise(samples):
            self._largest_rate = max(self._largest_rate, abs(float(a.rate)))
            self._largest_height = max(self._largest_height, abs(float(a.height)))
            when = first_zero(self._evaluate, a, b)
            if when is not None:
                self._found = Arrival(float(when), self.state(float(when)))
                return
        self._last = samples[-1]

    def _evaluate(self, t: Time) -> tuple[Time, Time]:
        return self._height_and_rate(float(t), self.state(float(t)))

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

    def _height_and_rate(self, t: float, x: NDArray[np.float64] | State) -> tuple[float, float]:
        y = x.astype(float)
        return self._side * float(self._g(t, y)), self._side * float(self._gdot(self._side, t, y))
