"""Warn where a surface is met so slowly that the rounding of g decides when."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from core.codegen.rounding import rounding_bound
from core.diagnostics.encounters import Branch, by_number, encounters
from core.integration.crossings import Crossings
from core.integration.trajectory import Trajectory
from core.kernels.arrays import Floats

__all__ = ["slow_crossings"]

#: Error of the state, relative to its size, and of the time, to that passed, that is told: half the digits are lost.
_HALF = 2.0**-26
#: Order of a root of g at most, by which the time that rounding lasts is longer than the rate there tells.
_ORDER = 5.0
_EPS = 2.0**-52


def slow_crossings(run: Trajectory, crossings: Crossings) -> Iterator[str]:
    """Say which crossing is told least well, if half its digits are lost.

    The value of g near the surface is rounding as long as it is less than the bound on that, or than the value at which
    the surface was taken to be met. The time that this lasts is an error of the crossing time; times the speed, of the
    state.

    Yields
    ------
    str
        A sentence without the last full stop.
    """
    arrival = encounters(run, crossings).before
    located = (crossings.x == crossings.surface).all(axis=1)  # not displaced by a perturbation
    at_once = np.diff(crossings.t, prepend=np.nan) == 0.0  # a mode entered beyond a guard
    with np.errstate(all="ignore"):
        rounding = _EPS * _noise(run, arrival)
        noise = np.maximum(rounding, np.where(located & ~at_once, np.abs(crossings.g), 0.0))
        lasts = _ORDER * noise / np.abs(arrival.rate)
        moved = lasts[:, None] * np.abs(_field(run, arrival))
        passed = np.maximum(np.abs(arrival.t - run.t[0]), run.tau)
        size = np.maximum(np.abs(run.x).max(axis=0), np.abs(arrival.x))
        lost = np.nan_to_num(np.column_stack([moved / size, lasts / passed])).max(axis=1)
    lost[~arrival.known] = 0.0  # g = 0 all along a slide, which ends for another reason
    lost[at_once & (np.abs(crossings.g) > _ORDER * rounding)] = 0.0  # it is not met, but has been passed by a jump
    instants = np.isin(arrival.surface, list(run.system.laws.instants))
    lost[instants] = 0.0  # met as fast as time goes, be the clock rounded as it is
    if lost.max(initial=0.0) > _HALF:
        worst = int(np.argmax(lost))
        time = f"about {lasts[worst]:.1g}" if np.isfinite(lasts[worst]) else "a time that cannot be told"
        yield (
            f"The surface is met slowly at t = {arrival.t[worst]:.6g}: the values of g are rounding errors for {time} "
            "there, by which the time of crossing is uncertain. No step size helps: change the initial condition or a "
            "parameter, or write g so that its terms do not cancel"
        )


def _noise(run: Trajectory, arrival: Branch) -> Floats:
    """(k,) bounds on the rounding of g at the surfaces met, in units of the machine epsilon."""
    laws, p = run.system.laws, run.system.parameter_array

    def of_one(surface: int, t: Floats, x: Floats) -> Floats:
        bound = (rounding_bound(laws.surfaces[surface]),)
        return laws.evaluate(("rounding of g", surface), bound, t, x, p)[:, 0]

    return by_number(arrival.surface, of_one, arrival.t, arrival.x)


def _field(run: Trajectory, arrival: Branch) -> Floats:
    """(k, d) the fields by which they are met; nan where the run slides."""
    laws, p = run.system.laws, run.system.parameter_array

    def of_one(mode: int, t: Floats, x: Floats) -> Floats:
        return laws.evaluate(("field", mode), laws.mode(mode).written.field, t, x, p)

    return by_number(arrival.mode, of_one, arrival.t, arrival.x)
