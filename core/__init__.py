"""Conservative integrators for piecewise smooth systems: the public names, nothing else."""

from core.compilation.compiled import compile_beside
from core.diagnostics import Diagnosis, diagnose
from core.integrate import integrate
from core.integration.trajectory import Crossing, Crossings, Status, Trajectory
from core.methods import METHODS, Method
from core.reference import reference_solution
from core.studies import OrderStudy, StabilityStudy, WorkPrecision, order_study, stability_study, work_precision
from core.system import Parameter, PiecewiseSystem
from core.systems import CATALOGUE

__all__ = [
    "CATALOGUE",
    "METHODS",
    "Crossing",
    "Crossings",
    "Diagnosis",
    "Method",
    "OrderStudy",
    "Parameter",
    "PiecewiseSystem",
    "StabilityStudy",
    "Status",
    "Trajectory",
    "WorkPrecision",
    "compile_beside",
    "diagnose",
    "integrate",
    "order_study",
    "reference_solution",
    "stability_study",
    "work_precision",
]
