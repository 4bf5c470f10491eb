"""Whether a motion has come to rest: whether it goes on by round-off only."""

from __future__ import annotations

import numpy as np

import core
from core import Status
from core.kernels import Floats
from pwsviz.geometry.section_plane import names_time
from pwsviz.results.requests import USUAL_METHOD

__all__ = ["ROUND_OFF", "first_at_rest"]

ROUND_OFF = 8 * float(np.finfo(float).eps)
"""Change of the state, relative to the largest one on the way, that is none."""

STEPS = 1000
"""Steps on which a motion at rest does not change the state: without t in the laws, it never will."""

FAR = 1e9
"""Time that these steps do not reach."""


def first_at_rest(system: core.PiecewiseSystem, states: Floats, size: float, sliding: str) -> int:
    """Return the number of the first of some states from which the motion goes on by round-off only.

    Parameters
    ----------
    states
        (n, d) states of one motion, in the order of time. Once at rest, it stays so.
    size
        Largest |number| of its states.
    sliding
        As of `core.integrate`.

    Returns
    -------
    int
        n if there is none, as where the laws contain t.
    """
    low, high = 0, len(states)
    if not high or names_time(system, "") or not _rests(system, states[-1], size, sliding):
        return high
    high -= 1
    while low < high:
        middle = (low + high) // 2
        if _rests(system, states[middle], size, sliding):
            high = middle
        else:
            low = middle + 1
    return high


def _rests(system: core.PiecewiseSystem, x: Floats, size: float, sliding: str) -> bool:
    """Whether the next steps from a state lead nowhere."""
    try:
        run = core.integrate(
            system, (0.0, FAR), tuple(x.tolist()), method=USUAL_METHOD, max_steps=STEPS, sliding=sliding
        )
    except ValueError:  # no run begins here
        return False
    return run.status is Status.STEP_LIMIT and float(np.abs(run.x - x).max()) <= ROUND_OFF * size
