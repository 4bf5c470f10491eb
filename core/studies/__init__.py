"""Studies of a method by many runs: its order, its cost, its stability."""

from core.studies.cost import CANCELLED, DONE, WAITING, CostCurve, WorkPrecision, work_precision
from core.studies.external_solvers import heyoka_integrator
from core.studies.order import OrderStudy, order_study
from core.studies.stability import (
    ENDINGS,
    NO_START,
    NOT_YET,
    WENT_ON,
    WRONG_CROSSINGS,
    Drift,
    Grazing,
    LargestTau,
    OutcomeMap,
    StabilityStudy,
    outcome_words,
    stability_study,
)

__all__ = [
    "CANCELLED",
    "DONE",
    "ENDINGS",
    "NOT_YET",
    "NO_START",
    "WAITING",
    "WENT_ON",
    "WRONG_CROSSINGS",
    "CostCurve",
    "Drift",
    "Grazing",
    "LargestTau",
    "OrderStudy",
    "OutcomeMap",
    "StabilityStudy",
    "WorkPrecision",
    "heyoka_integrator",
    "order_study",
    "outcome_words",
    "stability_study",
    "work_precision",
]
