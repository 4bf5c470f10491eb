"""A run that has ended, as a `Trajectory`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from core.integration.hits import all_crossings
from core.integration.outcome import cause_of
from core.integration.recorded import Entry, Once, Point, states_of
from core.integration.recording import Sampler
from core.integration.run import Run
from core.integration.run_settings import Asked
from core.integration.trajectory import Trajectory
from core.kernels.arrays import Floats

__all__ = ["trajectory_of"]


def trajectory_of(
    run: Run, record: str, keep_crossings: bool, sampler: Sampler | None, warn: Callable[[Trajectory], str]
) -> Trajectory:
    """Return what a run has come to.

    Parameters
    ----------
    record, warn
        As of `Trajectory`.
    keep_crossings
        Whether the run has kept its crossings.
    sampler
        What has replaced its rows, if anything.
    """
    settings, adaptive, segment = run.settings, run.method.adaptive, run.segment
    rows, entered = (run.rows, ()) if sampler is None else (sampler.rows, sampler.entered)
    entries = None if keep_crossings else (Entry(0, run.t0, run.start), *entered)
    if entries is not None and segment > 0:
        entries += (run.entry,)
    first = Point(run.t0, run.start, run.first_mode)
    return Trajectory.of_fields({
        "system": run.system,
        "method": run.method.name,
        "tau": run.longest if adaptive else settings.tau,
        "crossing_count": run.crossing_count,
        "status": run.status,
        "steps": run.steps,
        "evaluations": run.evaluations,
        "seconds": run.seconds,
        "states": Once(states_of, first, rows, run.last, segment, entries),
        "met": Once(all_crossings, run.chunks if keep_crossings else [], run.system.laws),
        "entries": entries,
        "cause": cause_of(run),
        "envelope": _envelope(run.envelope) if len(run.envelope) else None,
        "warn": warn,
        "asked": _asked(run),
        "record": record,
        "tolerance": settings.tolerance if adaptive else math.nan,
        "samples": run.samples,
        "unlike": run.unlike,
        "passes": run.passes,
        "slides": settings.slides,
        "events": run.log.events(),
    })  # fmt: skip


def _asked(run: Run) -> Asked:
    """What a run was asked for, without the function by which it can be cancelled, which no file can hold."""
    settings = run.settings if run.settings.cancel is None else replace(run.settings, cancel=None)
    return Asked(run.t0, run.start, run.t_end, settings)


def _envelope(found: Floats) -> Floats:
    """Least and greatest errors of ψ; nan in parts of the time in which no step ended."""
    kept = found.copy()
    kept[~np.isfinite(kept)] = np.nan
    return kept
