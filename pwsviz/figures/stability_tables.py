"""What the figures of a stability study draw, as tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

import core
from core.studies import NOT_YET, Drift, Grazing, LargestTau, OutcomeMap, outcome_words

__all__ = ["stability_tables"]

SIDES = ("less", "more")
"""The two sides of a tangency, in the order of the arrays of a `Grazing`."""

SLIDES = core.Tally._fields.index("slides")
"""Column of a tally."""

Columns = dict[str, ArrayLike]


def stability_tables(study: core.StabilityStudy, part: str) -> Mapping[str, Callable[[], Columns]]:
    """Return the tables of one part of a study, as far as it is computed; those of the map name its limits, too."""
    tables: dict[str, Callable[[], Columns]] = {}
    drawn, limits, drift, grazing = study.map, study.largest_tau, study.drift, study.grazing
    if part == "map" and drawn is not None:
        tables["map"] = lambda: _map_table(study, drawn)
    if part in ("map", "largest_tau") and limits is not None:
        tables["largest_tau"] = lambda: _limits_table(study, limits)
    if part == "drift" and drift is not None:
        tables["drift"] = lambda: _drift_table(study, drift)
    if part == "grazing" and grazing is not None and grazing.found:
        tables["grazing"] = lambda: _grazing_table(study, grazing)
    return tables


def _limits_table(study: core.StabilityStudy, largest: LargestTau) -> Columns:
    return {
        "integrator": np.array(study.methods), "largest_tau": largest.tau, "first_that_fails": largest.beyond,
        "reason": np.array(largest.reason),
    }  # fmt: skip


def _drift_table(study: core.StabilityStudy, drift: Drift) -> Columns:
    methods = np.array(study.methods)
    return {
        "integrator": np.repeat(methods, len(drift.t)),
        "tau": np.full(drift.error.size, drift.tau),
        "t": np.tile(drift.t, len(methods)),
        "change_of_psi": drift.error.ravel(),
    }


def _map_table(study: core.StabilityStudy, found: OutcomeMap) -> Columns:
    which, row, column = np.nonzero(found.outcome != NOT_YET)
    outcome = found.outcome[which, row, column]
    return {
        "integrator": np.array(study.methods)[which],
        "tau": found.taus[row],
        study.coordinate_name: found.values[column],
        "outcome": _words(outcome),
        "as_the_solution": found.works[which, row, column],
        "crossings": found.crossings[which, row, column],
        "slides": found.met[which, row, column, SLIDES],
        "expected_crossings": found.expected_crossings[column],
        "expected_slides": found.expected_met[column, SLIDES],
        "change_of_psi": found.error[which, row, column],
    }


def _grazing_table(study: core.StabilityStudy, grazing: Grazing) -> Columns:
    which, side, n = np.nonzero(grazing.computed)
    return {
        "integrator": np.array(study.methods)[which],
        "side": np.array(SIDES)[side],
        "tau": np.full(len(n), grazing.tau),
        "delta": grazing.delta[n],
        study.coordinate_name: grazing.starts[side, n],
        "t_end": grazing.horizon[side, n],
        "crossings": grazing.crossings[which, side, n],
        "slides": grazing.met[which, side, n, SLIDES],
        "expected_crossings": grazing.expected[side, n],
        "expected_slides": grazing.expected_met[side, n, SLIDES],
        "change_of_psi": grazing.error[which, side, n],
        "outcome": _words(grazing.status[which, side, n]),
    }


def _words(codes: NDArray[np.int64]) -> NDArray[np.str_]:
    return np.array([outcome_words(int(code)) for code in codes], dtype=str)
