"""How a run ended: what made it fail, in words a user can act on."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from core.integration.failure import GROWTH, Growth, ends_beyond, growth_of
from core.transition.event_location import BOUND
from core.transition.records import NO_MODE
from core.transition.status import Status

if TYPE_CHECKING:
    from core.integration.runner import Runner

__all__ = ["cause_of_failure", "outcome", "reason"]

#: A pole is searched beyond the end of the run by this part of the time since the mode was entered.
_MARGIN = 0.1
#: Steps ahead of a failed step within which the solution must run away to be the cause of the failure.
_AHEAD = 16.0


def cause_of_failure(runner: Runner) -> tuple[Status, Growth | None]:
    """Status of a run whose step has failed: the solution runs away, the scheme alone does, or the step fails.

    If the state has grown beyond bounds, the exact solution is followed from where the mode was entered, through the
    step that failed. If a step fails elsewhere, the solution is followed for some steps from here. For a state beyond
    bounds, how the solution grows is returned, too.
    """
    size, cancel = float(np.abs(runner.start).max()), runner.settings.cancel
    if runner.slides or runner.mode == NO_MODE:
        return runner.status, None
    system, here, step = runner.system, runner.x, _step_length(runner)
    name = system.laws.name(runner.mode)
    grown = runner.status is Status.ESCAPED or float(np.abs(here).max()) > GROWTH * size > 0.0
    if grown:
        (t, x), beyond = runner.entry(), _MARGIN * (runner.t - runner.entry()[0])
        growth = growth_of(system, name, t, x, runner.t + max(beyond, step, key=abs), size, cancel)
    else:
        ahead = runner.t + _AHEAD * step
        still = ahead == runner.t
        growth = Growth.BOUNDED if still else growth_of(system, name, runner.t, here, ahead, size, cancel)
    if growth is None:
        return Status.CANCELLED if cancel is not None and cancel() else runner.status, None
    if growth is Growth.BOUNDED:
        return Status.UNSTABLE if grown else runner.status, growth
    return Status.ESCAPED, growth if runner.status is Status.ESCAPED else None


def outcome(runner: Runner) -> str:
    """Where a run ended, why, and what to do about it."""
    status = runner.status
    where = f"t = {runner.t:.12g}"
    if status is Status.COMPLETED:
        return f"{where}: {status.reason}. {status.advice}".strip()
    places = zip(runner.system.variables, runner.x, strict=True)
    where += ", " + ", ".join(f"{name} = {v:.6g}" for name, v in places)
    return f"{where}: {reason(runner)}. {_advice(runner)}".strip()


def reason(runner: Runner) -> str:
    """Why a run ended."""
    if runner.status is Status.ESCAPED and runner.growth is Growth.LARGE:
        return f"the numerical solution grows beyond {BOUND:.0e}, up to which a run takes its numbers".replace("+", "")
    if runner.status is Status.CORNER:
        return f"{runner.status.reason}, and {runner.why_cornered}"
    return runner.status.reason_while_sliding if runner.slides else runner.status.reason


def _advice(runner: Runner) -> str:
    """What to do; where a field is not defined ahead, to write it differently."""
    status, laws = runner.status, runner.system.laws
    if status is Status.NO_CONVERGENCE and runner.mode != NO_MODE and not runner.slides:
        name = laws.name(runner.mode)
        if ends_beyond(runner.system, name, runner.t, runner.x, _step_length(runner)):
            field = ("f_minus", "f_plus")[runner.mode] if laws.two_sided else f"the field of region {name!r}"
            return (
                f"{field} is not defined a step ahead. If that is beyond the surface, write it so that it has a value "
                "there too: (u**2)**0.75 for u**1.5."
            )
    if status is Status.ESCAPED and runner.growth is Growth.LARGE:
        return "The exact one grows, too, without a pole: end the run before."
    if status is Status.SLIDING and laws.jumps:
        return "A system with a jump does not slide here: continue it with another system."
    if status in (Status.CORNER, Status.GRAZING) and runner.slides:
        return status.advice_while_sliding
    return status.advice_without_tau if runner.method.adaptive else status.advice


def _step_length(runner: Runner) -> float:
    """Signed length of a step; for a variable-step method, of its longest."""
    length = runner.settings.tau if math.isfinite(runner.settings.tau) else runner.longest
    return math.copysign(length, runner.direction)
