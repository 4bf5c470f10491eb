"""Studies of a method by many runs: its order, its cost, its stability."""

from core.studies.cost import CANCELLED, DONE, WAITING, CostCurve, WorkPrecision, work_precision
from core.studies.external_solvers import EXTERNAL_SOLVERS, heyoka_integrator
from core.studies.order import FIT_ABOVE, FIT_BELOW, OrderStudy, order_study
from core.studies.stability import (
    ENDINGS,
    NO_START,
    NOT_YET,
    STARTS_OF_MAP,
    UNCERTAIN,
    WENT_ON,
    WRONG_CROSSINGS,
    Drift,
    Grazing,
    LargestTau,
    OutcomeMap,
    StabilityStudy,
    default_taus,
    outcome_words,
    stability_study,
)
from core.studies.time_scale import moderate_time

__all__ = [
    "CANCELLED",
    "DONE",
    "ENDINGS",
    "EXTERNAL_SOLVERS",
    "FIT_ABOVE",
    "FIT_BELOW",
    "NOT_YET",
    "NO_START",
    "STARTS_OF_MAP",
    "UNCERTAIN",
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
    "default_taus",
    "heyoka_integrator",
    "moderate_time",
    "order_study",
    "outcome_words",
    "stability_study",
    "work_precision",
]
