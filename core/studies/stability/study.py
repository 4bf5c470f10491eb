"""stability_study(): check the arguments, compute the parts asked for, report progress after each task."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import Any, Protocol

from core.interface.arguments import listed
from core.interface.cancelling import Cancel
from core.interface.tasks import check_hooks
from core.methods import Method
from core.studies.stability import drift, grazing, largest, outcomes
from core.studies.stability.drift import Drift
from core.studies.stability.grazing import Grazing
from core.studies.stability.largest import LargestTau
from core.studies.stability.outcomes import OutcomeMap
from core.studies.stability.plan import Plan, checked_plan
from core.studies.stability.verdict import REFERENCE
from core.system import Start
from core.systems import System, system_of

__all__ = ["PARTS", "StabilityStudy", "stability_study"]

PARTS = ("largest_tau", "map", "drift", "grazing")


class _Part(Protocol):
    """The module of a part of the study."""

    def count(self, plan: Plan) -> int:
        """Number of tasks."""

    def run(self, plan: Plan, executor: Executor | None, cancel: Cancel | None) -> Iterator[Any]:
        """Yield the results so far after each task."""


_PARTS: dict[str, _Part] = {"largest_tau": largest, "map": outcomes, "drift": drift, "grazing": grazing}


@dataclass(frozen=True, eq=False)
class StabilityStudy:
    """The parts of a stability study; a part is None if it was not asked for, or not reached."""

    system: str
    """Name of the system."""
    methods: tuple[str, ...]
    t_span: tuple[float, float]
    x0: tuple[float, ...]
    coordinate: int
    """Index of the coordinate of x₀ that is varied."""
    coordinate_name: str
    """Its name."""
    reference: str
    """The reference for endings and crossings; for runs near a tangency it is `reference_solution`."""
    largest_tau: LargestTau | None = None
    map: OutcomeMap | None = None
    drift: Drift | None = None
    grazing: Grazing | None = None
    complete: bool = False
    """Whether all parts asked for are complete."""

    def __repr__(self) -> str:
        parts = ", ".join(part for part in PARTS if getattr(self, part) is not None) or "nothing yet"
        methods, span = ", ".join(self.methods), f"t = {self.t_span[0]:g} … {self.t_span[1]:g}"
        done = "complete" if self.complete else "not complete"
        return f"<StabilityStudy of {methods} on {self.system!r} over {span}: {parts}; {done}>"


def stability_study(
    system: System,
    t_span: tuple[float, float] | None = None,
    x0: Start | None = None,
    methods: Sequence[str | Method] | str | Method = ("dmm2", "rk2"),
    taus: Iterable[float] | None = None,
    coordinate: int | str = 0,
    values: Iterable[float] | None = None,
    parts: Sequence[str] = PARTS,
    *,
    tau: float | None = None,
    steps: int = 1_000_000,
    transition: str = "mannshardt",
    sliding: str = "stop",
    executor: Executor | None = None,
    progress: Callable[[int, int, StabilityStudy], object] | None = None,
    cancel: Cancel | None = None,
) -> StabilityStudy:
    """Find out how far a method can be trusted.

    Parameters
    ----------
    system
        A system, or a key of CATALOGUE.
    t_span
        Start and end time, the end later: 0 and 20 where not given.
    x0
        d numbers, or a mapping from the names of the variables; the system's own x0 where not given.
    methods
        Keys of METHODS, or its values.
    taus
        2 to 400 step sizes, for the largest τ and the map; 25 from 1/20,000 to 1/10 of the time span where not given. A
        run of more than 50,000 steps ends with STEP_LIMIT.
    coordinate
        Index or name of the coordinate of x₀ that is varied.
    values
        2 to 400 values of it; where not given, 25 over the range of the trajectory and a fifth of it beyond each end.
    parts
        The parts to compute:
        "largest_tau", the largest step size that works (`LargestTau`);
        "map", outcomes of runs over (τ, value) (`OutcomeMap`);
        "drift", the error of ψ in a long run (`Drift`);
        "grazing", runs near a tangency (`Grazing`).
    tau
        Step size of the long run and of the runs near a tangency; 1/1000 of the time span where not given.
    steps
        Number of steps of the long run; all methods run to the same time, tau · steps.
    transition
        As in `integrate`, for all runs but the reference.
    sliding
        As in `integrate`, for all runs.
    executor
        Where tasks run; threads of its own where not given. See `as_completed`.
    progress
        Called as ``progress(done, total, partial)`` after each task, in the caller's thread.
    cancel
        Called twenty times a second; once it returns True, the study so far is returned.

    Raises
    ------
    ValueError
        On arguments that make no sense, naming the value and what would do.
    """
    check_hooks(cancel, progress, executor)
    system = system_of(system)
    wanted = _checked_parts(parts)
    plan = checked_plan(system, t_span, x0, methods, taus, coordinate, values, tau, steps, transition, sliding, cancel)
    name = system.variables[plan.coordinate]
    study = StabilityStudy(system.name, plan.methods, plan.t_span, plan.x0, plan.coordinate, name, REFERENCE)
    total, before = sum(_PARTS[part].count(plan) for part in wanted), 0
    cancelled = cancel if cancel is not None else _never
    for part in wanted:
        for done, found in enumerate(_PARTS[part].run(plan, executor, cancel), start=1):
            study = replace(study, **{part: found})
            if progress is not None:
                progress(before + done, total, study)
            if cancelled():
                return study
        if cancelled():
            return study
        before += _PARTS[part].count(plan)
    return replace(study, complete=True)


def _never() -> bool:
    return False


def _checked_parts(parts: Sequence[str]) -> list[str]:
    given = listed(parts, "parts", "a tuple is needed, as in ('map', 'drift')", str)
    if not given or any(not isinstance(part, str) or part not in PARTS for part in given):
        raise ValueError(f"parts = {parts!r}: choose from {', '.join(PARTS)}")
    return [part for part in PARTS if part in given]
