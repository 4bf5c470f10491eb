"""The first time at which a solution reaches the surface, by bounds that leave no root unseen.

A step is cut into pieces. Bounds on g, ġ and g̈ over a piece decide it: g is positive all over it; or g is monotonic or
of one curvature, so that signs at its ends, or at its lowest point, tell. A piece that they do not decide is cut again.
Signs are those of the solution to many digits. Source: Moore, Kearfott, Cloud (2009), ch. 8.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from core.reference.surface import Enclosure

__all__ = ["FirstRoot", "newton", "zero_between"]

Look: TypeAlias = Callable[[Any], tuple[Any, Any]]  # of a number: a function and its slope

_PIECES = 12  # that a step or an undecided piece is cut into
_NARROWEST = 2.0**-44  # part of a step: bounds in doubles tell no more
_CLOSE = 2.0**-36  # lowest point, as part of the highest, that digits may decide
_DOUBLE = 1e-9  # Newton's method in doubles has converged
_MAX_TRIALS = 4000  # bisection alone takes one a bit


class View(Protocol):
    """side·g (positive inside) and its rate over a step, in parts of it from 0 to 1."""

    def look(self, part: Any) -> tuple[Any, Any]:
        """To many digits."""

    def glance(self, part: float) -> tuple[float, float]:
        """In doubles."""

    def enclose(self, edges: NDArray[np.float64]) -> Enclosure:
        """Bounds over the equal pieces between the edges (m + 1,)."""


class FirstRoot:
    """Search of one step for the first part of it, from 0 to 1, at which side·g vanishes.

    Parameters
    ----------
    view
    number
        A float as a number to many digits.
    eps
        Relative size of what is touched, and below which Newton's method has converged.
    leaving
        Whether the step begins on the surface; else side·g is positive there.
    """

    def __init__(self, view: View, number: Callable[[float], Any], eps: Any, leaving: bool) -> None:
        self._look, self._glance, self._enclose = view.look, view.glance, view.enclose
        self._number, self._eps, self._leaving = number, eps, leaving
        self._deepest = 0.0
        self.divided = False  #: whether a piece had to be cut again
        self.close = False  #: whether digits decided how the surface was reached, or passed

    def find(self) -> Any | None:
        """The first root, None if there is none; where bounds in doubles cannot tell, that place."""
        return self._over(0.0, 1.0)

    def _over(self, low: float, high: float) -> Any | None:
        """First root between two parts of the step, or None."""
        edges = np.linspace(low, high, _PIECES + 1)
        with np.errstate(all="ignore"):
            found = self._enclose(edges)
        self._deepest = max(self._deepest, found.deepest)
        safe = (found.rate.low > 0) | ((found.height.low > 0) & ~(self._leaving & (edges[:-1] == 0)))
        for k in range(_PIECES):
            if not safe[k]:
                root = self._piece(found, k, edges[k], edges[k + 1])
                if root is not None:
                    return root
        return None

    def _piece(self, found: Enclosure, k: int, a: float, b: float) -> Any | None:
        from_surface = self._leaving and a == 0
        if not from_surface and (found.rate.high[k] < 0 or found.bend.high[k] < 0):
            return self._fallen(a, b)
        if not from_surface and found.bend.low[k] > 0:
            return self._valley(a, b)
        if b - a < _NARROWEST:
            self.close = True
            return self._number(a)  # touched, or left, tangentially
        self.divided = True
        return self._over(a, b)

    def _fallen(self, a: float, b: float) -> Any | None:
        """The root in a piece where there is one if, and only if, side·g is not positive at its end."""
        inside, outside = self._number(a), self._number(b)
        return self._root(inside, outside) if self._look(outside)[0] <= 0 else None

    def _valley(self, a: float, b: float) -> Any | None:
        """The root in a piece where side·g is convex."""
        inside, outside = self._number(a), self._number(b)
        if self._look(inside)[1] >= 0:
            return None
        height, rate = self._look(outside)
        if rate <= 0:
            return self._root(inside, outside) if height <= 0 else None
        bottom = zero_between(lambda t: self._look(t)[1], inside, outside, self._eps)
        lowest = self._look(bottom)[0]
        self.close = self.close or abs(lowest) <= _CLOSE * self._deepest
        if abs(lowest) <= self._eps * self._deepest:
            return bottom
        return self._root(inside, bottom) if lowest < 0 else None

    def _root(self, inside: Any, outside: Any) -> Any:
        """Root in a bracket, to the last digit: from the one in doubles."""
        with np.errstate(all="ignore"):
            first = newton(self._glance, float(inside), float(outside), (float(inside) + float(outside)) / 2, _DOUBLE)
        return newton(self._look, inside, outside, self._number(first), self._eps)


def newton(look: Look, inside: Any, outside: Any, t: Any, eps: Any) -> Any:
    """Root in a bracket: Newton's method from t, bisecting where it would leave.

    It ends where a correction is `eps` of the root: the next one would be about the square of that.
    """
    for _ in range(_MAX_TRIALS):
        height, rate = look(t)
        if height > 0:
            inside = t
        else:
            outside = t
        new = t - height / rate if rate != 0 else inside
        new = new if inside < new < outside else (inside + outside) / 2
        if height == 0 or new in (inside, outside):
            return t
        if abs(new - t) <= eps * t:
            return new
        t = new
    return t


def zero_between(of: Callable[[Any], Any], low: Any, high: Any, eps: Any) -> Any:
    """Zero of a function that rises through it between two numbers: false position (Illinois).

    It ends where the function is `eps` of what it is at the ends, or two trials are as close.
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
