"""The catalogue: one file a system, each exporting SYSTEM. This list is the display order."""

from collections.abc import Mapping
from importlib import import_module
from types import MappingProxyType

from core.system import PiecewiseSystem

__all__ = ["CATALOGUE"]

_NAMES = ("harmonic_oscillator", "elliptic_curve")

#: Every built-in system by name, in display order.
CATALOGUE: Mapping[str, PiecewiseSystem] = MappingProxyType(
    {name: import_module(f"core.systems.{name}").SYSTEM for name in _NAMES}
)
