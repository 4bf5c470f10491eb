"""Functions that compiled code calls: calling convention, divided differences, root isolation, Taylor coefficients."""

from core.kernels.arrays import Floats

__all__ = ["Floats"]
