"""What an integrator makes of the conserved quantity, along the steps and at the crossings, as one curve."""

from __future__ import annotations

import numpy as np

import core
from pwsviz.geometry.polyline_reduction import Floats


def accumulated_error(run: core.Trajectory) -> Floats:
    """Size of the change of ψ that the integrator made (`Trajectory.accumulated_error`), of several ψ the worst.

    Returns
    -------
    (n,) array
        NaN where no conserved quantity is known.
    """
    error = run.accumulated_error()
    worst = np.full(len(error), np.nan)
    for column in error.T:  # numpy's own reduction takes ten times as long over a short axis
        np.fmax(worst, np.abs(column), out=worst)
    return worst
