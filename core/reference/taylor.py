"""The reference integrator for systems without a closed form: the Taylor method, at two tolerances."""

from __future__ import annotations

from bisect import bisect_right
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.integration.crossings import Crossings
from core.integration.outcome import ending_of, reason
from core.integration.run_settings import Settings
from core.integration.runner import Runner
from core.integration.trajectory import Status
from core.interface.cancelling import Cancel, Cancelled
from core.methods import METHODS
from core.reference.solution import Stop
from core.system import PiecewiseSystem
from core.transition.records import NO_MODE

__all__ = ["TaylorSolution"]

#: Finer tolerance, far below round-off: its steps are a fiftieth as long, so that the two runs differ where the field
#: or g varies within a coarse step and returns.
_FINE = 1e-58
#: Coarser tolerance.
_COARSE = 1e-13
#: Number of steps between two snapshots of a run, about.
_STRIDE = 32
#: Most steps of a solution before the search for a crossing is given up.
_MAX_STEPS = 1_000_000


class TaylorSolution:
    """Piecewise smooth solution from (t0, x0) by the Taylor method, extended as it is asked for.

    It is computed at tolerances of 1e-58 and 1e-13, with steps of different lengths. The difference of the two runs,
    some hundred times the error of the finer one, is the estimate of the error.

    Parameters
    ----------
    system
    x0
        (d,) initial state.
    t0
        Initial time.
    cancel
        As in `integrate`; what is asked for then raises `Cancelled`.
    slides
        Whether it slides along the surface where both fields point to it; else it ends there.
    """

    exact = False
    name = (
        "Taylor method in double precision, in short steps "
        f"(its error is estimated by comparison with a run at tolerance {_COARSE:g})"
    )

    def __init__(
        self, system: PiecewiseSystem, x0: NDArray[np.float64], t0: float, cancel: Cancel | None = None,
        slides: bool = False,
    ) -> None:  # fmt: skip
        settings = [Settings(np.inf, accuracy, max_steps=_MAX_STEPS, slides=slides, cancel=cancel)
                    for accuracy in (_FINE, _COARSE)]  # fmt: skip
        self._fine, self._coarse = (_Path(system, x0, t0, one) for one in settings)
        self._system, self._t0 = system, t0
        self._error = 0.0
        for path in (self._fine, self._coarse):
            path.begin()

    @property
    def error(self) -> float:
        """Largest difference of the two runs, in states and in times of crossings, of all that was asked for so far.

        It is no less than what rounding the time and the state does, which changes both runs alike.
        """
        return self._error

    @property
    def stop(self) -> Stop | None:
        """Where, when and why it ends, once that is known."""
        return self._fine.stop

    def crossing(self, k: int) -> tuple[float, NDArray[np.float64]]:
        """Time and state (d,) on the surface of crossing k = 1, 2, …; ValueError if the solution has fewer."""
        if k < 1:
            raise ValueError(f"crossing must be at least 1, not {k}")
        (fine, coarse) = (path.crossings(k) for path in (self._fine, self._coarse))
        t, x, mode = float(fine.t[k - 1]), fine.x[k - 1].copy(), int(fine.mode[k - 1])
        self._compare(np.append(x, t), np.append(coarse.x[k - 1], coarse.t[k - 1]), self._rounding(t, x, mode))
        return t, x

    def after(self, k: int) -> NDArray[np.float64]:
        """State (d,) from which the solution continues after crossing k: on the surface, or after the jump."""
        self.crossing(k)
        return np.array(self._fine.crossings(k).x_after[k - 1])

    def entered(self, k: int) -> int:
        """Side entered at crossing k, −1 or +1; 0 where sliding begins. Of several surfaces the number of the mode."""
        self.crossing(k)
        return self._system.laws.label(int(self._fine.crossings(k).mode[k - 1]))

    def count(self, t: float) -> int:
        """Number of crossings up to time t ≥ t0; ValueError past the end of the solution."""
        self._fine.mode(t)  # follows the solution up to there
        return int(np.searchsorted(self._fine.crossings(0).t, t, side="right"))

    def state(self, t: float) -> NDArray[np.float64]:
        """State (d,) at time t ≥ t0, at a crossing the one after its jump; ValueError past the end of the solution."""
        if not self._t0 <= t < np.inf:
            raise ValueError(f"time must be finite and at least {self._t0:.17g}, not {t}")
        fine, coarse = self._fine.state(t), self._coarse.state(t)
        self._compare(fine, coarse, self._rounding(t, fine, self._fine.mode(t)))
        return fine

    def side(self, t: float) -> int:
        """Side, −1 or +1, occupied at time t ≥ t0; 0 while sliding. Of several surfaces the number of the mode."""
        return self._system.laws.label(self._fine.mode(t))

    def _compare(self, fine: NDArray[np.float64], coarse: NDArray[np.float64], rounding: float) -> None:
        self._error = max(self._error, rounding, float(np.abs(fine - coarse).max()))

    def _rounding(self, t: float, x: NDArray[np.float64], mode: int) -> float:
        """Change of time and state by a unit in the last place of either."""
        speed = 0.0 if mode == NO_MODE else float(np.abs(self._system.field(self._system.laws.name(mode), t, x)).max())
        return float(np.spacing(abs(t)) * max(1.0, speed) + np.spacing(np.abs(x).max()))


class _Snapshot(NamedTuple):
    """A copy of a run in progress, at the time it has reached."""

    t: float
    runner: Runner


class _Path:
    """One run, with snapshots from which it can be continued to any time."""

    def __init__(self, system: PiecewiseSystem, x0: NDArray[np.float64], t0: float, settings: Settings) -> None:
        self._runner = Runner(system, METHODS["taylor"], t0, tuple(x0), settings)
        self._kept = [_Snapshot(t0, self._runner.copy())]
        self.stop: Stop | None = None  #: set once the run is known to end
        self._lost = False  # whether then the solution goes on, as far as is known
        # Beyond its region a law may have no value.
        speeds = [np.linalg.norm(system.field(law.name, t0, x0)) for law in system.laws.regions]
        speed = max((float(one) for one in speeds if 0.0 < one < np.inf), default=1.0)
        self._stride = float(np.linalg.norm(x0)) / speed or 1.0

    def begin(self) -> None:
        """Take the first stride; ValueError where the start is on the surface and cannot leave it to one side."""
        try:
            self._extend("its first step")
        except ValueError:
            if self._runner.t == self._kept[0].t:  # else it ends later, of which whoever asks so far is told
                raise

    def crossings(self, k: int) -> Crossings:
        """Crossings, the first k of them at least."""
        while self._runner.segment < k:  # a crossing at which the run ends does not count: nothing follows it
            try:
                self._extend(f"crossing {k}")
            except ValueError:
                if self._runner.segment < k:
                    raise
        return self._runner.crossings()

    def state(self, t: float) -> NDArray[np.float64]:
        """State (d,) at time t."""
        return self._at(t).x

    def mode(self, t: float) -> int:
        """Number of the mode occupied at time t."""
        mode = self._at(t).mode
        return self._runner.first_mode if mode == NO_MODE else mode

    def _at(self, t: float) -> Runner:
        while self._kept[-1].t < t and not (self.stop is not None and t < self._runner.t):
            try:
                self._extend(f"t = {t:.17g}")
            except ValueError:
                if not t < self._runner.t:
                    raise
        runner = self._kept[bisect_right([s.t for s in self._kept], t) - 1].runner.copy()
        _advance(runner, t)
        return runner

    def _extend(self, wanted: str) -> None:
        """Advance by a stride; ValueError where the run has stopped before what is `wanted`."""
        runner, before = self._runner, self._runner.steps
        if self.stop is None and _advance(runner, runner.t + self._stride) is not Status.COMPLETED:
            self.stop = Stop(runner.t, runner.x, reason(ending_of(runner)))
            self._lost = runner.status is Status.NO_CONVERGENCE
        if self.stop is not None:
            ends = "the reference cannot be continued beyond" if self._lost else "the solution ends at"
            raise ValueError(f"{ends} {self.stop.where}, before {wanted}: {self.stop.reason}")
        self._kept.append(_Snapshot(runner.t, runner.copy()))
        self._stride *= 2.0 if runner.steps - before < _STRIDE else 1.0


def _advance(runner: Runner, t: float) -> Status:
    """Advance a run to time t; raise `Cancelled` if it is given up on the way."""
    status = runner.advance(t)
    if status is Status.CANCELLED:
        raise Cancelled
    return status
