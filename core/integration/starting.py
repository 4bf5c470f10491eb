"""Where a run begins: the region of its initial value, and the regions into which the fields lead from a surface."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from core.codegen.rounding import rounding_bound, with_roundings
from core.integration.corner import Rate, WayOut, way_out_of
from core.kernels.arrays import Floats
from core.symbolic.laws import Laws
from core.system import PiecewiseSystem

__all__ = ["Leaning", "Place", "first_place", "leaning", "onto_surfaces", "regions_entered", "sliding_begun", "way_out"]

_EPS = 2.0**-52
_MARGIN = 16.0  #: a value below this many first-order bounds on its rounding counts as zero


_PARALLEL = 2.0**-20  #: surfaces at a smaller angle than this, in radians, are not told apart


class Place(NamedTuple):
    """Where a state lies among the surfaces."""

    region: int | None
    """Number of a region in which, or at the boundary of which, it lies; None where none is declared."""
    guard: int = 0
    """Guard of that region at which it lies; 0 if it lies at none."""
    corner: tuple[int, ...] = ()
    """Numbers of the surfaces on which it lies, if more than one."""


def first_place(system: PiecewiseSystem, t: float, x: Floats) -> Place:
    """Find the region of an initial value.

    Where regions have names, it is the first of which all guards are positive or zero.
    """
    laws = system.laws
    value, bound = _values(system, t, x)
    met = [k for k, (height, size) in enumerate(zip(value, bound, strict=True)) if abs(height) <= _EPS * size]
    if laws.regions[0].sides and not met:
        return Place(laws.regions_by_sides.get(tuple(1 if u > 0 else -1 for u in value)))
    for k, ways in enumerate(laws.ways):
        if all(way.surface in met or way.sign * value[way.surface] > 0 for way in ways):
            if laws.regions[0].sides and len(met) > 1:
                return Place(k, corner=tuple(met))
            return Place(k, next((n for n, way in enumerate(ways) if way.surface in met), 0))
    return Place(None)


def _values(system: PiecewiseSystem, t: float, x: Floats) -> tuple[list[float], list[float]]:
    """All switching functions at a state, and for each a bound on its rounding, in units of eps."""
    laws = system.laws
    both = laws.numbers("surfaces", with_roundings(laws.surfaces), t, x.tolist(), system.parameter_array)
    return both[: len(laws.surfaces)], both[len(laws.surfaces) :]


def way_out(system: PiecewiseSystem, t: float, x: Floats, surfaces: tuple[int, ...], direction: float) -> WayOut:
    """Where a run goes on from the point at which several surfaces meet.

    Parameters
    ----------
    t, x
        Time and state (d,) of the corner.
    surfaces
        Numbers of the surfaces that meet there.
    direction
        Positive where time runs on, negative where it runs back.
    """
    laws = system.laws

    def rate(region: int, surface: int) -> Rate:
        along = laws.regions[region].rate_of(laws.surfaces[surface])
        wanted = (along, rounding_bound(along))
        value, bound = laws.numbers(("rate", region, surface), wanted, t, x.tolist(), system.parameter_array)
        return Rate(np.sign(direction) * value, _MARGIN * _EPS * bound)

    heights, _ = _values(system, t, x)
    return way_out_of(laws, [int(np.sign(height)) for height in heights], surfaces, rate)


def onto_surfaces(system: PiecewiseSystem, t: float, x: Floats, surfaces: tuple[int, ...]) -> Floats:
    """The nearest state to one at a corner, (d,), at which all switching functions of the corner vanish to rounding.

    The loop has put the state on the surface that it met first. The others vanish there to the rounding of the step
    that led there, which near the origin is larger than that of the state. Where surfaces are nearly parallel, the
    state is moved only across the directions in which they are not. No state is nearer to an instant than
    another.
    """
    laws, d = system.laws, system.dimension
    surfaces = tuple(k for k in surfaces if k not in laws.instants)
    wanted = tuple(u for k in surfaces for u in (laws.surfaces[k], *(laws.surfaces[k].diff(v) for v in laws.x)))
    found = laws.numbers(("corner", *surfaces), wanted, t, x.tolist(), system.parameter_array)
    rows = np.array(found).reshape(len(surfaces), 1 + d)
    sizes = np.abs(rows[:, 1:]).max(axis=1, keepdims=True)
    if not (np.isfinite(rows).all() and (sizes > 0.0).all()):
        return x
    rows = rows / sizes
    return np.asarray(x - np.linalg.lstsq(rows[:, 1:], rows[:, 0], rcond=_PARALLEL)[0])


def regions_entered(
    system: PiecewiseSystem, region: int, guard: int, t: float, x: Floats, direction: float
) -> list[tuple[int, int]]:
    """Regions on both sides of a surface into which the solutions from a point on it may lead.

    A field leads into its region if the rate of g along the run has the sign of that side, or, at a fold, where the
    rate vanishes, the second derivative of g has (Filippov, Differential Equations with Discontinuous Righthand Sides,
    §19).

    Parameters
    ----------
    region, guard
        Region on one side, and its guard at which the point lies.
    t, x
        Time and state (d,), with g(t, x) = 0.
    direction
        Positive where time runs on, negative where it runs back.

    Returns
    -------
    list of (region, guard)
        One side, both (the solution is not unique), or neither; with the guard at which the point lies.
    """
    way = system.laws.ways[region][guard]
    sides = [(region, guard)]
    if way.to is not None and way.back is not None:
        sides.append((way.to, way.back))
    ordered = sorted(sides, key=lambda side: system.laws.ways[side[0]][side[1]].sign)
    return [side for side in ordered if leaning(system, *side, t, x, direction).way > 0]


def sliding_begun(
    system: PiecewiseSystem, region: int, guard: int, t: float, x: Floats, direction: float
) -> tuple[int, int] | None:
    """Mode of sliding that begins at a point on a surface to which both fields lead, one of them tangentially.

    There Filippov's field is the tangent one, so that the second derivative of g along it, which leads back to the
    surface, is the rate with which this field comes to point there.

    Parameters
    ----------
    region, guard, t, x, direction
        As of `regions_entered`.

    Returns
    -------
    (mode, guard) or None
        Its number, and the number of its guard that vanishes there: the rate of g with the tangent field.
    """
    way = system.laws.ways[region][guard]
    if way.to is None or way.back is None or way.sliding is None:
        return None
    sides = [(region, guard), (way.to, way.back)]
    below_and_above = sides if way.sign < 0 else sides[::-1]
    leans = [leaning(system, *side, t, x, direction) for side in below_and_above]
    folded = [k for k, lean in enumerate(leans) if lean.folded]
    return (way.sliding, folded[0]) if all(lean.way < 0 for lean in leans) and len(folded) == 1 else None


class Leaning(NamedTuple):
    """Where the field of a mode leads from the zero of one of its guards."""

    way: int
    """1: into the mode; −1: out of it; 0: two derivatives of the guard do not tell."""
    folded: bool
    """Whether the rate is zero to rounding, so that the second derivative tells."""


def leaning(system: PiecewiseSystem, number: int, guard: int, t: float, x: Floats, direction: float) -> Leaning:
    """Find where the field of a mode, given by its number, leads from the zero of a guard; see `regions_entered`."""
    laws: Laws = system.laws
    mode = laws.mode(number).written
    sign, rate = mode.signs[guard], mode.guard_rates[guard]
    wanted = (rate, rounding_bound(rate), mode.rate_of(rate))
    first, doubt, second = laws.evaluate(("fold", number, guard), wanted, t, x, system.parameter_array)
    if abs(first) > _MARGIN * _EPS * doubt:
        return Leaning(int(np.sign(sign * first * direction)), False)
    return Leaning(int(np.sign(np.nan_to_num(sign * second))), True)  # the same in both directions of time
