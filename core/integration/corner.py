r"""Where a solution goes on from a corner, at which several surfaces meet.

Around a corner of two surfaces lie four regions, and between them four half-surfaces. A solution leaves the corner into
a region whose own field points into it, or along a half-surface to which both fields beside it point, and along which
Filippov's field leads away from the corner. Only the rates of the two switching functions matter, in the plane as in
more dimensions.

Where there is exactly one such exit, the solution leaves by it, unless it may stay where the surfaces meet. That it
does not is shown with the field at the corner,

    f(u, v) = ¼ Σ (1 ± u)(1 ± v) f_±±,      −1 ≤ u, v ≤ 1,

in which each surface weighs the fields of its own sides (Alexander and Seidman, Rocky Mountain J. Math. 28, 1998): if
no weights make both rates vanish, no solution stays, and none winds around the corner. If a smooth step of any width
replaces each switch, then every solution leaves by the one exit as the widths tend to zero.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from enum import StrEnum
from itertools import product
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from core.symbolic.laws import Laws

__all__ = ["BEYOND", "Rate", "WayOut", "surfaces_met", "way_out_of"]

#: Most parts of the weights' square in which a zero of both rates is excluded.
_MOST_PARTS = 4096

Signs: TypeAlias = "tuple[int, ...]"


class Rate(NamedTuple):
    """Rate of a switching function with the field of a region."""

    value: float
    doubt: float
    """Bound on its error: a rate of at most this size is not clear."""


class WayOut(NamedTuple):
    """Where a solution goes on from a corner."""

    mode: int | None
    """Number of the region, or of the mode of sliding, entered; None where the laws do not determine it."""
    reason: str = ""
    """Why they do not."""
    slid_into: bool = False
    """Whether solutions slide into the corner, so that one beside it does."""

    @property
    def unclear(self) -> bool:
        """Whether that is because a rate is not clear."""
        return self.reason in (_Why.UNCLEAR, _Why.RESTS)


class _Why(StrEnum):
    """Why a solution does not go on from a corner."""

    NONE = "no field around leads out, and neither does sliding along one of them"
    SEVERAL = "the laws around lead out in more than one way"
    STAYS = "the solution may stay where they meet, along which no law is derived"
    UNCLEAR = "a field around is tangent to one of them there, to rounding, so that the way out is not clear"
    RESTS = "sliding along one of them is at rest there, to rounding, so that the way out is not clear"
    MANY = "the laws around do not all lead the same way out"
    UNDECLARED = "a region around is not declared, and the laws that are do not all lead the same way out"
    JUMPS = "at one of them the state jumps"
    BEYOND = "the state is beyond several surfaces at once, of which the laws do not tell which acts first"


BEYOND = WayOut(None, _Why.BEYOND)
"""From where a jump has led beyond several surfaces, or a run begins there."""


class _Exit(NamedTuple):
    mode: int
    clear: bool
    """Whether it is an exit whatever the rounding of the rates."""
    rests: bool = False
    """Whether that is because sliding along it is at rest at the corner, to rounding, between fields that are clear."""


def way_out_of(laws: Laws, sides: Sequence[int], surfaces: Sequence[int], rate: Callable[[int, int], Rate]) -> WayOut:
    """Where a solution goes on from a corner.

    Where more than two surfaces meet, or a region around is not declared, only to the region into which all fields
    around lead.

    Parameters
    ----------
    sides
        Signs of all switching functions near the corner; those of the surfaces that meet there do not matter.
    surfaces
        Numbers of the surfaces that meet there.
    rate
        (region, surface) -> rate of the switching function with the field of the region.
    """
    around = dict(_regions_around(laws, sides, surfaces))
    if any(way.jump is not None and way.surface in surfaces for k in around.values() for way in laws.ways[k]):
        return WayOut(None, _Why.JUMPS)
    rates = {signs: [rate(region, surface) for surface in surfaces] for signs, region in around.items()}
    if len(surfaces) != 2 or len(around) < 4:
        region = _agreed(around, rates)
        why = _Why.UNDECLARED if len(around) < 2 ** len(surfaces) else _Why.MANY
        return WayOut(region, "" if region is not None else why)
    slides = list(_along_surfaces(laws, around, rates, surfaces))
    exits = [*_into_regions(around, rates), *(leaving for leaving in slides if leaving is not None)]
    if len(exits) != 1:
        return WayOut(None, _doubt(exits) or (_Why.SEVERAL if exits else _Why.NONE))
    if doubt := _doubt(exits):
        return WayOut(None, doubt)
    return WayOut(None, _Why.STAYS) if _may_stay(rates) else WayOut(exits[0].mode, slid_into=None in slides)


def surfaces_met(guards: NDArray[Any], met_first: int, met: int, along: int | None) -> tuple[int, ...]:
    """Numbers of the surfaces that meet where the loop has stopped at a corner.

    Parameters
    ----------
    guards
        Those of the mode, from the table of guards.
    met_first
        Number of the guard that ended the mode.
    met
        Bits of the guards that vanish there; of sliding only where a field has turned.
    along
        Number of the surface along which it slides; None in a region.
    """
    reached = along is not None and not guards["turns"][met_first]
    numbers = [met_first] if reached else [k for k in range(len(guards)) if met >> k & 1 and not guards["turns"][k]]
    return tuple(sorted({int(guards["surface"][k]) for k in numbers} | ({along} if along is not None else set())))


def _regions_around(laws: Laws, sides: Sequence[int], surfaces: Sequence[int]) -> Iterator[tuple[Signs, int]]:
    """Signs of the surfaces that meet, and number, of each region that is declared around a corner."""
    near = list(sides)
    for signs in product((-1, 1), repeat=len(surfaces)):
        for surface, sign in zip(surfaces, signs, strict=True):
            near[surface] = sign
        if (region := laws.regions_by_sides.get(tuple(near))) is not None:
            yield signs, region


def _agreed(around: dict[Signs, int], rates: dict[Signs, list[Rate]]) -> int | None:
    """The region into which the fields of all regions around lead."""
    onward = {tuple(_sign(*u) for u in of_field) for of_field in rates.values()}
    return around.get(onward.pop()) if len(onward) == 1 else None


def _doubt(exits: Sequence[_Exit]) -> _Why | None:
    """Why exits are not clear; None if they all are."""
    unclear = [leaving for leaving in exits if not leaving.clear]
    if not unclear:
        return None
    return _Why.RESTS if all(leaving.rests for leaving in unclear) else _Why.UNCLEAR


def _sign(value: float, doubt: float) -> int:
    """The sign of a number, 0 where it is not clear."""
    return int(np.sign(value)) if abs(value) > doubt else 0


def _into_regions(around: dict[Signs, int], rates: dict[Signs, list[Rate]]) -> Iterator[_Exit]:
    """Regions whose own field points into them, clearly or perhaps."""
    for signs, region in around.items():
        inward = [sign * u.value for sign, u in zip(signs, rates[signs], strict=True)]
        doubts = [u.doubt for u in rates[signs]]
        if all(w >= -doubt for w, doubt in zip(inward, doubts, strict=True)):
            yield _Exit(region, all(w > doubt for w, doubt in zip(inward, doubts, strict=True)))


def _along_surfaces(
    laws: Laws, around: dict[Signs, int], rates: dict[Signs, list[Rate]], surfaces: Sequence[int]
) -> Iterator[_Exit | None]:
    """Half-surfaces that attract both fields, clearly or perhaps: exits, or None where sliding leads to the corner."""
    for k, side in product((0, 1), (-1, 1)):
        low, high = ((sign, side) if k == 0 else (side, sign) for sign in (-1, 1))
        (up, onward_low), (down, onward_high) = ((rates[s][k], rates[s][1 - k]) for s in (low, high))
        # Filippov's rate of the other surface, times the positive difference of the rates of this one.
        onward = side * (up.value * onward_high.value - down.value * onward_low.value)
        doubt = _doubt_of_product(up, onward_high) + _doubt_of_product(down, onward_low)
        if up.value < -up.doubt or down.value > down.doubt:
            continue
        if onward < -doubt:
            yield None
        else:
            attracts = up.value > up.doubt and down.value < -down.doubt
            clear = attracts and onward > doubt
            rests = attracts and not clear
            yield _Exit(laws.number_of_sliding(around[low], around[high], surfaces[k]), clear, rests)


def _doubt_of_product(a: Rate, b: Rate) -> float:
    return abs(a.value) * b.doubt + abs(b.value) * a.doubt + a.doubt * b.doubt


def _may_stay(rates: dict[Signs, list[Rate]]) -> bool:
    """Whether weights cannot be excluded with which both rates vanish.

    A function that is linear in each of two weights takes its extremes over a rectangle at the corners, so that one
    sign at all of them excludes a zero in it. Rectangles in which neither rate has one sign are divided.
    """
    values = np.array([[[u.value for u in rates[a, b]] for b in (-1, 1)] for a in (-1, 1)])
    doubts = np.array([u.doubt for of_field in rates.values() for u in of_field]).reshape(4, 2).max(axis=0)
    parts, count = [values], 0
    while parts:
        at = parts.pop()
        if ((at > doubts).all(axis=(0, 1)) | (at < -doubts).all(axis=(0, 1))).any():
            continue
        count += 1
        if count > _MOST_PARTS:
            return True
        middle = (at[:1] + at[1:]) / 2
        for half in (np.concatenate([at[:1], middle]), np.concatenate([middle, at[1:]])):
            centre = (half[:, :1] + half[:, 1:]) / 2
            parts += [np.concatenate([half[:, :1], centre], axis=1), np.concatenate([centre, half[:, 1:]], axis=1)]
    return False
