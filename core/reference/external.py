"""The reference integrator for systems without a closed form: SciPy's DOP853, restarted on the surface."""

from bisect import bisect_right
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import scipy  # loads a subpackage when it is first used
from numpy.typing import ArrayLike, NDArray

from core.reference.search import Sample, Time, first_zero
from core.reference.solution import MAX_CROSSINGS, Arc, Motion, ReferenceSolution, State, first_arc

__all__ = ["external_solution"]

_LOOKS = (0.25, 0.5, 0.75)  # where within a step g is looked at, besides its ends
_MAX_STEPS = 200_000  # of one arc
_PEER_RTOL = 1e-13
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
        The state after reaching the surface.

    Returns
    -------
    ReferenceSolution
        Its `error` is ten times what the tolerance lets one step err: for some tens of units of time; it grows.
    """

    def start(t: Time, x: State, side: int, on_surface: bool) -> Arc:
        return _PeerArc(float(t), x.astype(float), side, on_surface, f, g, gdot)

    def rate(side: int, t: Time, x: State) -> Time:
        return float(gdot(side, float(t), x.astype(float)))

    def height(t: Time, x: State) -> Time:
        return float(g(float(t), x.astype(float)))

    def land(t: Time, x: State) -> State:
        return np.asarray(jump(float(t), x.astype(float)) if jump else x, dtype=float)

    motion = Motion(start, height, rate, land if jump else None)
    x = np.asarray(x0, dtype=float)
    first = first_arc(motion, float(t0), x, 0.0)
    error = _STEPS_OF_ERROR * _PEER_RTOL * float(np.abs(x).max() or 1.0)
    return ReferenceSolution(f"SciPy DOP853, rtol {_PEER_RTOL:g}", motion, first, max_crossings, error)


class _PeerArc:
    """An arc by DOP853, one node a step."""

    def __init__(
        self, t: float, x: NDArray[np.float64], side: int, on_surface: bool,
        f: Callable[[int, float, NDArray[np.float64]], ArrayLike],
        g: Callable[[float, NDArray[np.float64]], float],
        gdot: Callable[[int, float, NDArray[np.float64]], float],
    ) -> None:  # fmt: skip
        self.t: Time = t
        self.x: State = x
        self.side = side
        self._g, self._gdot = g, gdot
        self._f = lambda u, y: np.asarray(f(side, u, y), dtype=float)
        self._atol = _PEER_RTOL / 10 * (np.abs(x).max() or 1.0)
        self._solver = scipy.integrate.DOP853(self._f, t, x, np.inf, rtol=_PEER_RTOL, atol=self._atol)
        self._times, self._states = [t], [x]
        depth, rate = self._look(t, x)
        self.steepest, self.deepest = abs(rate), abs(depth)
        self._last = Sample(t, 0.0 if on_surface else depth, rate)
        self._found: tuple[Time, State] | None = None

    def arrival(self, until: float) -> tuple[Time, State] | None:
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
        """Look along the step just taken, to (t, x), and keep the first crossing on it."""
        path, start = self._solver.dense_output(), self._times[-1]
        inner = [start + (t - start) * part for part in _LOOKS]
        samples = [
            self._last, *(Sample(u, *self._look(u, path(u))) for u in inner), Sample(t, *self._look(t, x))
        ]  # fmt: skip
        for a, b in pairwise(samples):
            self.steepest, self.deepest = max(self.steepest, abs(float(a.rate))), max(self.deepest, abs(float(a.depth)))
            when = first_zero(self._watch, a, b)
            if when is not None:
                self._found = float(when), self.state(float(when))
                return
        self._last = samples[-1]

    def _watch(self, t: Time) -> tuple[Time, Time]:
        return self._look(float(t), self.state(float(t)))

    def state(self, t: float) -> State:
        """State (d,) at time t, by a step of the integrator itself from the node before: no interpolant."""
        node = bisect_right(self._times, t) - 1
        t0, x0 = self._times[node], self._states[node]
        if t == t0:
            return x0
        run = scipy.integrate.solve_ivp(
            self._f, (t0, t), x0, "DOP853", rtol=_PEER_RTOL, atol=self._atol, first_step=t - t0
        )
        if not run.success:
            raise ValueError(f"the reference integrator stops after t = {t0:.17g}: {run.message}")
        return np.asarray(run.y[:, -1])

    def _look(self, t: float, x: NDArray[np.float64] | State) -> tuple[float, float]:
        y = x.astype(float)
        return self.side * float(self._g(t, y)), self.side * float(self._gdot(self.side, t, y))
