"""Causes of a failed run: the solution itself grows beyond bounds, or its field is not defined ahead."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from enum import Enum

import numpy as np
import scipy  # loads its subpackages on first use

from core.integration.growth_loop import BOUNDED, GROWTH, LARGE, POLE
from core.interface.cancelling import Cancel
from core.kernels.arrays import Floats
from core.system import PiecewiseSystem
from core.transition.event_location import BOUND

__all__ = ["Growth", "ends_beyond", "ends_here", "growth_of", "pole_ahead", "pole_of_growth"]

_EVALUATIONS = 20_000  #: largest number of evaluations of the field: some seconds
_AHEAD = (1.0, 3.0, 10.0)  #: distances ahead of a state, relative to it, at which the field is evaluated
_TOLERANCE = 1e-4  #: relative tolerance, enough to see whether the solution grows
#: Error of the time of a crossing, in units of the last place: ample, as it is a few of them.
_ROUNDING = 64.0
#: Near a pole the rate of growth grows like a power of the size: like its third root where the size goes like the time
#: left to the power of −3. A larger power than this one tells a pole; exponentials of exponentials come to a tenth of
#: it and less. Where it does not, the solution is followed on.
_POWER = 0.15


class Growth(Enum):
    """How a solution grows between two times."""

    BOUNDED = BOUNDED
    """By less than `GROWTH`."""
    LARGE = LARGE
    """By more, as a polynomial or an exponential does; no pole is met."""
    POLE = POLE
    """To a pole: within a time that is rounded away, or so it seems as far as it could be followed."""


def growth_of(
    system: PiecewiseSystem, mode: str, t0: float, x0: Floats, t1: float, size: float, cancel: Cancel | None = None
) -> Growth | None:
    """How the solution with the field of a mode grows, relative to its size, between two times.

    It is integrated by an implicit method of SciPy, so that stiff fields cost no more than others.

    Parameters
    ----------
    mode
        Name of the mode.
    t0, x0
        Initial time and state (d,).
    t1
        End time, before or after t0.
    size
        Largest |coordinate| of the initial value of the run.
    cancel
        Called after each step; once it returns True, this is given up.

    Returns
    -------
    Growth or None
        None where this cannot be decided: the field is not defined on the way, or needs too many evaluations, or the
        work is given up.
    """
    return _followed(system, mode, t0, x0, t1, size, cancel, inside=False)[0]


def pole_ahead(
    system: PiecewiseSystem, mode: str, t0: float, x0: Floats, t1: float, size: float, cancel: Cancel | None = None
) -> float:
    """Time of a pole to which the solution comes in a mode before another time, about; nan if none is found.

    Parameters
    ----------
    mode, t0, x0, t1, size, cancel
        As of `growth_of`.
    """
    growth, t = _followed(system, mode, t0, x0, t1, size, cancel, inside=True)
    return t if growth is Growth.POLE else math.nan


def _followed(
    system: PiecewiseSystem, mode: str, t0: float, x0: Floats, t1: float, size: float, cancel: Cancel | None,
    inside: bool,
) -> tuple[Growth | None, float]:  # fmt: skip
    """As `growth_of`, and where that was found; `inside`: as long as no guard of the mode is met."""
    size, grown = max(size, float(np.abs(x0).max())) or 1.0, False
    first: tuple[float, float] | None = None

    number = system.laws.numbers_of_modes[mode]
    law = system.laws.mode(number).written

    def field(t: float, x: Floats) -> Floats:
        return np.array(system.laws.numbers(("f", mode), law.field, t, x.tolist(), system.parameter_array))

    with np.errstate(all="ignore"):
        if not np.isfinite(field(t0, x0)).all():
            return None, t0
        solver = scipy.integrate.Radau(field, t0, x0, t1, rtol=_TOLERANCE, atol=_TOLERANCE * size)
        while solver.status == "running" and solver.nfev < _EVALUATIONS and not (cancel is not None and cancel()):
            try:
                solver.step()
            except (ValueError, np.linalg.LinAlgError):  # a Jacobian that is not finite
                return (Growth.POLE if grown else None), solver.t
            if inside and (system.heights(number, solver.t, solver.y) < 0.0).any():
                return None, solver.t
            largest = float(np.abs(solver.y).max())
            if largest >= BOUND:  # in steps that are not rounded away
                return Growth.LARGE, solver.t
            if first is None and largest > math.sqrt(GROWTH) * size:
                first = largest, _rate_of_growth(field, solver.t, solver.y)
            if not largest <= GROWTH * size:
                grown = True
                if first is not None and _nears_a_pole(*first, largest, _rate_of_growth(field, solver.t, solver.y)):
                    return Growth.POLE, solver.t
    if solver.status == "finished":
        return (Growth.LARGE if grown else Growth.BOUNDED), solver.t
    # The step size has reached the resolution of time: at a pole, or where the field ceases to be defined.
    ends = solver.status == "failed" and _pushes_outward(field, solver.t, solver.y)
    return (Growth.POLE if grown or ends else None), solver.t


def _rate_of_growth(field: Callable[[float, Floats], Floats], t: float, x: Floats) -> float:
    """Relative rate of change of the largest coordinate."""
    largest = int(np.abs(x).argmax())
    return float(abs(field(t, x)[largest] / x[largest]))


def _nears_a_pole(size: float, rate: float, later_size: float, later_rate: float) -> bool:
    """Whether the rate of growth has grown like a power of the size."""
    far = later_size > math.sqrt(GROWTH) * size
    return far and later_rate > rate * (later_size / size) ** _POWER > 0.0


def pole_of_growth(places: Sequence[tuple[float, float]]) -> float:
    """Time of a pole as the mean rates of growth between three places of a run tell it; nan if they tell none.

    Parameters
    ----------
    places : sequence of (float, float)
        Time and size of the state, at the start and twice later.
    """
    (t0, size0), (t1, size1), (t2, size2) = places
    if not 0.0 < size0 < size1 < size2 < math.inf:
        return math.nan
    early, late = abs(t1 - t0), max(abs(t2 - t1), math.ulp(t2))
    growth = math.log(size2 / size1)
    if not _nears_a_pole(size0, math.log(size1 / size0) / early, size1, growth / late):
        return math.nan
    return t2 + math.copysign(late / growth, t2 - t0)


def _pushes_outward(field: Callable[[float, Floats], Floats], t: float, x: Floats) -> bool:
    """Whether the field does not decrease along its own direction, up to ten times the size of the state ahead."""
    here = field(t, x)
    speed = float(np.abs(here).max())
    direction = here / speed
    ahead = [float(direction @ field(t, x + s * np.abs(x).max() * direction)) for s in _AHEAD]
    return 0.0 < float(direction @ here) <= min(ahead)


def ends_beyond(system: PiecewiseSystem, mode: str, t: float, x: Floats, h: float) -> bool:
    """Whether the field of a mode is defined at a state, but not everywhere within a step of length h from there."""
    here = system.field(mode, t, x)
    ahead = x + h * np.linspace(0.125, 1.0, 8)[:, None] * here
    return bool(np.isfinite(here).all() and np.isnan(system.field(mode, t, ahead)).any())


def ends_here(system: PiecewiseSystem, mode: str, t: float, x: Floats) -> bool:
    """Whether the field of a mode has a value on one side only of a time, at a state, as far as rounding shows."""
    times = t + _ROUNDING * np.spacing(abs(t)) * np.array([-1.0, 0.0, 1.0])
    defined = [bool(np.isfinite(system.field(mode, time, x)).all()) for time in times]
    return any(defined) and not all(defined)
