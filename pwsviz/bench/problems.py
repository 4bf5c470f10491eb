"""The systems on which integrators are compared, as every one of them is told, and the solutions they should find."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import sympy
from numpy.typing import NDArray
from sympy import Expr, Symbol

import core

__all__ = ["ENDS", "Problem", "problem_named"]

#: End times of some 500 crossings each, where the state is far from the surface.
ENDS = {"harmonic_oscillator": 1240.0, "elliptic_curve": 473.0, "pendulum": 755.0, "rigid_body": 1989.0}


@dataclass(frozen=True)
class Problem:
    """A system of the catalogue whose sides differ in the value of one coefficient only, to be integrated from x0."""

    name: str
    end: float

    @cached_property
    def system(self) -> core.PiecewiseSystem:
        """The system, with its default parameters."""
        return core.CATALOGUE[self.name]

    @cached_property
    def start(self) -> NDArray[np.float64]:
        """Initial state (d,)."""
        return np.array(self.system.x0)

    @cached_property
    def first_side(self) -> int:
        """Side, −1 or +1, of the initial state."""
        return 1 if self.system.switching(0.0, self.start) > 0 else -1

    @cached_property
    def coefficient(self) -> Symbol:
        """What is another number on each side; its own parameters are called after it, with _minus and _plus."""
        (stem,) = (n.removesuffix("_minus") for n in self.system.values if n.endswith("_minus"))
        return Symbol(stem)

    @cached_property
    def levels(self) -> dict[int, float]:
        """Value of the coefficient on each side."""
        return {side: self.system.values[f"{self.coefficient}_{word}"] for side, word in ((-1, "minus"), (1, "plus"))}

    @cached_property
    def field(self) -> tuple[Expr, ...]:
        """Right-hand side (d) in the variables and the coefficient, all other parameters being numbers.

        Raises
        ------
        ValueError
            If the sides differ in more than the coefficient.
        """
        below, above = (tuple(map(self._inserted, self.system.laws.sides[side].field)) for side in (-1, 1))
        if below != above:
            raise ValueError(f"the sides of {self.name!r} differ in more than {self.coefficient}: {below} and {above}")
        return below

    @cached_property
    def surface(self) -> Expr:
        """g in the variables."""
        return self._inserted(self.system.laws.g)

    def _inserted(self, expression: Expr) -> Expr:
        laws, own = self.system.laws, (f"{self.coefficient}_minus", f"{self.coefficient}_plus")
        values = zip(laws.p, self.system.parameter_array, strict=True)
        inserted = {s: self.coefficient if str(s) in own else sympy.Float(v, 17) for s, v in values}
        # Doubles, as the compiled code has them: heyoka takes no ratio but of a power of two.
        ratios = {q: sympy.Float(float(q), 17) for q in expression.atoms(sympy.Rational) if q.q & (q.q - 1)}
        return expression.xreplace(inserted | ratios)


def problem_named(name: str, share: float = 1.0) -> Problem:
    """The problem on a system of `ENDS`, to a part of its end time."""
    return Problem(name, share * ENDS[name])
