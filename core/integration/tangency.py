"""Sides entered from a start on the surface with tangent fields: given by the second derivative of g."""

from __future__ import annotations

import sympy

from core.codegen.printing import magnitude
from core.codegen.rounding import rounding_bound
from core.kernels.arrays import Floats
from core.system import PiecewiseSystem

__all__ = ["sides_entered"]

_EPS = 2.0**-52
_MARGIN = 16.0  #: a rate below this many first-order bounds on its rounding counts as zero


def sides_entered(system: PiecewiseSystem, t: float, x: Floats, direction: float) -> list[int]:
    """Sides into which the solutions from a point on the surface may lead.

    A field leads into its side if the rate of g along the run has the sign of the side, or, at a fold, where the rate
    vanishes, the second derivative of g has (Filippov, Differential Equations with Discontinuous Righthand Sides, §19).

    Parameters
    ----------
    t, x
        Time and state (d,), with g(t, x) = 0.
    direction
        Positive where time runs on, negative where it runs back.

    Returns
    -------
    list of int
        −1, +1, both (the solution is not unique), or neither.
    """
    return [side for side in (-1, 1) if _leads_into(system, side, t, x, direction)]


def _leads_into(system: PiecewiseSystem, side: int, t: float, x: Floats, direction: float) -> bool:
    laws = system.laws
    (rate,) = laws.modes[side].guard_rates
    bound = rounding_bound(rate).replace(magnitude, sympy.Abs)
    wanted = (rate, bound, laws.modes[side].rate_of(rate))
    first, doubt, second = laws.evaluate(("fold", side), wanted, t, x, system.parameter_array)
    if abs(first) > _MARGIN * _EPS * doubt:
        return bool(side * first * direction > 0.0)
    return bool(side * second > 0.0)  # the same in both directions of time
