"""Crossings of a piecewise solution whose flow is known on each side in closed form: what the tests compare with."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq

Flow = Callable[[int, float, np.ndarray], np.ndarray]
Height = Callable[[float, np.ndarray], float]


def crossings(flow: Flow, height: Height, x0: tuple[float, ...], side: int, count: int, stride: float = 0.02):
    """The first crossings of a solution that starts off the surface, and crosses it transversally each time.

    Parameters
    ----------
    flow : callable (side, s, x) -> (d,)
        State after a time s from x, exactly.
    height : callable (t, x) -> float
        g.
    side
        Side that x0 lies on.
    stride
        A time shorter than any visit of a side: how far apart g is looked at.

    Returns
    -------
    (count,) times and (count, d) states
    """
    t, x, found = 0.0, np.array(x0, dtype=float), []
    for _ in range(count):
        arc = Arc(flow, height, side, t, x)
        s = arc.first_zero(stride)
        t, x, side = t + s, flow(side, s, x), -side
        found.append((t, x))
    return np.array([t for t, _ in found]), np.array([x for _, x in found])


class Arc:
    """One visit of a side."""

    def __init__(self, flow: Flow, height: Height, side: int, t: float, x: np.ndarray) -> None:
        self.flow, self.height, self.side, self.t, self.x = flow, height, side, t, x

    def above(self, s: float) -> float:
        """Height over the surface on the side occupied, after a time s."""
        return self.side * self.height(self.t + s, self.flow(self.side, s, self.x))

    def first_zero(self, stride: float) -> float:
        """Time until the surface is met again."""
        s = stride
        while self.above(s) > 0.0:
            s += stride
        return brentq(self.above, s - stride if s > stride else 1e-3 * stride, s, xtol=1e-15, rtol=1e-15)
