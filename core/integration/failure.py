"""Why a run has failed: the solution itself runs away, or its field has no value where it leads."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy  # loads a subpackage when it is first used

from core.kernels.arrays import Floats
from core.system import PiecewiseSystem

__all__ = ["GROWTH", "ends_beyond", "runs_away"]

#: Growth of the state that is called running away: a pole, or an exponential that no run of use goes along.
GROWTH = 1e6
_EVALUATIONS = 20_000  #: of the field at most: a quarter of a second
_AHEAD = (1.0, 3.0, 10.0)  #: how far beyond a state, in parts of it, its field is looked at
_TOLERANCE = 1e-4  #: relative: whether it grows is the question, and not how


def runs_away(system: PiecewiseSystem, side: int, t0: float, x0: Floats, t1: float, size: float) -> bool | None:
    """Whether the solution with the field of a side grows beyond all bounds between two times.

    An implicit method of SciPy follows it, so that stiff fields cost no more than others.

    Parameters
    ----------
    t0, x0
        Start time and state (d,).
    t1
        End time, of either direction.
    size
        What is large: the largest coordinate that the run has begun with.

    Returns
    -------
    bool or None
        None where this cannot be told: the field has no value on the way, or the way is too long.
    """
    size = max(size, float(np.abs(x0).max())) or 1.0

    def field(t: float, x: Floats) -> Floats:
        return system.field(side, t, x)

    with np.errstate(all="ignore"):
        if not np.isfinite(field(t0, x0)).all():
            return None
        solver = scipy.integrate.Radau(field, t0, x0, t1, rtol=_TOLERANCE, atol=_TOLERANCE * size)
        while solver.status == "running" and solver.nfev < _EVALUATIONS:
            try:
                solver.step()
            except (ValueError, np.linalg.LinAlgError):  # a Jacobian that is not finite
                return None
            if not np.abs(solver.y).max() <= GROWTH * size:
                return True
    if solver.status == "finished":
        return False
    # Steps have become shorter than time is resolved: at a pole, or where the field itself ends.
    return True if solver.status == "failed" and _pushes_outward(field, solver.t, solver.y) else None


def _pushes_outward(field: Callable[[float, Floats], Floats], t: float, x: Floats) -> bool:
    """Whether the field goes on growing in its own direction, up to ten times the state away."""
    here = field(t, x)
    speed = float(np.abs(here).max())
    direction = here / speed
    ahead = [float(direction @ field(t, x + s * np.abs(x).max() * direction)) for s in _AHEAD]
    return 0.0 < float(direction @ here) <= min(ahead)


def ends_beyond(system: PiecewiseSystem, side: int, t: float, x: Floats, h: float) -> bool:
    """Whether the field of a side has a value at a state, and none within a step of length h from there."""
    here = system.field(side, t, x)
    ahead = x + h * np.linspace(0.125, 1.0, 8)[:, None] * here
    return bool(np.isfinite(here).all() and np.isnan(system.field(side, t, ahead)).any())
