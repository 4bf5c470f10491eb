"""The time loop, runs in progress and completed, the error of ψ along a run, and dense output."""

from core.integration.time_loop import compiled_march

__all__ = ["compiled_march"]
