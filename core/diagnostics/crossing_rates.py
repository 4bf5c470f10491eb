"""The rates at which motion meets a surface, by the declaration alone, and what their signs say."""

from __future__ import annotations

import sympy

from core.symbolic import TIME, Laws, Mode, Way, eliminated, is_larger
from core.symbolic.algebra import cancel
from core.system import PiecewiseSystem

__all__ = ["constant_sign", "rate_on_surface", "ratio"]

_NODES = 200
"""Most nodes of the tree of a ratio of rates that is simplified, as sympy takes long for more."""


def rate_on_surface(laws: Laws, mode: Mode, way: Way) -> sympy.Expr:
    """Return the rate of the switching function in a region, where that function vanishes."""
    g = laws.surfaces[way.surface]
    return eliminated(mode.rate_of(g), g, laws.x)


def ratio(rate: sympy.Expr, other: sympy.Expr) -> sympy.Expr:
    """Return the ratio of two rates without common factors, unless that would take long."""
    if other == 0:
        return sympy.nan
    quotient = rate / other
    return quotient if is_larger(quotient, _NODES) else cancel(quotient)


def constant_sign(system: PiecewiseSystem, value: sympy.Expr) -> int | None:
    """Return the sign of an expression at the values of the parameters; None if it depends on the state."""
    if value.free_symbols & {*system.laws.x, TIME}:
        return None
    number = value.subs({symbol: system.values[symbol.name] for symbol in value.free_symbols})
    return int(bool(number.is_positive)) - int(bool(number.is_negative))
