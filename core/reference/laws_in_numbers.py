"""Laws in exact numbers: what the exact solutions are derived from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy

from core.reference.recognition import closed_form, exact_numbers
from core.symbolic.algebra import cancel
from core.symbolic.laws import Laws, RegionLaw, Way
from core.symbolic.mode import Mode
from core.symbolic.sliding import eliminated

__all__ = ["followed_field", "laws_in_numbers", "two_sides"]


def laws_in_numbers(laws: Laws, values: Mapping[sympy.Symbol, float]) -> Laws:
    """The laws at values of the parameters, every double standing for the ratio that it is; without ψ."""
    numbers = {symbol: sympy.Rational(float(value)) for symbol, value in values.items()}

    def exact(expressions: Sequence[sympy.Expr]) -> tuple[sympy.Expr, ...]:
        return tuple(exact_numbers(u.xreplace(numbers)) for u in expressions)

    regions = []
    for mode, ways in zip(laws.regions, laws.ways, strict=True):
        jumping = tuple(way._replace(jump=None if way.jump is None else exact(way.jump)) for way in ways)
        regions.append(RegionLaw(mode.name, mode.sides, exact(mode.field), (), jumping))
    return Laws(laws.x, (), exact(laws.surfaces), tuple(regions))


def two_sides(
    field_minus: tuple[sympy.Expr, ...],
    field_plus: tuple[sympy.Expr, ...],
    g: sympy.Expr,
    variables: tuple[sympy.Symbol, ...],
    jump: tuple[sympy.Expr, ...] | None = None,
) -> Laws:
    """The laws, in numbers, of the regions on both sides of a surface; without a jump the state is continuous there."""
    minus = RegionLaw("-", (-1,), field_minus, (), (Way(0, -1, 1, jump=jump),))
    plus = RegionLaw("+", (1,), field_plus, (), (Way(0, 1, 0, jump=jump),))
    return laws_in_numbers(Laws(variables, (), (g,), (minus, plus)), {})


def followed_field(mode: Mode) -> tuple[str | None, tuple[sympy.Expr, ...]]:
    """Name of the functions that solve the equations of a mode, None if none is known, and its field.

    Where it slides, the field is that on the surface: a variable is expressed by the others, and common factors of
    numerator and denominator are cancelled.
    """
    field = mode.field
    if mode.surface is not None:
        field = tuple(cancel(eliminated(u, mode.surface, mode.variables)) for u in field)
    return closed_form(field, mode.variables), field
