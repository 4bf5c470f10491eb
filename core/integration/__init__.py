"""The time loop, runs in progress and completed, the error of ψ along a run, dense output, and how often a run
meets surfaces.
"""

from core.integration.tally import KINDS
from core.integration.time_loop import compiled_march

__all__ = ["KINDS", "compiled_march"]
