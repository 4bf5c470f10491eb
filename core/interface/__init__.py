"""Checks of the arguments of public functions, how they are given up and where they run, the display of results; what
is being compiled.
"""

from core.interface.cancelling import Cancel, Cancelled
from core.interface.machine import processor
from core.interface.under_way import being_compiled, compiling

__all__ = ["Cancel", "Cancelled", "being_compiled", "compiling", "processor"]
