"""What of a run the pictures need besides its curves: where it is at each instant, and what marks its way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import core
from pwsviz.geometry.numbers import MACHINE_EPSILON
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.geometry.projection import Axes, in_plane

ROUND_OFF = 2.0
"""Of ψ, in machine epsilons of `Trajectory.psi_size`: a few roundings of the state."""


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
    """What the plot of the conserved quantity marks of its first run.

    Attributes
    ----------
    places : (k, 2) array
        Where in the portrait each crossing is.
    kinds : tuple of str
        What kind each is.
    round_off : float
        What rounding alone does to ψ; 0 where no ψ is known.
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
    round_off = ROUND_OFF * MACHINE_EPSILON * run.psi_size()
    return Landmarks(np.ascontiguousarray(in_plane(run.crossings.x, axes)), kinds, round_off)
