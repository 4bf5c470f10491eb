"""What compiled code calls: how it is called, divided differences, root isolation, Taylor coefficients."""

from core.kernels.arrays import Floats

__all__ = ["Floats"]
