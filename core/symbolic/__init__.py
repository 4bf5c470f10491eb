"""Expressions: the whitelist parser, tests whether one is zero, laws, the discrete gradient and multiplier."""

from core.symbolic.declaration import SIDES, Declaration, Problem, RegionText, TransitionText, Verdict, miscounted
from core.symbolic.expressions import OPERATORS, TIME, parse, quoted, to_text
from core.symbolic.laws import Laws
from core.symbolic.mode import Mode
from core.symbolic.multiplier import DIFFERENCES, DividedDifference
from core.symbolic.switching_terms import Found, read_switching

__all__ = [
    "DIFFERENCES",
    "OPERATORS",
    "SIDES",
    "TIME",
    "Declaration",
    "DividedDifference",
    "Found",
    "Laws",
    "Mode",
    "Problem",
    "RegionText",
    "TransitionText",
    "Verdict",
    "miscounted",
    "parse",
    "quoted",
    "read_switching",
    "to_text",
]
