"""The time loop, a run in progress and when it is over, the error of ψ along it, states between its steps."""

from core.integration.time_loop import compiled_march

__all__ = ["compiled_march"]
