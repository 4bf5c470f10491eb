"""Expressions: the whitelist parser, tests whether one is zero, laws, the discrete gradient and multiplier."""

from core.symbolic.declaration import SIDES, Declaration, Problem, Verdict, miscounted
from core.symbolic.expressions import OPERATORS, TIME, parse, quoted, to_text
from core.symbolic.laws import Laws
from core.symbolic.mode import Mode
from core.symbolic.multiplier import DIFFERENCES, DividedDifference

__all__ = [
    "DIFFERENCES",
    "OPERATORS",
    "SIDES",
    "TIME",
    "Declaration",
    "DividedDifference",
    "Laws",
    "Mode",
    "Problem",
    "Verdict",
    "miscounted",
    "parse",
    "quoted",
    "to_text",
]
