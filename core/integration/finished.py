"""A run that has ended, as a `Trajectory`."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from core.integration.hits import all_crossings
from core.integration.outcome import cause_of
from core.integration.recorded import Entry, Once, Point, states_of
from core.integration.recording import Sampler
from core.integration.runner import Runner
from core.integration.trajectory import Trajectory
from core.kernels.arrays import Floats

__all__ = ["trajectory_of"]


def trajectory_of(
    runner: Runner, record: str, keep_crossings: bool, sampler: Sampler | None, warn: Callable[[Trajectory], str]
) -> Trajectory:
    """Return what a run has come to; it is not to be advanced further.

    Parameters
    ----------
    record, warn
        As of `Trajectory`.
    keep_crossings
        Whether the runner has kept its crossings.
    sampler
        What has replaced its rows, if anything.
    """
    settings, adaptive, segment = runner.settings, runner.method.adaptive, runner.segment
    rows, entered = (runner.rows, ()) if sampler is None else (sampler.rows, sampler.entered)
    entries = None if keep_crossings else (Entry(0, runner.t0, runner.start), *entered)
    if entries is not None and segment > 0:
        entries += (runner.entry,)
    first = Point(runner.t0, runner.start, runner.first_mode)
    return Trajectory.of_fields({
        "system": runner.system,
        "method": runner.method.name,
        "tau": runner.longest if adaptive else settings.tau,
        "crossing_count": runner.crossing_count,
        "status": runner.status,
        "steps": runner.steps,
        "evaluations": runner.evaluations,
        "seconds": runner.seconds,
        "states": Once(states_of, first, rows, runner.last, segment, entries),
        "met": Once(all_crossings, runner.chunks if keep_crossings else [], runner.system.laws),
        "entries": entries,
        "cause": cause_of(runner),
        "envelope": _envelope(runner.envelope) if len(runner.envelope) else None,
        "warn": warn,
        "record": record,
        "tolerance": settings.tolerance if adaptive else math.nan,
        "samples": runner.samples,
        "slides": settings.slides,
        "events": runner.log.events(),
    })  # fmt: skip


def _envelope(found: Floats) -> Floats:
    """Least and greatest errors of ψ; nan in parts of the time in which no step ended."""
    kept = found.copy()
    kept[~np.isfinite(kept)] = np.nan
    return kept
