"""The external solver on both sides of one surface, from plain functions: it shares no expressions with `core`."""

from collections.abc import Callable
from typing import Any

import numpy as np
import sympy

from core.reference import Functions, ReferenceSolution, external_solution, two_sides

SIDES = (-1, 1)


def by_sides(
    f: Callable[[int, float, Any], Any],
    g: Callable[[float, Any], float],
    gdot: Callable[[int, float, Any], float],
    t0: float,
    x0: Any,
    jump: Callable[[float, Any], Any] | None = None,
) -> ReferenceSolution:
    """Solution for f(side, t, x), g(t, x), its rate gdot(side, t, x), and the state jump(t, x) after the surface."""

    def guards(mode: int, t: float, x: Any) -> list[tuple[float, float]]:
        return [(SIDES[mode] * float(g(t, x)), SIDES[mode] * float(gdot(SIDES[mode], t, x)))]

    def land(_region: int, _guard: int, t: float, x: Any) -> Any:
        return x if jump is None else jump(t, x)

    laws = two_sides((), (), sympy.Symbol("g"), (), None if jump is None else ())
    functions = Functions(laws, lambda mode, t, x: f(SIDES[mode], t, x), guards, land)
    return external_solution(functions, t0, np.asarray(x0, dtype=float))
