"""Where a run begins: the region of its initial value, and the regions into which the fields lead from a surface."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
import sympy

from core.codegen.printing import magnitude
from core.codegen.rounding import rounding_bound
from core.kernels.arrays import Floats
from core.symbolic.laws import Laws
from core.system import PiecewiseSystem

__all__ = ["Leaning", "Place", "agreed_region", "first_place", "leaning", "regions_entered", "way_along", "way_out"]

_EPS = 2.0**-52
_MARGIN = 16.0  #: a value below this many first-order bounds on its rounding counts as zero


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
    """All switching functions at a state, and for each the size of which rounding the state changes it by eps."""
    laws = system.laws
    both = laws.numbers("surfaces", laws.surfaces_and_roundings, t, x.tolist(), system.parameter_array)
    return both[: len(laws.surfaces)], both[len(laws.surfaces) :]


def way_out(system: PiecewiseSystem, t: float, x: Floats, surfaces: tuple[int, ...], direction: float) -> int | None:
    """Region into which every field around a corner leads, out of the point at which several surfaces meet.

    Parameters
    ----------
    t, x
        Time and state (d,) of the corner.
    surfaces
        Numbers of the surfaces that meet there.
    direction
        Positive where time runs on, negative where it runs back.

    Returns
    -------
    int or None
        None where the fields of the regions around do not all lead to the same declared region.
    """
    heights, _ = _values(system, t, x)
    sides = [int(np.sign(height)) for height in heights]

    def rate(region: int, surface: int) -> float:
        return direction * _rate(system, region, surface, t, x)

    return agreed_region(system.laws, sides, surfaces, rate)


def agreed_region(
    laws: Laws, sides: Sequence[int], surfaces: Sequence[int], rate: Callable[[int, int], float]
) -> int | None:
    """Region into which the fields of all regions around a corner lead.

    Parameters
    ----------
    sides
        Signs of all switching functions near the corner; those of the surfaces that meet there do not matter.
    surfaces
        Numbers of the surfaces that meet there.
    rate
        (region, surface) -> rate of the switching function with the field of the region; 0 where it is not clear.

    Returns
    -------
    int or None
        As from `way_out`.
    """
    found: set[tuple[int, ...]] = set()
    numbers, around = laws.regions_by_sides, list(sides)
    for signs in product((-1, 1), repeat=len(surfaces)):
        for surface, sign in zip(surfaces, signs, strict=True):
            around[surface] = sign
        region = numbers.get(tuple(around))
        if region is not None:
            onward = list(around)
            for surface in surfaces:
                onward[surface] = int(np.sign(rate(region, surface)))
            found.add(tuple(onward))
    return numbers.get(found.pop()) if len(found) == 1 else None


def way_along(system: PiecewiseSystem, mode: int, surface: int, t: float, x: Floats, direction: float) -> int | None:
    """Mode of sliding in which a run that slides along one surface goes on beyond another one.

    Parameters
    ----------
    mode
        Number of the mode in which it slides.
    surface
        Number of the other surface, which it has reached.
    t, x
        Time and state (d,) there.
    direction
        Positive where time runs on, negative where it runs back.

    Returns
    -------
    int or None
        None unless both fields beyond point to the surface along which it slides, and the field of sliding there leads
        on; or where a region beyond is not declared.
    """
    laws = system.laws
    number = laws.sliding_beyond(mode, surface)
    if number is None:
        return None
    sliding = laws.mode(number)
    sign = sliding.sides[surface]
    way = 1 if direction > 0 else -1
    rate = sign * sliding.rate_of(laws.surfaces[surface])
    heights = [way * u for u in (*sliding.heights[:2], rate)]
    bounds = [rounding_bound(h).replace(magnitude, sympy.Abs) for h in heights]
    both = laws.numbers(("beyond", number, surface, way), (*heights, *bounds), t, x.tolist(),
                        system.parameter_array)  # fmt: skip
    clear = all(height > _MARGIN * _EPS * doubt for height, doubt in zip(both[:3], both[3:], strict=True))
    return number if clear else None


def _rate(system: PiecewiseSystem, region: int, surface: int, t: float, x: Floats) -> float:
    """Rate of a switching function with the field of a region; 0 where it is within rounding of that."""
    rate = system.laws.regions[region].rate_of(system.laws.surfaces[surface])
    wanted = (rate, rounding_bound(rate).replace(magnitude, sympy.Abs))
    value, doubt = system.laws.numbers(("rate", region, surface), wanted, t, x.tolist(), system.parameter_array)
    return value if abs(value) > _MARGIN * _EPS * doubt else 0.0


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


class Leaning(NamedTuple):
    """Where the field of a mode leads from the zero of one of its guards."""

    way: int
    """1: into the mode; −1: out of it; 0: two derivatives of the guard do not tell."""
    folded: bool
    """Whether the rate is zero to rounding, so that the second derivative tells."""


def leaning(system: PiecewiseSystem, number: int, guard: int, t: float, x: Floats, direction: float) -> Leaning:
    """Find where the field of a mode, given by its number, leads from the zero of a guard; see `regions_entered`."""
    laws: Laws = system.laws
    mode = laws.mode(number)
    sign, rate = mode.signs[guard], mode.guard_rates[guard]
    wanted = (rate, rounding_bound(rate).replace(magnitude, sympy.Abs), mode.rate_of(rate))
    first, doubt, second = laws.evaluate(("fold", number, guard), wanted, t, x, system.parameter_array)
    if abs(first) > _MARGIN * _EPS * doubt:
        return Leaning(int(np.sign(sign * first * direction)), False)
    return Leaning(int(np.sign(np.nan_to_num(sign * second))), True)  # the same in both directions of time
