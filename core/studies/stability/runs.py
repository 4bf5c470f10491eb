"""Runs of one method from one start with many step sizes: how each ends, its crossings, its largest |Δψ|."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from core.integrate import checked_method, checked_settings
from core.integration.members import Block, Members, Wanted, integrate_members
from core.integration.trajectory import Status
from core.interface.cancelling import raise_if
from core.interface.tasks import GivenUp
from core.studies.sequence import CrossingSequence
from core.system import PiecewiseSystem
from core.transition.records import NO_MODE

__all__ = ["EndedRun", "runs_of"]

#: Endings after which Δψ is a difference of huge numbers.
_GONE = (Status.ESCAPED, Status.UNSTABLE)


class EndedRun(NamedTuple):
    """What a run has come to."""

    status: Status
    passed: CrossingSequence
    """The crossings after which it went on."""
    error: float
    """Largest |Δψ| off the surface, see `Trajectory.change_of_psi`; nan where no ψ is known, where it is undefined, and
    if the run has escaped or become unstable: its Δψ would be a difference of huge numbers."""


def runs_of(
    system: PiecewiseSystem, x0: tuple[float, ...], t_span: tuple[float, float], method: str, taus: Iterable[float],
    max_steps: int, transition: str, sliding: str, given_up: GivenUp,
) -> list[EndedRun]:  # fmt: skip
    """Run a method with each step size, in the compiled loop.

    Raises
    ------
    Cancelled
        If given up.
    """
    chosen = checked_method(system, method)
    each = [
        checked_settings(
            chosen, tau, transition=transition, max_crossings=max_steps, max_steps=max_steps, sliding=sliding
        )
        for tau in taus
    ]
    x, p = np.empty((len(each), system.dimension)), np.empty((len(each), len(system.parameters)))
    x[:], p[:] = x0, system.parameter_array
    block = integrate_members(Members.of(system, chosen, each[0], each, t_span, x, p, Wanted(psi=1), given_up))
    raise_if(given_up)
    ends = block.ends
    error = np.where(np.isin(ends["status"], _GONE), np.nan, ends["change_of_psi"])
    statuses = map(Status, ends["status"].tolist())
    return list(map(EndedRun, statuses, _passed(system, block), error.tolist()))


def _passed(system: PiecewiseSystem, block: Block) -> list[CrossingSequence]:
    hits, first = block.hits, block.ends["first_mode"]
    went_on = hits["mode"] != NO_MODE
    member = np.repeat(np.arange(len(first)), block.ends["kept"])[went_on]
    t, mode = hits["t"][went_on], hits["mode"][went_on]
    bounds = np.searchsorted(member, np.arange(len(first) + 1))
    modes = np.insert(mode, bounds[:-1], first)
    parts = enumerate(pairwise(bounds.tolist()))
    return [CrossingSequence(system, t[a:b], modes[a + k : b + k + 1]) for k, (a, b) in parts]
