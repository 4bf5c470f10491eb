"""What of a run the pictures need besides its curves: where it is at each instant, and what marks its way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import sympy

import core
from pwsviz.geometry.numbers import MACHINE_EPSILON
from pwsviz.geometry.polyline_reduction import Floats, Indices
from pwsviz.geometry.projection import Axes, in_plane

ROUND_OFF = 4.0
"""Of ψ, in machine epsilons of the terms it is the sum of."""

SAMPLE = 500
"""States in which these terms are looked at."""


@dataclass(frozen=True)
class Frames:
    """One integrator's way through the plane, at its own steps.

    Attributes
    ----------
    method : str
        The integrator.
    t : (n,) array
        Ascending.
    places : (n, 2) array
        Where it is then.
    crossings : (k,) array
        When it crosses: the first `limit` of them.
    """

    method: str
    t: Floats
    places: Floats
    crossings: Floats


@dataclass(frozen=True)
class Landmarks:
    """What the plot of the conserved quantity marks of the run it looks into first.

    Attributes
    ----------
    places : (k, 2) array
        Where in the portrait each crossing is.
    kinds : tuple of str
        What kind each is.
    round_off : float
        What rounding alone does to ψ; NaN where no ψ is known.
    """

    places: Floats
    kinds: tuple[str, ...]
    round_off: float


def frames(run: core.Trajectory, axes: Axes, limit: int = 2000) -> Frames:
    """Return the steps of a run, every k-th where there are more than `limit` of them.

    Parameters
    ----------
    run : core.Trajectory
        The first and last state are always kept; states that are not finite never.
    axes : (int, int)
        The variables that span the portrait.
    limit : int
        Bound on the steps shown, at least 1: there is one instant more than there are steps.

    Raises
    ------
    ValueError
        If the limit is below 1.
    """
    if limit < 1:
        raise ValueError(f"limit = {limit}: it takes one step at least, from the first state to the last")
    places = in_plane(run.x, axes)
    there = np.flatnonzero(np.isfinite(places).all(axis=1))
    every = max(1, -(-(len(there) - 1) // limit))
    kept = there[::every] if (len(there) - 1) % every == 0 else np.append(there[::every], there[-1])
    return Frames(run.method, run.t[kept], np.ascontiguousarray(places[kept]), run.crossings.t[:limit])


def landmarks(run: core.Trajectory, axes: Axes) -> Landmarks:
    """Return what the plot of the conserved quantity marks of a run."""
    kinds = tuple(str(kind) for kind in run.crossings.kind)
    return Landmarks(np.ascontiguousarray(in_plane(run.crossings.x, axes)), kinds, round_off(run))


def round_off(run: core.Trajectory) -> float:
    """Return what rounding alone does to ψ: a few units in the last place of the largest of the terms it adds up.

    A ψ close to 0 may be the difference of large terms; no arithmetic of double precision tells it better than these
    are told. Of several conserved quantities the one with the largest terms counts, as the plot shows the worst.

    Returns
    -------
    float
        NaN where no ψ is known.
    """
    rows = np.arange(0, len(run.t), max(1, len(run.t) // SAMPLE))
    largest = [_largest_terms(run, side, rows[run.side[rows] == side]) for side in (-1, 1)]
    return ROUND_OFF * MACHINE_EPSILON * float(np.fmax.reduce(largest))


def _largest_terms(run: core.Trajectory, side: int, rows: Indices) -> float:
    """Return the largest term of ψ of a side in some of the states; NaN where there is none."""
    system = run.system
    terms = [term for psi in system.laws.sides[side].conserved for term in sympy.Add.make_args(psi)]
    if not terms or not len(rows):
        return float("nan")
    values = system.laws.evaluate(("terms", side), terms, run.t[rows], run.x[rows], system.parameter_array)
    return float(np.abs(values[np.isfinite(values)]).max(initial=0.0))
