"""Judge a run apart from its clock, where that does not resolve its steps: t₀ + τ is rounded.

The time loop knows how long each step is, whatever the time. What is recorded are times, whose differences are the
steps only up to rounding. Where no law names t, the clock can begin at zero.
"""

from __future__ import annotations

import math

import numpy as np

from core.diagnostics.made_again import first_steps
from core.integration.trajectory import Trajectory
from core.methods import METHODS
from core.symbolic.expressions import TIME

__all__ = ["blurs", "by_its_own_clock", "from_zero", "is_blurred"]

#: Rounding of the time, as part of a step, from which on differences of times no longer tell what a step does.
_UNRESOLVED = 2.0**-16


def is_blurred(run: Trajectory) -> bool:
    """Whether the clock at the start of a run does not resolve its steps."""
    if run.asked is None or not run.steps:
        return False
    return _rounding(run) > _UNRESOLVED * _step(run)


def by_its_own_clock(run: Trajectory) -> bool:
    """Whether neither a law nor an event function names the time, so that it is no matter when a run begins."""
    events = () if run.asked is None else run.asked.settings.events.functions
    return not run.system.laws.names_time and not any(TIME in function.free_symbols for function in events)


def from_zero(run: Trajectory) -> Trajectory:
    """The first steps of a run made again, with the clock set to zero at its start."""
    if (asked := run.asked) is None:
        return run
    return first_steps(run, asked._replace(t0=0.0, t_end=asked.t_end - asked.t0))


def blurs(run: Trajectory) -> str:
    """Say what rounding of the time does to laws that name it; a sentence."""
    t, rounding, step = run.t[0], _rounding(run), _step(run)
    what = "tau" if math.isfinite(run.tau) and not METHODS[run.method].adaptive else "a step"
    return (
        f"Times near t = {t:.3g} are rounded to {rounding:.2g}, and {what} is {step:.2g}: what names t is evaluated at "
        "times so far off, and no step size helps. Count the time from the start of the run: begin at t = 0, and write "
        "the law for that, as cos(t + a) with its phase at the start for a periodic one."
    )


def _rounding(run: Trajectory) -> float:
    """Distance of neighbouring numbers at the start time."""
    return float(np.spacing(abs(run.t[0])))


def _step(run: Trajectory) -> float:
    """Length of a step: of a method that chooses it, a typical one."""
    return abs(float(run.t[-1] - run.t[0])) / run.steps if METHODS[run.method].adaptive else run.tau
