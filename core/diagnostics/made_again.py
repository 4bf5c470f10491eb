"""The first steps of a run that has not recorded them, made again: what is recorded hides no step from the checks."""

from __future__ import annotations

from dataclasses import replace

from core.integration.finished import trajectory_of
from core.integration.runner import Runner
from core.integration.trajectory import Trajectory
from core.methods import METHODS

__all__ = ["with_steps"]

#: Most steps that are made again: some 10 ms, and the checks of them some 100 ms.
_MOST = 50_000


def with_steps(run: Trajectory) -> Trajectory:
    """A run itself if it has recorded its steps; else its first steps made again, which are the same bit by bit.

    If these are all of its steps, the run ends as it did.
    """
    if run.record == "steps" or run.asked is None or run.steps == 0:
        return run
    asked, count = run.asked, min(run.steps, _MOST)
    settings = replace(asked.settings, max_steps=count)  # no step that failed is made again: why it did takes long
    runner = Runner(run.system, METHODS[run.method], asked.t0, asked.x0, settings)
    runner.advance(asked.t_end, record=True)
    again = trajectory_of(runner, "steps", True, None, run.warn)
    runner.release()
    if again.steps < run.steps:
        return again
    return Trajectory.of_fields({**again.__dict__, "status": run.status, "cause": run.cause})
