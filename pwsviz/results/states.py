"""The state against time: the curves of one run, coordinate by coordinate, at screen resolution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import core
from pwsviz.geometry.envelope import envelope
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.results.orbits import RUNS_OFF

SAMPLES = 1200
"""Times at least at which a curve is drawn: about one a pixel. Runs of fewer steps are evaluated between them."""

FEW_STEPS = 80
"""Most steps that are marked by dots: on a narrow screen more of them would touch one another, and hide the curve."""

OUTLIERS = 0.02
"""Part of the values at either end that the axis need not hold if the run may have run off."""

NEAR = 1.0
"""Range of the other values within which the axis holds these, too: what is beyond has run off."""


@dataclass(frozen=True)
class StateCurves:
    """One run as the plot of the state shows it.

    Attributes
    ----------
    method : str
        The integrator.
    curves : tuple of (t, y)
        (k,) times and values of each coordinate; NaN between the two ends of a jump.
    steps : (n,) array, (n, d) array
        Times and states of the steps; empty if there are more than `FEW_STEPS`.
    bounds : (d, 2) array
        Least and greatest value of each coordinate, without outliers of a run that may have run off.
    reached : (d, 2) array
        Least and greatest value of each coordinate.
    runs_off : bool
        Whether it may have.
    t_end : float
        Last time of the run.
    """

    method: str
    curves: tuple[tuple[Floats, Floats], ...]
    steps: tuple[Floats, Floats]
    bounds: Floats
    reached: Floats
    runs_off: bool
    t_end: float


def state_curves(run: core.Trajectory) -> StateCurves:
    """Return the curves of a run, drawn through its steps and, where these are long, between them."""
    t, x = with_crossings(run.crossings, *_samples(run))
    few = slice(None) if len(run.t) <= FEW_STEPS else slice(0)
    reached = _quantiles(x, 0.0)
    return StateCurves(
        method=run.method,
        curves=tuple(envelope(t, column, SAMPLES) for column in x.T),
        steps=(run.t[few], run.x[few]),
        bounds=_without_outliers(x, reached) if run.status in RUNS_OFF else reached,
        reached=reached,
        runs_off=run.status in RUNS_OFF,
        t_end=float(run.t[-1]),
    )


def _samples(run: core.Trajectory) -> tuple[Floats, Floats]:
    """Return times and states of a run: its steps, and as many times between them as the screen resolves."""
    if len(run.t) >= SAMPLES:
        return run.t, run.x
    t = np.union1d(run.t, np.linspace(run.t[0], run.t[-1], SAMPLES))
    try:
        return t, run.at(t)
    except ValueError:  # the equations of a shorter step have no solution: the curve leads straight from step to step
        return run.t, run.x


def with_crossings(crossings: core.Crossings, t: Floats, x: Floats) -> tuple[Floats, Floats]:
    """Insert the states before and after each crossing, and between the two a gap where they differ."""
    jump = crossings.kind == "jump"
    gaps = np.full((np.count_nonzero(jump), x.shape[1]), np.nan)
    times = np.concatenate([crossings.t, crossings.t[jump], crossings.t, t])
    states = np.concatenate([crossings.x, gaps, crossings.x_after, x])
    rank = np.repeat(np.arange(4), [len(crossings), len(gaps), len(crossings), len(t)])
    order = np.lexsort((rank, times))
    return times[order], states[order]


def _quantiles(x: Floats, left_out: float) -> Floats:
    """Return (d, 2): least and greatest value of each coordinate, but for this part of the values at either end."""
    return np.nanquantile(np.where(np.isfinite(x), x, np.nan), [left_out, 1.0 - left_out], axis=0).T


def _without_outliers(x: Floats, reached: Floats) -> Floats:
    """Return (d, 2): the least and greatest value of each coordinate where they are near the others, else theirs."""
    usual = _quantiles(x, OUTLIERS)
    return np.where(np.abs(reached - usual) <= NEAR * np.diff(usual), reached, usual)
