"""The catalogue: one file a system, each exporting SYSTEM. This list is the display order."""

from collections.abc import Mapping
from importlib import import_module
from types import MappingProxyType
from typing import TypeAlias

from core.system import PiecewiseSystem

__all__ = ["CATALOGUE", "System", "system_of"]

#: A system, or the key of one in the catalogue.
System: TypeAlias = PiecewiseSystem | str

_NAMES = (
    "harmonic_oscillator",
    "elliptic_curve",
    "pendulum",
    "predator_prey",
    "rigid_body",
    "kepler",
    "damped_oscillator",
    "coulomb_friction",
    "bouncing_ball",
    "diode_circuit",
    "relay_feedback",
    "gene_switch",
    "type_upward",
    "type_downward",
    "type_repelling",
    "type_sliding",
    "moving_interface",
)

#: Every built-in system by name, in display order.
CATALOGUE: Mapping[str, PiecewiseSystem] = MappingProxyType(
    {name: import_module(f"core.systems.{name}").SYSTEM for name in _NAMES}
)


def system_of(system: System) -> PiecewiseSystem:
    """Return a system, or the one of that key in the catalogue.

    Raises
    ------
    ValueError
        If it is neither.
    """
    if isinstance(system, PiecewiseSystem):
        return system
    if isinstance(system, str) and system in CATALOGUE:
        return CATALOGUE[system]
    known = ", ".join(CATALOGUE)
    raise ValueError(f"system = {system!r}: give a PiecewiseSystem, or a key of CATALOGUE, which are {known}")
