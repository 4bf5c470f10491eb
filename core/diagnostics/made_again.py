"""The first steps of a run made again: as they were, so that what is recorded hides none, or with other settings."""

from __future__ import annotations

from dataclasses import replace

from core.integration.finished import trajectory_of
from core.integration.run_settings import Asked, Settings
from core.integration.runner import Runner
from core.integration.trajectory import COMPARED, Status, Trajectory
from core.methods import METHODS

__all__ = ["anew", "first_steps", "with_steps"]

#: How runs end of which the step that failed is not made again: to find out why it did takes long.
_FAILED = (Status.NO_CONVERGENCE, Status.ESCAPED, Status.UNSTABLE, Status.SINGULAR, Status.CANCELLED)


def with_steps(run: Trajectory) -> Trajectory:
    """A run itself if it has recorded its steps; else its first steps made again, which are the same bit by bit.

    If these are all of its steps, the run ends as it did.
    """
    if run.record == "steps" or run.asked is None or run.steps == run.crossing_count == 0:
        return run
    return first_steps(run, run.asked)


def first_steps(run: Trajectory, asked: Asked) -> Trajectory:
    """The first steps of a run made again, asked for as it was, or with another clock."""
    most = min(run.steps + (run.status not in _FAILED), COMPARED)  # some 10 ms, and the checks of them some 100 ms
    again = anew(run, asked, replace(asked.settings, max_steps=most))
    if again.steps < run.steps:
        return again
    return Trajectory.of_fields({**again.__dict__, "status": run.status, "cause": run.cause})


def anew(run: Trajectory, asked: Asked, settings: Settings) -> Trajectory:
    """What a run was asked for with some settings, its steps recorded."""
    runner = Runner(run.system, METHODS[run.method], asked.t0, asked.x0, settings)
    runner.advance(asked.t_end, record=True)
    made = trajectory_of(runner, "steps", True, None, run.warn)
    runner.release()
    return made
