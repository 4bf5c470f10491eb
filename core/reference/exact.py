"""Exact piecewise solutions of fields with closed forms, computed in as many digits as they need.

Between crossings a solution is a power series of time in many digits; crossings are found by bounds that miss none. It
is computed at two precisions, and at higher ones where these differ by more than the round-off of a double: so the
digits suffice also where a saddle, or many crossings, magnify errors.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import count
from typing import Any, TypeAlias

import numpy as np
import sympy
from numpy.typing import ArrayLike, NDArray

from core.interface.cancelling import Cancel
from core.reference.arcs import ExactArc, Level
from core.reference.powers import GUARD, Field
from core.reference.program import Digits, Program
from core.reference.recognition import closed_form, exact_numbers
from core.reference.solution import MAX_CROSSINGS, Dynamics, ReferenceSolution, State, Stop, first_arc
from core.reference.surface import Surface
from core.symbolic.expressions import TIME

__all__ = ["ExactSolution", "exact_solution"]

#: Precisions in bits, tried two at a time; each includes none of the guard bits.
_BITS = (60, 76, 114, 171, 256, 384, 576)
#: (precision in bits, the solution at a lower one or None) -> the solution at that precision.
Begin: TypeAlias = "Callable[[int, ReferenceSolution | None], ReferenceSolution]"
#: Relative difference of two precisions that agree: at most an eighth of half an ulp.
_AGREEMENT = 2.0**-57


def exact_solution(
    field_minus: tuple[sympy.Expr, ...],
    field_plus: tuple[sympy.Expr, ...],
    g: sympy.Expr,
    variables: tuple[sympy.Symbol, ...],
    t0: float,
    x0: ArrayLike,
    max_crossings: int = MAX_CROSSINGS,
    jump: tuple[sympy.Expr, ...] | None = None,
    cancel: Cancel | None = None,
) -> ExactSolution | None:
    """Exact solution of x' = field_± (x), or None if no closed form of one of the fields is known.

    Parameters
    ----------
    field_minus, field_plus : tuple of d expressions
        In the variables only.
    g : expression
        In the variables and time.
    variables : tuple of d symbols
    t0 : float
    x0 : (d,)
        ValueError if it lies on the surface and the two fields do not say which side it enters.
    max_crossings : int
    jump : tuple of d expressions, or None
        In the variables and time: the state after reaching the surface.
    cancel : callable () -> bool, or None
        Called at each step; once it returns True, what is asked for raises `Cancelled`.
    """
    below, above = closed_form(field_minus, variables), closed_form(field_plus, variables)
    names = {TIME, *variables}
    if below is None or above is None or any(e.free_symbols - names for e in (g, *(jump or ()))):
        return None
    fields = {side: tuple(map(exact_numbers, f)) for side, f in ((-1, field_minus), (1, field_plus))}
    surface = Surface(exact_numbers(g), fields, variables)
    flows = {side: Field(f, variables) for side, f in fields.items()}
    jumps = None if jump is None else Program([exact_numbers(u) for u in jump], (TIME, *variables))
    start = np.asarray(x0, dtype=float)

    def begin(bits: int, guide: ReferenceSolution | None) -> ReferenceSolution:
        level = Level(Digits.of(bits + GUARD), flows, surface, cancel)
        return _solution(level, jumps, float(t0), start, max_crossings, guide)

    return ExactSolution(", ".join(sorted({below, above})), float(t0), begin)


class ExactSolution:
    """Piecewise smooth solution, computed at two precisions, and at higher ones where these do not agree.

    Parameters
    ----------
    basis : str
        The closed forms of its fields, for display.
    t0 : float
    begin : callable
        (precision in bits, the solution at a lower one or None) -> the solution at that precision.
    """

    def __init__(self, basis: str, t0: float, begin: Begin) -> None:
        self._basis, self._t0, self._begin = basis, t0, begin
        self._level = 0
        self._coarse = begin(_BITS[0], None)
        self._fine = begin(_BITS[1], self._coarse)
        self._error = 0.0
        self.exact = True  #: whether all that was asked for so far is right to round-off of a double

    @property
    def name(self) -> str:
        """The closed forms on which it rests; where the highest precision was not enough, also a bound on its error."""
        return f"exact ({self._basis})" if self.exact else f"power series ({self._basis}), error {self._error:.1e}"

    @property
    def error(self) -> float:
        """Bound on the error of all times and states asked for so far, before they are rounded to double.

        The largest difference between the last two precisions: the error of the lower one, far above that of the
        higher one, whose results are returned.
        """
        return self._error

    @property
    def stop(self) -> Stop | None:
        """Where, when and why it ends, once that is known."""
        return self._fine.stop

    def crossing(self, k: int) -> tuple[float, NDArray[np.float64]]:
        """Time and state (d,) on the surface of crossing k = 1, 2, …; ValueError if the solution has fewer."""
        t, x, _ = self._agreed(lambda solution: solution.crossing_in_digits(k))
        return float(t), as_doubles(x)

    def after(self, k: int) -> NDArray[np.float64]:
        """State (d,) from which the solution continues after crossing k: on the surface, or after the jump."""
        return as_doubles(self._agreed(lambda solution: solution.crossing_in_digits(k))[2])

    def entered(self, k: int) -> int:
        """Side entered at crossing k, −1 or +1."""
        return int(self._agreed(lambda solution: (solution.entered(k),))[0])

    def state(self, t: float) -> NDArray[np.float64]:
        """State (d,) at time t ≥ t0, at a crossing the one after its jump; ValueError past the end of the solution."""
        return as_doubles(self._agreed(lambda solution: (solution.state_in_digits(t),))[0])

    def side(self, t: float) -> int:
        """Side, −1 or +1, occupied at time t ≥ t0; at a crossing the side entered."""
        return int(self._agreed(lambda solution: (solution.side(t),))[0])

    def _agreed(self, ask: Callable[[ReferenceSolution], tuple[Any, ...]]) -> tuple[Any, ...]:
        """The result on which two precisions agree, else that of the highest."""
        while True:
            coarse, fine = _outcome(ask, self._coarse), _outcome(ask, self._fine)
            absolute, relative = self._difference(coarse, fine)
            if relative <= _AGREEMENT or self._level + 2 == len(_BITS):
                break
            self._level += 1
            self._coarse, self._fine = self._fine, self._begin(_BITS[self._level + 1], self._fine)
        self.exact = self.exact and relative <= _AGREEMENT
        self._error = max(self._error, absolute)
        if isinstance(fine, ValueError):
            raise fine
        agreed: tuple[Any, ...] = fine
        return agreed

    def _difference(self, coarse: Any, fine: Any) -> tuple[float, float]:
        """Largest difference of two outcomes, absolute and relative to the time or to the size of the state."""
        if isinstance(coarse, ValueError) or isinstance(fine, ValueError):
            return (0.0, 0.0) if isinstance(coarse, ValueError) and isinstance(fine, ValueError) else (np.inf, np.inf)
        absolute = relative = 0.0
        for a, b in zip(coarse, fine, strict=True):
            difference = float(np.max(np.abs(b - a)))
            size = float(np.max(np.abs(b))) if isinstance(b, np.ndarray) else float(abs(b)) + abs(self._t0)
            absolute = max(absolute, difference)
            relative = max(relative, difference / size if difference else 0.0)
        return absolute, relative


def as_doubles(x: State) -> NDArray[np.float64]:
    """The state (d,) in doubles, each number rounded once."""
    return np.array([float(u) for u in x])


def _outcome(ask: Callable[[ReferenceSolution], tuple[Any, ...]], solution: ReferenceSolution) -> Any:
    try:
        return ask(solution)
    except ValueError as end:
        return end


def _solution(
    level: Level, jumps: Program | None, t0: float, x0: NDArray[np.float64], most: int, guide: ReferenceSolution | None
) -> ReferenceSolution:
    """The solution at one precision, guided by that at a lower one if there is one."""
    digits, surface, numbers = level.digits, level.surface, count()

    def start(t: Any, x: State, side: int, on_surface: bool) -> ExactArc:
        along = guide.arc(next(numbers)) if guide is not None else None
        return ExactArc(level, t, x, side, on_surface, along if isinstance(along, ExactArc) else None)

    def height(t: Any, x: State) -> Any:
        return surface.evaluate(digits, 1, t, x)[0]

    def rate(side: int, t: Any, x: State) -> Any:
        return surface.evaluate(digits, side, t, x)[1]

    def land(t: Any, x: State) -> State:
        return np.array(jumps.run(digits, [t, *x]) if jumps else x, dtype=object)

    dynamics = Dynamics(start, height, rate, land if jumps else None)
    t, x = digits.context.mpf(t0), np.array([digits.context.mpf(float(u)) for u in x0], dtype=object)
    return ReferenceSolution("", dynamics, first_arc(dynamics, t, x, surface.round_off(digits, t, x)), most)
