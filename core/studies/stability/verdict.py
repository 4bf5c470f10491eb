"""The outcome of a run, judged by the solution."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from core.diagnostics import times_of_near_touches
from core.integrate import integrate
from core.integration.tally import Tally
from core.integration.trajectory import Status, Trajectory
from core.interface.cancelling import Cancel
from core.interface.tasks import GivenUp
from core.studies.sequence import CrossingSequence
from core.studies.stability.runs import EndedRun, runs_of
from core.system import PiecewiseSystem

__all__ = [
    "ENDINGS",
    "NOT_YET",
    "NO_START",
    "REFERENCE",
    "UNCERTAIN",
    "WENT_ON",
    "WRONG_CROSSINGS",
    "Expected",
    "Verdict",
    "expected_of",
    "judge",
    "outcome_words",
    "reference_run",
    "start_at",
]

#: Tolerance of the reference.
_TOLERANCE = 1e-15
REFERENCE = f"Taylor method at tolerance {_TOLERANCE:g}"
"""The reference for the crossings and the ending of a solution: equally accurate for every system, and a run
takes a fifth of a millisecond. Tests compare its crossings with exact solutions."""

#: Another tolerance, with which the crossings have to be the same …
_OTHER_TOLERANCE = 1e-14
#: … and their times, to this part of the gaps between them: as long as they agree so far, errors have not outgrown it.
_SAME = 2.0**-4
#: Most steps of the reference.
_REFERENCE_STEPS = 20_000
#: Part of the time span by which the reference goes beyond its end, to find the next crossing.
_BEYOND = 0.25
#: Least distance of the horizon from a crossing, as part of the gap between crossings.
_CLEAR = 0.25

#: Outcome of a run that is not computed yet. Other outcomes are the values of `Status`, and the following.
NOT_YET = 0
#: Outcome: the run ends as the solution does, with another sequence of crossings.
WRONG_CROSSINGS = 101
#: Outcome: the run reaches the end time, the solution does not.
WENT_ON = 102
#: Outcome: the solution cannot start there, as where f or g is undefined.
NO_START = 103
#: How a solution goes on that is not known: rounding decides the crossings of the reference.
UNCERTAIN = 104
_OTHER_WORDS = {
    NOT_YET: "not computed yet",
    WRONG_CROSSINGS: "incorrect or mistimed crossings",
    WENT_ON: "continues where the solution stops",
    NO_START: "no start there",
    UNCERTAIN: "rounding decides the crossings",
}

ENDINGS = (Status.COMPLETED, Status.SLIDING, Status.REPELLING, Status.GRAZING, Status.ESCAPED, Status.ZENO)
"""Endings of a solution; any other status of the reference is its own failure."""

#: Endings with which crossings are compared. Where they accumulate (Zeno), or the trajectory touches the surface,
#: round-off decides the number of the last ones.
_COUNTED = (Status.COMPLETED, Status.SLIDING, Status.REPELLING, Status.ESCAPED)


def outcome_words(code: int) -> str:
    """Return what an outcome means, in plain words."""
    return _OTHER_WORDS[code] if code in _OTHER_WORDS else Status(code).reason


@dataclass(frozen=True)
class Expected:
    """Ending and crossings of the solution from one start."""

    status: int
    """How it ends, a `Status`: COMPLETED if it reaches the end time; `UNCERTAIN` where the reference cannot tell."""
    crossings: CrossingSequence
    """Its crossings up to `horizon`."""
    horizon: float
    """End time of runs: about that of the study, but far enough from crossings that small errors do not count."""
    size: float
    """`Trajectory.psi_size` of the solution."""
    reason: str = Status.COMPLETED.reason
    """Why the reference ended."""


@dataclass(frozen=True)
class Verdict:
    """Outcome of one run."""

    outcome: int
    """A value of `Status`, or one of the outcomes above."""
    met: Tally
    error: float
    """Largest |Δψ|, see `EndedRun`."""
    message: str


def start_at(x0: tuple[float, ...], coordinate: int, value: float) -> tuple[float, ...]:
    """Return the start with another value of one coordinate."""
    return (*x0[:coordinate], float(value), *x0[coordinate + 1 :])


def reference_run(
    system: PiecewiseSystem,
    x0: tuple[float, ...],
    t_span: tuple[float, float],
    record: str = "crossings",
    sliding: str = "stop",
    cancel: Cancel | None = None,
    tolerance: float = _TOLERANCE,
) -> Trajectory:
    """Run the reference; ValueError where it cannot start."""
    return integrate(
        system, t_span, x0, method="taylor", tolerance=tolerance, record=record, max_steps=_REFERENCE_STEPS,
        sliding=sliding, cancel=cancel,
    )  # fmt: skip


def expected_of(
    system: PiecewiseSystem, x0: tuple[float, ...], t_span: tuple[float, float], sliding: str = "stop",
    cancel: Cancel | None = None,
) -> Expected:  # fmt: skip
    """Return what to expect of a run from x0; ValueError where it cannot start.

    A solution ends where it touches a surface: rounding decides how the reference goes on.
    """
    t0, t1 = t_span
    beyond = t1 + _BEYOND * (t1 - t0)
    run = reference_run(system, x0, (t0, beyond), sliding=sliding, cancel=cancel)
    t, size = run.crossings.t, run.psi_size()
    touch = next(times_of_near_touches(run), math.inf)
    if touch <= min(t1, run.t[-1]):
        return Expected(Status.GRAZING, CrossingSequence.of(run, until=touch), beyond, size, Status.GRAZING.reason)
    other = reference_run(system, x0, (t0, beyond), sliding=sliding, cancel=cancel, tolerance=_OTHER_TOLERANCE)
    if run.status is not Status.COMPLETED and run.t[-1] <= t1:
        known = run.status not in _COUNTED or _is_certain(run, other, float(run.t[-1]))
        status, why = (run.status, run.reason) if known else (UNCERTAIN, _OTHER_WORDS[UNCERTAIN])
        return Expected(status, CrossingSequence.of(run), beyond, size, why)
    before, after = t[t <= t1], t[t > t1]
    start = float(before[-1]) if len(before) else t0
    end = float(after[0]) if len(after) else float(run.t[-1])
    clear = _CLEAR * (end - start)
    low, high = start + clear if len(before) else t0, end - clear if end < beyond else beyond
    passed = CrossingSequence.of(run, until=t1)
    horizon = min(max(t1, low), high)
    if not _is_certain(run, other, horizon):
        return Expected(UNCERTAIN, passed, horizon, size, _OTHER_WORDS[UNCERTAIN])
    return Expected(Status.COMPLETED, passed, horizon, size)


def _is_certain(run: Trajectory, other: Trajectory, until: float) -> bool:
    """Whether two runs of the reference have the same crossings up to a time, each nearly at the same time."""
    one, two = (CrossingSequence.of(each, until=until) for each in (run, other))
    if other.status is not run.status and other.t[-1] < until:
        return False
    if len(one) != len(two) or (one.modes != two.modes).any():
        return False
    gaps = np.diff(np.concatenate([run.t[:1], one.t, [until]]))
    return bool((np.abs(one.t - two.t) <= _SAME * np.minimum(gaps[:-1], gaps[1:])).all())


def judge(
    system: PiecewiseSystem, x0: tuple[float, ...], t0: float, expected: Expected, method: str, taus: Iterable[float],
    max_steps: int, transition: str = "mannshardt", sliding: str = "stop", given_up: GivenUp | None = None,
) -> list[Verdict]:  # fmt: skip
    """Run a method with each step size, and compare ending and crossings with the solution.

    Raises
    ------
    Cancelled
        If told to stop.
    """
    given = transition, sliding, GivenUp() if given_up is None else given_up
    runs = runs_of(system, x0, (t0, expected.horizon), method, taus, max_steps, *given)
    return [_verdict(run, expected) for run in runs]


def _verdict(run: EndedRun, expected: Expected) -> Verdict:
    status, passed = run.status, run.passed
    outcome, message = int(status), status.reason
    if status != expected.status:
        if status is Status.COMPLETED and expected.status != UNCERTAIN:
            outcome, message = WENT_ON, f"it continues where the solution stops because {expected.reason}"
    elif status in _COUNTED and (difference := passed.difference(expected.crossings)):
        outcome, message = WRONG_CROSSINGS, difference
    return Verdict(outcome, passed.tally, run.error, message)
