"""The curves of a portrait and the ends of their steps, as columns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

import core
from pwsviz.figures.lines import WIDEST, line_of, look_columns, together
from pwsviz.figures.sent_arrays import sent
from pwsviz.geometry.turns import spacing
from pwsviz.geometry.window import Window
from pwsviz.results.orbits import Orbit
from pwsviz.results.results import Pictures
from pwsviz.text.math_names import variable_name

__all__ = ["OF_OTHERS", "alongside_columns", "curve_columns", "fitted_widths", "step_columns", "thin_shares"]

OF_OTHERS = 0.5
"""Width of the curves of other starts, relative to those of the selected one."""

THINNER = 0.5
"""Width of the curves of each further body alongside, relative to those of the one before."""

TOUCH = 0.45
"""Width of the widest curve, relative to the distance between its turns, from which on all curves are thinner."""

THINNEST = 0.7
"""Width in pixels of a curve whose turns touch all the same, and of any other at least."""


def curve_columns(orbits: Sequence[Orbit], view: Window | None, shares: Sequence[float] = ()) -> dict[str, list[Any]]:
    """Return a row for each orbit; `shares` are the widths of the curves relative to the usual ones, else 1."""
    return {
        "xs": sent([orbit.path[:, 0] for orbit in orbits]),
        "ys": sent([orbit.path[:, 1] for orbit in orbits]),
        **look_columns([orbit.method for orbit in orbits]),
        "width": fitted_widths(orbits, view, shares),
    }


def thin_shares(pictures: Pictures) -> list[float]:
    """Return the relative widths of the thin curves: of bodies alongside, each one is thinner than the one before."""
    shares = [OF_OTHERS] * len(pictures.others)
    for k, orbits in enumerate(pictures.alongside.values()):
        shares += [OF_OTHERS * THINNER**k] * len(orbits)
    return shares


def fitted_widths(orbits: Sequence[Orbit], view: Window | None, shares: Sequence[float] = ()) -> list[float]:
    """Return the width of each curve: its share of the usual one, or less where its turns would touch."""
    lines = together(line_of(orbit.method) for orbit in orbits)
    usual = [
        max(THINNEST, share * line.width) for share, line in zip(shares or [1.0] * len(orbits), lines, strict=True)
    ]
    if view is None:
        return usual
    fits = [min(1.0, TOUCH * spacing(orbit.path, view) / WIDEST) for orbit in orbits]
    return [max(min(THINNEST, width), fit * width) for width, fit in zip(usual, fits, strict=True)]


def alongside_columns(system: core.PiecewiseSystem, pictures: Pictures) -> dict[str, list[Any]]:
    """Return a row for each start alongside, with the names of the variables of its plane beside the selected one."""
    each, rows = len(pictures.orbits), []
    for plane, orbits in pictures.alongside.items():
        name = ", ".join(variable_name(system.variables[k]) for k in plane)
        rows += [(*orbit.start, "" if k else name) for k, orbit in enumerate(orbits[::each])]
    return {name: [row[k] for row in rows] for k, name in enumerate(("x", "y", "label"))}


def step_columns(orbits: Sequence[Orbit]) -> dict[str, Any]:
    """Return a row for each step that is marked."""
    dots = np.concatenate([orbit.steps for orbit in orbits])
    colours = [line_of(orbit.method).colour for orbit in orbits for _ in orbit.steps]
    return {"x": dots[:, 0], "y": dots[:, 1], "colour": colours}
