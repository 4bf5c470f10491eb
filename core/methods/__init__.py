"""The integrators, each a declaration in the file of its family."""

from core.methods.base import Method, Scheme
from core.methods.discrete_multiplier import Composition, DiscreteMultiplier
from core.methods.projected import Projected, TaylorSeries
from core.methods.registry import METHODS, method_named
from core.methods.runge_kutta import ButcherTableau

__all__ = [
    "METHODS", "ButcherTableau", "Composition", "DiscreteMultiplier", "Method", "Projected", "Scheme", "TaylorSeries",
    "method_named",
]  # fmt: skip
