"""The first time at which a guard of the mode vanishes, by bounds that leave no root unseen.

A step is cut into pieces. Bounds on the height and its first two rates over a piece decide whether it has a root: the
height is positive throughout; or it is monotonic, or convex, and its signs at both ends or at its minimum tell. A piece
that they do not decide is cut again. Signs are those of the solution in many digits. Source: Moore, Kearfott, Cloud
(2009), ch. 8.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from core.reference.guard import Enclosure

__all__ = ["FirstRoot", "TooLongError", "newton", "zero_between"]

Evaluate: TypeAlias = Callable[[Any], tuple[Any, Any]]  # argument -> a function and its slope

#: Number of equal pieces into which a step, or an undecided piece, is cut.
_PIECES = 12
#: Least length of a piece, as part of the step: over a shorter one bounds in doubles tell no more.
_NARROWEST = 2.0**-44
#: Length of a piece, as part of the step, below which the height in its middle is worked out in many digits.
_NARROW = 2.0**-6
#: Range of the height over the narrowest piece, as part of the largest height, above which bounds tell nothing of it.
_WIDE = 2.0**-20
#: Most pieces of a step that are cut again.
_MAX_CUTS = 1024
#: Part to which a step is to be shortened that has more.
_SHORTER = 2.0**-4
#: |minimum| of the height, as part of the largest, below which more digits could change its sign.
_CLOSE = 2.0**-36
#: Relative correction at which Newton's method in doubles ends; the root is then refined in many digits.
_DOUBLE = 1e-9
#: Most iterations of a root finder: bisection alone takes one a bit.
_MAX_TRIALS = 4000


class TooLongError(Exception):
    """A step is too long for bounds to tell where the height vanishes.

    Parameters
    ----------
    part : float
        To which part of it the step is to be shortened.
    """

    def __init__(self, part: float) -> None:
        super().__init__(f"a step is to be shortened to {part:g} of itself")
        self.part = part


class View(Protocol):
    """The height of a guard and its rate over a step, as functions of the part of it, from 0 to 1."""

    span: float
    """Length of the step in time."""
    shortest: float
    """Time that doubles do not tell from none."""

    def evaluate(self, part: Any) -> tuple[Any, Any]:
        """In many digits."""

    def evaluate_in_doubles(self, part: float) -> tuple[float, float]:
        """In doubles."""

    def enclose(self, edges: NDArray[np.float64]) -> Enclosure:
        """Bounds over the equal pieces between the edges (m + 1,)."""


class FirstRoot:
    """Search for the first root of a height on one step, as the part of the step from 0 to 1.

    Parameters
    ----------
    view
        The height on the step.
    number
        float -> the same number in many digits.
    eps
        Relative correction at which Newton's method ends; a minimum below it, relative to the largest height, is 0.
    leaving
        Whether the step begins where the height vanishes; otherwise it is positive there.
    folded
        Whether its rate vanishes there, too.
    """

    def __init__(
        self, view: View, number: Callable[[float], Any], eps: Any, leaving: bool, folded: bool = False
    ) -> None:
        self._evaluate, self._evaluate_in_doubles, self._enclose = view.evaluate, view.evaluate_in_doubles, view.enclose
        self._span, self._shortest = view.span, view.shortest
        self._number, self._eps, self._leaving, self._folded = number, eps, leaving, folded
        self._largest_height, self._before, self._cuts = 0.0, 1.0, 0
        self.divided = False  #: whether a piece was cut again
        self.undefined = False  #: whether the height is not defined after what is found
        self.decided_by_digits = False  #: whether the result hangs on round-off: more digits could change it

    def find(self, before: float = 1.0) -> Any | None:
        """The first root up to `before`, or None; where bounds in doubles cannot tell, the start of that piece.

        Raises
        ------
        TooLongError
            If they cannot because the step is too long.
        """
        self._before = before
        return self._over(0.0, 1.0)

    def _over(self, low: float, high: float) -> Any | None:
        """First root between two parts of the step, or None."""
        edges = np.linspace(low, high, _PIECES + 1)
        with np.errstate(all="ignore"):
            found = self._enclose(edges)
        self._largest_height = max(self._largest_height, found.largest_height)
        first = edges[:-1] == 0
        rising = found.is_bounded & ((found.rate.low > 0) | (self._folded & first & (found.second_rate.low > 0)))
        safe = rising | ((found.height.low > 0) & ~(self._leaving & first))
        for k in range(_PIECES):
            if not safe[k] and edges[k] <= self._before:
                root = self._piece(found, k, edges[k], edges[k + 1])
                if root is not None:
                    return root
        return None

    def _piece(self, found: Enclosure, k: int, a: float, b: float) -> Any | None:
        from_surface = self._leaving and a == 0
        smooth = found.is_bounded[k] and not from_surface
        if smooth and (found.rate.high[k] < 0 or found.second_rate.high[k] < 0):
            return self._root_if_falling(a, b)
        if smooth and found.second_rate.low[k] > 0:
            return self._root_if_convex(a, b)
        if b - a < _NARROW and not from_surface and self._stays_above(found, k, a, b):
            return None
        if b - a < _NARROWEST:
            if not found.height.high[k] - found.height.low[k] <= _WIDE * self._largest_height:  # or it is not defined
                if self._span * (b - a) > self._shortest:
                    raise TooLongError(max(a, b - a))
                self.undefined = True
            self.decided_by_digits = True
            return self._number(a)  # the surface is touched, or left, tangentially
        self.divided, self._cuts = True, self._cuts + 1
        if self._cuts > _MAX_CUTS:
            raise TooLongError(_SHORTER)
        return self._over(a, b)

    def _stays_above(self, found: Enclosure, k: int, a: float, b: float) -> bool:
        """Whether the height in the middle of a piece, in many digits, exceeds what the rate can take from it."""
        fastest = max(abs(float(found.rate.low[k])), abs(float(found.rate.high[k])))
        return bool(self._evaluate(self._number((a + b) / 2))[0] > fastest * self._span * (b - a))

    def _root_if_falling(self, a: float, b: float) -> Any | None:
        """The root in a piece where the height falls or is concave: there is one if it is not positive at the end."""
        inside, outside = self._number(a), self._number(b)
        return self._root(inside, outside) if self._evaluate(outside)[0] <= 0 else None

    def _root_if_convex(self, a: float, b: float) -> Any | None:
        """The root in a piece where the height is convex."""
        inside, outside = self._number(a), self._number(b)
        if self._evaluate(inside)[1] >= 0:
            return None
        height, rate = self._evaluate(outside)
        if rate <= 0:
            return self._root(inside, outside) if height <= 0 else None
        bottom = zero_between(lambda t: self._evaluate(t)[1], inside, outside, self._eps)
        lowest = self._evaluate(bottom)[0]
        self.decided_by_digits = self.decided_by_digits or abs(lowest) <= _CLOSE * self._largest_height
        if abs(lowest) <= self._eps * self._largest_height:
            return bottom
        return self._root(inside, bottom) if lowest < 0 else None

    def _root(self, inside: Any, outside: Any) -> Any:
        """Root in a bracket, in many digits, by Newton's method from the root in doubles."""
        with np.errstate(all="ignore"):
            low, high = float(inside), float(outside)
            first = newton(self._evaluate_in_doubles, low, high, (low + high) / 2, _DOUBLE)
        return newton(self._evaluate, inside, outside, self._number(first), self._eps)


def newton(evaluate: Evaluate, inside: Any, outside: Any, t: Any, eps: Any) -> Any:
    """Root in a bracket by Newton's method from t, with bisection where an iterate would leave the bracket.

    It ends at a relative correction of `eps`: the next one would be about its square.
    """
    for _ in range(_MAX_TRIALS):
        height, rate = evaluate(t)
        if height > 0:
            inside = t
        else:
            outside = t
        new = t - height / rate if rate != 0 else inside
        if rate < 0 and abs(new - t) <= eps * t:  # even if round-off has led it out of the bracket
            return new
        new = new if inside < new <= outside else (inside + outside) / 2  # the root may be the end of the bracket
        if height == 0 or new in (inside, t):
            return t
        if abs(new - t) <= eps * t:
            return new
        t = new
    return t


def zero_between(of: Callable[[Any], Any], low: Any, high: Any, eps: Any) -> Any:
    """Zero of a function that is negative at `low` and positive at `high`: false position (Illinois).

    It ends at a value of `eps` times the difference of those at the ends, or at a relative correction of `eps`.
    """
    below, above = of(low), of(high)
    least, kept = eps * (above - below), 0
    t = low
    for _ in range(_MAX_TRIALS):
        before, t = t, low - below * (high - low) / (above - below)
        value = of(t)
        if abs(value) <= least or abs(t - before) <= eps * abs(t):
            break
        if value < 0:
            low, below, above, kept = t, value, above / (2 if kept < 0 else 1), -1
        else:
            high, above, below, kept = t, value, below / (2 if kept > 0 else 1), 1
    return t
