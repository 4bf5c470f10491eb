"""Why the laws do not tell where to go on from a surface, other than by a touch."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from sympy import Expr

from core.codegen.rounding import rounding_bound
from core.integration.explained import Explained
from core.integration.recorded import Point
from core.kernels.arrays import Floats
from core.symbolic.expressions import TIME
from core.system import PiecewiseSystem
from core.transition.records import NO_MODE

__all__ = ["AtSurface", "at_surface"]

#: A value is known if it exceeds its rounding by this factor.
_ROUNDING = 16.0 * float(np.finfo(float).eps)
#: Largest g′²/(|g g″|) at a multiple zero: 2 at a double one, 1.5 at a triple one; the rest is for the rounding of g.
_MULTIPLE = 4.0


class AtSurface(Explained):
    """Why the laws do not tell where to go on from a surface; each with what to do about it."""

    MULTIPLE = (
        "the gradient of g vanishes on the surface g = 0 there, as far as rounding shows, so that rates of g do not "
        "tell whether the solution crosses it",
        "Write g such that it has a simple zero on the surface: h for h**3. If it has one elsewhere on the surface, "
        "change the initial condition slightly.",
    )
    MET = (
        "the trajectory meets the surface where the field beyond is tangent to it, or vanishes: how the solution goes "
        "on is told by higher derivatives, which a run does not ask for",
        "No step size helps: change the initial condition or a parameter slightly, or begin beyond the surface.",
    )
    BEGINS = (
        "the initial value is on the surface, and a field is tangent to it there, or vanishes: rates do not tell how "
        "the solution goes on",
        "Start off the surface, on the side you want.",
    )
    RESTS = (
        "the state is on the surface, where all fields vanish, and rests there",
        "For a solution that moves, start elsewhere.",
    )


def at_surface(system: PiecewiseSystem, last: Point, *, forward: bool) -> AtSurface | None:
    """What is known of g and of the fields where a run ends as if it touched a surface; None if it may touch it."""
    laws, begins = system.laws, last.mode == NO_MODE
    fields = [laws.mode(mode).written.field for mode in range(len(laws.regions))]
    if not laws.names_time and not any(_known(system, last, mode, field)[1].any() for mode, field in enumerate(fields)):
        return AtSurface.RESTS
    mode = 0 if begins else last.mode
    law = laws.mode(mode).written
    met = int(np.argmin(np.abs(_known(system, last, mode, law.heights)[0])))
    if _has_multiple_zero(system, last, mode, law.heights[met]):
        return AtSurface.MULTIPLE
    if begins:
        return AtSurface.BEGINS
    rate, known = _known(system, last, mode, (law.rate_of(law.heights[met]),))
    arrives = bool(known[0]) and float(rate[0]) * (1.0 if forward else -1.0) < 0.0
    return AtSurface.MET if arrives else None


def _has_multiple_zero(system: PiecewiseSystem, last: Point, mode: int, g: Expr) -> bool:
    """Whether g is as near a multiple zero as its rounding shows.

    Along its gradient, in s, g = sᵏ has g′² = k/(k − 1) |g g″|, wherever beside the zero the state is. At a simple zero
    g is no more than its rounding, and g′² exceeds this by far.
    """
    along = (TIME, *system.laws.x)
    slopes = tuple(g.diff(v) for v in along)
    bends = tuple(slope.diff(v) for slope in slopes for v in along)
    height = abs(float(_values(system, last, ("g", mode, g), (g,))[0]))
    noise = _ROUNDING * float(_values(system, last, ("rounding", mode, g), (rounding_bound(g),))[0])
    slope = _values(system, last, ("slopes", mode, g), slopes)
    bend = _values(system, last, ("bends", mode, g), bends).reshape(len(along), len(along))
    largest = float(np.abs(slope).max())
    if not 0.0 < largest < np.inf:
        return largest == 0.0
    direction = slope / largest
    curvature, depth = abs(float(direction @ (bend / largest) @ direction)), max(height, noise) / largest
    return float(direction @ direction) ** 2 <= _MULTIPLE * curvature * depth


def _known(
    system: PiecewiseSystem, last: Point, mode: int, expressions: tuple[Expr, ...]
) -> tuple[Floats, NDArray[np.bool_]]:
    """Values of expressions of a mode where the run ended, and whether they are more than their rounding."""
    values = _values(system, last, ("at its end", mode, expressions), expressions)
    bounds = tuple(map(rounding_bound, expressions))
    return values, np.abs(values) > _ROUNDING * _values(system, last, ("rounding", mode, expressions), bounds)


def _values(system: PiecewiseSystem, last: Point, key: object, expressions: tuple[Expr, ...]) -> Floats:
    """Values of expressions where the run ended."""
    values: Floats = system.laws.evaluate(key, expressions, [last.t], [last.x], system.parameter_array)[0]
    return values
