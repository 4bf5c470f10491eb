"""Conservative integrators for piecewise smooth systems: the public names, nothing else.

Studies, diagnostics and reference solutions are loaded on first use.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from core.compilation.compiled import compile_beside
from core.ensemble import Ensemble, EnsembleCrossings, EnsembleEvents, ensemble
from core.integrate import integrate
from core.integration.crossings import Crossing, Crossings
from core.integration.events import Event, Events
from core.integration.tally import Tally
from core.integration.trajectory import Status, Trajectory
from core.methods import METHODS, Method
from core.system import Parameter, PiecewiseSystem, Region, Transition
from core.systems import CATALOGUE

if TYPE_CHECKING:
    from core.diagnostics import Diagnosis, diagnose
    from core.maps import Section, Sweep, section, sweep
    from core.reference import reference_solution
    from core.studies import OrderStudy, StabilityStudy, WorkPrecision, order_study, stability_study, work_precision

__all__ = [
    "CATALOGUE",
    "METHODS",
    "Crossing",
    "Crossings",
    "Diagnosis",
    "Ensemble",
    "EnsembleCrossings",
    "EnsembleEvents",
    "Event",
    "Events",
    "Method",
    "OrderStudy",
    "Parameter",
    "PiecewiseSystem",
    "Region",
    "Section",
    "StabilityStudy",
    "Status",
    "Sweep",
    "Tally",
    "Trajectory",
    "Transition",
    "WorkPrecision",
    "compile_beside",
    "diagnose",
    "ensemble",
    "integrate",
    "order_study",
    "reference_solution",
    "section",
    "stability_study",
    "sweep",
    "work_precision",
]

#: Name that is loaded on first use -> its package.
_LATE = {
    "Diagnosis": "core.diagnostics",
    "OrderStudy": "core.studies",
    "Section": "core.maps",
    "StabilityStudy": "core.studies",
    "Sweep": "core.maps",
    "WorkPrecision": "core.studies",
    "diagnose": "core.diagnostics",
    "order_study": "core.studies",
    "reference_solution": "core.reference",
    "section": "core.maps",
    "stability_study": "core.studies",
    "sweep": "core.maps",
    "work_precision": "core.studies",
}


def __getattr__(name: str) -> Any:
    if name not in _LATE:
        raise AttributeError(f"module 'core' has no attribute {name!r}")
    globals()[name] = getattr(import_module(_LATE[name]), name)
    return globals()[name]


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
