"""A mode: a smooth law, and the guards that end it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import sympy
from sympy import Expr, Symbol

from core.symbolic.expressions import TIME
from core.symbolic.multiplier import DiscreteField, Endpoints

__all__ = ["SLIDING", "Mode", "rate_along"]

#: Side of the mode in which the state slides along the surface.
SLIDING = 0


@dataclass(frozen=True)
class Mode:
    """A smooth law: its field f, its conserved quantities ψ, and the guards of which a zero ends it."""

    side: int
    """−1 where g < 0, +1 where g > 0, `SLIDING` on the surface."""
    variables: tuple[Symbol, ...]
    field: tuple[Expr, ...]
    conserved: tuple[Expr, ...]
    guards: tuple[Expr, ...]
    """g; of sliding, the rates ġ₋ and ġ₊ of g with the fields of the sides, of which each ends it where it vanishes."""
    taken: frozenset[str]
    """Names of the variables and of the parameters."""

    @property
    def heights(self) -> tuple[Expr, ...]:
        """The guards with the signs that make them positive in this mode, if time runs forward."""
        signs = (1, -1) if self.side == SLIDING else (self.side,)
        return tuple(sign * guard for sign, guard in zip(signs, self.guards, strict=True))

    @cached_property
    def guard_rates(self) -> tuple[Expr, ...]:
        """Time derivatives of the guards along the field: of g it is ġ = g_t + ∇g·f."""
        return tuple(map(self.rate_of, self.guards))

    @cached_property
    def discrete(self) -> DiscreteField:
        """The Discrete Multiplier Method of this law."""
        return DiscreteField(self.field, self.conserved, Endpoints.of(self.variables, set(self.taken)))

    def rate_of(self, u: Expr) -> Expr:
        """Time derivative of u along the field: zero if u is conserved."""
        return rate_along(self.field, self.variables, u)


def rate_along(field: Sequence[Expr], variables: Sequence[Symbol], u: Expr) -> Expr:
    """Time derivative of u along a field: u_t + ∇u·f."""
    return sympy.Add(u.diff(TIME), *(u.diff(v) * f for v, f in zip(variables, field, strict=True)))
