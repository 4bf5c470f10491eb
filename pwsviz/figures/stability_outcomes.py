"""Outcomes of the runs of a stability study: words and colour of each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from core import Status
from core.studies import ENDINGS, NO_START, NOT_YET, WENT_ON, WRONG_CROSSINGS, OutcomeMap
from pwsviz.figures.colours import BLUE, BROWN, CALM, GREEN, GREY, MILD, OCHRE, PURPLE, VERMILION, VIOLET

__all__ = ["LIKEWISE", "OUTCOMES", "UNJUDGED", "Outcome", "lasts", "outcomes_shown"]

UNJUDGED = -1
"""Outcome of a run that nothing can be compared with: the reference ends early, or rounding decides its crossings."""


LIKEWISE = -2
"""Outcome of a run that ends before the end time, as the solution does, after the same crossings."""


class Outcome(NamedTuple):
    """How an outcome is shown."""

    words: str
    colour: str


OUTCOMES: Mapping[int, Outcome] = {
    Status.COMPLETED: Outcome("correct sequence of crossings", CALM),
    LIKEWISE: Outcome("ends early, as the solution does", MILD),
    WRONG_CROSSINGS: Outcome("incorrect or mistimed crossings", "#c47a14"),
    WENT_ON: Outcome("continues where the solution stops", OCHRE),
    Status.ESCAPED: Outcome("the numerical solution blows up", VERMILION),
    Status.UNSTABLE: Outcome("unstable: the step is too long", "#7f1d1d"),
    Status.CONTRADICTION: Outcome("an error of the program", "#000000"),
    Status.NO_CONVERGENCE: Outcome("a step has no solution", PURPLE),
    Status.SINGULAR: Outcome("a step passes a singularity", "#db2777"),
    Status.SLIDING: Outcome("stops: sliding", GREEN),
    Status.GRAZING: Outcome("stops: tangent to the surface", BROWN),
    Status.ZENO: Outcome("stops: accumulation (Zeno)", VIOLET),
    Status.REPELLING: Outcome("stops: repelled from both sides", BLUE),
    Status.CORNER: Outcome("stops: two surfaces at once", "#b45309"),
    Status.UNDECLARED: Outcome("stops: no law declared", "#78716c"),
    Status.STEP_LIMIT: Outcome("too many steps", GREY),
    Status.CROSSING_LIMIT: Outcome("too many crossings", GREY),
    NO_START: Outcome("no trajectory starts here", "#404040"),
    UNJUDGED: Outcome("not judged: no reference to the end", "#e4e4e4"),
}
"""What is shown of each outcome, by its code."""


def outcomes_shown(found: OutcomeMap, k: int) -> NDArray[np.int64]:
    """Return (m, n) keys of `OUTCOMES` for the runs of integrator k, and `NOT_YET` where a run is not computed.

    A run that ends as the solution does has the correct sequence of crossings.
    """
    judged = np.isin(found.expected, (*ENDINGS, NO_START))
    correct = np.where(found.expected == Status.COMPLETED, Status.COMPLETED, LIKEWISE)
    codes = np.where(found.works[k], correct, found.outcome[k])
    return np.where(judged | (codes == NOT_YET), codes, UNJUDGED)


def lasts(found: OutcomeMap, k: int) -> NDArray[np.bool_]:
    """Return (m, n) which runs of integrator k last as long as they should: |Δψ| of others is that of a part of a run.

    They reach the end time, or end as the solution does.
    """
    return np.asarray(found.works[k] | np.isin(found.outcome[k], (Status.COMPLETED, WRONG_CROSSINGS, WENT_ON)))
