"""METHODS: every integrator. A new one is a declaration in the file of its family, and a name here."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from core.methods.base import Method
from core.methods.discrete_multiplier import DMM2, DMM4, DMM6, DMM8
from core.methods.projected import PRK8, TAYLOR
from core.methods.runge_kutta import GAUSS4, RK2, RK4, RK8

__all__ = ["METHODS", "method_named"]

#: Every integrator by name, in the order in which they are shown.
METHODS: Mapping[str, Method] = MappingProxyType({
    method.name: method for method in (DMM2, DMM4, DMM6, DMM8, RK2, RK4, RK8, GAUSS4, PRK8, TAYLOR)
})  # fmt: skip


def method_named(method: str | Method) -> Method:
    """The method of that name, or the method itself where it is one of METHODS.

    Raises
    ------
    ValueError
        If there is no such method.
    """
    name = method.name if isinstance(method, Method) else method
    found = METHODS.get(name) if isinstance(name, str) else None
    if found is None or (isinstance(method, Method) and method != found):
        raise ValueError(f"unknown method {method!r}; known are {', '.join(METHODS)}")
    return found
