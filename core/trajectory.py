"""What a run returns: Trajectory, Crossings, Status."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from core.excess import excess_along, with_exits
from core.laws import Floats
from core.system import PiecewiseSystem

__all__ = ["CROSSING_KINDS", "Crossings", "Status", "Trajectory"]

Integers = NDArray[np.int64]


class Status(IntEnum):
    """How a run ended. Its `advice` says what to do about it."""

    RUNNING = 0
    COMPLETED = 1
    SLIDING = 2
    REPELLING = 3
    GRAZING = 4
    NO_CONVERGENCE = 5
    ESCAPED = 6
    ZENO = 7
    CROSSING_LIMIT = 8
    STEP_LIMIT = 9
    CANCELLED = 10
    CONTRADICTION = 11
    UNSTABLE = 12

    @property
    def reason(self) -> str:
        """Why a run stops so, in plain words."""
        return _WORDS[self][0]

    @property
    def advice(self) -> str:
        """What to do about it."""
        return _WORDS[self][1]


_WORDS = {
    Status.RUNNING: ("still running", ""),
    Status.COMPLETED: ("reached the end time", ""),
    Status.SLIDING: (
        "both fields point to the surface, so the state slides along it",
        "Transversal dynamics end here; a sliding flow is another system.",
    ),
    Status.REPELLING: (
        "both fields point away from the surface, so where to go on is not determined",
        "Start off the surface, on the side you want.",
    ),
    Status.GRAZING: (
        "the trajectory touches the surface without a transversal crossing",
        "Move the initial condition or a parameter a little, or take a smaller step size tau.",
    ),
    Status.NO_CONVERGENCE: (
        "the equations of the step, or the switching function, have no real solution that can be found",
        "Take a smaller step size tau.",
    ),
    Status.ESCAPED: (
        "the state runs away beyond any bound",
        "The solution may have a pole: end the run before it. If it has none, take a smaller step size tau.",
    ),
    Status.ZENO: (
        "crossings come ever closer and accumulate here (Zeno)",
        "The motion does not go on by these laws; say what follows with another system.",
    ),
    Status.CROSSING_LIMIT: ("reached max_crossings", "Raise max_crossings to go on."),
    Status.STEP_LIMIT: ("reached max_steps", "Take a larger step size tau, a shorter time, or raise max_steps."),
    Status.CANCELLED: ("cancelled", ""),
    Status.CONTRADICTION: (
        "the state lies on the other side of the surface than the one whose law it has followed",
        "This is an error of the program, not of yours: please report the system, and discard the run.",
    ),
    Status.UNSTABLE: (
        "the step is too long for this field: the scheme leaves the solution, which does not move so",
        "Take a smaller step size tau, or a method that chooses its steps (taylor).",
    ),
}

#: Names of the kinds of crossing, in the order of the compiled codes.
CROSSING_KINDS = ("transversal", "grazing", "sliding", "repelling", "jump")


@dataclass(frozen=True)
class Crossings:
    """Where a run met the switching surface."""

    t: Floats
    """(k,) times t̂."""
    x: Floats
    """(k, d) states x̂ on the surface (beside it, if moved by a perturbation)."""
    x_after: Floats
    """(k, d) states it went on from: x, or what the jump made of it."""
    surface: Floats
    """(k, d) states where the scheme itself met the surface: x, unless it was perturbed or stepped over."""
    side: Integers
    """(k,) side entered, −1 or +1; 0 where the run could not go on."""
    g: Floats
    """(k,) residual of the switching function at x."""
    kind: NDArray[np.str_]
    """(k,) one of CROSSING_KINDS."""
    rate_before: Floats
    """(k,) ∇g·f + g_t of the side left, at the surface."""
    rate_after: Floats
    """(k,) the same of the side entered."""

    def __len__(self) -> int:
        return len(self.t)

    def first(self, count: int) -> Crossings:
        """The first `count` of them."""
        return Crossings(*(getattr(self, f.name)[:count] for f in fields(self)))


def _nothing(_run: Trajectory) -> str:
    return ""


@dataclass(frozen=True)
class Trajectory:
    """A run: what was recorded, where it crossed, how it ended."""

    system: PiecewiseSystem
    method: str
    tau: float
    """Step size; of a method that chooses its own, the longest it took."""
    t: Floats
    """(n,) times recorded; the first and the last state are always among them."""
    x: Floats
    """(n, d) states."""
    side: Integers
    """(n,) side occupied, −1 or +1 (0 if the run started on the surface and could not leave it)."""
    segment: Integers
    """(n,) which segment between crossings each row lies in: an index into `entered_t`."""
    entered_t: Floats
    """(s,) when each segment was entered: the start, then every crossing (of ``record="end"`` only the last)."""
    entered_x: Floats
    """(s, d) the states there."""
    crossings: Crossings
    crossing_count: int
    """How many crossings there were; with ``record="end"`` they are counted but not kept."""
    status: Status
    outcome: str
    """Where it stopped, why, and what to do about it."""
    steps: int
    """Steps taken."""
    evaluations: int
    """Evaluations of the (discrete) field."""
    seconds: float
    """Processor time inside the compiled loop."""
    envelope: Floats | None = None
    """(columns, m, 2) least and greatest error of ψ in equal parts of the time asked for, where `integrate` was asked
    to keep it: ψ of the side occupied less its value where that side was entered, worked out in double-double."""
    warn: Callable[[Trajectory], str] = field(default=_nothing, repr=False, compare=False)
    """What the theory has to say against the step size of such a run, worked out when `message` is asked for."""

    @cached_property
    def message(self) -> str:
        """The outcome, and a warning where the step size exceeds a bound of the theory (see `diagnose`)."""
        return f"{self.outcome} {self.warn(self)}".strip()

    def conserved_error(self, exits: bool = True) -> Floats:
        """ψ of the side occupied, less its value where that side was entered, worked out in double-double.

        Parameters
        ----------
        exits
            Whether a row also tells of the crossings met since the row before, where a side was left with an error
            that is larger (see `exit_error`).

        Returns
        -------
        (n, m) with m the larger number of conserved quantities; nan where the side has fewer.
        """
        error = excess_along(
            self.system, self.method, self.t, self.x, self.side, self.segment, self.entered_t, self.entered_x
        )
        return with_exits(error, self.segment, self.exit_error()) if exits else error

    def exit_error(self) -> Floats:
        """ψ of the side left at each crossing, before any jump, less its value where that side was entered.

        Returns
        -------
        (k, m), nan where the side has fewer conserved quantities. With ``record="end"`` no crossing is kept: an
        `envelope` sees them all the same.
        """
        met = self.crossings
        left = np.concatenate([self.side[:1], met.side])[: len(met)]
        visits = np.arange(len(met))
        return excess_along(self.system, self.method, met.t, met.x, left, visits, self.entered_t, self.entered_x)

    def carried_error(self) -> Floats:
        """Change of ψ that the integrator has made by the time each segment between crossings begins, in all.

        At a crossing ψ changes its meaning and its value, which is no error, and a jump is part of the system. What is
        added up is what every visit to a side has lost by its end, and what going on from beside the surface loses.

        Returns
        -------
        (s, m) beside `entered_t`, the first row 0.
        """
        met = self.crossings
        beside = excess_along(
            self.system, self.method, met.t, met.x_after, met.side, np.arange(len(met)), met.t, met.surface
        )
        beside[met.kind == "jump"] = 0.0
        lost = np.nan_to_num(self.exit_error()) + np.nan_to_num(beside)
        total = np.zeros((len(self.entered_t), lost.shape[1]))
        if len(lost):
            total[1:] = np.cumsum(lost, axis=0)[: len(total) - 1]
        return total

    def accumulated_error(self) -> Floats:
        """Change of ψ that the integrator has made since the start: within the visit, and in those before.

        Returns
        -------
        (n, m); nan where the side occupied has fewer conserved quantities.
        """
        return self.conserved_error(exits=False) + self.carried_error()[self.segment]
