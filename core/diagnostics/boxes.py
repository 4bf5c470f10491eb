"""Boxes around the way of steps between places, and bounds on expressions over them by interval arithmetic.

Between two places the state follows the cubic with its values and rates there. What is narrower than a thousandth of
the bend of the way between two places stays unseen: so far may the state be from the cubic.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from sympy import Expr, Symbol

from core.kernels.arrays import Floats
from core.symbolic.intervals import Interval, Intervals
from core.symbolic.program import Program

__all__ = ["CUTS", "PARTS", "Bounds", "Cubics", "Way"]

PARTS = 8
"""Parts into which a piece is cut."""

CUTS = 10
"""How often: the shortest piece is 2⁻³⁰ of that between two places."""

#: Distance of the state from the cubic, as part of the largest distance of this from the straight way; over a step.
_BESIDE, _BESIDE_STEP = 2.0**-10, 2.0**-4

Box = tuple[Floats, Floats]
"""Lower and upper ends (p, 1 + d) of boxes of time and state."""


class Way(NamedTuple):
    """Places in k steps, n in each."""

    times: Floats
    """(k, n)."""
    states: Floats
    """(k, n, d)."""
    rates: Floats
    """(k, n, d) of the states in time."""


class Cubics(NamedTuple):
    """Time and state between neighbouring places as cubics of a part from 0 to 1, (m, 1 + d) each."""

    coefficients: Floats
    """(4, m, 1 + d), the lowest power first."""
    bend: Floats
    """Largest second derivative."""

    @classmethod
    def of(cls, way: Way) -> Cubics:
        """Between all neighbouring places, step by step."""
        points = np.concatenate([way.times[..., None], way.states], axis=2)
        slopes = np.concatenate([np.ones_like(way.times)[..., None], way.rates], axis=2)
        span = np.diff(way.times)[..., None]
        begin, go, first, last = points[:, :-1], np.diff(points, axis=1), span * slopes[:, :-1], span * slopes[:, 1:]
        rows = np.stack([begin, first, 3.0 * go - 2.0 * first - last, first + last - 2.0 * go])
        rows = rows.reshape(4, -1, points.shape[2])
        second = 2.0 * np.abs(np.stack([rows[2], rows[2] + 3.0 * rows[3]]))
        return cls(rows, second.max(axis=0))

    @property
    def known(self) -> NDArray[np.bool_]:
        """(m,) which cubics have numbers throughout."""
        return np.asarray(np.isfinite(self.coefficients).all(axis=(0, 2)))

    def boxes_of_all(self) -> Box:
        """Boxes around whole cubics, each of a whole step, from which the state may be farther."""
        return self.boxes(np.arange(len(self.bend)), np.zeros(len(self.bend)), 1.0, _BESIDE_STEP)

    def boxes(self, number: NDArray[np.intp], begin: Floats, width: float, slack: float = _BESIDE) -> Box:
        """Boxes around pieces of cubics that begin at parts (p,)."""
        a, b = (self.at(number, part[:, None]) for part in (begin, begin + width))
        beside = self.bend[number] * (0.125 * (width**2 + slack)) + np.spacing(np.maximum(np.abs(a), np.abs(b)))
        return np.minimum(a, b) - beside, np.maximum(a, b) + beside

    def at(self, number: NDArray[np.intp], part: Floats) -> Floats:
        """Time and state (p, 1 + d) on cubics at parts (p, 1)."""
        c0, c1, c2, c3 = self.coefficients[:, number]
        return np.asarray(c0 + part * (c1 + part * (c2 + part * c3)))


class Bounds:
    """Bounds on expressions over boxes of time and state.

    Parameters
    ----------
    expressions : sequence of expressions
        In the symbols.
    symbols : sequence of symbols
        Time, the d variables, and the parameters.
    parameters : (m,) array
        Values of the parameters.
    """

    def __init__(self, expressions: Sequence[Expr], symbols: Sequence[Symbol], parameters: Floats) -> None:
        self._program, self._arithmetic = Program(list(expressions), symbols), Intervals()
        self._parameters = [Interval(value, value) for value in np.asarray(parameters, dtype=float)[:, None]]

    def over(self, box: Box) -> tuple[Floats, Floats]:
        """Lower and upper bounds (p, n) of n expressions; nan where one is not defined throughout."""
        low, high = box
        inputs = [*map(Interval, low.T, high.T), *self._parameters]
        found = [one.spread(len(low)) for one in self._program.run(self._arithmetic, inputs)]
        return np.stack([one.low for one in found], axis=1), np.stack([one.high for one in found], axis=1)
