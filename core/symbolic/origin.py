"""The point about which expressions are written most simply, such as c of −(x − c)³.

Multiplied out about another point, their powers cancel: at x = 10⁴ those of a cubic leave no digit.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import sympy
from sympy import Expr, Symbol

__all__ = ["Origin"]


class Origin(NamedTuple):
    """What is subtracted from the variables, in units that are parameters or products of them: w = v/s − shift."""

    units: dict[Symbol, Expr]
    shifts: dict[Symbol, Expr]

    @classmethod
    def of(cls, expressions: Sequence[Expr], variables: Sequence[Symbol]) -> Origin:
        """The origin of some expressions in the variables."""
        units, shifts = {}, {}
        for v in variables:
            units[v], shifts[v] = _unit_and_shift(expressions, v, variables)
            expressions = cls({v: units[v]}, {v: shifts[v]}).about(expressions)
        return cls(units, shifts)

    def about(self, expressions: Sequence[Expr]) -> tuple[Expr, ...]:
        """Expressions in the variables w, by the names of v."""
        moved = {v: (v + self.shifts[v]) / unit for v, unit in self.units.items()}
        return tuple(u.xreplace(moved) for u in expressions)

    def back(self, expression: Expr) -> Expr:
        """An expression in the variables w, by the names of v, in v again."""
        return expression.xreplace({v: unit * v - self.shifts[v] for v, unit in self.units.items()})


def _unit_and_shift(expressions: Sequence[Expr], v: Symbol, variables: Sequence[Symbol]) -> tuple[Expr, Expr]:
    """The unit and the shift of a variable with which expressions are written most simply; 1 and 0 if with none."""
    as_they_are: tuple[Expr, Expr] = (sympy.Integer(1), sympy.Integer(0))
    choices = {as_they_are}
    for node in (node for u in expressions for node in u.atoms(sympy.Add)):
        rest, slope = node.as_independent(v, as_Add=True)
        factor, alone = slope.as_independent(*variables, as_Add=False)
        number, unit = factor.as_coeff_Mul()
        if alone == v and sympy.fraction(unit)[0] == 1:  # of k x − a, x would be divided by k, which may be zero
            # Of 2 (x − a) + 3 (y − b) sympy makes 2 x + 3 y − 2 a − 3 b.
            constant, others = rest.as_independent(*variables, as_Add=True)
            choices |= {(unit, -u / number) for u in (sympy.Add.make_args(constant) if others != 0 else (constant,))}

    def length(choice: tuple[Expr, Expr]) -> tuple[float, bool, str]:
        unit, shift = choice
        moved = Origin({v: unit}, {v: shift}).about(expressions)
        written = sum(float(sympy.count_ops(u)) for u in moved)
        return written, choice != as_they_are, str(choice)  # the same one each time

    return min(choices, key=length) if len(choices) > 1 else choices.pop()
