"""The curve of |Δψ| of one run, and what is said about it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

import core
from core.integration import largest_size
from pwsviz.geometry.envelope import envelope
from pwsviz.geometry.numbers import MACHINE_EPSILON
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.geometry.shades import shade_names, shades_of
from pwsviz.results.orbits import RUNS_OFF
from pwsviz.results.requests import RunInputs

__all__ = ["ROUND_OFF", "ErrorCurve", "error_curve"]

ROUND_OFF = 2.0
"""Round-off of ψ in machine epsilons of `Trajectory.psi_size`: the effect of a few roundings of the state."""


@dataclass(frozen=True)
class ErrorCurve:
    """|Change of ψ| that the integrator has made up to each time, at screen resolution."""

    method: str
    t: Floats
    error: Floats
    t_end: float
    crossings: Floats
    sides: NDArray[np.int64]
    """(1 + len(crossings),) shade of the mode occupied from the start, and from each crossing on; 0 where it slides. Of
    one surface it is the side."""
    names: Mapping[int, str] = field(default_factory=lambda: {-1: "g < 0", 1: "g > 0", 0: "sliding"})
    """What a legend calls each shade."""
    psi_size: Floats = field(default_factory=lambda: np.ones(1))
    """(n,) greatest `Trajectory.psi_sizes` up to each of the times, or (1,) of all: its round-off is that of Δψ."""
    runs_off: bool = False
    """Whether the run may have gone very far."""
    keeps: bool = False
    """Whether the method keeps ψ to round-off, be it for the form of ψ: of any ψ if it is conservative."""
    between: Floats | None = None
    """(n,) |change of ψ| since the last crossing, if crossings lie off the surface: what that has no part in."""
    undefined: float = np.nan
    """Time from which on ψ is not defined where the run is, though one is known there; NaN if there is none."""
    steps: int = 0
    """How many steps the run has made."""
    shift: float = 0.0
    """How far the mean of a Δψ moves from the first to the last third of the run, in widths of its band in a third; the
    largest over several ψ. It is 2 for a change in proportion to time, and about 0 where Δψ only oscillates."""
    jumps: bool = False
    """Whether the state jumps at crossings, where no change of ψ counts."""

    @property
    def round_off(self) -> Floats:
        """(n,) size of the round-off of ψ at each of the times; 0 if no ψ is known."""
        return np.broadcast_to(ROUND_OFF * MACHINE_EPSILON * self.psi_size, self.t.shape)

    @property
    def accumulated_round_off(self) -> Floats:
        """(n,) size that the round-off of all steps may reach, as independent errors of one rounding each add up."""
        return self.round_off * max(1.0, float(np.sqrt(self.steps)) / ROUND_OFF)

    @property
    def sliding(self) -> NDArray[np.bool_]:
        """(n,) which of the times lie in sliding, where the error is |g| and what else sliding keeps."""
        return np.asarray(self.sides[np.searchsorted(self.crossings, self.t, side="right")] == 0)


def error_curve(inputs: RunInputs, run: core.Trajectory, error: Floats) -> ErrorCurve:
    """Return the curve of a run, of which `error` is the accumulated error of each ψ at each state."""
    size_of_error = largest_size(error)
    t, reduced = envelope(run.t, size_of_error)
    met = run.crossings.passed  # where it stops it does not begin to slide
    shades = shades_of(run.system, np.concatenate([run.mode[:1], met.mode]))
    names = shade_names(run.system)
    when, sizes = run.psi_sizes()
    size = np.interp(t, when, np.maximum.accumulate(sizes))
    crossings, runs_off = met.t, run.status in RUNS_OFF
    undefined = _undefined(run, size_of_error)
    method, t_end = inputs.scheme.method, float(run.t[-1])
    keeps = all(core.METHODS[method].keeps(mode) for mode in run.system.laws.regions)
    between = None
    off_surface = inputs.scheme.perturbation_order is not None or not inputs.scheme.locate
    if off_surface and len(crossings):
        _, between = envelope(run.t, np.fmax.reduce(np.abs(run.conserved_error()), axis=1, initial=0.0))
    return ErrorCurve(
        method, t, reduced, t_end, crossings, shades, names, size, runs_off, keeps, between, undefined, int(run.steps),
        _shift(run, error), bool((met.kind == "jump").any()),
    )  # fmt: skip


def _shift(run: core.Trajectory, error: Floats) -> float:
    """Return `ErrorCurve.shift`; 0 where no Δψ is known."""
    off_surface, most = shades_of(run.system, run.mode) != 0, 0.0
    for column in error.T:
        known = np.isfinite(column) & off_surface
        t, signed = run.t[known], column[known]
        if not len(t):
            continue
        third = (t[-1] - t[0]) / 3
        early, late = signed[t <= t[0] + third], signed[t >= t[-1] - third]
        with np.errstate(over="ignore", invalid="ignore"):  # where a run blows up, which is told otherwise
            band = max(np.ptp(early), np.ptp(late))
            most = max(most, abs(late.mean() - early.mean()) / band if band > 0 else 0.0)
    return float(most)


def _undefined(run: core.Trajectory, error: Floats) -> float:
    """Return from when on ψ is not defined though it is known; one that has overflowed does not count."""
    known = np.array([bool(mode.conserved) for mode in run.system.laws.regions])
    inside = (run.mode >= 0) & (run.mode < len(known))
    lost = np.isnan(error) & inside & known[np.where(inside, run.mode, 0)]
    lost &= ~np.maximum.accumulate(np.isinf(error))
    return float(run.t[np.argmax(lost)]) if lost.any() else np.nan
