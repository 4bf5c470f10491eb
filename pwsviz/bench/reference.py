"""What the end states are measured against: by nothing that is compared."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import core
from pwsviz.bench.heyoka_rival import HeyokaRun, installed_heyoka
from pwsviz.bench.problems import Problem

__all__ = ["Reference", "reference_of"]

_TOLERANCE = 1e-18


class Reference(NamedTuple):
    """State at the end of a problem."""

    name: str
    """What it rests on."""
    state: NDArray[np.float64]
    """(d,)"""
    crossings: int
    """How many there are before the end."""


def reference_of(problem: Problem) -> Reference:
    """The exact solution where a closed form is known, else heyoka in extended precision, else SciPy's DOP853.

    Only the last is too coarse for the smallest errors: at the end of 500 crossings it is good to some 1e-11.
    """
    solution = core.reference_solution(problem.system)
    heyoka = installed_heyoka()
    if not solution.name.startswith("exact") and hasattr(heyoka, "taylor_adaptive_ldbl"):
        run = HeyokaRun(problem, np.longdouble(_TOLERANCE), counting=True, extended=True)
        run.run()
        return Reference(f"heyoka in extended precision, tolerance {_TOLERANCE:g}", run.state, run.crossings)
    state = solution.state(problem.end)
    crossings = 0
    while True:
        try:
            t, _ = solution.crossing(crossings + 1)
        except ValueError:
            break
        if t > problem.end:
            break
        crossings += 1
    return Reference(solution.name, state, crossings)
