"""The figures of one run, for the text below the portrait."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

import core
from core.diagnostics import step_warning
from core.integration import largest_size
from pwsviz.geometry.polyline_reduction import Floats
from pwsviz.geometry.shades import shades_of
from pwsviz.results.requests import RunInputs
from pwsviz.scene.names import as_met, met_at_surfaces, tally_of, told
from pwsviz.text.advice import locating, on_page

__all__ = ["Summary", "summary_of", "warning_of"]


@dataclass(frozen=True)
class Summary:
    """The figures of one run, for the text below the portrait."""

    method: str
    steps: int
    met: core.Tally
    """How often the run crossed, jumped and slid."""
    seconds: float
    worst_error: float
    status: core.Status
    message: str
    """Where and why it stopped early; empty if it reached the end time."""
    t_end: float = math.nan
    """Time at which it ended."""
    begins: str = ""
    """That it rests, or slides along a surface, from its start on; empty where it does neither."""

    meets: str = "crossings"
    """What runs of its system meet at the surfaces: crossings, jumps or both."""

    @property
    def course(self) -> str:
        """How it begins, if that is worth a word, and how often it crossed, jumped and slid."""
        met = "" if self.begins and not any(self.met[:3]) else told(self.met, self.meets)
        return ", ".join(filter(None, (self.begins, met)))


def summary_of(inputs: RunInputs, run: core.Trajectory, error: Floats) -> Summary:
    """Return the figures of a run, of which `error` is the accumulated error of each ψ at each state."""
    sizes = largest_size(error[shades_of(run.system, run.mode) != 0])
    return Summary(
        method=inputs.scheme.method,
        steps=int(run.steps),
        met=tally_of(run),
        seconds=float(run.seconds),
        t_end=float(run.t[-1]),
        worst_error=float(np.fmax.reduce(sizes, initial=np.nan)),
        status=run.status,
        message=_message(run) if run.status is not core.Status.COMPLETED else "",
        begins=_beginning(run),
        meets=met_at_surfaces(run.system),
    )


def _message(run: core.Trajectory) -> str:
    """Return why a run ended, with what it meets at its surfaces by its name."""
    return as_met(on_page(run.outcome, run.system.variables), met_at_surfaces(run.system))


def warning_of(run: core.Trajectory, locate: bool = True) -> str:
    """Return what is said against the step size of a run; empty if that is nothing. It takes longer than many a run.

    One that steps over surfaces is not mended by shorter steps: there the advice is to `locate` crossings first.
    """
    words = on_page(step_warning(run), run.system.variables)
    return words if locate or not run.crossing_count else locating(words)


def _beginning(run: core.Trajectory) -> str:
    """Say that a run rests, or slides, from its start on; empty where it does neither."""
    if run.t[-1] == run.t[0]:
        return ""
    where = " on the surface" if run.sliding[0] else ""
    if bool((run.x[-1] == run.x[0]).all()) and bool((run.x == run.x[0]).all()):
        return f"at rest{where} from t = 0 on"
    if not where:
        return ""
    ends = run.crossings.passed.t
    return f"slides from t = 0 {f'to t = {ends[0]:.4g}' if len(ends) else 'on'}"
