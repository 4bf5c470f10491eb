"""The result of a run."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from core.integration.between_steps import states_at
from core.integration.conserved_error import largest_size, level_residual_along, psi_size, with_exits
from core.integration.crossings import Crossings, Integers, side_columns, with_columns
from core.integration.events import Events
from core.integration.outcome import Cause, Ending, outcome, reason
from core.integration.recorded import Entry, Once, Point, States, distinct
from core.integration.run_settings import Asked
from core.integration.tally import Tally, kinds_of
from core.interface.arguments import numbers
from core.kernels.arrays import Floats
from core.methods import METHODS
from core.system import PiecewiseSystem
from core.transition.records import NO_MODE
from core.transition.status import Status

__all__ = ["COMPARED", "Status", "Trajectory"]

COMPARED = 50_000
"""Steps of a run, the first ones, that are compared with shorter ones."""

#: Number of recorded states at which the size of ψ is evaluated.
_SAMPLE = 500


def _nothing(_run: Trajectory) -> str:
    return ""


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A run: its recorded states, its crossings, and how it ended."""

    system: PiecewiseSystem
    method: str
    tau: float
    """Step size; of a method that chooses its own, the longest it took."""
    crossing_count: int
    """Number of crossings; with ``record="end"`` they are counted but not kept."""
    status: Status
    steps: int
    """Steps taken."""
    evaluations: int
    """Evaluations of the (discrete) field."""
    seconds: float
    """Processor time inside the compiled loop."""
    states: Once[States] = field(repr=False)
    """What `t`, `x`, `mode` and `segment` are taken from."""
    met: Once[Crossings] = field(repr=False)
    """What `crossings` are taken from."""
    entries: tuple[Entry, ...] | None = field(repr=False)
    """What `entered_t` and `entered_x` are taken from; None: the start, and every crossing."""
    cause: Cause = field(repr=False)
    """What `outcome` is found from."""
    envelope: Floats | None = None
    """(columns, m, 2) least and greatest error of ψ in equal parts of the time span, if `integrate` was asked for it:
    ψ of the mode occupied less its value where that mode was entered, evaluated in double-double."""
    warn: Callable[[Trajectory], str] = field(default=_nothing, repr=False, compare=False)
    """Gives the warnings of the theory about the step size of a run, evaluated when `message` is read."""
    asked: Asked | None = field(default=None, repr=False, compare=False)
    """What it was asked for, by which its steps can be made again."""
    record: str = "steps"
    """Which states are recorded: "steps", "crossings", "end", or "t_eval" for those at given times."""
    tolerance: float = math.nan
    """Tolerance of a method that chooses its own step size; else nan."""
    samples: Floats | None = field(default=None, repr=False)
    """(k, 3 + d) time, mode, length and state at the start of some steps; the length ends at a crossing."""
    unlike: Floats | None = field(default=None, repr=False)
    """(k, 3 + d) time, -, mode and state where stretches of steps begin that may hold one unlike the others."""
    passes: Floats | None = field(default=None, repr=False)
    """(k, 4 + d) time, -, row of the guard, time since the last crossing, and state where a height comes to its least
    near the surface: see `core.transition.passes`."""
    slides: bool = False
    """Whether the run was asked to slide along the surface where both fields point to it."""
    events: Events = field(default_factory=Events)
    """The events that `integrate` was asked for; the run is the same without them, but for where one ends it."""

    @cached_property
    def t(self) -> Floats:
        """(n,) times recorded; the first and the last state are always among them."""
        return self.states().t

    @cached_property
    def x(self) -> Floats:
        """(n, d) states."""
        return self.states().x

    @cached_property
    def mode(self) -> Integers:
        """(n,) index into `PiecewiseSystem.modes` of the mode occupied (−1 if the run started on the surface and could
        not leave it).
        """
        return self.states().mode

    @cached_property
    def segment(self) -> Integers:
        """(n,) index, into `entered_t`, of the segment between crossings in which each row lies."""
        return self.states().segment

    @cached_property
    def crossings(self) -> Crossings:
        """The crossings; none with ``record="end"``."""
        return self.met()

    @cached_property
    def entered_t(self) -> Floats:
        """(s,) times at which segments were entered: the start, then every crossing (with ``record="end"`` only those
        in which a state is recorded).
        """
        if self.entries is None:
            return np.concatenate([self.t[:1], self.crossings.t])
        return np.array([entry.t for entry in distinct(self.entries)])

    @cached_property
    def entered_x(self) -> Floats:
        """(s, d) the states there."""
        if self.entries is None:
            return np.concatenate([self.x[:1], self.crossings.x_after])
        return np.array([entry.x for entry in distinct(self.entries)])

    @property
    def tally(self) -> Tally:
        """How often it crossed, jumped and slid; ValueError with ``record="end"``, which does not keep crossings."""
        return Tally.of(self.kinds_met)

    @property
    def kinds_met(self) -> Integers:
        """(k,) what happened at each of ``crossings.passed``: indices into the fields of `Tally`."""
        self._require_crossings("what happened at crossings")
        return kinds_of(np.append(self.mode[:1], self.crossings.passed.mode), len(self.system.laws.regions))

    @property
    def side(self) -> Integers:
        """(n,) side occupied, −1 or +1; 0 while sliding (or if the run could not leave the surface at its start).

        Of several surfaces (n, surfaces): the sign of each switching function. Where regions have names there are no
        columns; see `mode`.
        """
        side: Integers = self.system.laws.sides[self.mode]
        return side[:, 0] if side.shape[1] == 1 else side

    @property
    def sliding(self) -> NDArray[np.bool_]:
        """(n,) whether the state slides along a surface (or could not leave it at the start)."""
        there: NDArray[np.bool_] = self._is_sliding(self.mode) | (self.mode == NO_MODE)
        return there

    def _is_sliding(self, mode: Integers) -> NDArray[np.bool_]:
        return np.asarray(mode >= len(self.system.laws.regions))

    def __repr__(self) -> str:
        step = f"tolerance = {self.tolerance:g}" if METHODS[self.method].adaptive else f"tau = {self.tau:g}"
        return (
            f"<Trajectory of {self.system.name!r} by {self.method}, {step}: t = {self.t[0]:.6g} … {self.t[-1]:.6g}, "
            f"states: {len(self.t)}, crossings: {self.crossing_count}, {self.status.name}>"
        )

    @classmethod
    def of_fields(cls, values: dict[str, Any]) -> Trajectory:
        """Make a run from all its fields; to set them one by one, as a frozen class does, takes longer than a run."""
        run = object.__new__(cls)
        object.__setattr__(run, "__dict__", values)
        return run

    @property
    def _ending(self) -> Ending:
        last = Point(float(self.t[-1]), tuple(self.x[-1].tolist()), int(self.mode[-1]))
        with np.errstate(invalid="ignore"):
            sizes = np.nan_to_num(np.abs(np.concatenate([self.x, self.crossings.x]))).max(axis=0)
        return Ending(self.system, METHODS[self.method], self.status, last, self.cause, tuple(sizes))

    @cached_property
    def outcome(self) -> str:
        """Where it stopped, why, and what to do about it."""
        return outcome(self._ending)

    @property
    def reason(self) -> str:
        """Why it ended: a clause of `outcome`."""
        return reason(self._ending)

    @cached_property
    def warning(self) -> str:
        """A warning where steps are too long, or τ exceeds a bound of the theory (see `diagnose`); else empty."""
        return self.warn(self)

    @cached_property
    def message(self) -> str:
        """The outcome, the warning, and of a long run how much of it has been looked into for that."""
        part = f"Only the first {COMPARED:,} of {self.steps:,} steps were compared with shorter ones."
        return " ".join(filter(None, (self.outcome, self.warning, part * (self.steps > COMPARED))))

    def conserved_error(self, exits: bool = True) -> Floats:
        """ψ of the mode occupied, less its value where that mode was entered, evaluated in double-double.

        The modes are both sides of the surface, and sliding along it, of which g is a conserved quantity.

        Parameters
        ----------
        exits
            Whether the last row before a crossing gives the error at the crossing, where that is larger in size (see
            `exit_error`).

        Returns
        -------
        (n, m) with m the larger number of conserved quantities; nan where the mode has fewer.
        """
        error = self._level_residual(self.t, self.x, self.mode, self.segment, self.entered_t, self.entered_x)
        return with_exits(error, self.segment, self.exit_error()) if exits else error

    def exit_error(self) -> Floats:
        """ψ of the mode left at each crossing, before any jump, less its value where that mode was entered.

        Returns
        -------
        (k, m), nan where the mode has fewer conserved quantities. With ``record="end"`` no crossing is kept; an
        `envelope` includes them all the same.
        """
        met = self.crossings
        left = np.concatenate([self.mode[:1], met.mode])[: len(met)]
        return self._level_residual(met.t, met.x, left, np.arange(len(met)), self.entered_t, self.entered_x)

    def carried_error(self) -> Floats:
        """Total error of ψ that the integrator has made before each segment between crossings.

        At a crossing ψ becomes another function, and a jump is part of the system: these changes are not errors. The
        errors added up are those at the end of every segment, and those of continuing from a state off the surface;
        those of sliding, where g is a conserved quantity too, are not carried on.

        Returns
        -------
        (s, m) for the entries of `entered_t`; the first row is 0.

        Raises
        ------
        ValueError
            If there were crossings that ``record="end"`` has not kept.
        """
        self._require_crossings("the error made before a segment")
        met = self.crossings
        off_surface = self._level_residual(met.t, met.x_after, met.mode, np.arange(len(met)), met.t, met.surface)
        off_surface[(met.kind == "jump") | (self._is_sliding(met.mode))] = 0.0
        left = np.nan_to_num(self.exit_error())
        left[met.kind == "leaving"] = 0.0
        errors = left + np.nan_to_num(off_surface)
        total = np.zeros((len(self.entered_t), errors.shape[1]))
        if len(errors):
            total[1:] = np.cumsum(errors, axis=0)[: len(total) - 1]
        return total

    def _require_crossings(self, wanted: str) -> None:
        if len(self.crossings) != self.crossing_count:
            raise ValueError(
                f"{wanted} is not known of a run that has kept {len(self.crossings)} of its {self.crossing_count} "
                "crossings: integrate with record='crossings' or record='steps'"
            )

    def _level_residual(
        self, t: Floats, x: Floats, mode: Integers, segment: Integers, entered_t: Floats, entered_x: Floats
    ) -> Floats:
        """`level_residual_along` at some states of this run."""
        entries = entered_t, entered_x
        return level_residual_along(self.system, self.method, t, x, mode, segment, *entries, sliding=self.slides)

    def accumulated_error(self) -> Floats:
        """Total error of ψ that the integrator has made since the start: in the current segment and in those before.

        Returns
        -------
        (n, m); nan where the mode occupied has fewer conserved quantities. While sliding, only the error of that.
        """
        carried = self.carried_error()[self.segment]
        carried[self._is_sliding(self.mode)] = 0.0
        return self.conserved_error(exits=False) + carried

    def change_of_psi(self) -> Floats:
        """|Δψ|: size of the accumulated error, the largest over the conserved quantities.

        Returns
        -------
        (n,); nan where no conserved quantity is known.
        """
        return largest_size(self.accumulated_error())

    def psi_size(self) -> float:
        """Largest `psi_size` at about 500 of the recorded states: rounding changes ψ by about eps times this.

        Returns
        -------
        float
            0 where no conserved quantity is known.
        """
        return float(self.psi_sizes()[1].max(initial=0.0))

    def psi_sizes(self) -> tuple[Floats, Floats]:
        """`psi_size` along the run: of one that blows up it grows by many powers of ten.

        Returns
        -------
        (k,), (k,)
            Times of about 500 recorded states, with all of the last 500; sizes there, 0 where no conserved quantity is
            known.
        """
        count = len(self.t)
        rows = np.union1d(np.arange(0, count, max(1, count // _SAMPLE)), np.arange(max(0, count - _SAMPLE), count))
        modes, found = self.mode[rows], np.zeros(len(rows))
        for number in np.unique(modes[modes >= 0]).tolist():
            there = modes == number
            found[there] = psi_size(self.system, number, self.t[rows[there]], self.x[rows[there]])
        return self.t[rows], found

    def at(self, t: ArrayLike, before: bool = False) -> Floats:
        """States at any times within the run (dense output).

        Each is reached by one step of the method itself, from the last state recorded before it or from the state after
        the last crossing before it; for "taylor" that is its Taylor polynomial. So the order is that of the method, a
        conservative method keeps ψ there to round-off, and a recorded time gives the recorded state.

        With a perturbation, crossings take place at their perturbed times, within their steps. Without a transition the
        side changes at the ends of steps only, as in the run.

        Parameters
        ----------
        t
            Times of any shape and in any order, from the first to the last of the run.
        before
            Whether to give the state before a crossing at exactly its time, instead of the one after it. They differ at
            jumps only.

        Returns
        -------
        (..., d) states.

        Raises
        ------
        ValueError
            If a time is not a number or outside the run, if it was not recorded by a run that has not recorded its
            steps, or if the equations of a step have no solution.
        """
        times = numbers(t, "t")
        return states_at(self, times.ravel(), before).reshape(*times.shape, self.x.shape[1])

    @property
    def nbytes(self) -> int:
        """Bytes of its arrays, also of those that are yet to be made."""
        states = self.t, self.x, self.mode, self.segment, self.entered_t, self.entered_x
        own = (*states, self.samples, self.unlike, self.passes, self.envelope)
        met = (getattr(part, column.name) for part in (self.crossings, self.events) for column in fields(part))
        return sum(part.nbytes for part in (*own, *met) if isinstance(part, np.ndarray))

    def columns(self) -> dict[str, NDArray[Any]]:
        """One (n,) array a column, as data frames take them: ``pandas.DataFrame(run.columns())``.

        Returns
        -------
        dict
            "t", the variables by name, "side", and for each conserved quantity "psi error" (with a number from 1 where
            there are several): see `conserved_error`.
        """
        columns: dict[str, NDArray[Any]] = {"t": self.t}
        columns |= {name: self.x[:, i] for i, name in enumerate(self.system.variables)}
        error = self.conserved_error()
        names = ["psi error"] if error.shape[1] == 1 else [f"psi error {j + 1}" for j in range(error.shape[1])]
        return with_columns(columns, {**side_columns(self.side), **{name: error[:, j] for j, name in enumerate(names)}})
