"""Where a start on the surface leads whose field is tangent to it there: told by the second derivative of g."""

from __future__ import annotations

import sympy

from core.codegen.printing import magnitude
from core.codegen.rounding import rounding_bound
from core.kernels.arrays import Floats
from core.system import PiecewiseSystem

__all__ = ["sides_entered"]

_EPS = 2.0**-52
_MARGIN = 16.0  #: of a first-order bound on rounding, within which a rate is taken for zero


def sides_entered(system: PiecewiseSystem, t: float, x: Floats, direction: float) -> list[int]:
    """Sides into which the motion from a place on the surface may lead.

    A field leads into its side if g moves that way to first order, or, at a fold, where the rate of g vanishes, to
    second order (Filippov, Differential Equations with Discontinuous Righthand Sides, §19).

    Parameters
    ----------
    t, x
        Time and state (d,), with g(t, x) = 0.
    direction
        Positive where time runs on, negative where it runs back.

    Returns
    -------
    list of int
        −1, +1, both (the motion is not unique), or neither.
    """
    return [side for side in (-1, 1) if _leads_into(system, side, t, x, direction)]


def _leads_into(system: PiecewiseSystem, side: int, t: float, x: Floats, direction: float) -> bool:
    laws = system.laws
    rate = laws.modes[side].g_dot
    bound = rounding_bound(rate).replace(magnitude, sympy.Abs)
    wanted = (rate, bound, laws.modes[side].rate_of(rate))
    first, doubt, second = laws.evaluate(("fold", side), wanted, t, x, system.parameter_array)
    if abs(first) > _MARGIN * _EPS * doubt:
        return bool(side * first * direction > 0.0)
    return bool(side * second > 0.0)  # in time that runs back, too
