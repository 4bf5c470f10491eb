"""What an integrator makes of the conserved quantity, along the steps and at the crossings."""

from __future__ import annotations

import numpy as np

import core
from pwsviz.curves import Floats


def accumulated_error(run: core.Trajectory) -> Floats:
    """Change of ψ that the integrator made, added up over the visits to both sides.

    At a crossing ψ changes its meaning and its value, which is no error; so each visit is measured from where the side
    was entered, and what the visit lost by its end is carried on. So is what was lost at the crossing itself, by going
    on from another place than where the scheme met the surface. Of several conserved quantities the worst is taken.

    Returns
    -------
    (n,) array
        Absolute values; NaN where no conserved quantity is known.
    """
    within = run.conserved_error()
    if within.shape[1] == 0:
        return np.full(len(within), np.nan)
    visits = len(run.entered_t) - 1
    lost = np.zeros((visits + 1, within.shape[1]))
    lost[1:] = _lost_on_visits(run, visits, within.shape[1]) + _lost_at_crossings(run, visits, within.shape[1])
    total = within + np.cumsum(lost, axis=0)[run.segment]
    worst = np.abs(total[:, 0])
    for other in total.T[1:]:
        np.fmax(worst, np.abs(other), out=worst)
    return worst


def _lost_on_visits(run: core.Trajectory, visits: int, count: int) -> Floats:
    """Change of ψ from where each side was entered to where it was left."""
    lost = np.zeros((visits, count))
    sides = np.concatenate([run.side[:1], run.crossings.side])[:visits]
    for side in (-1, 1):
        number = np.flatnonzero(sides == side)
        at_end = run.system.conserved(side, run.crossings.t[number], run.crossings.x[number])
        at_entry = run.system.conserved(side, run.entered_t[number], run.entered_x[number])
        lost[number, : at_end.shape[1]] = at_end - at_entry
    return lost


def _lost_at_crossings(run: core.Trajectory, visits: int, count: int) -> Floats:
    """Change of ψ of the side entered, from where the scheme met the surface to where it went on.

    A jump is part of the system, and loses nothing.
    """
    lost = np.zeros((visits, count))
    crossings = run.crossings.first(visits)
    for side in (-1, 1):
        number = np.flatnonzero((crossings.side == side) & (crossings.kind != "jump"))
        t = crossings.t[number]
        after = run.system.conserved(side, t, crossings.x_after[number])
        lost[number, : after.shape[1]] = after - run.system.conserved(side, t, crossings.surface[number])
    return lost
