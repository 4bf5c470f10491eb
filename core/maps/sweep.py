"""sweep(): what runs leave on a surface after a transient, for each value of a parameter: a bifurcation diagram."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from core.interface.arguments import choice, numbers
from core.interface.cancelling import Cancel
from core.kernels.arrays import Floats
from core.maps.section import section
from core.system import Start
from core.systems import System, system_of
from core.transition.status import Status

__all__ = ["Sweep", "sweep"]

_CONTINUATIONS = ("none", "up", "down")


@dataclass(frozen=True, eq=False)
class Sweep:
    """A bifurcation diagram: points over values of a parameter."""

    parameter: str
    coordinate: str
    values: Floats
    """(v,) values, as given."""
    statuses: tuple[Status, ...]
    """(v,) how the run of each ended: CROSSING_LIMIT where it has all its points."""
    value: Floats
    """(c,) value of each point."""
    points: Floats
    """(c,) coordinate of each point."""

    def __len__(self) -> int:
        return len(self.points)

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
        smaller, or larger, value has ended, so that it follows a branch for as long as that attracts.
    executor, cancel, progress
        As of `ensemble`; with a continuation, runs follow each other, and there is no use for an executor.
    **settings
        Others of `section`: of, direction, tau, method, tolerance, max_steps, sliding.

    Returns
    -------
    Sweep
        Cancelled, it has the points of the values that are done.

    Raises
    ------
    ValueError
        On arguments that make no sense.
    """
    own = system_of(system)
    given = numbers(values, "values")
    if given.ndim != 1:
        raise ValueError(f"values has shape {given.shape}: (v,) is needed")
    start = np.array(own.x0 if x0 is None else own.check_state(x0))
    common = {"points": points, "discard": discard, "coordinates": (coordinate,), "cancel": cancel, **settings}
    if choice(continuation, "continuation", _CONTINUATIONS) == "none":
        found = section(
            own, t_span, start, {parameter: given}, executor=executor, progress=progress, **common
        )  # fmt: skip
        statuses = tuple(map(Status, found.ensemble.status.tolist()))
        return Sweep(parameter, coordinate, given, statuses, given[found.member], found.points[:, 0])
    ends = [Status.CANCELLED] * len(given)
    order = np.argsort(given, kind="stable")[:: 1 if continuation == "up" else -1]
    parts: dict[int, Floats] = {}
    here = start
    for done, k in enumerate(order.tolist(), start=1):
        if cancel is not None and cancel():
            break
        one = section(own, t_span, here, {parameter: given[k : k + 1]}, **common)
        ends[k], parts[k] = Status(int(one.ensemble.status[0])), one.points[:, 0]
        here = one.ensemble.x[0] if ends[k] in (Status.CROSSING_LIMIT, Status.COMPLETED) else start
        if progress is not None:
            progress(done / len(given))
    shown = [k for k in range(len(given)) if k in parts]
    value = np.repeat(given[shown], [len(parts[k]) for k in shown])
    return Sweep(
        parameter, coordinate, given, tuple(ends), value, np.concatenate([np.empty(0), *(parts[k] for k in shown)])
    )
