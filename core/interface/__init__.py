"""Checks of the arguments of public functions, how they are given up and where they run, the display of results."""

from core.interface.cancelling import Cancel, Cancelled
from core.interface.machine import processor

__all__ = ["Cancel", "Cancelled", "processor"]
