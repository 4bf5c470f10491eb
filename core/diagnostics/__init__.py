"""The constants and step bounds of the paper's theory, computed along a run, to judge its step size."""

from core.diagnostics.diagnosis import Diagnosis, diagnose, step_warning
from core.diagnostics.scheme import stand_in

__all__ = ["Diagnosis", "diagnose", "stand_in", "step_warning"]
