"""sweep(): what runs leave on a surface after a transient, for each value of a parameter: a bifurcation diagram."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from core.codegen.rounding import with_roundings
from core.ensemble import Ensemble, ensemble
from core.interface.arguments import choice, numbers
from core.interface.cancelling import Cancel
from core.interface.tasks import check_hooks
from core.kernels.arrays import Floats
from core.maps.section import Section, section
from core.system import PiecewiseSystem, Start
from core.systems import System, system_of
from core.transition.status import Status

__all__ = ["Sweep", "sweep"]

#: Roundings of a switching function below which a state is on the surface.
_ON = 8.0
#: Arguments of `section` that a sweep gives itself.
_SET = ("parameters", "coordinates")
#: Runs of a continuation that are looked into for a message.
_LOOKED_INTO = 4
_CONTINUATIONS = ("none", "up", "down")


@dataclass(frozen=True, eq=False)
class Sweep:
    """A bifurcation diagram: points over values of a parameter."""

    parameter: str
    coordinate: str
    values: Floats
    """(v,) values, as given."""
    statuses: tuple[Status, ...]
    """(v,) how the run of each ended: CROSSING_LIMIT, or EVENT_LIMIT, where it has all its points and could go on."""
    value: Floats
    """(c,) value of each point."""
    points: Floats
    """(c,) coordinate of each point; where a reset map acts, that after it."""
    following: Floats
    """(d,) state in which a continuation goes on, with further values."""
    begins: float
    """Time at which it goes on: of laws that contain t the time goes on, too."""
    region: str | None
    """Name of the region in which it goes on, where regions have names."""
    sides: Floats
    """(surfaces,) signs of the switching functions there, if the parameter moves a surface: 0 on it; else empty."""
    ensembles: tuple[Ensemble, ...] = field(repr=False)
    """What has run: all values together, or, with a continuation, each by itself."""

    def __len__(self) -> int:
        return len(self.points)

    @cached_property
    def message(self) -> str:
        """How the runs ended, and a warning of steps that are too long, with the value of the parameter.

        With a continuation, those runs are looked into in which rates change most.
        """
        found, counts = np.unique(np.array(self.statuses, dtype=int), return_counts=True)
        ends = ", ".join(f"{n} {Status(code).name}" for code, n in zip(found.tolist(), counts.tolist(), strict=True))
        worst = sorted(self.ensembles, key=lambda one: -float(np.nan_to_num(one.unlike).max(initial=0.0)))
        told = (one.message.partition(". ")[2] for one in worst[:_LOOKED_INTO])
        return f"{len(self.values)} values of {self.parameter}: {ends}. {next(filter(None, told), '')}".strip()

    def __repr__(self) -> str:
        return f"<Sweep: {len(self)} points of {self.coordinate} over {len(self.values)} values of {self.parameter}>"


def sweep(
    system: System,
    t_span: tuple[float, float],
    parameter: str,
    values: ArrayLike,
    coordinate: str,
    x0: Start | None = None,
    *,
    points: int,
    discard: int = 0,
    continuation: str = "none",
    after: Sweep | None = None,
    executor: Executor | None = None,
    cancel: Cancel | None = None,
    progress: Callable[[float], object] | None = None,
    **settings: Any,
) -> Sweep:
    """Find what is left of a run after a transient, for each value of a parameter.

    Parameters
    ----------
    system
        A system, or a key of CATALOGUE.
    t_span
        Start and latest end time of each run.
    parameter, values
        Name of a parameter, and its (v,) values.
    coordinate
        Variable that is shown of each point of the section.
    x0
        Initial state; the system's own where not given.
    points, discard
        Number of points for each value, and of those before which are left out, as of `section`.
    continuation
        "none": each run begins at x0, and all run side by side. "up", "down": each begins where the run of the next
        smaller, or larger, value has ended (or a little later, if the parameter moves a surface), so that it follows a
        branch for as long as that attracts: in the region of that end, if regions have names, and if the laws contain
        t, at that time, in the same phase of what drives them; it lasts as long as the first. The next begins at x0
        after a run that has stopped, and where the surface has moved over that state.
    after
        The part of a continuation before, which goes on from there.
    executor, cancel, progress
        As of `ensemble`; with a continuation, runs follow each other, and there is no use for an executor.
    **settings
        Others of `section`: of, direction, tau, method, tolerance, max_steps, sliding; and region, that of the first
        run of a continuation.

    Returns
    -------
    Sweep
        Cancelled, it has the points of the values that are done.

    Raises
    ------
    ValueError
        On arguments that make no sense.
    """
    check_hooks(cancel, progress, executor)
    _check_settings(settings)
    own = system_of(system)
    given = numbers(values, "values")
    if given.ndim != 1:
        raise ValueError(f"values has shape {given.shape}: (v,) is needed")
    first = _Begin(t_span[0], np.array(own.x0 if x0 is None else own.check_state(x0)), settings.pop("region", None))
    common = {"points": points, "discard": discard, "coordinates": (coordinate,), "cancel": cancel, **settings}
    if choice(continuation, "continuation", _CONTINUATIONS) == "none":
        found = section(
            own, t_span, first.x, {parameter: given}, region=first.region, executor=executor, progress=progress,
            **common,
        )  # fmt: skip
        statuses, of_points = tuple(map(Status, found.ensemble.status.tolist())), given[found.member]
        return Sweep(
            parameter, coordinate, given, statuses, of_points, found.points[:, 0], first.x, first.t, first.region,
            np.empty(0), (found.ensemble,),
        )  # fmt: skip
    ends = [Status.CANCELLED] * len(given)
    order = np.argsort(given, kind="stable")[:: 1 if continuation == "up" else -1]
    parts: dict[int, Floats] = {}
    ensembles: list[Ensemble] = []
    moves = any(symbol.name == parameter for g in own.laws.surfaces for symbol in g.free_symbols)
    lasts = t_span[1] - t_span[0]
    here, sides = (first, np.empty(0)) if after is None else (_Begin.after(after), after.sides)
    for done, k in enumerate(order.tolist(), start=1):
        if cancel is not None and cancel():
            break
        value = {parameter: given[k : k + 1]}
        if len(sides) and (sides * _sides(own, here, value) < 0.0).any():
            here = first
        one = section(own, (here.t, here.t + lasts), here.x, value, region=here.region, **common)
        ends[k], parts[k] = Status(int(one.ensemble.status[0])), one.points[:, 0]
        ensembles.append(one.ensemble)
        last, goes_on = one.ensemble, ends[k] in (Status.CROSSING_LIMIT, Status.EVENT_LIMIT, Status.COMPLETED)
        if moves and ends[k] is Status.CROSSING_LIMIT:
            last = _going_on(own, here.t, one, value, settings)
            goes_on = last.status[0] == Status.COMPLETED
        here = _Begin.at_end(own, last, first.t) if goes_on else first
        if moves:
            sides = _sides(own, here, value)
        if progress is not None:
            progress(done / len(given))
    shown = [k for k in range(len(given)) if k in parts]
    repeated = np.repeat(given[shown], [len(parts[k]) for k in shown])
    coordinates = np.concatenate([np.empty(0), *(parts[k] for k in shown)])
    return Sweep(
        parameter, coordinate, given, tuple(ends), repeated, coordinates, here.x, here.t, here.region, sides,
        tuple(ensembles),
    )  # fmt: skip


class _Begin(NamedTuple):
    """Where a run begins: at a time, in a state and, if regions have names, in one of them."""

    t: float
    x: Floats
    region: str | None

    @classmethod
    def after(cls, before: Sweep) -> _Begin:
        """Where a continuation goes on."""
        return cls(before.begins, before.following, before.region)

    @classmethod
    def at_end(cls, own: PiecewiseSystem, run: Ensemble, t0: float) -> _Begin:
        """Where a run has ended; at time t0 if the time is no matter."""
        t = float(run.t[0]) if own.laws.names_time else t0
        return cls(t, run.x[0], own.laws.named_region(int(run.mode[0])))


def _going_on(
    own: PiecewiseSystem, began: float, one: Section, value: Mapping[str, Floats], settings: Mapping[str, Any]
) -> Ensemble:
    """Continue a run by half of the mean time between two crossings.

    Where it has ended, on the surface, would be beyond that of another parameter.
    """
    at, x, region = float(one.ensemble.t[0]), one.ensemble.x, own.laws.named_region(int(one.ensemble.mode[0]))
    later = at + (at - began) / int(one.ensemble.crossing_count[0]) / 2
    how = {name: given for name, given in settings.items() if name not in ("of", "direction")}
    return ensemble(own, (at, later), x, value, region=region, **how)


def _check_settings(settings: Mapping[str, Any]) -> None:
    """Refuse arguments that `section` does not take, or that a sweep gives itself."""
    own = {*inspect.signature(sweep).parameters, *_SET}
    known = [name for name in inspect.signature(section).parameters if name not in own]
    for name in settings:
        if name not in known:
            raise ValueError(f"{name} is not an argument of a sweep; of those of section it takes {', '.join(known)}")


def _sides(own: PiecewiseSystem, here: _Begin, value: Mapping[str, Floats]) -> Floats:
    """Return (surfaces,) signs of the switching functions where a run begins; 0 where it is on one, to rounding.

    And of those that do not bound its region, if regions have names: it is no matter on which side of them it is.
    """
    laws = own.laws
    p = np.array([value.get(name, np.array([given])) for name, given in own.values.items()])
    both = laws.evaluate("surfaces", with_roundings(laws.surfaces), here.t, here.x[None], p)[0]
    heights, roundings = np.split(both, 2)
    sides = np.where(np.abs(heights) <= _ON * np.finfo(float).eps * roundings, 0.0, np.sign(heights))
    if here.region is not None:
        guards = {way.surface for way in laws.ways[laws.numbers_of_modes[here.region]]}
        sides[[k for k in range(len(sides)) if k not in guards]] = 0.0
    return sides
