"""Checks of the arguments of public functions, how they are given up, and the display of their results."""

from core.interface.cancelling import Cancel, Cancelled

__all__ = ["Cancel", "Cancelled"]
