"""Stability: the largest step size, outcomes over starts and step sizes, drift of ψ, and runs near a tangency."""

from core.studies.stability.drift import Drift
from core.studies.stability.grazing import Grazing
from core.studies.stability.largest import LargestTau
from core.studies.stability.outcomes import OutcomeMap
from core.studies.stability.plan import STARTS_OF_MAP, default_taus
from core.studies.stability.study import PARTS, StabilityStudy, stability_study
from core.studies.stability.verdict import (
    ENDINGS,
    NO_START,
    NOT_YET,
    UNCERTAIN,
    WENT_ON,
    WRONG_CROSSINGS,
    outcome_words,
)

__all__ = [
    "ENDINGS",
    "NOT_YET",
    "NO_START",
    "PARTS",
    "STARTS_OF_MAP",
    "UNCERTAIN",
    "WENT_ON",
    "WRONG_CROSSINGS",
    "Drift",
    "Grazing",
    "LargestTau",
    "OutcomeMap",
    "StabilityStudy",
    "default_taus",
    "outcome_words",
    "stability_study",
]
