"""An exact solution, continued by the Taylor method from where it would slide along the surface."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from core.reference.exact import ExactSolution
from core.reference.solution import Solution
from core.reference.taylor import TaylorSolution

__all__ = ["ContinuedSolution"]

T = TypeVar("T")


class ContinuedSolution:
    """The exact solution as long as it crosses the surface; what it cannot answer is asked of the Taylor method.

    Parameters
    ----------
    exact
        The exact solution, which ends where it would slide.
    slide
        Makes the solution by the Taylor method, which slides; called when it is first needed.
    """

    def __init__(self, exact: ExactSolution, slide: Callable[[], TaylorSolution]) -> None:
        self._used: Solution = exact
        self._exact, self._slide = exact, slide

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
        """Bound on the error of the exact solution; once it slides, the estimate of the Taylor method."""
        return self._used.error

    def crossing(self, k: int) -> tuple[float, NDArray[np.float64]]:
        """Time and state (d,) on the surface of crossing k = 1, 2, …; sliding begins and ends with one, too."""
        return self._ask(lambda solution: solution.crossing(k))

    def after(self, k: int) -> NDArray[np.float64]:
        """State (d,) from which the solution continues after crossing k."""
        return self._ask(lambda solution: solution.after(k))

    def entered(self, k: int) -> int:
        """Side entered at crossing k; 0 where sliding begins."""
        return self._ask(lambda solution: solution.entered(k))

    def state(self, t: float) -> NDArray[np.float64]:
        """State (d,) at time t."""
        return self._ask(lambda solution: solution.state(t))

    def side(self, t: float) -> int:
        """Side occupied at time t; 0 while sliding."""
        return self._ask(lambda solution: solution.side(t))

    def _ask(self, question: Callable[[Solution], T]) -> T:
        """The answer of the exact solution or, once that has ended on the surface, of the Taylor method."""
        try:
            return question(self._used)
        except ValueError:
            if self._used is not self._exact or self._exact.stop is None:
                raise
            self._used = self._slide()
            return question(self._used)
