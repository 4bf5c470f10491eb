"""The constants and step bounds of the paper's theory, computed along a run, to judge its step size."""

from core.diagnostics.amplification import tells_of_growth
from core.diagnostics.crossing_rates import constant_sign, rate_on_surface, ratio
from core.diagnostics.diagnosis import Diagnosis, diagnose, step_warning
from core.diagnostics.near_touches import times_of_near_touches
from core.diagnostics.scheme import stand_in
from core.diagnostics.walls import beyond_walls, inhabited, start_warning, starts_beyond_wall

__all__ = [
    "Diagnosis",
    "beyond_walls",
    "constant_sign",
    "diagnose",
    "inhabited",
    "rate_on_surface",
    "ratio",
    "stand_in",
    "start_warning",
    "starts_beyond_wall",
    "step_warning",
    "tells_of_growth",
    "times_of_near_touches",
]
