"""The catalogue: one file a system, each exporting SYSTEM. The list of names is the display order."""

from collections.abc import Iterator, Mapping
from importlib import import_module
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
    "henon_heiles",
    "three_bodies",
    "damped_oscillator",
    "coulomb_friction",
    "stick_slip",
    "bouncing_ball",
    "vibrating_table",
    "diode_circuit",
    "relay_feedback",
    "gene_switch",
    "type_upward",
    "type_downward",
    "type_repelling",
    "type_sliding",
    "moving_interface",
    "chua",
    "two_walls",
    "thermostat",
    "gene_ring",
    "diode_bridge",
)


class _Catalogue(Mapping[str, PiecewiseSystem]):
    """The systems by name. Each is imported, and so parsed, on first use: all together take some seconds."""

    def __init__(self) -> None:
        self._known: dict[str, PiecewiseSystem] = {}

    def __getitem__(self, name: str) -> PiecewiseSystem:
        if name not in self._known:
            if name not in _NAMES:
                raise KeyError(name)
            self._known[name] = import_module(f"core.systems.{name}").SYSTEM
        return self._known[name]

    def __contains__(self, name: object) -> bool:
        return name in _NAMES

    def __iter__(self) -> Iterator[str]:
        return iter(_NAMES)

    def __len__(self) -> int:
        return len(_NAMES)


#: Every built-in system by name, in display order.
CATALOGUE: Mapping[str, PiecewiseSystem] = _Catalogue()


def system_of(system: System) -> PiecewiseSystem:
    """Return a system, or the one of that key in the catalogue.

    Raises
    ------
    ValueError
        If `system` is neither.
    """
    if isinstance(system, PiecewiseSystem):
        return system
    if isinstance(system, str) and system in _NAMES:
        return CATALOGUE[system]
    known = ", ".join(CATALOGUE)
    raise ValueError(f"system = {system!r}: give a PiecewiseSystem, or a key of CATALOGUE, which are {known}")
