"""The curves of a portrait and the ends of their steps, as columns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

import core
from pwsviz.figures.lines import WIDEST, line_of, look_columns, together
from pwsviz.figures.sent_arrays import sent
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.geometry.turns import spacing
from pwsviz.geometry.window import Window
from pwsviz.results.orbits import Orbit
from pwsviz.results.results import Pictures
from pwsviz.text.math_names import variable_name

__all__ = [
    "OF_OTHERS", "alongside_columns", "curve_columns", "fitted", "selected_shares", "starts_of_thin", "step_columns",
    "thin_shares",
]  # fmt: skip

OF_OTHERS = 0.5
"""Width of the curves of other starts, relative to those of the selected one."""

STRONG = 2.6
"""Least width in pixels of the curves of the selected start beside those of others."""

THINNER = 0.5
"""Width of the curves of each further body alongside, relative to those of the one before."""

TOUCH = 0.45
"""Width of the widest curve, relative to the distance between its turns, from which on all curves are thinner."""

WOUND = 3.5
"""Pixels between the turns of a curve below which it is solid: dashes side by side look like bricks, not like turns."""

ALONGSIDE_SIZE = 11
"""Size in pixels of a disc at a start alongside."""

THINNEST = 0.7
"""Width in pixels of a curve whose turns touch all the same, and of any other at least."""


def curve_columns(orbits: Sequence[Orbit], view: Window | None, shares: Sequence[float] = ()) -> dict[str, list[Any]]:
    """Return a row for each orbit; `shares` are the widths of the curves relative to the usual ones, else 1."""
    return {
        "xs": sent([orbit.path[:, 0] for orbit in orbits]),
        "ys": sent([orbit.path[:, 1] for orbit in orbits]),
        **look_columns([orbit.method for orbit in orbits]),
        **fitted(orbits, view, shares),
    }


def thin_shares(pictures: Pictures) -> list[float]:
    """Return the relative widths of the thin curves: of bodies alongside, each one is thinner than the one before."""
    shares = [OF_OTHERS] * len(pictures.others)
    for k, orbits in enumerate(pictures.alongside.values()):
        shares += [OF_OTHERS * THINNER**k] * len(orbits)
    return shares


def selected_shares(pictures: Pictures) -> list[float]:
    """Return the relative widths of the curves of the selected start, which are strong beside those of others."""
    if not pictures.others:
        return []
    return [max(1.0, STRONG / line.width) for line in together(line_of(orbit.method) for orbit in pictures.orbits)]


def starts_of_thin(pictures: Pictures) -> list[int]:
    """Return the number of the start of each thin curve, from 1."""
    numbers = [number for number, _ in pictures.numbered]
    return numbers[len(pictures.orbits) :] + numbers * len(pictures.alongside)


def fitted(orbits: Sequence[Orbit], view: Window | None, shares: Sequence[float] = ()) -> dict[str, list[Any]]:
    """Return what the view asks of each curve: its width, less than its share where turns would touch; and its stroke.

    The stroke is the dash of the integrator, or none where turns are close to one another.
    """
    lines = together(line_of(orbit.method) for orbit in orbits)
    usual = [
        max(THINNEST, share * line.width) for share, line in zip(shares or [1.0] * len(orbits), lines, strict=True)
    ]
    dashes = [list(line.dash) for line in lines]
    if view is None:
        return {"width": usual, "stroke": dashes}
    apart = [spacing(orbit.path, view) for orbit in orbits]
    fits = [min(1.0, TOUCH * pixels / WIDEST) for pixels in apart]
    return {
        "width": [max(min(THINNEST, width), fit * width) for width, fit in zip(usual, fits, strict=True)],
        "stroke": [dash if pixels >= WOUND else [] for dash, pixels in zip(dashes, apart, strict=True)],
    }


def alongside_columns(system: core.PiecewiseSystem, pictures: Pictures, view: Window | None) -> dict[str, list[Any]]:
    """Return a row for each start alongside, and one for the selected start, without a disc.

    Of each plane the one of the selected start is named by its variables, on the side of it that curves leave free.
    """
    columns: dict[str, list[Any]] = {name: [] for name in ("x", "y", "size", "label", *_SIDES[0])}
    if not pictures.alongside:
        return columns
    paths = np.concatenate([orbit.path for orbit in (*pictures.orbits, *pictures.thin)])
    window, each = view or Window.around(paths), len(pictures.orbits)
    for plane, orbits in {pictures.plane: pictures.orbits[:1], **pictures.alongside}.items():
        name = ", ".join(variable_name(system.variables[k]) for k in plane.axes)
        size = 0 if plane == pictures.plane else ALONGSIDE_SIZE
        for k, orbit in enumerate(orbits[::each]):
            side = _free_side(orbit.start, paths, window)
            row = {"x": orbit.start[0], "y": orbit.start[1], "size": size, "label": "" if k else name, **side}
            for column, one in row.items():
                columns[column].append(one)
    return columns


_SIDES = [
    {"align": align, "baseline": baseline, "dx": dx, "dy": dy}
    for baseline, dy in (("bottom", -5), ("top", 5))
    for align, dx in (("left", 9), ("right", -9))
]
"""Where a name may stand beside a start: to its right or left, above or below."""

_LONG, _HIGH = 0.14, 0.06
"""Size of a name, relative to the view."""


def _free_side(start: tuple[float, float], paths: Floats, view: Window) -> dict[str, Any]:
    """Return the side of a start with the fewest points of curves in the place of its name."""
    along, up = ((paths - np.array(start)) / (view.width, view.height)).T

    def met(side: dict[str, Any]) -> int:
        right, above = np.sign(side["dx"]) * along, -np.sign(side["dy"]) * up
        return int(((right > 0.0) & (right < _LONG) & (above > 0.0) & (above < _HIGH)).sum())

    return min(_SIDES, key=met)


def step_columns(orbits: Sequence[Orbit]) -> dict[str, Any]:
    """Return a row for each step that is marked."""
    dots = np.concatenate([orbit.steps for orbit in orbits])
    colours = [line_of(orbit.method).colour for orbit in orbits for _ in orbit.steps]
    return {"x": dots[:, 0], "y": dots[:, 1], "colour": colours}
