"""A mode: a smooth law, and the guards that end it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import sympy
from sympy import Expr, Symbol

from core.symbolic.derivative import derivative
from core.symbolic.expressions import TIME
from core.symbolic.multiplier import DiscreteField, Endpoints
from core.symbolic.near_zeros import written_near
from core.symbolic.singularities import Ends, Singularity, Zeros, is_singular, zeros_of_denominators

__all__ = ["Mode", "rate_along"]


@dataclass(frozen=True)
class Mode:
    """A smooth law: its field f, its conserved quantities ψ, and the guards of which a zero ends it."""

    name: str
    """Its key among the regions, as “-+”; with 0 for the surface along which it slides."""
    sides: tuple[int, ...]
    """Sign of each surface's switching function, 0 where it slides along it; () where regions have names."""
    variables: tuple[Symbol, ...]
    field: tuple[Expr, ...]
    conserved: tuple[Expr, ...]
    guards: tuple[Expr, ...]
    """Switching functions; of sliding, first the rates of g with the fields of both sides, which end it where they
    vanish."""
    signs: tuple[int, ...]
    """Signs that make the guards positive in this mode, if time runs forward."""
    taken: frozenset[str]
    """Names of the variables and of the parameters."""
    surface: Expr | None = None
    """The switching function along whose zeros it slides; None for a region."""
    declared: Mode | None = None
    """The same mode as it was declared, if this is how it is written for evaluation."""

    @cached_property
    def written(self) -> Mode:
        """The same mode as it is evaluated: its field keeps its digits near zeros of denominators."""
        return self._written(self.zeros.near)

    @cached_property
    def expanded(self) -> Mode:
        """The same as its Taylor coefficients are: near such zeros they lose digits even where the field keeps them."""
        return self._written((*self.zeros.near, *self.zeros.removable))

    def _written(self, zeros: Sequence[Expr]) -> Mode:
        field, guards = (tuple(written_near(u, zeros) for u in part) for part in (self.field, self.guards))
        if (field, guards) == (self.field, self.guards):
            return self
        return replace(self, field=field, guards=guards, declared=self)

    @property
    def slides(self) -> bool:
        """Whether the state slides along a surface."""
        return self.surface is not None

    @cached_property
    def heights(self) -> tuple[Expr, ...]:
        """The guards with the signs that make them positive in this mode, if time runs forward."""
        return tuple(sign * guard for sign, guard in zip(self.signs, self.guards, strict=True))

    def turns(self, guard: int) -> bool:
        """Whether the sign of a guard turns with the direction of time: it is a rate."""
        return self.slides and guard < 2

    @cached_property
    def guard_rates(self) -> tuple[Expr, ...]:
        """Time derivatives of the guards along the field: of g it is ġ = g_t + ∇g·f."""
        return tuple(map(self.rate_of, self.guards))

    @cached_property
    def discrete(self) -> DiscreteField:
        """The Discrete Multiplier Method of this law."""
        if self.declared is not None:
            return replace(self.declared.discrete, written=lambda u: written_near(u, self.zeros.near))
        return DiscreteField(self.field, self.conserved, Endpoints.of(self.variables, set(self.taken)))

    @cached_property
    def zeros(self) -> Zeros:
        """Where denominators vanish within the mode."""
        if self.declared is not None:
            return self.declared.zeros
        return zeros_of_denominators(self.field, self.variables, self._ends)

    @property
    def _ends(self) -> Ends:
        """Where the mode ends: sliding has ended before the rates of both sides agree."""
        zeros = (*self.guards, self.guards[0] - self.guards[1]) if self.slides else self.guards
        return Ends(zeros, self.slides)

    @property
    def singularities(self) -> tuple[Singularity, ...]:
        """Where the field is not bounded within the mode."""
        return self.zeros.singular

    def is_singular_with(self, values: Mapping[str, float], zero: Expr) -> bool:
        """Whether the field is not bounded at a zero for some parameter values, taken as the decimals they are."""
        numbers = {Symbol(name): sympy.Rational(repr(value)) for name, value in values.items()}
        u, *field = (e.xreplace(numbers) for e in (zero, *self.field))
        ends = self._ends._replace(zeros=tuple(e.xreplace(numbers) for e in self._ends.zeros))
        return is_singular(u, field, ends)

    @cached_property
    def _rates(self) -> dict[Expr, Expr]:
        """Time derivatives asked for so far: sympy takes a millisecond for each."""
        return {}

    def rate_of(self, u: Expr) -> Expr:
        """Time derivative of u along the field: zero if u is conserved."""
        if u not in self._rates:
            self._rates[u] = rate_along(self.field, self.variables, u)
        return self._rates[u]


def rate_along(field: Sequence[Expr], variables: Sequence[Symbol], u: Expr) -> Expr:
    """Time derivative of u along a field: u_t + ∇u·f."""
    return sympy.Add(derivative(u, TIME), *(derivative(u, v) * f for v, f in zip(variables, field, strict=True)))
