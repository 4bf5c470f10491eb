"""An exact solution, continued in numbers from where it slides by a field without a known closed form."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from core.reference.exact import ExactSolution
from core.reference.solution import Solution, Stop

__all__ = ["ContinuedSolution"]

T = TypeVar("T")


class ContinuedSolution:
    """The exact solution as long as closed forms are known; what lies beyond is asked of an integrator.

    Parameters
    ----------
    exact
        The exact solution, which ends where no closed form is known.
    go_on
        Makes the solution by the Taylor method or an external solver; called when it is first needed.
    """

    def __init__(self, exact: ExactSolution, go_on: Callable[[], Solution]) -> None:
        self._used: Solution = exact
        self._exact, self._go_on = exact, go_on

    @property
    def name(self) -> str:
        """What it rests on, for display."""
        return self._used.name

    @property
    def exact(self) -> bool:
        """Whether all that was asked for so far is exact."""
        return self._used.exact

    @property
    def error(self) -> float:
        """Bound on the error of the exact solution; beyond it, the estimate of the integrator."""
        return self._used.error

    @property
    def stop(self) -> Stop | None:
        """Where, when and why it ends, once that is known; it does not end where it is continued."""
        stop = self._used.stop
        return None if stop is not None and stop.unknown else stop

    def crossing(self, k: int) -> tuple[float, NDArray[np.float64]]:
        """Time and state (d,) on the surface of crossing k = 1, 2, …; sliding begins and ends with one, too."""
        return self._ask(lambda solution: solution.crossing(k))

    def after(self, k: int) -> NDArray[np.float64]:
        """State (d,) from which the solution continues after crossing k."""
        return self._ask(lambda solution: solution.after(k))

    def entered(self, k: int) -> int:
        """Side entered at crossing k; 0 where sliding begins. Of several surfaces the number of the mode."""
        return self._ask(lambda solution: solution.entered(k))

    def count(self, t: float) -> int:
        """Number of crossings up to time t."""
        return self._ask(lambda solution: solution.count(t))

    def state(self, t: float) -> NDArray[np.float64]:
        """State (d,) at time t."""
        return self._ask(lambda solution: solution.state(t))

    def side(self, t: float) -> int:
        """Side occupied at time t; 0 while sliding. Of several surfaces the number of the mode."""
        return self._ask(lambda solution: solution.side(t))

    def _ask(self, question: Callable[[Solution], T]) -> T:
        """The answer of the exact solution or, where that knows no closed form, of the integrator."""
        try:
            return question(self._used)
        except ValueError:
            if self._used is not self._exact or self._exact.stop is None or not self._exact.stop.unknown:
                raise
            self._used = self._go_on()
            return question(self._used)
