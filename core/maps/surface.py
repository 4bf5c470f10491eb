"""The surface of a section: one of the system's own, or the zeros of another function."""

from __future__ import annotations

from typing import NamedTuple

import sympy

from core.symbolic.expressions import parse
from core.system import PiecewiseSystem
from core.transition.records import ANY_SURFACE

__all__ = ["Surface", "own_surface"]


class Surface(NamedTuple):
    """A surface of a system."""

    number: int
    """Number of the surface; `records.ANY_SURFACE` for all."""
    sign: int = 1
    """Sign with which the system has its function: a guard may be the negative of another one."""

    def has(self, number: int) -> bool:
        """Whether a surface of the system, by its number, is this one or one of these."""
        return self.number in (ANY_SURFACE, number)


def own_surface(system: PiecewiseSystem, function: str | None) -> Surface | None:
    """Return the surface of the system of whose switching function another one is a multiple; None if there is none.

    Parameters
    ----------
    function
        None: the switching surface; of several, all.

    Raises
    ------
    ValueError
        If the function makes no sense.
    """
    if function is None:
        return Surface(0 if system.two_sided else ANY_SURFACE)
    names = (*system.variables, *(q.name for q in system.parameters))
    wanted = sympy.expand(parse(function, names, "of")).primitive()[1]
    for number, surface in enumerate(system.laws.surfaces):
        for sign in (1, -1):
            if sympy.expand(sign * surface).primitive()[1] == wanted:
                return Surface(number, sign)
    return None
