"""Exact piecewise solutions of fields with closed forms, computed in as many digits as they need.

Within a mode a solution is a power series of time in many digits; where its guards vanish, at surfaces or where sliding
ends, is found by bounds that miss no zero. It is computed at two precisions, and at higher ones where these differ by
more than the round-off of a double: so the digits suffice also where a saddle, or many crossings, magnify errors.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import count
from typing import Any, TypeAlias

import numpy as np
import sympy
from numpy.typing import ArrayLike, NDArray

from core.interface.cancelling import Cancel
from core.reference.arcs import ExactArc, Level, Motion, zero_of
from core.reference.laws_in_numbers import followed_field
from core.reference.powers import GUARD
from core.reference.recognition import exact_numbers
from core.reference.solution import MAX_CROSSINGS, ReferenceSolution, State, Stop
from core.reference.transitions import Dynamics, Entry, Transitions
from core.symbolic.expressions import TIME
from core.symbolic.laws import Laws
from core.symbolic.program import Digits, Program

__all__ = ["ExactSolution", "exact_solution"]

#: Precisions in bits, tried two at a time; each includes none of the guard bits.
_BITS = (60, 76, 114, 171, 256, 384, 576)
#: Bits by which a number may be smaller than the others without further digits.
_USUAL = 20
#: (precision in bits, the solution at a lower one or None) -> the solution at that precision.
Begin: TypeAlias = "Callable[[int, ReferenceSolution | None], ReferenceSolution]"
#: Size of a state, as part of the initial one, below which it is zero: the highest precision tells no smaller one.
_ZERO = 2.0**-340
#: Relative rounding of an initial value that is meant to lie on a surface.
_ROUNDED = 2.0**-51
#: Relative difference of two precisions that agree: at most an eighth of half an ulp.
_AGREEMENT = 2.0**-57


def exact_solution(
    laws: Laws,
    t0: float,
    x0: ArrayLike,
    max_crossings: int = MAX_CROSSINGS,
    slides: bool = False,
    cancel: Cancel | None = None,
) -> ExactSolution | None:
    """Exact solution of laws in numbers, or None if no closed form of the field of a region is known.

    Parameters
    ----------
    laws : Laws
        Without parameters: see `laws_in_numbers`.
    t0 : float
    x0 : (d,)
        ValueError if it lies on a surface and the fields do not say which side it enters.
    max_crossings : int
    slides : bool
        Whether it slides along a surface to which both fields point, if a closed form of sliding is known; else it
        ends there.
    cancel : callable () -> bool, or None
        Called at each step; once it returns True, what is asked for raises `Cancelled`.
    """
    motions, names = Motions(laws), {TIME, *laws.x}
    jumps = [u for ways in laws.ways for way in ways for u in way.jump or ()]
    if any(e.free_symbols - names for e in (*laws.surfaces, *jumps)):
        return None
    if any(motions.form(region) is None for region in range(len(laws.regions))):
        return None
    start = np.asarray(x0, dtype=float)
    more = _bits_to_tell_from_zero(laws, start)

    def begin(bits: int, guide: ReferenceSolution | None) -> ReferenceSolution:
        level = Level(Digits.of(bits + more + GUARD), motions.motion, cancel)
        return _solution(level, motions, float(t0), start, max_crossings, slides, guide)

    return ExactSolution(motions, float(t0), _ZERO * float(np.abs(start).max() or 1.0), begin)


def _bits_to_tell_from_zero(laws: Laws, start: NDArray[np.float64]) -> int:
    """Bits by which small coordinates and constants lie below the others: in fewer bits, they would be zero.

    Two precisions that both take them for zero agree, and are wrong where the solution magnifies them.
    """
    sizes = np.log2(np.abs(start[start != 0.0]))
    numbers = {abs(q) for mode in laws.regions for u in mode.field for q in u.atoms(sympy.Rational) if q}
    small: list[float] = [float(-sympy.log(q, 2)) for q in numbers] + (sizes.max(initial=0.0) - sizes).tolist()
    return math.ceil(sum(bits - _USUAL for bits in small if bits > _USUAL))


class Motions:
    """The modes of laws in numbers, derived when they are entered.

    Parameters
    ----------
    laws : Laws
        Without parameters.
    """

    def __init__(self, laws: Laws) -> None:
        self.laws = laws
        self._forms: dict[int, tuple[str | None, tuple[sympy.Expr, ...]]] = {}
        self._motions: dict[int, Motion] = {}
        self._jumps: dict[tuple[int, int], Program] = {}

    @property
    def basis(self) -> str:
        """The closed forms of the regions, and of sliding as far as it was entered, for display."""
        return ", ".join(sorted({name for name, _ in self._forms.values() if name is not None}))

    def form(self, mode: int) -> str | None:
        """Name of the closed form of a mode; None if none is known."""
        return self._form(mode)[0]

    def motion(self, mode: int) -> Motion:
        """A mode whose closed form is known."""
        if mode not in self._motions:
            heights = [exact_numbers(u) for u in self.laws.mode(mode).heights]
            self._motions[mode] = Motion(self._form(mode)[1], heights, self.laws.x)
        return self._motions[mode]

    def jump(self, region: int, guard: int) -> Program:
        """The state after reaching a guard, of time and state."""
        if (region, guard) not in self._jumps:
            after = self.laws.ways[region][guard].jump or self.laws.x
            self._jumps[region, guard] = Program(after, (TIME, *self.laws.x))
        return self._jumps[region, guard]

    def _form(self, mode: int) -> tuple[str | None, tuple[sympy.Expr, ...]]:
        if mode not in self._forms:
            self._forms[mode] = followed_field(self.laws.mode(mode))
        return self._forms[mode]


class ExactSolution:
    """Piecewise smooth solution, computed at two precisions, and at higher ones where these do not agree.

    Parameters
    ----------
    motions : Motions
    t0 : float
    zero : float
        Size of a state that is zero.
    begin : callable
        (precision in bits, the solution at a lower one or None) -> the solution at that precision.
    """

    def __init__(self, motions: Motions, t0: float, zero: float, begin: Begin) -> None:
        self._motions, self._t0, self._zero, self._begin = motions, t0, zero, begin
        self._level = 0
        self._coarse = begin(_BITS[0], None)
        self._fine = begin(_BITS[1], self._coarse)
        self._error = 0.0
        self.exact = True  #: whether all that was asked for so far is right to round-off of a double

    @property
    def name(self) -> str:
        """The closed forms on which it rests; where the highest precision was not enough, also a bound on its error."""
        basis = self._motions.basis
        return f"exact ({basis})" if self.exact else f"power series ({basis}), error {self._error:.1e}"

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
        """Side entered at crossing k, −1 or +1; 0 where sliding begins. Of several surfaces the number of the mode."""
        return int(self._agreed(lambda solution: (solution.entered(k),))[0])

    def count(self, t: float) -> int:
        """Number of crossings up to time t ≥ t0; ValueError past the end of the solution."""
        return int(self._agreed(lambda solution: (solution.count(t),))[0])

    def state(self, t: float) -> NDArray[np.float64]:
        """State (d,) at time t ≥ t0, at a crossing the one after its jump; ValueError past the end of the solution."""
        return as_doubles(self._agreed(lambda solution: (solution.state_in_digits(t),))[0])

    def side(self, t: float) -> int:
        """Side, −1 or +1, occupied at time t ≥ t0, at a crossing the side entered; 0 while sliding.

        Of several surfaces the number of the mode.
        """
        return int(self._agreed(lambda solution: (solution.side(t),))[0])

    def _agreed(self, ask: Callable[[ReferenceSolution], tuple[Any, ...]]) -> tuple[Any, ...]:
        """The result on which two precisions agree, else that of the highest."""
        while True:
            coarse, fine = _outcome(ask, self._coarse), _outcome(ask, self._fine)
            absolute, relative = self._difference(coarse, fine)
            stop = self._fine.stop if isinstance(fine, ValueError) else None
            decided = relative <= _AGREEMENT and not (stop is not None and stop.doubtful)
            if decided or self._level + 2 == len(_BITS):
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
            size = (
                max(float(np.max(np.abs(b))), self._zero)
                if isinstance(b, np.ndarray)
                else float(abs(b)) + abs(self._t0)
            )
            absolute = max(absolute, difference)
            relative = max(relative, (difference / size if size else np.inf) if difference else 0.0)
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
    level: Level,
    motions: Motions,
    t0: float,
    x0: NDArray[np.float64],
    most: int,
    slides: bool,
    guide: ReferenceSolution | None,
) -> ReferenceSolution:
    """The solution at one precision, guided by that at a lower one if there is one."""
    digits, numbers = level.digits, count()

    def start(t: Any, x: State, entry: Entry) -> ExactArc:
        along = guide.arc(next(numbers)) if guide is not None else None
        return ExactArc(level, t, x, entry, along if isinstance(along, ExactArc) else None)

    def evaluate(mode: int, guard: int, t: Any, x: State) -> tuple[Any, Any]:
        return motions.motion(mode).guards[guard].evaluate(digits, t, x)

    def size(mode: int, guard: int, t: Any, x: State) -> float:
        return motions.motion(mode).guards[guard].size(digits, t, x)

    def jump(region: int, guard: int, t: Any, x: State) -> State:
        return np.array(motions.jump(region, guard).run(digits, [t, *x]), dtype=object)

    def obstacle(mode: int) -> str:
        return "" if motions.form(mode) else "it slides along the surface, where no closed form of its field is known"

    zero = float(zero_of(digits))
    dynamics = Dynamics(motions.laws, start, evaluate, jump, size, _ROUNDED, zero, math.sqrt(zero), obstacle)
    t, x = digits.context.mpf(t0), np.array([digits.context.mpf(float(u)) for u in x0], dtype=object)
    return ReferenceSolution("", Transitions(dynamics, slides), t, x, most)
